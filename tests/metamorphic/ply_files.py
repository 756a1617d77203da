"""A small mesh with colours and uvs, and ways to write it as PLY files that all mean the same."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from random import Random
from typing import Any, Final

from .spellings import BLANKS, LINE_ENDS, number

__all__ = ["FACES", "plain", "rewritten"]

Column = tuple[str, str, list[Any]]
"""Type and name of a property, and its values; lists are tuples, and the type is then "list COUNT ITEM"."""

POINTS: Final = [(0, 0, 0), (1.125, 0.125, 0), (1, 1, 0.25), (0, 0.875, -0.375), (0.5, 0.625, 0.875)]
NORMALS: Final = [(0, 0, 1), (0.125, 0, 1), (0, -0.5, 1), (0.25, 0.25, 1), (0, 0, -1)]
UVS: Final = [(0, 0), (1, 0.25), (0.875, 1), (0.125, 0.5), (-0.5, 2)]
COLORS: Final = [(0, 1, 2), (51, 102, 255), (254, 1, 0), (7, 8, 9), (255, 255, 255)]
FACES: Final = [(0, 1, 2, 3), (0, 1, 4), (1, 2, 4), (4, 2, 3)]
CODES: Final = {
    **{"char": "b", "uchar": "B", "short": "h", "ushort": "H", "int": "i", "uint": "I", "float": "f", "double": "d"},
    **{"int8": "b", "uint8": "B", "int16": "h", "uint16": "H", "int32": "i", "uint32": "I"},
    **{"float32": "f", "float64": "d"},
}
WHOLE: Final = [type_ for type_, code in CODES.items() if code.lower() in "bhi"]
BYTES: Final = ["uchar", "uint8"]
REALS: Final = ["float", "float32", "double", "float64"]
NAMES: Final[dict[str, list[tuple[str, ...]]]] = {
    "uv": [("u", "v"), ("s", "t"), ("texture_u", "texture_v"), ("texture_s", "texture_t")],
    "color": [("r", "g", "b"), ("red", "green", "blue"), ("diffuse_red", "diffuse_green", "diffuse_blue")],
}


def plain(colors: Sequence[Sequence[int]] = COLORS) -> bytes:
    """Return the file as a simple exporter writes it, perhaps with other colours."""
    vertex = [("float", name, [row[k] for row in POINTS]) for k, name in enumerate("xyz")]
    vertex += [("float", f"n{name}", [row[k] for row in NORMALS]) for k, name in enumerate("xyz")]
    vertex += [("float", name, [row[k] for row in UVS]) for k, name in enumerate("uv")]
    vertex += [("uchar", name, [row[k] for row in colors]) for k, name in enumerate("rgb")]
    faces = [("list uchar int", "vertex_indices", FACES)]
    return _written([("vertex", vertex, len(POINTS)), ("face", faces, len(FACES))], "", None)


def rewritten(random: Random) -> bytes:
    """Return the same file in other words."""
    elements = [("vertex", _vertex(random), len(POINTS)), ("face", _faces(random), len(FACES))]
    if random.random() < 0.3:
        extra: list[Column] = [
            ("list uchar float", "weights", [(0.5,) * k for k in range(3)]),
            ("short", "id", [1, 2, 3]),
        ]
        elements.insert(random.randrange(3), ("edge", extra, 3))
    elif random.random() < 0.3:
        elements.reverse()
    return _written(elements, random.choice(("", "<", ">")), random)


def _vertex(random: Random) -> list[Column]:
    groups: list[tuple[Sequence[str], Sequence[Sequence[float]], list[str]]] = [
        ("xyz", POINTS, REALS),
        (("nx", "ny", "nz"), NORMALS, REALS),
        (random.choice(NAMES["uv"]), UVS, REALS),
        (random.choice(NAMES["color"]), COLORS, BYTES),
    ]
    byte = random.choice(BYTES)
    columns: list[Column] = [
        (byte if types is BYTES else random.choice(types), name, [row[k] for row in rows])
        for names, rows, types in groups
        for k, name in enumerate(names)
    ]
    extra: list[Column] = [("uchar", "alpha", [255] * 5), ("double", "quality", [0.5] * 5), ("int", "flags", [3] * 5)]
    columns += random.sample(extra, random.randint(0, 3))
    if random.random() < 0.2:
        columns.append(("list ushort double", "neighbours", [(0.5,) * k for k in range(5)]))
    random.shuffle(columns)
    return columns


def _faces(random: Random) -> list[Column]:
    indices = f"list {random.choice(WHOLE)} {random.choice(WHOLE)}"
    columns: list[Column] = [(indices, random.choice(("vertex_indices", "vertex_index")), FACES)]
    extra: list[Column] = [
        ("int", "material_index", [0] * 4),
        ("list uint8 float", "scalars", [(), (0.5,), (1, 2), ()]),
    ]
    columns += random.sample(extra, random.randint(0, 2))
    random.shuffle(columns)
    return columns


def _written(elements: list[tuple[str, list[Column], int]], order: str, random: Random | None) -> bytes:
    rng = random or Random(0)
    end = rng.choice(LINE_ENDS) if random else b"\n"
    kind = {"": "ascii", "<": "binary_little_endian", ">": "binary_big_endian"}[order]
    lines = [f"format {kind} 1.0"]
    for name, columns, count in elements:
        lines += [f"element {name} {count}", *(f"property {type_} {column}" for type_, column, _ in columns)]
    if random:
        for _ in range(rng.randint(0, 3)):
            odd = rng.choice(
                ("comment property float red", "comment", "obj_info by hand", "", "comment TextureFiles a.png")
            )
            lines.insert(rng.randrange(len(lines) + 1), odd)
    header = [b"ply", *(_spaced(line.split(" "), random) for line in lines), b"end_header"]
    mark = b"\xef\xbb\xbf" if random and rng.random() < 0.2 else b""
    body = (_text if not order else _binary)(elements, order, random, end)
    return mark + b"".join(line + end for line in header) + body


def _spaced(words: list[str], random: Random | None) -> bytes:
    if random is None:
        return " ".join(words).encode()
    return b"".join(word.encode() + random.choice(BLANKS) for word in words)


def _text(elements: list[tuple[str, list[Column], int]], _: str, random: Random | None, end: bytes) -> bytes:
    out = []
    for _name, columns, count in elements:
        for i in range(count):
            words = []
            for type_, _column, values in columns:
                items = (len(values[i]), *values[i]) if type_.startswith("list") else (values[i],)
                whole = [True, CODES[type_.split()[-1]] not in "fd"] if type_.startswith("list") else [type_ in WHOLE]
                words += [_word(x, whole[min(k, len(whole) - 1)], random) for k, x in enumerate(items)]
            separator = random.choice(BLANKS) if random else b" "
            out.append(separator.join(words) + (random.choice((b"", b" ", b"\t")) if random else b"") + end)
            if random and random.random() < 0.1:
                out.append(end)
    return b"".join(out)


def _word(value: float, whole: bool, random: Random | None) -> bytes:
    return str(value).encode() if whole or random is None else number(float(value), random)


def _binary(elements: list[tuple[str, list[Column], int]], order: str, _: Random | None, _end: bytes) -> bytes:
    out = b""
    for _name, columns, count in elements:
        for i in range(count):
            for type_, _column, values in columns:
                if type_.startswith("list"):
                    _list, length, item = type_.split()
                    out += struct.pack(order + CODES[length], len(values[i]))
                    out += struct.pack(f"{order}{len(values[i])}{CODES[item]}", *values[i])
                else:
                    out += struct.pack(order + CODES[type_], values[i])
    return out
