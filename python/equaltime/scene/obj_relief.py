"""The pictures of the word ``bump`` in MTL files: heights, or normals, which some exporters write under this word.

Normals are in tangent space. Red leans along u. Green leans along v, which points upwards in the picture.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Final, Literal

import numpy as np

from equaltime.scene.mesh_readers import MeshData
from equaltime.scene.pictures import largest, read_picture

__all__ = ["Content", "content_of", "is_mirrored"]

Content = Literal["grey", "normals", "colours"]
_SAMPLES: Final = 256
"""Largest number of rows and of columns of texels that are examined to tell normals from other colours."""
_SHARE: Final = 0.75
"""Fraction of the coloured texels that must be unit normals in a picture of normals."""


def content_of(path: Path) -> Content:
    """Return the kind of a picture's content: ``grey`` (heights), ``normals``, or else ``colours``.

    An unreadable picture counts as ``grey``. It is refused later, when the scene's pictures are read.
    """
    try:
        texels = read_picture(path, raw=True).texels
    except ValueError:
        return "grey"
    if texels.shape[2] == 1 or all((texels[..., 0] == texels[..., channel]).all() for channel in (1, 2)):
        return "grey"
    rows, columns = (math.ceil(size / _SAMPLES) for size in texels.shape[:2])
    few = texels[::rows, ::columns].astype(np.float64) / largest(texels)
    vectors = 2.0 * few[(few != few[..., :1]).any(axis=2)] - 1.0
    normals = (np.abs(np.linalg.norm(vectors, axis=1) - 1.0) < 0.1) & (vectors[:, 2] > 0.0)
    return "normals" if np.count_nonzero(normals) > _SHARE * len(vectors) else "colours"


def is_mirrored(mesh: MeshData) -> bool:
    """Tell whether any face of a mesh, seen from its front, shows the image mirrored.

    The mesh must have texture coordinates, with v upwards in the image.
    """
    assert mesh.uvs is not None, "only what has uvs has an image"
    a, b, c = np.moveaxis(mesh.uvs[mesh.faces], 1, 0)
    (u1, v1), (u2, v2) = (b - a).T, (c - a).T
    return bool((u1 * v2 < u2 * v1).any())
