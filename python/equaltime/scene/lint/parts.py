"""The scene as lint looks at it: surfaces as they are rendered, with vertices rounded as in the core."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray

from equaltime.errors import Problem, SceneError
from equaltime.scene.extents import bounds
from equaltime.scene.geometry import MeshSurface, QuadSurface, Surface, surface
from equaltime.scene.model import (
    Bsdf,
    Dielectric,
    MeshFile,
    Plugin,
    Principled,
    Solid,
    ThinDielectric,
    as_array,
    poses,
)
from equaltime.scene.naming import Name, Names
from equaltime.scene.scene import Scene

__all__ = ["Part", "World", "leaves", "lets_light_through"]

Array = NDArray[np.float64]
Hashes = NDArray[np.uint64]

FAST_TRIANGLES: Final = 10_000
"""Number of triangles that a fast check looks at in total; further meshes are skipped."""


@dataclass(eq=False)
class Part:
    """One surface of the scene."""

    shape: Solid
    name: Name
    surface: Surface
    grouped: bool
    """Whether the surface is part of a group, in whose own space it stands."""
    origin: Array | None = None
    """Point that is moved to 0 before vertices are rounded; see `World.parts`."""

    @cached_property
    def mesh(self) -> MeshSurface | None:
        """The surface's triangles, in the scene's units, or None."""
        if isinstance(self.surface, QuadSurface):
            return self.surface.mesh()
        return self.surface if isinstance(self.surface, MeshSurface) else None

    @cached_property
    def points(self) -> NDArray[np.float32]:
        """The vertices (N, 3) as the core rounds them."""
        assert self.mesh is not None
        assert self.origin is not None
        with np.errstate(over="ignore"):
            return (self.mesh.vertices - self.origin).astype(np.float32) + np.float32(0.0)  # turns -0 into +0

    @cached_property
    def bounds(self) -> Array:
        """The lower and the upper corner, in the scene's units."""
        return bounds(self.surface)

    @property
    def extent(self) -> float:
        """The longest side of the bounds."""
        return float((self.bounds[1] - self.bounds[0]).max())

    @property
    def one_sided(self) -> bool:
        """Whether only one side absorbs everything; a black front that emits counts too."""
        sides = self.surface.sides
        return (sides.front is None) != (sides.back is None) or (sides.front is None and sides.radiance is not None)

    @property
    def refracts(self) -> bool:
        """Whether the surface is an interface between two media, which must close to have an inside."""
        return any(
            (isinstance(leaf, Dielectric) and not isinstance(leaf, ThinDielectric) and leaf.int_ior != leaf.ext_ior)
            or (isinstance(leaf, Principled) and leaf.transmits)
            for leaf in leaves(self.shape.bsdf)
        )


class World:
    """The scene for lint; its meshes are placed when first needed."""

    def __init__(self, scene: Scene, *, fast: bool = False) -> None:
        self.scene = scene
        self.names = Names(scene)
        self.camera = as_array(poses(scene.model.sensor.to_world)[0])[:3, 3]
        self.fast = fast
        self.skipped = 0
        """Number of meshes that were skipped to save time."""

    def called(self, node: Plugin) -> str:
        """Return the words by which a finding names `node`, which is any part of the scene but a shape."""
        return str(Name(node.id, node.title, self.scene.place_of(node)))

    @cached_property
    def parts(self) -> tuple[Part, ...]:
        """All surfaces, each once; surfaces of groups come last."""
        parts = tuple(self._surfaces())
        corners = np.array([part.bounds for part in parts if not part.grouped]).reshape(-1, 3)
        origin = np.clip(self.camera, corners.min(axis=0), corners.max(axis=0)) if len(corners) else self.camera
        for part in parts:
            part.origin = part.bounds.mean(axis=0) if part.grouped else origin
        return parts

    def _surfaces(self) -> Iterator[Part]:
        budget = FAST_TRIANGLES
        for shape, name, grouped in self.names.solids():
            if isinstance(shape, MeshFile):
                data = self.scene.assets.mesh(shape)
                if self.fast and (budget := budget - len(data.faces)) < 0:
                    self.skipped += 1
                    continue
                flat = shape if data.normals is not None else shape.replace(face_normals=True)  # avoids making normals
                yield Part(shape, name, self._surface(shape, flat), grouped)
            else:
                yield Part(shape, name, self._surface(shape, shape), grouped)

    def _surface(self, shape: Solid, looked_at: Solid) -> Surface:
        """Return the surface of `looked_at`; raises SceneError, with the place of `shape`, if it cannot be placed."""
        try:
            return surface(looked_at, self.scene.assets)
        except ValueError as error:
            raise SceneError((Problem(self.scene.place_of(shape), str(error)),)) from error

    @cached_property
    def meshes(self) -> tuple[Part, ...]:
        """The surfaces that are made of triangles."""
        return tuple(part for part in self.parts if part.mesh is not None)


def lets_light_through(part: Part) -> bool:
    """Tell whether any light passes the surface."""
    return part.shape.bsdf is not None and part.shape.bsdf.transmits


def leaves(bsdf: Bsdf | None) -> Iterator[Bsdf]:
    """Iterate over the BSDFs in `bsdf` that wrap no other."""
    if bsdf is None:
        return
    inner = getattr(bsdf, "bsdf", None)
    if inner is None:
        yield bsdf
    for part in inner if isinstance(inner, tuple) else () if inner is None else (inner,):
        yield from leaves(part)
