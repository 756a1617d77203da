"""Colours of vertices in glTF files."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import equaltime as et
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
    assert shape.emitter.radiance == m.MeshAttribute(name="vertex_radiance")
    surface = next(scene.surfaces())
    assert isinstance(surface, MeshSurface)
    assert surface.attributes["vertex_radiance"] == pytest.approx(COLORS * (0.5, 1, 1))
    assert scene.core.triangles == 2


def test_of_unlit_vertices_with_a_texture_the_colours_are_told_to_be_left_out(tmp_path: Path) -> None:
    material = {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}, "extensions": {"KHR_materials_unlit": {}}}
    builder = textured(np.full((1, 1, 3), 255, np.uint8), tmp_path, **material)
    builder.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = builder.accessor([[1, 0.5, 0.25]] * 3)
    assert any("colours of vertices are not used" in told for told in loaded(builder, tmp_path).warnings)


# -- opacity of vertices ----------------------------------------------------------------------------------------------

ALPHAS = np.array([1.0, 0.25, 0.5, 0.75])
RGBA = np.column_stack([COLORS, ALPHAS])


def faded(mode: str, colors: np.ndarray = RGBA, **material: Any) -> Builder:
    builder = Builder()
    index = builder.add("materials", {"alphaMode": mode, **material})
    builder.node(mesh=builder.mesh(POINTS, indices=[0, 1, 2, 2, 1, 3], material=index, COLOR_0=colors))
    return builder


def attributes(builder: Builder, folder: Path) -> dict[str, NDArray[np.float64]]:
    surface = next(loaded(builder, folder).surfaces())
    assert isinstance(surface, MeshSurface)
    return {**surface.attributes}


@pytest.mark.parametrize(("mode", "cutoff"), [("BLEND", None), ("MASK", 0.375)])
def test_the_opacity_of_vertices_is_multiplied_by_the_factor(tmp_path: Path, mode: str, cutoff: float | None) -> None:
    pbr = {"pbrMetallicRoughness": {"baseColorFactor": [0.5, 1, 1, 0.5]}}
    builder = faded(mode, **pbr, **({} if cutoff is None else {"alphaCutoff": cutoff}))
    mask = bsdf(builder, tmp_path)
    assert isinstance(mask, m.Mask)
    assert mask.opacity == m.MeshAttribute(name="vertex_alpha")
    assert mask.cutoff == cutoff
    found = attributes(builder, tmp_path)
    assert found["vertex_alpha"][:, 0] == pytest.approx(0.5 * ALPHAS)
    assert found["vertex_color"] == pytest.approx(COLORS * (0.5, 1, 1))


@pytest.mark.parametrize("mode", ["BLEND", "MASK"])
def test_the_opacity_of_vertices_is_multiplied_by_a_texture(tmp_path: Path, mode: str) -> None:
    pbr = {"baseColorTexture": {"index": 0}, "baseColorFactor": [1, 1, 1, 0.5]}
    builder = textured(np.full((1, 1, 4), 102, np.uint8), tmp_path, alphaMode=mode, pbrMetallicRoughness=pbr)
    builder.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = builder.accessor(RGBA[:3])
    mask = bsdf(builder, tmp_path)
    assert isinstance(mask, m.Mask)
    assert isinstance(mask.opacity, m.MeshAttribute)
    assert texels(mask.opacity.times, tmp_path).texels == pytest.approx(0.2, abs=1e-3)
    assert attributes(builder, tmp_path)["vertex_alpha"][:, 0] == pytest.approx(ALPHAS[:3])


def test_the_opacity_of_vertices_is_ignored_where_a_material_is_opaque(tmp_path: Path) -> None:
    assert isinstance(bsdf(faded("OPAQUE"), tmp_path), m.Principled)


def seen(builder: Builder, folder: Path) -> NDArray[np.float32]:
    """Return what a camera sees of the middle of a square before a sky of radiance 2."""
    half = {"xmag": 0.25, "ymag": 0.25, "znear": 0.1, "zfar": 10}
    camera = builder.add("cameras", {"type": "orthographic", "orthographic": half})
    builder.node(camera=camera, translation=[0.5, 0.5, 1])
    scene = et.load(builder.glb(folder / "a.glb"), sky=2.0).with_(size=(8, 8))
    return et.render(scene, spp=256, seed=3).image[..., 0]


UNLIT: dict[str, Any] = {"extensions": {"KHR_materials_unlit": {}}}
"""A square that shines in white."""


def across(alphas: list[float]) -> NDArray[np.float64]:
    """Return white vertices whose opacities go from the first on the left to the last on the right."""
    left, right = alphas
    return np.array([[1, 1, 1, left], [1, 1, 1, right], [1, 1, 1, left], [1, 1, 1, right]], np.float64)


def test_what_is_blended_lets_light_through_as_its_vertices_say(tmp_path: Path) -> None:
    image = seen(faded("BLEND", across([0.0, 1.0]), **UNLIT), tmp_path)
    alpha = 0.25 + 0.5 * (np.arange(8) + 0.5) / 8
    assert image.mean(axis=0) == pytest.approx(2.0 * (1.0 - alpha) + alpha, abs=0.08)


def test_what_is_cut_is_seen_where_the_interpolated_opacity_reaches_the_cutoff(tmp_path: Path) -> None:
    black = {"pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 1]}}
    image = seen(faded("MASK", across([0.0, 1.0]), alphaCutoff=0.5, **black), tmp_path)
    assert image[:, :2] == pytest.approx(2.0, abs=1e-5)
    assert (image[:, 6:] < 0.2).all()


def test_vertices_whose_opacity_is_the_cutoff_leave_no_holes(tmp_path: Path) -> None:
    """Though interpolation between equal numbers rounds them."""
    for alpha in (0.5, 0.7, 0.1):
        image = seen(faded("MASK", across([alpha, alpha]), alphaCutoff=float(np.float32(alpha)), **UNLIT), tmp_path)
        assert image == pytest.approx(1.0, abs=1e-5)


def test_colours_in_whole_numbers_must_be_normalized(tmp_path: Path) -> None:
    for dtype, largest in (("u1", 255), ("u2", 65535)):
        builder = Builder()
        colors = builder.accessor(np.full((3, 3), largest // 5), dtype)
        builder.node(mesh=builder.mesh(COLOR_0=colors))
        with pytest.raises(et.SceneError, match=r"accessors\[0\].normalized: expected true for colours in whole"):
            loaded(builder, tmp_path)
        builder.json["accessors"][colors]["normalized"] = True
        assert attributes(builder, tmp_path)["vertex_color"] == pytest.approx(0.2)


def test_colours_beyond_one_are_cut_and_those_that_are_no_numbers_are_black_which_is_told(tmp_path: Path) -> None:
    builder = Builder()
    builder.node(mesh=builder.mesh(COLOR_0=[[2, -1, 0.5], [np.nan, 1, 1], [1, 1, 1]]))
    assert attributes(builder, tmp_path)["vertex_color"].tolist() == [[1, 0, 0.5], [0, 0, 0], [1, 1, 1]]
    told = "\n".join(loaded(builder, tmp_path).warnings)
    assert "1 colours are cut to [0, 1]; they reach from -1 to 2" in told
    assert "1 colours are not finite: black is taken" in told


@pytest.mark.parametrize("mode", ["BLEND", "MASK"])
def test_opacities_of_vertices_are_written_for_other_renderers(tmp_path: Path, mode: str) -> None:
    for material in ({}, UNLIT):
        scene = loaded(faded(mode, **material), tmp_path).with_(size=(8, 8))
        scene.write(tmp_path / f"{len(material)}.xml")
        again = et.load(tmp_path / f"{len(material)}.xml")
        assert np.array_equal(et.render(again, spp=4).image, et.render(scene, spp=4).image)
