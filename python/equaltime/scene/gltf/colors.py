"""Colours of vertices as a bitmap: four texels a triangle, whose bilinear interpolation is linear over the triangle.

The texels of a triangle hold its corners a, b, c and b + c - a, so that what is between their centres is exactly the
interpolated colour. The texture coordinates of its corners are the centres of the first three.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from equaltime.scene.gltf.primitives import Triangles
from equaltime.scene.gltf.slots import Texels

__all__ = ["color_texels", "with_color_uvs"]


def with_color_uvs(mesh: Triangles) -> Triangles:
    """Return the mesh with three vertices of its own for each triangle, and texture coordinates for `color_texels`."""
    corners = mesh.faces.reshape(-1)
    first, side = _blocks(len(mesh.faces))
    places = first[:, None, :] + np.array([[0.5, 0.5], [1.5, 0.5], [0.5, 1.5]])
    return replace(
        mesh,
        vertices=mesh.vertices[corners],
        faces=np.arange(len(corners), dtype=np.uint32).reshape(-1, 3),
        normals=None if mesh.normals is None else mesh.normals[corners],
        uvs=places.reshape(-1, 2) / side,
        colors=None,
    )


def color_texels(mesh: Triangles) -> Texels:
    """Return the bitmap (side, side, 3) of the colours of a mesh that has some."""
    assert mesh.colors is not None, "only meshes with colours are asked for them"
    a, b, c = np.moveaxis(mesh.colors[mesh.faces, :3], 1, 0)
    first, side = _blocks(len(mesh.faces))
    x, y = first.T
    texels = np.zeros((side, side, 3), np.float32)
    texels[y, x], texels[y, x + 1], texels[y + 1, x], texels[y + 1, x + 1] = a, b, c, b + c - a
    return Texels(texels, False)


def _blocks(count: int) -> tuple[NDArray[np.intp], int]:
    """Return the first texel (x, y) of each of `count` triangles (count, 2), and the side of a square for them all."""
    columns = math.isqrt(max(count, 1) - 1) + 1
    index = np.arange(count)
    return np.column_stack([index % columns, index // columns]) * 2, 2 * columns
