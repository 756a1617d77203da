"""Meshes that deform while the shutter is open: lists of keys. A key is a time and the mesh file of the pose then.

All files have the same triangles. The core (the renderer in C++) only supports poses at evenly spaced times. The time
in which the shutter is open is therefore divided into the fewest equal intervals whose ends include all key times.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Final

import numpy as np

from equaltime.scene.assets import Assets, Mesh
from equaltime.scene.core import SMOOTHING
from equaltime.scene.geometry import MeshSurface, Surface, surface
from equaltime.scene.model import Deformation, Instance, MeshFile, SceneModel, Solid, mesh_files
from equaltime.scene.motion import in_shutters, span
from equaltime.scene.transforms import numbers
from equaltime.words import shortened

__all__ = ["check", "parse", "steps", "uneven"]

MOST_PARTS: Final = 128
"""Largest number of equal intervals of the time in which the shutter is open, which is Embree's limit."""
NEAR: Final = 1e-4
"""Largest distance between a key's time and an interval's end, as a fraction of the time the shutter is open."""


def parse(value: Mapping[str, object]) -> Deformation:
    """Return the deformation that `value`, a dict ``{"animation": [{"time": t, "filename": name}, …]}``, describes.

    With a further entry ``time``, the mesh does not move, and keeps its pose at that time. Raises ValueError if `value`
    describes no deformation.
    """
    keys = value["animation"]
    if not set(value) <= {"animation", "time"} or not isinstance(keys, list | tuple):
        raise ValueError("an animation of files is a table with a list of keys, and perhaps a time to hold")
    pairs = [_key(key) for key in keys]
    held = numbers(value["time"], 1)[0] if "time" in value else None
    return Deformation(tuple(time for time, _ in pairs), tuple(name for _, name in pairs), held)


def _key(key: object) -> tuple[float, str]:
    if not isinstance(key, Mapping) or set(key) != {"time", "filename"} or not isinstance(key["filename"], str):
        raise ValueError(
            "a key of an animation of files is a table with a time and a file, such as "
            f'{{time = 0, filename = "first.ply"}}, found {shortened(key, 80)}'
        )
    return numbers(key["time"], 1)[0], key["filename"]


def check(shape: MeshFile, assets: Assets) -> Iterator[tuple[str, str]]:
    """Read all files of the mesh `shape`, to find errors early, and yield warnings as pairs (file name, message).

    Raises ValueError for a file that cannot be read, or whose triangles differ from the first file's.
    """
    first, *later = dict.fromkeys(mesh_files(shape.filename))
    mesh = assets.mesh(shape)
    yield from ((first, text) for text in _warnings(mesh, shape))
    for name in later:
        other = assets.mesh(shape.replace(filename=name))
        if wrong := _difference(other, mesh):
            raise ValueError(f"{assets.absolute(name)}: {wrong} {first}, but both must be poses of one mesh")
        yield from ((name, text) for text in _warnings(other, shape))


def _warnings(mesh: Mesh, shape: MeshFile) -> list[str]:
    """Return a file's warnings for `shape`; smoothing groups mean nothing for flat faces."""
    return [text for text in mesh.warnings if not (shape.face_normals and SMOOTHING in text)]


def _difference(mesh: Mesh, first: Mesh) -> str | None:
    """Return a difference between a mesh and the first, or None; vertex positions and normal directions may differ."""
    if len(mesh.vertices) != len(first.vertices):
        return f"has {len(mesh.vertices)} vertices instead of {len(first.vertices)} as in"
    if not np.array_equal(mesh.faces, first.faces):
        return "has other faces than"
    if (mesh.normals is None) != (first.normals is None):
        return f"has {'no ' if mesh.normals is None else ''}normals, unlike"
    ours, theirs = mesh.uvs, first.uvs
    if (ours is None) != (theirs is None) or (ours is not None and theirs is not None and (ours != theirs).any()):
        return "has other texture coordinates than"
    attributes, others = mesh.attributes, first.attributes
    same = attributes.keys() == others.keys() and all(np.array_equal(attributes[k], others[k]) for k in others)
    return None if same else "has other attributes than"


def steps(shape: Solid, assets: Assets) -> Sequence[Surface]:
    """Return the poses of `shape` at evenly spaced times from opening to closing of the shutter.

    A shape that does not deform has one pose. Raises ValueError if a file cannot be used, and `Unsupported` if the core
    cannot use the shape.
    """
    mesh = shape.filename if isinstance(shape, MeshFile) else None
    if not isinstance(mesh, Deformation) or mesh.held is not None:
        return [surface(shape, assets)]
    poses = [_pose(shape, name, assets) for name in mesh.filenames]
    if all((pose.vertices == poses[0].vertices).all() for pose in poses):
        return [poses[0]]
    count = _parts(mesh.times)
    spans = (span(_rounded(mesh.times, count), k / count) for k in range(count + 1))
    return [poses[i].towards(poses[i + 1], share) if share > 0.0 else poses[i] for i, share in spans]


def _pose(shape: Solid, filename: str, assets: Assets) -> MeshSurface:
    placed = surface(shape.replace(filename=filename), assets)
    assert isinstance(placed, MeshSurface), "what has a file is a mesh"
    return placed


def uneven(model: SceneModel) -> str | None:
    """Return a warning, as text, if the evenly spaced times miss the time of a key, else None.

    A key is missed if it is off by more than `NEAR`, a fraction of the time in which the shutter is open.
    """
    begin, end = model.sensor.shutter_open, model.sensor.shutter_close
    shapes = in_shutters(model).shapes
    groups = {id(shape.shapegroup): shape.shapegroup for shape in shapes if isinstance(shape, Instance)}
    for shape in (*shapes, *(part for group in groups.values() for part in group.shapes)):
        mesh = shape.filename if isinstance(shape, MeshFile) else None
        if isinstance(mesh, Deformation) and mesh.held is None:
            times = _rounded(mesh.times, _parts(mesh.times))
            off, name = max(zip(np.abs(np.subtract(times, mesh.times)).tolist(), mesh.filenames, strict=True))
            if off > NEAR:
                parts = f"{MOST_PARTS} equal parts of the shutter's time meet"
                return f"'{name}' is taken to be {off * (end - begin):.2g} off its time: keys are where {parts}"
    return None


def _parts(times: Sequence[float]) -> int:
    """Return the smallest number of equal parts of the shutter time with bounds near all keys, or `MOST_PARTS`."""

    def off(count: int) -> float:
        return max(abs(a - b) for a, b in zip(times, _rounded(times, count), strict=True))

    return next((count for count in range(1, MOST_PARTS + 1) if off(count) <= NEAR), MOST_PARTS)


def _rounded(times: Sequence[float], count: int) -> tuple[float, ...]:
    """Return the times; times inside the shutter are rounded to the nearest boundary of equal parts."""
    return tuple(round(time * count) / count if 0.0 < time < 1.0 else time for time in times)
