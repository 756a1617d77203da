"""Reads primitives of glTF meshes as indexed triangles: as stored, or deformed, with the material's factors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray

from equaltime.scene.gltf.accessors import floats, integers
from equaltime.scene.gltf.document import Document, Malformed
from equaltime.scene.gltf.poses import Pose, skinned
from equaltime.scene.gltf.surfaces import SurfaceLook, look

__all__ = ["TRIANGLES", "Source", "Triangles", "box", "color", "mirrored_uvs", "read", "triangles"]

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
    """Return primitive `primitive` of mesh `mesh` of `document` as triangles.

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
    """Return one boolean per triangle of `mesh`, (M,): True if a texture appears mirrored, as seen from the front.

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


@dataclass(frozen=True, slots=True)
class Source:
    """Address of a primitive: the index of a mesh, or of a node that deforms a mesh, and the primitive's number in it.

    The vertices are in the coordinates of the mesh, or in world space if the node has a skin.
    """

    owner: Literal["meshes", "nodes"]
    index: int
    primitive: int

    def __str__(self) -> str:
        return f"/{self.owner}/{self.index}/primitives/{self.primitive}"


def read(pose: Pose, source: Source) -> Triangles | None:
    """Return the primitive at `source` as triangles, deformed as in `pose`, or None if there is no such primitive.

    Vertex colours are multiplied by the material's constant base colour, and vertex opacities by the constant opacity.
    If a texture gives the base colour or the opacity, the bitmap of that texture includes the constant factor. If the
    material has textures and the primitive lacks their texture coordinates, these are (0, 0). Raises `Malformed` if the
    data is not valid.
    """
    document, mesh = pose.document, _mesh(pose.document, source)
    gltf = document.gltf
    if mesh is None or source.primitive >= len(gltf.meshes[mesh].primitives):
        return None
    primitive = gltf.meshes[mesh].primitives[source.primitive]
    seen = look(None if primitive.material is None else gltf.materials[primitive.material])
    node = source.index if source.owner == "nodes" else None
    found = triangles(document, mesh, source.primitive, seen.uv_set, pose.weights(mesh, node))
    if node is not None and gltf.nodes[node].skin is not None:
        vertices, normals = skinned(pose, node, primitive, found.vertices, found.normals, found.warnings)
        found = replace(found, vertices=vertices, normals=normals)
    if found.uvs is None and seen.textured:
        found = replace(found, uvs=np.zeros((len(found.vertices), 2)))
    return found if found.colors is None else _colored(found, found.colors, seen)


def _colored(found: Triangles, colors: Array, seen: SurfaceLook) -> Triangles:
    """Return a primitive with its colours (N, 4) times the material's constant factors, and with its emission."""
    base, alpha, light = (seen.slots.get(name) for name in ("base_color", "alpha", "radiance"))
    color = base.factor if base is not None and base.texture is None else (1.0, 1.0, 1.0)
    opacity = alpha.factor if alpha is not None and alpha.texture is None else (1.0,)
    tinted = colors * (*color, *opacity)
    if light is None or light.texture is not None:
        return replace(found, colors=tinted)
    shown = colors[:, :3] if seen.unlit else np.ones((len(colors), 3))
    if alpha is not None:
        cutoff = seen.slots["opacity"].cutoff
        shown = shown * (colors[:, 3:] if cutoff is None else tinted[:, 3:] >= cutoff)
    return replace(found, colors=tinted, light=shown * light.factor)


def _mesh(document: Document, source: Source) -> int | None:
    """Return the index of the mesh that a primitive belongs to, if there is one."""
    gltf, index = document.gltf, source.index
    if source.owner == "meshes":
        return index if index < len(gltf.meshes) else None
    mesh: int | None = gltf.nodes[index].mesh if index < len(gltf.nodes) else None
    return mesh


def box(document: Document, source: Source) -> Array | None:
    """Return the corners (8, 3) of the bounding box of the primitive at `source` in `document`.

    Returns None if the primitive cannot be read or has no finite vertices.
    """
    try:
        found = read(Pose(document), source)
    except ValueError:  # reported where the mesh itself is read
        return None
    vertices = np.empty((0, 3)) if found is None else found.vertices[np.unique(found.faces)]
    vertices = vertices[np.isfinite(vertices).all(axis=1)]
    if len(vertices) == 0:
        return None
    ends = np.array([vertices.min(axis=0), vertices.max(axis=0)])
    return np.array([[ends[i, 0], ends[j, 1], ends[k, 2]] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
