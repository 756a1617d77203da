"""Reads a single mesh file (.obj, .ply) as a scene: the mesh with its materials, on a ground, under a sky and a sun.

`equaltime.scene.obj_materials` makes the materials of an OBJ file. Faces whose material has no colour take the colours
of their vertices. A PLY file is coloured by the image that a comment ``TextureFile`` names, or by the colours of its
vertices or faces. These materials are only used if the mesh itself is loaded as a scene. In a scene file, a shape of
type ``obj`` or ``ply`` has the BSDF that the scene gives it, as in Mitsuba.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from equaltime.scene.core import SMOOTHING, MeshData, read_obj_by_material, read_ply
from equaltime.scene.creases import has_creases
from equaltime.scene.mtl import shown
from equaltime.scene.obj_materials import GREY, ObjMaterials, file_beside
from equaltime.scene.report import Account, Report, told_once
from equaltime.scene.search import Search
from equaltime.scene.studio import (
    NOT_FRAMED,
    SUN_ANGLE,
    UPS,
    VIEWS,
    Z_UP,
    Strength,
    choice,
    default_camera,
    framed,
    ground,
    number_of,
    sky,
    soft_sun,
    strength,
    sun_angle,
    switch,
    unused,
)
from equaltime.scene.tree import Child, Object, Place, add, plant

__all__ = ["MESHES", "read_mesh"]

MESHES: Final = (".obj", ".ply")
DEFINITIONS: Final[Mapping[str, object]] = {
    "ground": 0.6,
    "sky": 0.3,
    "sun": 2.2,
    "sun_angle": SUN_ANGLE,
    "view": "front",
    "up": "y",
    "face_normals": False,
    "crease_angle": 40.0,
}
"""Names that ``-D`` may set, with the defaults: the ground's reflectance, the sky's radiance, the sun's irradiance, and
the sun's angular radius in degrees. ``view`` is the camera's side (`equaltime.scene.studio.VIEWS`), ``up`` the axis of
the mesh that points up, and ``face_normals`` makes all faces flat; by default they are flat where the file says so.
Where faces of a mesh without normals meet at more than the crease angle, in degrees, their edge is hard. The default of
40 degrees keeps a box hard, and a ball of 10 sides or more round. With the defaults, a white surface that faces the sun
is white in the image."""
_ADDED: Final = (
    "the file is only a mesh: {}; -D view=back shows its back, -D up=z if "
    "it lies on its back; also -D sky=, sun=, sun_angle=, ground="
)
_CREASED: Final = (
    "without normals: edges of more than {:g} degrees are hard, others smooth; -D crease_angle=180 smooths all, "
    "-D face_normals=true makes all hard"
)
_COLORS: Final = ("vertex_color", "face_color")
_LARGEST: Final = 1e300
"""Largest coordinate of a mesh whose studio, which is larger, still has finite numbers."""


def read_mesh(
    file: str, content: bytes, defines: Mapping[str, object], report: Report, search: Search
) -> Object | None:
    """Return the root of the tree (parsed nodes) of a scene that shows the mesh `file`.

    If the file is invalid, return None, with the problem in `report`. `defines` has the values of the option ``-D``;
    see `DEFINITIONS`. `content` only tells whether an OBJ file wants flat faces, because the mesh readers read the file
    themselves.
    """
    place, path = Place(file), Path(file)
    for name in sorted(set(defines) - set(DEFINITIONS)):
        report.add(place, unused(name, DEFINITIONS))
    search.note(path)
    account = Account()
    try:
        if path.suffix.lower() == ".obj":
            parts = read_obj_by_material(path)
            shapes = list(_painted(path, parts, place, account, search))
        else:
            parts = {b"": read_ply(path)}
            shapes = [_ply(path, parts[b""], place, account)]
    except ValueError as error:
        report.add(*told_once(place, str(error)))
        return None
    try:
        options = _Options.of({"face_normals": _wants_flat_faces(content, parts.values()), **defines})
        around = _studio([mesh.vertices for mesh in parts.values()], options, place, account)
    except ValueError as error:
        report.add(place, str(error))
        return None
    for shape in shapes:
        add(shape, "face_normals", options.face_normals or None)
        add(shape, "to_world", Z_UP if options.up == "z" else None)
    if not options.face_normals:
        _crease(shapes, list(parts.values()), options.crease_angle)
        bare = (mesh for mesh in parts.values() if mesh.normals is None)
        if "crease_angle" not in defines and any(has_creases(mesh, options.crease_angle) for mesh in bare):
            account.tell(_CREASED.format(options.crease_angle), path.name)
    for line in (*account, _ADDED.format(options.added)):
        report.note(line)
    return Object(place, "scene", "scene", children=[Child(each.id, each) for each in (*shapes, *around)])


@dataclass(frozen=True)
class _Options:
    """Values of the definitions of `DEFINITIONS`."""

    ground: Strength
    sky: Strength
    sun: Strength
    sun_angle: float
    view: str
    up: str
    face_normals: bool
    crease_angle: float

    @property
    def added(self) -> str:
        """Clause on the parts that are put around the mesh. Parts of strength 0 are left out."""
        *parts, last = ["a camera", *(f"a {name}" for name in ("sky", "sun", "ground") if np.any(getattr(self, name)))]
        return f"{', '.join(parts)} and {last} are added" if parts else f"{last} is added"

    @classmethod
    def of(cls, defines: Mapping[str, object]) -> _Options:
        """Return the given values, and the defaults of all others; a value that makes no sense raises ValueError."""
        given = {**DEFINITIONS, **defines}
        return cls(
            strength(given["ground"], "ground", most=1.0),
            strength(given["sky"], "sky"),
            strength(given["sun"], "sun"),
            sun_angle(given["sun_angle"]),
            choice(given["view"], "view", VIEWS),
            choice(given["up"], "up", UPS),
            switch(given["face_normals"], "face_normals"),
            number_of(given["crease_angle"], "crease_angle", most=180.0),
        )


def _crease(shapes: Sequence[Object], parts: Sequence[MeshData], angle: float) -> None:
    """Give shapes whose mesh has no normals the crease angle; without a library, one shape has all parts of a file."""
    bare = [mesh.normals is None for mesh in parts]
    for shape, edged in zip(shapes, bare if len(shapes) == len(parts) else [all(bare)], strict=True):
        add(shape, "crease_angle", angle if edged else None)


def _wants_flat_faces(content: bytes, parts: Collection[MeshData]) -> bool:
    """Tell whether an OBJ file without normals switches smoothing off before its first face, and never on.

    A file that wants only some of its faces flat is smooth: a shape is flat or smooth as a whole.
    """
    if not all(mesh.normals is None and any(SMOOTHING in text for text in mesh.warnings) for mesh in parts):
        return False  # the reader has found no statement that matters
    groups = list(re.finditer(rb"[\n\r][ \t]*[sS][ \t]+([^\n\r#]*)", content))
    face = re.search(rb"[\n\r][ \t]*[fF][oO]?[ \t]", content)
    if not groups or face is None or face.start() < groups[0].start():
        return False
    return all(group[1].strip() in (b"0", b"off") for group in groups)


def _studio(
    vertices: list[NDArray[np.floating[Any]]], options: _Options, place: Place, account: Account
) -> list[Object]:
    """Return camera, ground, sky and sun around a mesh; each of its parts has ``vertices`` (N, 3)."""
    parts = [part.astype(np.float64) for part in vertices]
    if options.up == "z":
        parts = [part @ Z_UP[:3, :3].T for part in parts]
    points = np.concatenate(parts)
    bounds = np.stack([points.min(axis=0), points.max(axis=0)])
    if not np.abs(bounds).max() <= _LARGEST:
        raise ValueError(f"the mesh reaches to {np.abs(bounds).max():.3g}; no coordinate may be beyond {_LARGEST:g}")
    seen = framed(parts)
    if len(seen) < len(parts):
        account.tell(NOT_FRAMED, Path(place.file).name)
    added = (
        default_camera(np.concatenate(seen), place, options.view),
        ground(options.ground, bounds, place) if np.any(options.ground) else None,
        sky(options.sky, place),
        soft_sun(options.sun, bounds, place, options.view, options.sun_angle),
    )
    return [each for each in added if each is not None]


def _painted(
    path: Path, parts: Mapping[bytes, MeshData], place: Place, account: Account, search: Search
) -> Iterator[Object]:
    """Yield a shape for each material that has faces, or one for all faces if there is no material library."""
    first = next(iter(parts.values()))
    materials = ObjMaterials(path, first.files, account, search)
    if not materials:
        if any(parts):
            account.tell("no library has the materials of the file: they have no colours", path.name)
        yield _shape("obj", path, place, _both(_reflectance(first, path, place, account), place))
        return
    for name, mesh in parts.items():
        found = materials.of(name)
        own = _reflectance(mesh, path, place, account, used=found is None or not found[1].has_color)
        if found is None and name:
            instead = f"of reflectance {own:g}" if isinstance(own, float) else "of the mesh's own colours"
            account.tell(f"the material '{shown(name)}' is in no library: its faces are matt, {instead}", path.name)
        bsdf, emitter = _both(own, place), None
        if found is not None:
            bsdf = materials.bsdf(*found, own, place, mesh)
            emitter = materials.emitter(*found, place, has_uvs=mesh.uvs is not None)
        material = shown(name)
        if material.encode() != name and material.encode() in parts:
            material = name.decode("utf-8", "surrogateescape")  # `shown` would give two materials the same name
        yield _shape("obj", path, place, bsdf, emitter=emitter, material=material)


def _ply(path: Path, mesh: MeshData, place: Place, account: Account) -> Object:
    """Return the shape of a PLY file; the first row of its image is at v = 1, as in MeshLab."""
    image = _image(path, mesh, account)
    own = _reflectance(mesh, path, place, account, used=image is None)
    if image is None:
        return _shape("ply", path, place, _both(own, place))
    texture = plant("texture", "bitmap", place, filename=image)
    return _shape("ply", path, place, _both(texture, place), flip_tex_coords=True)


def _image(path: Path, mesh: MeshData, account: Account) -> str | None:
    """Return the first image that a PLY file names, if the image exists and the mesh has texture coordinates."""
    used = None
    for name, line in mesh.files:
        found = file_beside(path, "", name)
        if used is not None:
            account.tell("an image after the first is not used", f"{path.name}:{line}")
        elif found is None:
            account.tell(f"the image '{shown(name)}' is left out: no such file", f"{path.name}:{line}")
        elif mesh.uvs is None:
            account.tell(f"the image '{shown(name)}' is not used: the mesh has no uvs", f"{path.name}:{line}")
        else:
            used = found
    return used


def _reflectance(mesh: MeshData, path: Path, place: Place, account: Account, *, used: bool = True) -> object:
    """Return the texture of a mesh's own colours, or grey; unused colours are reported."""
    name = next((name for name in _COLORS if used and name in mesh.attributes), None)
    for other in mesh.attributes.keys() - {name}:
        account.tell(f"{other} is not used", path.name)
    if name is None:
        return GREY
    values, full = mesh.attributes[name], mesh.full[name]
    low, high = float(values.min()) / full, float(values.max()) / full
    beyond = low < 0.0 or high > 1.0
    if beyond:
        account.tell(f"{name} has values outside [0, 1], which are clamped", path.name)
    return plant("texture", "mesh_attribute", place, name=name, scale=1.0 / full, cut=beyond or None)


def _both(reflectance: object, place: Place) -> Object:
    """Return a diffuse BSDF for both sides."""
    return plant("bsdf", "twosided", place, bsdf=plant("bsdf", "diffuse", place, reflectance=reflectance))


def _shape(kind: str, path: Path, place: Place, bsdf: Object, **fields: Any) -> Object:
    return plant("shape", kind, place, filename=path.name, bsdf=bsdf, **fields)
