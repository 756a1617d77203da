"""Colours of vertices in glTF files."""

from pathlib import Path

import numpy as np
import pytest

from equaltime.scene import model as m
from equaltime.scene.geometry import MeshSurface

from .gltf_files import Builder
from .gltf_materials import bsdf, loaded, texels, textured

POINTS = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]]
COLORS = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 0]], np.float64)


def test_vertex_colours_are_multiplied_by_the_factor(tmp_path: Path) -> None:
    builder = Builder()
    material = builder.add("materials", {"pbrMetallicRoughness": {"baseColorFactor": [0.5, 1, 1, 1]}})
    builder.node(mesh=builder.mesh(POINTS, indices=[0, 1, 2, 2, 1, 3], material=material, COLOR_0=COLORS))
    scene = loaded(builder, tmp_path)
    found = scene.model.shapes[0].bsdf
    assert isinstance(found, m.Principled)
    assert found.base_color == m.MeshAttribute(name="vertex_color")
    surface = next(scene.surfaces())
    assert isinstance(surface, MeshSurface)
    assert surface.attributes["vertex_color"] == pytest.approx(COLORS * (0.5, 1, 1))


def test_vertex_colours_are_multiplied_by_a_texture(tmp_path: Path) -> None:
    """Which has the factor in it."""
    pbr = {"baseColorTexture": {"index": 0}, "baseColorFactor": [0.5, 0.5, 0.5, 1]}
    builder = textured(np.full((1, 1, 3), 255, np.uint8), tmp_path, pbrMetallicRoughness=pbr)
    colors = builder.accessor([[1, 0.5, 0.25]] * 3)
    builder.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = colors
    scene = loaded(builder, tmp_path)
    found = scene.model.shapes[0].bsdf
    assert isinstance(found, m.Principled)
    assert isinstance(found.base_color, m.MeshAttribute)
    assert float(texels(found.base_color.times, tmp_path).texels.max()) < 255
    surface = next(scene.surfaces())
    assert isinstance(surface, MeshSurface)
    assert surface.attributes["vertex_color"] == pytest.approx(np.array([[1, 0.5, 0.25]] * 3))
    assert scene.core.triangles == 1


def test_white_vertices_change_nothing(tmp_path: Path) -> None:
    builder = Builder()
    builder.node(mesh=builder.mesh(COLOR_0=[[1, 1, 1, 1]] * 3))
    assert bsdf(builder, tmp_path).base_color == (1, 1, 1)  # type: ignore[union-attr]


def test_unlit_vertices_shine_in_their_colours(tmp_path: Path) -> None:
    builder = Builder()
    unlit = {"pbrMetallicRoughness": {"baseColorFactor": [0.5, 1, 1, 1]}, "extensions": {"KHR_materials_unlit": {}}}
    material = builder.add("materials", unlit)
    builder.node(mesh=builder.mesh(POINTS, indices=[0, 1, 2, 2, 1, 3], material=material, COLOR_0=COLORS))
    scene = loaded(builder, tmp_path)
    (shape,) = scene.model.shapes
    assert shape.emitter is not None
    assert shape.emitter.radiance == m.MeshAttribute(name="vertex_color")
    surface = next(scene.surfaces())
    assert isinstance(surface, MeshSurface)
    assert surface.attributes["vertex_color"] == pytest.approx(COLORS * (0.5, 1, 1))
    assert scene.core.triangles == 2


def test_of_unlit_vertices_with_a_texture_the_colours_are_told_to_be_left_out(tmp_path: Path) -> None:
    material = {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}, "extensions": {"KHR_materials_unlit": {}}}
    builder = textured(np.full((1, 1, 3), 255, np.uint8), tmp_path, **material)
    builder.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = builder.accessor([[1, 0.5, 0.25]] * 3)
    assert any("colours of vertices are not used" in told for told in loaded(builder, tmp_path).warnings)
