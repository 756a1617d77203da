"""A small mesh with materials, and ways to write it as OBJ and MTL files that all mean the same."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from random import Random
from typing import Final

from .spellings import blank, cased, joined, number

__all__ = ["FACES", "MATERIALS", "NAMES", "Paint", "plain", "rewritten", "write"]

Face = tuple[int, tuple[int, ...]]


@dataclass(frozen=True)
class Paint:
    """One material, as far as these files describe it."""

    color: tuple[float, float, float] | None = None
    opacity: float = 1.0
    radiance: float = 0.0
    image: str | None = None
    normals: str | None = None
    heights: str | None = None


POINTS: Final = [
    (x / 8, y / 8, z / 8) for x, y, z in ((0, 0, 0), (9, 1, 0), (8, 8, 2), (0, 7, -3), (4, 5, 7), (-6, 2, 1))
]
UVS: Final = [(0.0, 0.0), (1.0, 0.25), (0.875, 1.0), (0.125, 0.5), (-0.5, 2.0), (3.0, 0.625)]
FACES: Final[list[Face]] = [
    *[(0, (0, 1, 2, 3)), (1, (0, 1, 4)), (1, (1, 2, 4)), (2, (2, 3, 4)), (0, (3, 0, 4))],
    *[(3, (0, 5, 3)), (4, (5, 4, 3)), (2, (5, 0, 4))],
]
"""Materials and corners, which have the uvs of the same numbers."""
MATERIALS: Final = [
    Paint((0.75, 0.125, 0.0), heights="my heights.png"),
    Paint((0.25, 0.5, 0.5), opacity=0.25),
    Paint((0.5, 0.5, 0.5), radiance=2.5),
    Paint((1.0, 1.0, 1.0), image="my wood.png", normals="my normals.png"),
    Paint(),
]
NAMES: Final = [b"red", b"glass", b"lamp", b"wood", b"plain"]
ODD_NAMES: Final = [
    *[b"dark red", b"Material #25", b"Material_#25", b"M\xf6bel", "Möbel".encode(), b"#5", b"C#", b"a\\", b"f 1 2 3"],
    *[b"usemtl", b"newmtl", b"C:\\tex\\red", b'"quoted"', b"red.", b"RED", b"(null)", b"a/b", "木".encode()],
]


def plain(names: list[bytes] = NAMES) -> tuple[bytes, bytes]:
    """Return the OBJ file and its library as a simple exporter writes them."""
    lines = [b"mtllib a.mtl"]
    lines += [b"v " + b" ".join(repr(x).encode() for x in point) for point in POINTS]
    lines += [b"vt " + b" ".join(repr(x).encode() for x in uv) for uv in UVS]
    for material, corners in FACES:
        lines += [b"usemtl " + names[material], b"f " + b" ".join(b"%d/%d" % (i + 1, i + 1) for i in corners)]
    library = [line for name, paint in zip(names, MATERIALS, strict=True) for line in _said(name, paint, None)]
    return b"\n".join(lines) + b"\n", b"\n".join(library) + b"\n"


def rewritten(random: Random) -> tuple[bytes, bytes]:
    """Return the same files in other words."""
    names = random.sample([*NAMES, *ODD_NAMES], len(NAMES))
    return _obj(names, random), _mtl(names, random)


def write(folder: Path, files: tuple[bytes, bytes]) -> Path:
    """Write an OBJ file and its library."""
    (folder / "a.obj").write_bytes(files[0])
    (folder / "a.mtl").write_bytes(files[1])
    return folder / "a.obj"


def _obj(names: list[bytes], random: Random) -> bytes:
    library = random.choice((b"a.mtl", b'"a.mtl"', b"./a.mtl", b".\\a.mtl", b"a.mtl # paint"))
    points = [_line(b"v", [number(x, random) for x in point], random) for point in POINTS]
    uvs = [_line(b"vt", [number(x, random) for x in (*uv, *([0.0] * random.randint(0, 1)))], random) for uv in UVS]
    faces, behind = [], random.random() < 0.3  # faces may come before what they name, but not from behind it
    current = None
    for material, corners in FACES:
        if material != current or random.random() < 0.3:
            faces.append(_named(b"usemtl", names[material], random))
        current = material
        counted_back = not behind and random.random() < 0.3
        indices = [i - len(POINTS) if counted_back else i + 1 for i in corners]
        faces.append(_line(b"f", [b"%d/%d" % (i, i) for i in indices], random))
        faces += random.choices((b"", b"g a f b", b"o C:\\a\\", b"s 1", b"G", b"lod 1"), k=random.randint(0, 1))
    given = (
        [*points, *uvs] if random.random() < 0.5 else [line for pair in zip(points, uvs, strict=True) for line in pair]
    )
    lines = [*faces, *given] if behind else [*given, *faces]
    lines.insert(random.randrange(len(lines) + 1), _named(b"mtllib", library, random))
    return joined(lines, random)


def _mtl(names: list[bytes], random: Random) -> bytes:
    order = list(zip(names, MATERIALS, strict=True))
    random.shuffle(order)
    return joined([line for name, paint in order for line in _said(name, paint, random)], random)


def _said(name: bytes, paint: Paint, random: Random | None) -> list[bytes]:
    """Return the statements of a material: in one way, or in one of many."""
    rng = random or Random(0)

    def spelt(value: float) -> bytes:
        return number(value, rng) if random else repr(value).encode()

    said: list[tuple[bytes, list[bytes]]] = []
    if paint.color is not None:
        alike = random is not None and len(set(paint.color)) == 1 and rng.random() < 0.5
        said.append((b"Kd", [spelt(x) for x in (paint.color[:1] if alike else paint.color)]))
    if paint.opacity != 1.0 or rng.random() < 0.3:
        turned = random is not None and rng.random() < 0.5
        said.append((b"Tr", [spelt(1.0 - paint.opacity)]) if turned else (b"d", [spelt(paint.opacity)]))
    if paint.radiance:
        said.append((b"Ke", [spelt(paint.radiance)] * rng.choice((1, 3))))
    if paint.image is not None:
        said.append((b"map_Kd", _image(paint.image, random)))
    if paint.normals is not None:
        said.append((b"norm", [*rng.choice(([], [b"-bm", spelt(1.0)])), *_image(paint.normals, random)]))
    if paint.heights is not None:
        word = rng.choice((b"bump", b"map_Bump"))
        said.append((word, [b"-bm", spelt(0.125), *_image(paint.heights, random)]))
    if random is None:
        return [b"newmtl " + name, *(b" ".join((word, *rest)) for word, rest in said)]
    rng.shuffle(said)
    silent = rng.choices((b"Ka 1 1 1", b"illum 2", b"Ns 10", b"Ks 0 0 0", b""), k=rng.randint(0, 2))
    return [_named(b"newmtl", name, rng), *(_line(word, rest, rng, any_case=True) for word, rest in said), *silent]


def _image(name: str, random: Random | None) -> list[bytes]:
    """Return a file with options that ask for nothing."""
    file = name.encode()
    if random is None:
        return [file]
    options = random.choice(([], [b"-s", b"1", b"1", b"1"], [b"-clamp", b"off"], [b"-mm", b"0", b"1"]))
    return [*options, random.choice((file, b'"' + file + b'"', b".\\" + file, file + b" # oak"))]


def _named(word: bytes, name: bytes, random: Random) -> bytes:
    return (
        cased(word, random) + blank(random) + name + random.choice((b"", b" ", b"\t", b" # a comment", b" # C:\\a\\"))
    )


def _line(word: bytes, rest: list[bytes], random: Random, *, any_case: bool = False) -> bytes:
    """Return a statement with its words apart, perhaps in two lines and with a comment."""
    out = cased(word, random) if any_case or random.random() < 0.5 else word
    numeric = word.lower() in (b"v", b"vt", b"f", b"kd", b"ke", b"d", b"tr")
    for item in rest:
        out += b" \\\n " if numeric and random.random() < 0.05 else blank(random)
        out += item
    return out + (random.choice((b"", b" # a \\", b"#")) if numeric else b"")
