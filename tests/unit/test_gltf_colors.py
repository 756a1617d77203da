"""Colours of vertices in glTF files."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from equaltime.scene import model as m
from equaltime.scene.geometry import MeshSurface

from .gltf_files import Builder
from .gltf_materials import bsdf, loaded, texels, textured, warnings


def test_vertex_colours_are_multiplied_by_the_factor_and_interpolated(tmp_path: Path) -> None:
    """Between the corners of a triangle the bitmap's bilinear interpolation is linear."""
    builder = Builder()
    points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]]
    given = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 0]], np.float64)
    material = builder.add("materials", {"pbrMetallicRoughness": {"baseColorFactor": [0.5, 1, 1, 1]}})
    builder.node(mesh=builder.mesh(points, indices=[0, 1, 2, 2, 1, 3], material=material, COLOR_0=given))
    scene = loaded(builder, tmp_path)
    found = scene.model.shapes[0].bsdf
    assert isinstance(found, m.Principled)
    texels_ = texels(found.base_color, tmp_path).texels
    surface = next(scene.surfaces())
    assert isinstance(surface, MeshSurface)
    assert surface.uvs is not None
    for face, corners in zip(surface.faces, ([0, 1, 2], [2, 1, 3]), strict=True):
        assert np.allclose(surface.vertices[face], np.array(points)[corners])
        for share in ([1, 0, 0], [0, 1, 0], [0, 0, 1], [0.2, 0.3, 0.5]):
            expected = share @ given[corners] * (0.5, 1, 1)
            assert bilinear(texels_, share @ surface.uvs[face]) == pytest.approx(expected, abs=1e-6)


def bilinear(image: NDArray[np.float32], uv: NDArray[np.float64]) -> NDArray[np.float64]:
    x, y = uv * image.shape[0] - 0.5
    i, j = int(np.floor(x + 1e-9)), int(np.floor(y + 1e-9))
    s, t, last = x - i, y - j, image.shape[0] - 1
    rows = [image[k, i].astype(np.float64) * (1 - s) + image[k, min(i + 1, last)] * s for k in (j, min(j + 1, last))]
    return rows[0] * (1 - t) + rows[1] * t


def test_vertex_colours_give_way_to_textures(tmp_path: Path) -> None:
    builder = textured(np.zeros((1, 1, 3), np.uint8), tmp_path, pbrMetallicRoughness={"baseColorTexture": {"index": 0}})
    colors = builder.accessor([[1, 0, 0]] * 3)
    builder.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = colors
    assert "COLOR_0 is not used where the material has textures (meshes[0].primitives[0])" in warnings(
        builder, tmp_path
    )


def test_white_vertices_change_nothing(tmp_path: Path) -> None:
    builder = Builder()
    builder.node(mesh=builder.mesh(COLOR_0=[[1, 1, 1, 1]] * 3))
    assert bsdf(builder, tmp_path).base_color == (1, 1, 1)  # type: ignore[union-attr]
