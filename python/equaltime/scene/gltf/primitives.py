"""Reads primitives of glTF meshes as indexed triangles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from equaltime.scene.gltf.accessors import floats, integers
from equaltime.scene.gltf.document import Document, Malformed

__all__ = ["TRIANGLES", "Triangles", "color", "mirrored_uvs", "triangles"]

Array = NDArray[np.float64]

FLOAT: Final = 5126
"""Value of ``componentType`` for float32."""
NAMES: Final = ("points", "lines", "line loop", "line strip", "triangles", "triangle strip", "triangle fan")
TRIANGLES: Final = frozenset({4, 5, 6})
"""Modes of primitives that have a surface: triangles, triangle strip, triangle fan."""


@dataclass(frozen=True, slots=True, eq=False)
class Triangles:
    """A triangle mesh in its own coordinates, with the field names of `equaltime._core.MeshData`."""

    vertices: Array
    """Positions (N, 3)."""
    faces: NDArray[np.uint32]
    """Indices of the corners (M, 3), counter-clockwise as seen from the front."""
    normals: Array | None
    """Vertex normals (N, 3), or None."""
    uvs: Array | None
    """Texture coordinates (N, 2), with v downwards, or None."""
    colors: Array | None
    """Vertex colours (N, 4) from COLOR_0: linear RGB and opacity; or None."""
    warnings: list[str]
    light: Array | None = None
    """Vertex radiances (N, 3), for meshes with vertex colours whose emission has no texture; or None."""

    @property
    def attributes(self) -> dict[str, Array]:
        """Vertex attributes by Mitsuba's names: colours (N, 3), opacities (N, 1) and radiances (N, 3).

        Opacities are left out if all are 1, and radiances if the vertices emit no light of their own. Without vertex
        colours, the dictionary is empty.
        """
        if self.colors is None:
            return {}
        alpha = {"vertex_alpha": self.colors[:, 3:]} if (self.colors[:, 3] != 1.0).any() else {}
        light = {} if self.light is None else {"vertex_radiance": self.light}
        return {"vertex_color": self.colors[:, :3], **alpha, **light}


def triangles(
    document: Document, mesh: int, primitive: int, uv_set: int, weights: Sequence[float] | None = None
) -> Triangles:
    """Return primitive `primitive` of mesh `mesh` as triangles.

    Texture coordinates come from the set with index `uv_set`. Morph targets are added with `weights`, or with the
    weights of the mesh if `weights` is None. A primitive without normals keeps None as normals; its shape has flat
    faces, as the specification requires. Raises `Malformed` if the data is not valid.
    """
    if weights is None:
        weights = document.gltf.meshes[mesh].weights or ()
    source = document.gltf.meshes[mesh].primitives[primitive]
    attributes, place = vars(source.attributes), f"meshes[{mesh}].primitives[{primitive}]"
    vertices = _positions(document, mesh, primitive, weights)
    warnings: list[str] = []
    indices = _indices(document, source, len(vertices), place)
    faces = _faces(indices, source.mode, place, warnings)
    normals, uvs = attributes.get("NORMAL"), attributes.get(f"TEXCOORD_{uv_set}")
    result = Triangles(
        vertices,
        faces,
        None
        if normals is None
        else _finite(
            _morphed(document, mesh, source, weights, "NORMAL", floats(document, normals, "VEC3")),
            f"{place}: {{}} normals are not finite: those of the faces around are taken",
            warnings,
        ),
        None
        if uvs is None
        else _finite(
            floats(document, uvs, "VEC2"),
            f"{place}: {{}} texture coordinates are not finite: (0, 0) is taken",
            warnings,
        ),
        color(document, source, warnings, place),
        warnings,
    )
    for name, values in (("NORMAL", result.normals), (f"TEXCOORD_{uv_set}", result.uvs), ("COLOR_0", result.colors)):
        if values is not None and len(values) != len(vertices):
            message = f"has {len(values)} values for {len(vertices)} positions"
            raise Malformed((f"{place}.attributes.{name}", message))
    return result


def _finite(values: Array, message: str, warnings: list[str]) -> Array:
    """Return the values (N, K) with zeros in rows that are not finite; a warning counts these rows."""
    wrong = np.flatnonzero(~np.isfinite(values).all(axis=1))
    if not wrong.size:
        return values
    warnings.append(message.format(wrong.size))
    mended = values.copy()
    mended[wrong] = 0.0
    return mended


def _positions(document: Document, mesh: int, primitive: int, weights: Sequence[float]) -> Array:
    """Return the vertices (N, 3) of a primitive, with morph targets added; raises `Malformed`."""
    source = document.gltf.meshes[mesh].primitives[primitive]
    index = vars(source.attributes).get("POSITION")
    if index is None:
        raise Malformed((f"meshes[{mesh}].primitives[{primitive}].attributes", "needs 'POSITION'"))
    return _morphed(document, mesh, source, weights, "POSITION", floats(document, index, "VEC3"))


def mirrored_uvs(mesh: Triangles) -> NDArray[np.bool_]:
    """Return one boolean per triangle (M,): True if a texture appears mirrored, as seen from the front.

    The corners are drawn in a plane with u to the right and v upwards. Unmirrored triangles then run clockwise, because
    v points downwards in glTF. Without texture coordinates, all are False.
    """
    if mesh.uvs is None:
        return np.zeros(len(mesh.faces), np.bool_)
    a, b, c = np.moveaxis(mesh.uvs[mesh.faces], 1, 0)
    (u1, v1), (u2, v2) = (b - a).T, (c - a).T
    mirrored: NDArray[np.bool_] = u1 * v2 > u2 * v1
    return mirrored


def color(document: Document, primitive: Any, warnings: list[str], place: str) -> Array | None:
    """Return the vertex colours and opacities (N, 4) of a primitive, in [0, 1], or None without COLOR_0.

    The opacity is 1 if the file has none. Changes to values are reported in `warnings`, with the primitive's path
    `place` in the JSON. Integers that are not normalised raise `Malformed`, because their value for white is not
    defined.
    """
    index = vars(primitive.attributes).get("COLOR_0")
    if index is None:
        return None
    accessor = document.gltf.accessors[index]
    if accessor.componentType != FLOAT and not accessor.normalized:
        expected = "expected true for colours in whole numbers, or numbers of type 5126 (float)"
        raise Malformed((f"accessors[{index}].normalized", expected))
    values = floats(document, index, "VEC3", "VEC4")
    values = _finite(values, f"{place}: {{}} colours are not finite: black is taken", warnings)
    if beyond := int(((values < 0.0) | (values > 1.0)).any(axis=1).sum()):
        reach = f"they reach from {values.min():g} to {values.max():g}"
        warnings.append(f"{place}: {beyond} colours are cut to [0, 1]; {reach}")
    values = np.clip(values, 0.0, 1.0)
    return values if values.shape[1] == 4 else np.column_stack([values, np.ones(len(values))])


def _morphed(
    document: Document, mesh: int, primitive: Any, weights: Sequence[float], name: str, values: Array
) -> Array:
    """Return the values with the morph targets of a primitive added by their weights."""
    for weight, target in zip(weights, primitive.targets or (), strict=False):
        index = vars(target).get(name)
        if weight and index is not None:
            moved = floats(document, index, "VEC3")
            if moved.shape != values.shape:
                message = f"a morph target has {len(moved)} values for {len(values)} vertices"
                raise Malformed((f"meshes[{mesh}]", message))
            values = values + weight * moved
    return values


def _indices(document: Document, primitive: Any, count: int, place: str) -> NDArray[np.uint32]:
    if primitive.indices is None:
        return np.arange(count, dtype=np.uint32)
    indices = integers(document, primitive.indices, "SCALAR")[:, 0]
    if len(indices) and int(indices.max()) >= count:
        wrong = int(np.flatnonzero(indices >= count)[0])
        message = f"index {wrong} names vertex {indices[wrong]}, but there are {count}"
        raise Malformed((f"{place}.indices", message))
    return indices


def _faces(indices: NDArray[np.uint32], mode: int, place: str, warnings: list[str]) -> NDArray[np.uint32]:
    """Return the triangles (M, 3) of a list, strip or fan, with the winding that the specification gives."""
    if mode not in TRIANGLES:
        raise Malformed((place, f"{NAMES[mode]} have no surface"))
    if mode == 4:
        if extra := len(indices) % 3:
            warnings.append(f"{place}: {extra} of its {len(indices)} indices make no triangle")
        return np.ascontiguousarray(indices[: len(indices) - extra].reshape(-1, 3))
    if len(indices) < 3:
        return np.empty((0, 3), np.uint32)
    if mode == 6:
        return np.column_stack([indices[1:-1], indices[2:], np.broadcast_to(indices[0], len(indices) - 2)])
    faces = np.column_stack([indices[:-2], indices[1:-1], indices[2:]])
    faces[1::2] = faces[1::2][:, [0, 2, 1]]
    return faces
