"""The scene as lint checks it: one surface per shape, with vertices rounded as in the core."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray

from equaltime.errors import Problem, SceneError
from equaltime.scene.geometry import MeshSurface, QuadSurface, Surface, bounds, surface
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

__all__ = ["LintScene", "Part", "leaves", "lets_light_through"]

Array = NDArray[np.float64]
Hashes = NDArray[np.uint64]

FAST_TRIANGLES: Final = 10_000
"""Number of triangles that a fast check processes in total; further meshes are skipped."""


@dataclass(eq=False)
class Part:
    """The surface of one shape of the scene, with the shape's name, for the checks of lint."""

    shape: Solid
    name: Name
    surface: Surface
    grouped: bool
    """True if the shape is part of a group; the surface is then in the group's own space."""
    origin: Array | None = None
    """Point (3,) that is subtracted from the vertices before rounding; set by `LintScene.parts`."""

    @cached_property
    def mesh(self) -> MeshSurface | None:
        """Triangles of the surface, in the scene's units; None for an analytic surface."""
        if isinstance(self.surface, QuadSurface):
            return self.surface.mesh()
        return self.surface if isinstance(self.surface, MeshSurface) else None

    @cached_property
    def points(self) -> NDArray[np.float32]:
        """Vertices (N, 3) less `origin`, then rounded to float32: the numbers that the core computes with."""
        assert self.mesh is not None
        assert self.origin is not None
        with np.errstate(over="ignore"):
            return (self.mesh.vertices - self.origin).astype(np.float32) + np.float32(0.0)  # turns -0 into +0

    @cached_property
    def bounds(self) -> Array:
        """Bounding box (2, 3): lower and upper corner, in the scene's units."""
        return bounds(self.surface)

    @property
    def extent(self) -> float:
        """Longest side of the bounding box, in the scene's units."""
        return float((self.bounds[1] - self.bounds[0]).max())

    @property
    def one_sided(self) -> bool:
        """True if exactly one side of the surface absorbs all light.

        Also True if the front emits light and absorbs all incident light.
        """
        sides = self.surface.sides
        return (sides.front is None) != (sides.back is None) or (sides.front is None and sides.radiance is not None)

    @property
    def refracts(self) -> bool:
        """True if the surface is a refracting interface, such as clear glass.

        A refracting surface should belong to a closed shape.
        """
        return any(
            (isinstance(leaf, Dielectric) and not isinstance(leaf, ThinDielectric) and leaf.int_ior != leaf.ext_ior)
            or (isinstance(leaf, Principled) and leaf.transmits)
            for leaf in leaves(self.shape.bsdf)
        )


class LintScene:
    """A scene as lint checks it: its surfaces in world space, camera position and names for findings.

    Meshes are transformed to world space at the first use.
    """

    def __init__(self, scene: Scene, *, fast: bool = False) -> None:
        self.scene = scene
        self.names = Names(scene)
        self.camera = as_array(poses(scene.model.sensor.to_world)[0])[:3, 3]
        self.fast = fast
        self.skipped = 0
        """Number of meshes that were skipped to save time."""

    def called(self, node: Plugin) -> str:
        """Return the name of `node` for findings, with its position in the scene file.

        The node can be any object of the scene except a shape.
        """
        return str(Name.of(node, self.scene.place_of(node)))

    @cached_property
    def parts(self) -> tuple[Part, ...]:
        """Surfaces of all shapes, each once. Surfaces of shape groups come last.

        A fast check skips meshes after `FAST_TRIANGLES` triangles, and counts the skipped meshes in `skipped`.
        """
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
        """All surfaces in `parts` that consist of triangles."""
        return tuple(part for part in self.parts if part.mesh is not None)


def lets_light_through(part: Part) -> bool:
    """Tell whether the BSDF of the surface `part` lets light through."""
    return part.shape.bsdf is not None and part.shape.bsdf.transmits


def leaves(bsdf: Bsdf | None) -> Iterator[Bsdf]:
    """Iterate over the innermost BSDFs inside `bsdf`, such as the two BSDFs of a blend.

    A BSDF without nested BSDFs yields itself, and None yields no BSDF.
    """
    if bsdf is None:
        return
    inner = getattr(bsdf, "bsdf", None)
    if inner is None:
        yield bsdf
    for part in inner if isinstance(inner, tuple) else () if inner is None else (inner,):
        yield from leaves(part)
