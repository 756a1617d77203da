"""Changes that break files: numbers beyond all measure, letters that only look right, doubled parts, flipped bits.

Which change is made follows from the random generator alone, so that an input can be made again from its seed.
"""

from __future__ import annotations

import json
import random
import re
import struct
from collections.abc import Callable, Mapping
from typing import Any, Final

from .doubling import doubled_json, doubled_toml, doubled_xml

__all__ = ["mutated"]

Mutator = Callable[[bytes, random.Random], bytes]

NUMBERS: Final = (
    *("1e20", "1e38", "3.5e38", "1e155", "1e200", "1e308", "1e309", "-1e38", "1e-40", "1e-200", "1e-324", "nan", "inf"),
    *("0", "-0.0", "-1", "1", "2", "3", "0.5", "255", "65536", "2147483647", "2147483648", "4294967295", "-2147483649"),
    *("9223372036854775808", "1" * 400, "1" * 5000, "0x10", "1_000", "01", "1.", "\u00b2", "\u0661", "1e", "--1"),
)
"""What stands for a number: ends of float32, float64 and of integers, and digits that are no decimals."""
LETTERS: Final = (
    "\u2028",
    "\x85",
    "\x0c",
    "\0",
    "\u00b2",
    "$",
    "\\",
    '"',
    "'",
    "<",
    "&",
    "{",
    "[",
    "#",
    "\r",
    "\ufeff",
)
"""What text may hold without an end of a line, or as one."""
_NUMBER: Final = re.compile(rb"-?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")
_WORD: Final = re.compile(rb"[A-Za-z_][\w.]*")
_SHORT: Final = 64


def number_changed(content: bytes, chance: random.Random) -> bytes:
    return _replaced(content, _NUMBER, chance, chance.choice(NUMBERS).encode())


def word_changed(content: bytes, chance: random.Random) -> bytes:
    """Put one word of the file in the place of another."""
    words = _WORD.findall(content)
    return _replaced(content, _WORD, chance, chance.choice(words)) if words else content


def letter_added(content: bytes, chance: random.Random) -> bytes:
    at = chance.randrange(len(content) + 1)
    return content[:at] + chance.choice(LETTERS).encode() + content[at:]


def line_moved(content: bytes, chance: random.Random) -> bytes:
    """Leave a line out, or write it twice, or elsewhere."""
    lines = content.split(b"\n")
    line = lines.pop(chance.randrange(len(lines)))
    for _ in range(chance.randrange(3)):
        lines.insert(chance.randrange(len(lines) + 1), line)
    return b"\n".join(lines)


def bit_flipped(content: bytes, chance: random.Random) -> bytes:
    changed = bytearray(content)
    for _ in range(chance.choice((1, 1, 1, 2, 8))):
        if changed:
            changed[chance.randrange(len(changed))] ^= 1 << chance.randrange(8)
    return bytes(changed)


def piece_moved(content: bytes, chance: random.Random) -> bytes:
    """Leave a piece out, or write it over another."""
    begin, to = chance.randrange(len(content) + 1), chance.randrange(len(content) + 1)
    piece = content[begin : begin + chance.randrange(1, _SHORT)]
    if chance.random() < 0.5:
        return content[:begin] + content[begin + len(piece) :]
    return content[:to] + piece + content[to + len(piece) :]


def cut_off(content: bytes, chance: random.Random) -> bytes:
    return content[: chance.randrange(len(content) + 1)]


def word_of_four_bytes(content: bytes, chance: random.Random) -> bytes:
    """Write a number of four or eight bytes somewhere."""
    kind, value = chance.choice(
        [
            ("<I", chance.choice((0, 1, 2**16, 2**31 - 1, 2**31, 2**32 - 1))),
            ("<Q", chance.choice((2**32, 2**63, 2**64 - 1))),
            (chance.choice("<>") + "f", chance.choice((1e20, 1e38, -1e38, 1e-40, float("nan"), float("inf")))),
            (chance.choice("<>") + "d", chance.choice((1e155, 1e200, 1e-200, float("nan"), float("inf")))),
        ]
    )
    written = struct.pack(kind, value)
    at = chance.randrange(max(1, len(content) - len(written) + 1))
    return content[:at] + written + content[at + len(written) :]


