"""The rules for docstrings that a script can see: a first word that is a fragment's, riddles, long sentences."""

from __future__ import annotations

import ast
import inspect
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "python" / "equaltime"
FRAGMENTS = re.compile(r"(Of|What|Where|That|Those|The same|None|Nothing|By|As|Who)\b")
"""First words of docstrings that are no sentences and name nothing."""
RIDDLES = re.compile(r"\b(so many|those of|what is|be it|whither)\b", re.IGNORECASE)
LONGEST_SENTENCE = 30
"""Words in a sentence of a docstring."""


def docstrings(path: Path) -> Iterator[tuple[int, str]]:
    """Yield line and text of each docstring, those of constants and fields too."""
    for node in ast.walk(ast.parse(path.read_text())):
        body = getattr(node, "body", ())
        for child in body if isinstance(body, list) else ():
            if (
                isinstance(child, ast.Expr)
                and isinstance(child.value, ast.Constant)
                and isinstance(child.value.value, str)
            ):
                yield child.lineno, child.value.value


def paragraphs(text: str) -> Iterator[str]:
    """Yield the paragraphs of running text: without code, tables, and headings of sections."""
    literal = False
    for paragraph in re.split(r"\n\s*\n", inspect.cleandoc(text)):
        lines = paragraph.splitlines()
        if literal and lines[0].startswith(" "):
            continue
        literal = paragraph.rstrip().endswith("::")
        if not any(line.strip().startswith(("=", ">>>", "|")) or set(line.strip()) == {"-"} for line in lines):
            yield re.sub(r"``[^`]*``|`[^`]*`", "code", " ".join(line.strip() for line in lines))


def sentences(text: str) -> Iterator[str]:
    """Yield the sentences of running text."""
    for paragraph in paragraphs(text):
        yield from re.split(r"(?<=[.:;?!])\s+|\s- ", paragraph)


def problems(text: str) -> list[str]:
    """Return what is wrong with a docstring."""
    found = [f"begins with a fragment: {text.splitlines()[0]}"] if FRAGMENTS.match(text) else []
    found += [f"says {riddle.group()!r}" for riddle in RIDDLES.finditer("\n".join(paragraphs(text)))]
    long = [sentence for sentence in sentences(text) if len(sentence.split()) > LONGEST_SENTENCE]
    return found + [f"has a sentence of {len(sentence.split())} words: {sentence[:60]} ..." for sentence in long]


ROOMS = sorted({path.relative_to(PACKAGE).parts[0] for path in PACKAGE.rglob("*.py")})


@pytest.mark.parametrize("room", ROOMS)
def test_docstrings_of_a_room_are_sentences(room: str) -> None:
    place = PACKAGE / room
    files = sorted(place.rglob("*.py")) if place.is_dir() else [place]
    found = [
        f"{path.relative_to(ROOT)}:{line}: {problem}"
        for path in files
        for line, text in docstrings(path)
        for problem in problems(text)
    ]
    assert found == []


@pytest.mark.parametrize(
    "text", ["Of a pilot, in seconds.", "Return what is left.", f"Return {'very ' * 30}much.", "Take so many samples."]
)
def test_a_docstring_that_breaks_a_rule_is_seen(text: str) -> None:
    assert problems(text) != []


def test_a_plain_sentence_passes() -> None:
    assert problems("Longest time of pilot plus probe, in seconds.") == []
