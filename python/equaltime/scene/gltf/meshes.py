"""Reads primitives of a glTF file as triangles, deformed, with the texture coordinates that the material uses."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from equaltime.scene.gltf.document import Document
from equaltime.scene.gltf.poses import Pose
from equaltime.scene.gltf.primitives import Triangles, triangles
from equaltime.scene.gltf.skins import skinned
from equaltime.scene.gltf.surfaces import SurfaceLook, look

__all__ = ["Source", "box", "read"]


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
    """Return a primitive as triangles, deformed as in `pose`, or None if the primitive does not exist.

    Vertex colours are multiplied by the material's constant base colour, and vertex opacities by the constant opacity.
    If a texture gives the base colour or the opacity, the bitmap of that texture includes the constant factor. Raises
    `Malformed` if the data is not valid.
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
        vertices, normals = skinned(pose, node, primitive, found.vertices, found.normals)
        found = replace(found, vertices=vertices, normals=normals)
    return found if found.colors is None else _colored(found, found.colors, seen)


def _colored(found: Triangles, colors: NDArray[np.float64], seen: SurfaceLook) -> Triangles:
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


def box(document: Document, source: Source) -> NDArray[np.float64] | None:
    """Return the corners (8, 3) of the bounding box of a primitive's triangles.

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
