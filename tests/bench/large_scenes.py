"""Scenes too large to ship: generated meshes as binary PLY, with a scene file round them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

TERRAIN = """
[integrator]
type = "path"
max_depth = 8

[sensor]
type = "perspective"
fov = 45
to_world = [{ look_at = { origin = [0, -1.7, 1.1], target = [0, 0, 0], up = [0, 0, 1] } }]
film = { type = "hdrfilm", width = 256, height = 256, rfilter = { type = "box" } }

[terrain]
type = "ply"
filename = "terrain.ply"
face_normals = true
bsdf = { type = "twosided", bsdf = { type = "diffuse", reflectance = [0.7, 0.6, 0.5] } }

[lamp]
type = "rectangle"
to_world = [{ scale = 0.3 }, { look_at = { origin = [1, 1, 2], target = [0, 0, 0], up = [0, 0, 1] } }]
emitter = { type = "area", radiance = 20 }

[sky]
type = "constant"
radiance = [0.3, 0.4, 0.6]
"""


def write_terrain(folder: Path, triangles: int) -> Path:
    """Write a rugged square of about so many triangles under a lamp and a sky; return the scene file."""
    write_ply(folder / "terrain.ply", *heightfield(triangles))
    scene = folder / "terrain.toml"
    scene.write_text(TERRAIN)
    return scene


def heightfield(triangles: int) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
    """Return vertices (N, 3) over [-1, 1]² and faces (M, 3): noise of many wavelengths, each as steep as the next."""
    side = max(2, round((triangles / 2) ** 0.5) + 1)
    x, y = np.meshgrid(*[np.linspace(-1.0, 1.0, side)] * 2)
    random, z = np.random.default_rng(0), np.zeros_like(x)
    for octave in range(12):
        angle, phase = random.uniform(0.0, 2 * np.pi, 2)
        frequency = 3.0 * 1.6**octave
        z += 0.9 / frequency * np.sin(frequency * (np.cos(angle) * x + np.sin(angle) * y) + phase)
    first = (np.arange(side - 1)[:, None] * side + np.arange(side - 1)).ravel()
    quads = np.stack([first, first + 1, first + side + 1, first + side], axis=1).astype(np.int32)
    faces = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]], axis=1).reshape(-1, 3)
    return np.stack([x, y, z], axis=-1).reshape(-1, 3).astype(np.float32), faces


def write_ply(path: Path, vertices: NDArray[np.float32], faces: NDArray[np.int32]) -> None:
    """Write a binary PLY as most programs do: float x, y, z, and lists of int32 with a length of one byte."""
    header = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {len(vertices)}\n"
        "property float x\nproperty float y\nproperty float z\n"
        f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    records = np.empty(len(faces), [("count", "u1"), ("indices", "<i4", (3,))])
    records["count"], records["indices"] = 3, faces
    with path.open("wb") as file:
        file.write(header.encode())
        file.write(vertices.astype("<f4").tobytes())
        file.write(records.tobytes())
