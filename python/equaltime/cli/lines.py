"""Lines of text that fit a terminal: broken between words, but never within a number with its unit and interval."""

from __future__ import annotations

import re
import shutil
import textwrap
from collections.abc import Iterable
from typing import IO, Final

__all__ = ["fitted", "in_columns"]

_NARROWEST: Final = 40
"""Columns below which a line is not broken: hardly a word would fit beside the indent."""
_WIDEST_LABEL: Final = 26
"""Columns of the widest label or indent below which further lines begin."""
_UNIT = r"(?: (?:%|ms|s|min|h|days|[kMG]B|spp)(?!\w))?"
_WHOLE: Final = re.compile(
    rf"\d[\d.,]*{_UNIT} \([\d.,]+ (?:to [\d.,]+|or more)\)"  # 2.1 s (1.9 to 2.4)
    rf"|(?:\d+:? )?\d[\d.,]*{_UNIT} ±[\d.]+"  # 3: 39.4 % ±6.7
    r"|\d+:? none measurable"
    rf"|(?:(?:about|under|most|[≥±<>=]) )?\d[\d.,]*(?: to \d[\d.,]*)?{_UNIT}"
    r"|`[^`]{,50}`"
    r"|equaltime [a-z]+ [^;]*? -+[a-z][^;]*"  # a command, to be copied as one line
)
"""Parts of a line that are not broken."""
_LABEL: Final = re.compile(r" *\S+(?: \S+){,5} {2,}|\S+: | {8,}")
"""Label, indent or heading of a line; further lines begin below its end."""


def fitted(text: str, stream: IO[str]) -> str:
    """Return a line as it is to be printed to ``stream``: broken to the width of a terminal, else unchanged."""
    if not stream.isatty():
        return text
    width = shutil.get_terminal_size().columns
    if len(text) <= width or width < _NARROWEST:
        return text
    kept = _WHOLE.sub(lambda match: match[0].replace(" ", "\0"), text)
    longest = max(map(len, kept.split(" ")))
    label = _LABEL.match(text)
    hang = label.end() if label else len(text) - len(text.lstrip()) + 2
    if hang > _WIDEST_LABEL or hang + longest > width:
        hang = 2
    lines = textwrap.wrap(
        kept,
        width,
        subsequent_indent=" " * hang,
        break_long_words=False,
        break_on_hyphens=False,
        replace_whitespace=False,
    )
    return "\n".join(lines).replace("\0", " ")


def in_columns(rows: Iterable[tuple[str, str]]) -> list[str]:
    """Return one line for each pair of title and text; all texts begin in the same column."""
    rows = list(rows)
    width = max((len(title) for title, _ in rows), default=0)
    return [f"{title:<{width}}  {text}" for title, text in rows]