def json_changed(content: bytes, chance: random.Random) -> bytes:
    """Change a value of JSON, or leave it out, or write it twice; the same in the first chunk of a GLB file."""
    begin, end = (20, 20 + struct.unpack_from("<I", content, 12)[0]) if content[:4] == b"glTF" else (0, len(content))
    try:
        document = json.loads(content[begin:end])
    except (ValueError, RecursionError):
        return number_changed(content, chance)
    if chance.random() < 0.1:
        document = doubled_json(document, chance)
    else:
        _change(document, chance)
    text = json.dumps(document).encode()
    if begin == 0:
        return text
    text += b" " * (-len(text) % 4)
    size = len(content) - (end - begin) + len(text)
    head = b"glTF" + struct.pack("<III", 2, size, len(text)) + content[16:20]
    return head + text + content[end:]


def _change(document: Any, chance: random.Random) -> None:
    """Change one entry, however deep."""
    holders: list[Any] = []
    waiting = [document]
    while waiting:
        holder = waiting.pop()
        items = list(holder.values()) if isinstance(holder, dict) else holder if isinstance(holder, list) else []
        if items:
            holders.append(holder)
        waiting.extend(items)
    if not holders:
        return
    holder, other = chance.choice(holders), chance.choice(holders)
    keys = list(holder) if isinstance(holder, dict) else range(len(holder))
    key = chance.choice(list(keys))
    kind = chance.randrange(6)
    if kind == 0:
        del holder[key]
    elif kind == 1 and isinstance(holder, list):
        holder.extend([holder[key]] * chance.choice((1, 2, 100)))
    elif kind == 2:
        holder[key] = chance.choice(list(other.values()) if isinstance(other, dict) else other)
        _unshare(holder)
    elif kind == 3:
        holder[key] = chance.choice((None, True, "", "\u2028", [], {}, [[]], "\u00b2.0"))
    else:
        holder[key] = chance.choice((0, -1, 1, 3, 1 << 20, 1 << 31, 1e20, 1e38, 1e155, 1e200, 1e-200, 1e-40, 0.5))


def _unshare(holder: Any) -> None:
    """Let nothing contain itself, which JSON could not write."""
    try:
        json.dumps(holder)
    except ValueError:
        holder.clear()


def _replaced(content: bytes, what: re.Pattern[bytes], chance: random.Random, new: bytes) -> bytes:
    found = list(what.finditer(content))
    if not found:
        return content
    at = chance.choice(found)
    return content[: at.start()] + new + content[at.end() :]


TEXT: Final[tuple[Mutator, ...]] = (
    number_changed,
    number_changed,
    number_changed,
    word_changed,
    letter_added,
    line_moved,
)
BINARY: Final[tuple[Mutator, ...]] = (bit_flipped, bit_flipped, piece_moved, cut_off, word_of_four_bytes)
MUTATORS: Final[Mapping[str, tuple[Mutator, ...]]] = {
    "toml": (*TEXT, *TEXT, doubled_toml, piece_moved, bit_flipped),
    "xml": (*TEXT, *TEXT, doubled_xml, piece_moved, bit_flipped),
    "gltf": (*[json_changed] * 6, number_changed, letter_added, piece_moved),
    "glb": (*[json_changed] * 6, *BINARY),
    "dict": (*[json_changed] * 6, number_changed, letter_added, word_changed),
    "mtl": (*TEXT, piece_moved),
    "obj": (*TEXT, piece_moved, bit_flipped),
    "ply": (*TEXT, *BINARY),
    "csv": (*TEXT, *BINARY),
    "json": (*[json_changed] * 6, number_changed, letter_added, piece_moved),
    "experiment": (*TEXT, *TEXT, piece_moved, bit_flipped),
}
"""By the name of the corpus; all others are binary."""


def mutated(name: str, content: bytes, chance: random.Random) -> bytes:
    """Return a file of a corpus with one change or a few."""
    for _ in range(chance.choice((1, 1, 1, 2, 3))):
        content = chance.choice(MUTATORS.get(name, BINARY))(content, chance)
    return content
