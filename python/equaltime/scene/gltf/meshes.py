"""The primitives of a document as their shapes need them: with their material's texture coordinates, skinned."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from equaltime.scene.gltf.document import Document
from equaltime.scene.gltf.primitives import Triangles, triangles
from equaltime.scene.gltf.skins import skinned
from equaltime.scene.gltf.surfaces import look

__all__ = ["Source", "box", "read"]


@dataclass(frozen=True, slots=True)
class Source:
    """Where a primitive comes from: a mesh, in its own coordinates, or a node with a skin, in the world."""

    owner: Literal["meshes", "nodes"]
    index: int
    primitive: int

    def __str__(self) -> str:
        return f"/{self.owner}/{self.index}/primitives/{self.primitive}"


def read(document: Document, source: Source) -> Triangles | None:
    """Return a primitive, or None if there is none; raises `Malformed`.

    Colours of vertices are multiplied by the base colour of the material, unless that is a texture, which has it.
    """
    gltf, mesh = document.gltf, _mesh(document, source)
    if mesh is None or source.primitive >= len(gltf.meshes[mesh].primitives):
        return None
    primitive = gltf.meshes[mesh].primitives[source.primitive]
    seen = look(None if primitive.material is None else gltf.materials[primitive.material])
    found = triangles(document, mesh, source.primitive, seen.uv_set)
    if source.owner == "nodes":
        vertices, normals = skinned(document, source.index, primitive, found.vertices, found.normals)
        found = replace(found, vertices=vertices, normals=normals)
    if found.colors is not None and seen.slots["base_color"].texture is None:
        found = replace(found, colors=found.colors * (*seen.slots["base_color"].factor, 1.0))
    return found


def _mesh(document: Document, source: Source) -> int | None:
    """Return the index of the mesh that a primitive belongs to, if there is one."""
    gltf, index = document.gltf, source.index
    if source.owner == "meshes":
        return index if index < len(gltf.meshes) else None
    node = gltf.nodes[index] if index < len(gltf.nodes) else None
    return None if node is None or node.skin is None else node.mesh


def box(document: Document, source: Source) -> NDArray[np.float64] | None:
    """Return the corners (8, 3) of the box around a primitive, or None if it cannot be told."""
    try:
        found = read(document, source)
    except ValueError:  # told where the mesh itself is read
        return None
    vertices = np.empty((0, 3)) if found is None else found.vertices[np.isfinite(found.vertices).all(axis=1)]
    if len(vertices) == 0:
        return None
    ends = np.array([vertices.min(axis=0), vertices.max(axis=0)])
    return np.array([[ends[i, 0], ends[j, 1], ends[k, 2]] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
