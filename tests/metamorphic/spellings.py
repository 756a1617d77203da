"""Other spellings of the same text: numbers, blanks, letter case, comments, line ends."""

from __future__ import annotations

from random import Random
from typing import Final

__all__ = ["BLANKS", "LINE_ENDS", "blank", "cased", "joined", "number"]

LINE_ENDS: Final = (b"\n", b"\r\n", b"\r")
BLANKS: Final = (b" ", b"  ", b"\t", b" \t ", b"\v", b"\f ")
COMMENTS: Final = (
    b"#",
    b"# f 1 2 3",
    b"# C:\\folder\\",
    b"#usemtl z",
    b" \t# newmtl z",
    b"# M\xf6bel \xe6\x9c\xa8",
    b"",
    b" ",
)


def number(value: float, random: Random) -> bytes:
    """Return a number that is a multiple of 1/8, in one of its spellings."""
    plain = f"{value:.3f}"
    spellings = [repr(value), plain, f"{value:.6f}", f"{value:e}", f"{value:.4E}", plain.rstrip("0")]
    if value >= 0.0:
        spellings += [f"+{value!r}", f"+{value:e}", f"00{value!r}"]
    if abs(value) < 1.0:
        spellings.append(plain.replace("0.", ".", 1))
    if value == int(value):
        spellings.append(str(int(value)))
    return random.choice(spellings).encode()


def blank(random: Random) -> bytes:
    """Return what separates two words."""
    return random.choice(BLANKS)


def cased(word: bytes, random: Random) -> bytes:
    """Return a word that is known in any letter case."""
    return random.choice((word, word.upper(), word.lower(), word.title()))


def joined(lines: list[bytes], random: Random, *, one_end: bool = False) -> bytes:
    """Return a text of these lines, with comments between them, and perhaps a byte-order mark.

    Its lines end in one way or, unless `one_end`, in several.
    """
    ends = (random.choice(LINE_ENDS),) if one_end or random.random() < 0.5 else LINE_ENDS
    out = [random.choice((b"", b"\xef\xbb\xbf"))]
    for line in lines:
        while random.random() < 0.2:
            out += [random.choice(COMMENTS), random.choice(ends)]
        out += [random.choice((b"", b" ", b"\t")) + line + random.choice((b"", b" ", b" \t")), random.choice(ends)]
    if random.random() < 0.3:
        out.pop()  # the last line has no end
    return b"".join(out)
