"""Reads a mesh file by itself (.obj, .ply) as a scene: its materials as diffuse ones, a camera, a sky and a sun.

Of the materials of an OBJ file there are the diffuse colour and its image (``Kd``, ``map_Kd``), on both sides; of a PLY
file the colours of its vertices or faces. Mitsuba knows none of them: a shape of type ``obj`` in a scene ignores them.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from equaltime.scene.assets import Assets, Mesh
from equaltime.scene.gltf.plant import plant
from equaltime.scene.gltf.views import SKY, SUN, default_camera, sky, sun
from equaltime.scene.model import Obj, Ply
from equaltime.scene.places import told_once
from equaltime.scene.search import Search
from equaltime.scene.tree import Child, Object, Place, Report

__all__ = ["MESHES", "read_mesh"]

MESHES: Final = (".obj", ".ply")
GREY: Final = 0.5
_STATEMENT: Final = re.compile(rb"^[ \t]*(usemtl|mtllib)[ \t]+([^\r\n#]*)", re.MULTILINE)
_FACE: Final = re.compile(rb"^[ \t]*f[ \t]", re.MULTILINE)
_BYTES: Final = 1 / 255


@dataclass(frozen=True, slots=True)
class _Paint:
    """The diffuse part of a material."""

    color: tuple[float, ...] = (GREY, GREY, GREY)
    image: str | None = None


def read_mesh(
    file: str, content: bytes, defines: Mapping[str, object], report: Report, search: Search
) -> Object | None:
    """Return the scene of a mesh `file` with this `content`; problems go to `report`, None if there is no scene."""
    place, path = Place(file), Path(file)
    for name in sorted(defines):
        report.add(place, f"nothing in the scene uses the definition '{name}'")
    is_obj = path.suffix.lower() == ".obj"
    try:
        mesh = Assets(search).mesh((Obj if is_obj else Ply)(filename=path.name))
    except ValueError as error:
        report.add(*told_once(place, str(error)))
        return None
    if is_obj:
        shapes = list(_painted_parts(path, content, place, report, search))
    else:
        shapes = [_shape("ply", path, place, _colors(mesh, place))]
    report.note("the file is a mesh without a camera: one is added that has everything in view")
    report.note(f"and without light: a sky of radiance {SKY:g} and a sun of irradiance {SUN:g} are added")
    ends: NDArray[np.float64] = np.stack([mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)])
    corners = np.stack(np.meshgrid(*ends.T), axis=-1).reshape(-1, 3)
    parts = [default_camera(corners, place), *shapes, sky(SKY, place), sun(SUN, place)]
    return Object(place, "scene", "scene", children=[Child(part.id, part) for part in parts if part is not None])


def _shape(kind: str, path: Path, place: Place, reflectance: object, material: str | None = None) -> Object:
    diffuse = plant("bsdf", "diffuse", place, reflectance=reflectance)
    both = plant("bsdf", "twosided", place, bsdf=diffuse)
    return plant("shape", kind, place, filename=path.name, bsdf=both, material=material)


def _colors(mesh: Mesh, place: Place) -> object:
    """Return the texture of a mesh's own colours, or grey; whole numbers are bytes."""
    name = next((name for name in ("vertex_color", "face_color") if name in mesh.attributes), None)
    if name is None:
        return GREY
    scale = _BYTES if float(mesh.attributes[name].max()) > 1.0 else 1.0
    return plant("texture", "mesh_attribute", place, name=name, scale=scale)


def _painted_parts(path: Path, content: bytes, place: Place, report: Report, search: Search) -> Iterator[Object]:
    """Yield a shape for each material that has faces; one for all if no library of materials is there."""
    said = [(word, name.decode("utf-8", "replace").strip()) for word, name in _STATEMENT.findall(content)]
    paints: dict[str, _Paint] = {}
    for library in dict.fromkeys(name for word, name in said if word == b"mtllib"):
        try:
            paints |= _library(_text(search.note(path.parent / library)), path.parent, report)
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or error
            report.note(f"the materials of '{library}' are left out: {reason}")
    if not paints:
        yield _shape("obj", path, place, GREY)
        return
    for material in _with_faces(content):
        if material and material not in paints:
            report.note(f"the material '{material}' is in no library: it is grey")
        paint = paints.get(material, _Paint())
        image = paint.image and plant("texture", "bitmap", place, filename=paint.image)
        yield _shape("obj", path, place, image or paint.color, material=material)


def _text(path: Path) -> str:
    """Return what is in a file; raises OSError, or ValueError for a name that none can have."""
    if path.exists() and not path.is_file():  # a device may never end, a pipe never begin
        raise ValueError("not a regular file")
    return path.read_text("utf-8", "replace")


def _with_faces(content: bytes) -> list[str]:
    """Return the materials that have faces, "" being that of those before any `usemtl`."""
    found = [(match.start(), match[2]) for match in _STATEMENT.finditer(content) if match[1] == b"usemtl"]
    ends = [*(start for start, _ in found), len(content)]
    sections = zip([(0, b""), *found], ends, strict=True)
    names = [
        name.decode("utf-8", "replace").strip() for (start, name), end in sections if _FACE.search(content, start, end)
    ]
    return list(dict.fromkeys(names))


def _library(text: str, folder: Path, report: Report) -> dict[str, _Paint]:
    """Return the diffuse parts of the materials in an MTL file, by name."""
    found: dict[str, _Paint] = {}
    current = ""
    for line in text.splitlines():
        word, _, rest = line.strip().partition(" ")
        if word == "newmtl":
            current = rest.strip()
            found[current] = _Paint()
        elif word == "Kd" and current and (color := _color(rest)) is not None:
            found[current] = _Paint(color, found[current].image)
        elif word == "map_Kd" and current:
            name = _image(rest)
            if (folder / name).is_file():
                found[current] = _Paint(found[current].color, name)
            else:
                report.note(f"the image '{name}' of the material '{current}' is left out: no such file")
    return found


def _color(text: str) -> tuple[float, ...] | None:
    """Return a colour in [0, 1], one number standing for three; None if it is another kind (``spectral``, ``xyz``)."""
    try:
        numbers = [min(max(float(word), 0.0), 1.0) for word in text.split()[:3]]
    except ValueError:
        return None
    return tuple(numbers if len(numbers) == 3 else numbers[:1] * 3) or None


def _image(text: str) -> str:
    """Return the file of a map, without the options before it; Windows' separators become slashes."""
    words = text.split()
    begin = 0
    while begin < len(words) - 1 and (words[begin].startswith("-") or _is_argument(words[begin])):
        begin += 1
    return " ".join(words[begin:]).replace("\\", "/")


def _is_argument(word: str) -> bool:
    return word in ("on", "off") or re.fullmatch(r"[-+]?[\d.]+(?:[eE][-+]?\d+)?", word) is not None
