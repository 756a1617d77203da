"""Keyframe animations, an extension to Mitsuba 3. A key is a time with a transform, or a time with the file of a mesh.

Between two keys, the translation and the scale (with any shear) change linearly. The rotation turns at constant speed,
the shorter way round. Vertices and normals of meshes change linearly. Before the first key and after the last key
nothing moves. See `equaltime.scene.motion`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated, Final

from pydantic import AfterValidator, ConfigDict, PlainValidator, SerializeAsAny, TypeAdapter, ValidationError

from equaltime.scene.model.values import Matrix, RigidTransform, Transform, as_array, mirrors

__all__ = ["Animation", "Deformation", "MeshName", "Placement", "RigidPlacement", "mesh_files", "poses"]


@dataclass(frozen=True, slots=True)
class Animation:
    """Motion of a shape or a camera: transforms from local to world space at several times (keys)."""

    times: tuple[float, ...]
    """Times of the keys, increasing, in the units of the sensor's ``shutter_open`` and ``shutter_close``."""
    matrices: tuple[Matrix, ...]
    """One transform (4, 4) for each time."""


@dataclass(frozen=True, slots=True)
class Deformation:
    """A mesh that deforms: one file for each of several times.

    All files have the same triangles, but different vertices.
    """

    times: tuple[float, ...]
    """Times of the keys, increasing, in the units of the sensor's ``shutter_open`` and ``shutter_close``."""
    filenames: tuple[str, ...]
    """One file name for each time, relative to the scene file."""
    held: float | None = None
    """Time at which the mesh is frozen, between its keys; None if the mesh deforms during the exposure."""


def mesh_files(filename: str | Deformation) -> tuple[str, ...]:
    """Return the file names of a mesh as a tuple: one name, or for a `Deformation` one name for each key."""
    return filename.filenames if isinstance(filename, Deformation) else (filename,)


def poses(placement: Matrix | Animation) -> tuple[Matrix, ...]:
    """Return the transforms (4, 4) in `placement` as a tuple: one, or for an `Animation` one for each key."""
    return placement.matrices if isinstance(placement, Animation) else (placement,)


FINITE: Final = ConfigDict(strict=True, allow_inf_nan=False)
FREE: Final[TypeAdapter[Matrix]] = TypeAdapter(Transform, config=FINITE)
RIGID: Final[TypeAdapter[Matrix]] = TypeAdapter(RigidTransform, config=FINITE)


def _validator(one: TypeAdapter[Matrix]) -> Callable[[object], Matrix | Animation]:
    def validate(value: object) -> Matrix | Animation:
        if not isinstance(value, Animation):
            return _checked(one, value)
        _check_times(value.times)
        matrices = tuple(_checked(one, matrix) for matrix in value.matrices)
        if len({mirrors(as_array(matrix)) for matrix in matrices}) > 1:
            raise ValueError("the keys of an animation must all mirror, or none: between them, all would be flat")
        return Animation(value.times, matrices)

    return validate


def _check_times(times: tuple[float, ...]) -> None:
    if len(times) < 2:
        raise ValueError("an animation needs two keys at least")
    if any(not before < after for before, after in pairwise(times)):
        raise ValueError("the times of an animation's keys must increase")


def _check_keys(filename: str | Deformation) -> str | Deformation:
    if isinstance(filename, Deformation):
        _check_times(filename.times)
    return filename


def _checked(one: TypeAdapter[Matrix], value: object) -> Matrix:
    """Return the checked transform; raises ValueError with the message of the check that failed."""
    try:
        return one.validate_python(value)
    except ValidationError as error:
        details = error.errors()[0]
        if details["type"] == "finite_number":
            raise ValueError(f"expected a finite number, found {details['input']}") from None
        raise details["ctx"]["error"] from None


Placement = Annotated[Matrix | Animation, PlainValidator(_validator(FREE)), SerializeAsAny()]
"""An affine, invertible map from local to world space, or an animation of such maps."""
RigidPlacement = Annotated[Matrix | Animation, PlainValidator(_validator(RIGID)), SerializeAsAny()]
"""A rotation or reflection followed by a translation, or an animation of such maps."""
MeshName = Annotated[str | Deformation, AfterValidator(_check_keys)]
"""The file name of a mesh, or the file names of a mesh that deforms."""
