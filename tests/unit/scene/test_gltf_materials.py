"""Materials of glTF files as the principled BSDF, its wrappers and area lights; textures as one bitmap a parameter."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import equaltime as et
from equaltime.scene import model as m

from .gltf_files import SQUARE, Builder, one_triangle
from .gltf_materials import UV, bsdf, loaded, principled, texels, textured, warnings


def srgb(byte: int) -> float:
    value = byte / 255
    return value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4


# -- metallic-roughness -----------------------------------------------------------------------------------------------


def test_factors_are_parameters_of_principled(tmp_path: Path) -> None:
    pbr = {"baseColorFactor": [0.1, 0.2, 0.3, 1], "metallicFactor": 0.4, "roughnessFactor": 0.6}
    found = principled(tmp_path, pbrMetallicRoughness=pbr)
    assert (found.base_color, found.metallic, found.roughness, found.eta) == ((0.1, 0.2, 0.3), 0.4, 0.6, 1.5)


def test_factors_above_one_count_as_one_and_are_told(tmp_path: Path) -> None:
    pbr = {"baseColorFactor": [1.0000001, 0.5, 1.5, 1], "roughnessFactor": 1.0000001}
    clearcoat = {"KHR_materials_clearcoat": {"clearcoatFactor": 1.5}}
    builder = one_triangle(pbrMetallicRoughness=pbr, extensions=clearcoat)
    builder.json["extensionsUsed"] = ["KHR_materials_clearcoat"]
    found = bsdf(builder, tmp_path)
    assert isinstance(found, m.Principled)
    assert (found.base_color, found.roughness, found.clearcoat) == ((1, 0.5, 1), 1, 1)
    assert "a factor above 1 counts as 1 (materials[0].pbrMetallicRoughness.baseColorFactor" in warnings(
        builder, tmp_path
    )


@pytest.mark.parametrize("material", [{}, {"name": "nothing said"}, {"pbrMetallicRoughness": {}}])
def test_the_default_is_white_rough_metal(tmp_path: Path, material: dict[str, Any]) -> None:
    found = principled(tmp_path, **material)
    assert (found.base_color, found.metallic, found.roughness) == ((1, 1, 1), 1, 1)


def test_both_sides_only_where_the_file_says_so(tmp_path: Path) -> None:
    assert isinstance(bsdf(one_triangle(doubleSided=True), tmp_path), m.TwoSided)


def test_one_material_is_one_bsdf(tmp_path: Path) -> None:
    builder = one_triangle(name="a")
    builder.node(mesh=0)
    shapes = loaded(builder, tmp_path).model.shapes
    assert shapes[0].bsdf is shapes[1].bsdf


def test_roughness_is_green_and_metalness_blue(tmp_path: Path) -> None:
    pixels = np.array([[[10, 20, 30, 40]]], np.uint8)
    pbr = {"metallicRoughnessTexture": {"index": 0}, "roughnessFactor": 1.0, "metallicFactor": 0.5}
    found = bsdf(textured(pixels, tmp_path, pbrMetallicRoughness=pbr), tmp_path)
    assert isinstance(found, m.Principled)
    rough, metal = texels(found.roughness, tmp_path), texels(found.metallic, tmp_path)
    assert rough.texels.tolist() == [[[20]]]
    assert rough.texels.dtype == np.uint8
    assert metal.texels.dtype == np.float16
    assert metal.texels[0, 0] == pytest.approx(15 / 255, rel=1e-3)


def test_a_colour_texture_stays_as_it_is_without_a_factor(tmp_path: Path) -> None:
    pixels = np.arange(24, dtype=np.uint8).reshape(2, 3, 4) * 10
    found = bsdf(textured(pixels, tmp_path, pbrMetallicRoughness={"baseColorTexture": {"index": 0}}), tmp_path)
    assert isinstance(found, m.Principled)
    color = texels(found.base_color, tmp_path)
    assert color.srgb
    assert np.array_equal(color.texels, pixels[..., :3])


def test_a_factor_multiplies_the_decoded_colour(tmp_path: Path) -> None:
    pixels = np.array([[[200, 100, 50]]], np.uint8)
    pbr = {"baseColorTexture": {"index": 0}, "baseColorFactor": [0.5, 1.0, 0.25, 1.0]}
    found = bsdf(textured(pixels, tmp_path, pbrMetallicRoughness=pbr), tmp_path)
    assert isinstance(found, m.Principled)
    color = texels(found.base_color, tmp_path)
    assert not color.srgb
    assert color.texels[0, 0] == pytest.approx([0.5 * srgb(200), srgb(100), 0.25 * srgb(50)], rel=1e-3)


@pytest.mark.parametrize(("channels", "expected"), [(1, [[9, 9, 9]]), (2, [[9, 9, 9]]), (3, [[9, 8, 7]])])
def test_images_may_be_grey(tmp_path: Path, channels: int, expected: list[list[int]]) -> None:
    pixels = np.array([[[9, 8, 7][:channels]]], np.uint8)
    found = bsdf(textured(pixels, tmp_path, pbrMetallicRoughness={"baseColorTexture": {"index": 0}}), tmp_path)
    assert isinstance(found, m.Principled)
    assert texels(found.base_color, tmp_path).texels[0].tolist() == expected


def test_samplers_say_how_a_texture_is_looked_up(tmp_path: Path) -> None:
    builder = textured(np.zeros((1, 1, 3), np.uint8), tmp_path, pbrMetallicRoughness={"baseColorTexture": {"index": 0}})
    builder.json["samplers"] = [{"wrapS": 33071, "wrapT": 33648, "magFilter": 9728}]
    builder.json["textures"][0]["sampler"] = 0
    found = bsdf(builder, tmp_path)
    assert isinstance(found, m.Principled)
    assert isinstance(found.base_color, m.Bitmap)
    assert (found.base_color.wrap_mode, found.base_color.filter_type) == ("clamp", "nearest")
    assert "v is wrapped like u" in warnings(builder, tmp_path)


def test_texture_coordinates_are_scaled_then_turned_then_moved(tmp_path: Path) -> None:
    transform = {"offset": [10, 20], "rotation": math.pi / 2, "scale": [2, 3]}
    use = {"index": 0, "extensions": {"KHR_texture_transform": transform}}
    found = bsdf(
        textured(np.zeros((1, 1, 3), np.uint8), tmp_path, pbrMetallicRoughness={"baseColorTexture": use}), tmp_path
    )
    assert isinstance(found, m.Principled)
    assert isinstance(found.base_color, m.Bitmap)
    # u = 1 becomes (2, 0), turned counter-clockwise as one sees it, v being downwards, to (0, -2)
    assert np.allclose(found.base_color.uv_rows, [[0, 3, 10], [-2, 0, 20]])


def test_a_texture_scaled_to_0_is_one_texel(tmp_path: Path) -> None:
    pixels = np.array([[[10, 20, 30], [200, 210, 220]]], np.uint8)
    transform = {"scale": [0, 0], "offset": [0.75, 0.5]}
    use = {"index": 0, "extensions": {"KHR_texture_transform": transform}}
    builder = textured(pixels, tmp_path, pbrMetallicRoughness={"baseColorTexture": use})
    builder.json["materials"][0]["extensions"] = {"KHR_materials_unlit": {}}
    image = et.render(et.load(builder.glb(tmp_path / "a.glb"), sky=0, sun=0).with_(size=(16, 12)), spp=4).image
    np.testing.assert_allclose(image[image[..., 0] > 0.3].max(axis=0), [srgb(200), srgb(210), srgb(220)], rtol=1e-3)


def test_a_set_of_texture_coordinates_may_be_chosen(tmp_path: Path) -> None:
    builder = Builder()
    builder.image(np.zeros((1, 1, 3), np.uint8), tmp_path)
    material = builder.add(
        "materials",
        {
            "pbrMetallicRoughness": {"baseColorTexture": {"index": 0, "texCoord": 1}},
            "normalTexture": {"index": 0},
        },
    )
    builder.node(mesh=builder.mesh(material=material, TEXCOORD_0=UV, TEXCOORD_1=np.array(UV) * 7.0))
    surface = next(loaded(builder, tmp_path).surfaces())
    assert surface.uvs.tolist() == [[0, 7], [7, 7], [0, 0]]  # type: ignore[union-attr]
    assert "all textures are looked up with TEXCOORD_1, not with TEXCOORD_0 (materials[0])" in warnings(
        builder, tmp_path
    )


# -- opacity ----------------------------------------------------------------------------------------------------------


def test_blending_is_a_mask_of_that_opacity(tmp_path: Path) -> None:
    found = bsdf(one_triangle(alphaMode="BLEND", pbrMetallicRoughness={"baseColorFactor": [1, 1, 1, 0.25]}), tmp_path)
    assert isinstance(found, m.Mask)
    assert found.opacity == 0.25


@pytest.mark.parametrize(("alpha", "cutoff", "opacity"), [(0.5, None, 1), (0.49, None, 0), (0.2, 0.1, 1), (1, 1.1, 0)])
def test_masks_are_opaque_from_the_cutoff_on(
    tmp_path: Path, alpha: float, cutoff: float | None, opacity: float
) -> None:
    given = {} if cutoff is None else {"alphaCutoff": cutoff}
    pbr = {"baseColorFactor": [1, 1, 1, alpha]}
    found = bsdf(one_triangle(alphaMode="MASK", pbrMetallicRoughness=pbr, **given), tmp_path)
    assert isinstance(found, m.Mask)
    assert found.opacity == opacity


def test_opacity_means_nothing_to_an_opaque_material(tmp_path: Path) -> None:
    assert principled(tmp_path, pbrMetallicRoughness={"baseColorFactor": [1, 1, 1, 0.25]})


def test_opacity_is_the_alpha_of_the_colours_texture(tmp_path: Path) -> None:
    pixels = np.array([[[255, 255, 255, 51], [255, 255, 255, 204]]], np.uint8)
    pbr = {"baseColorTexture": {"index": 0}}
    found = bsdf(textured(pixels, tmp_path, pbrMetallicRoughness=pbr, alphaMode="BLEND"), tmp_path)
    assert isinstance(found, m.Mask)
    assert texels(found.opacity, tmp_path).texels.tolist() == [[[51], [204]]]


def test_a_mask_is_cut_where_the_interpolated_opacity_is(tmp_path: Path) -> None:
    """A ramp over two texels crosses the cutoff between them, not at a texel's border."""
    pixels = np.zeros((1, 2, 4), np.uint8)
    pixels[0, :, 3] = (0, 255)
    pbr = {"baseColorTexture": {"index": 0}}
    builder = textured(pixels, tmp_path, pbrMetallicRoughness=pbr, alphaMode="MASK", alphaCutoff=0.3)
    found = bsdf(builder, tmp_path)
    assert isinstance(found, m.Mask)
    assert isinstance(found.opacity, m.Bitmap)
    assert found.opacity.filter_type == "nearest"
    row = texels(found.opacity, tmp_path).texels[0, :, 0]
    # texel centres at 1/4 and 3/4: the ramp reaches 0.3 at u = 0.4, and on the way back, repeated, at u = 0.1
    centres = (np.arange(8) + 0.5) / 8
    assert row.tolist() == [255 if u < 0.1 or u > 0.4 else 0 for u in centres]


@pytest.mark.parametrize(
    ("sampler", "expected"),
    [
        ({"magFilter": 9728}, [0, 255, 255]),  # not interpolated: the texels themselves
        ({"wrapS": 33071, "wrapT": 33071}, [0] * 5 + [255] * 7),  # a ramp from 1/6 to 1/2, which reaches 0.8 at 0.43
        ({"wrapS": 33648, "wrapT": 33648}, [0] * 5 + [255] * 7),
        ({}, [0] * 5 + [255] * 6 + [0]),  # after the last texel, a ramp to the repeated first one
    ],
    ids=["nearest", "clamp", "mirror", "repeat"],
)
def test_a_mask_is_cut_as_its_sampler_looks_it_up(sampler: dict[str, int], expected: list[int], tmp_path: Path) -> None:
    pixels = np.zeros((1, 3, 4), np.uint8)
    pixels[0, :, 3] = (0, 255, 255)
    pbr = {"baseColorTexture": {"index": 0}}
    builder = textured(pixels, tmp_path, pbrMetallicRoughness=pbr, alphaMode="MASK", alphaCutoff=0.8)
    builder.json["textures"][0]["sampler"] = builder.add("samplers", sampler)
    found = bsdf(builder, tmp_path)
    assert isinstance(found, m.Mask)
    assert texels(found.opacity, tmp_path).texels[0, :, 0].tolist() == expected


# -- normals and emission ---------------------------------------------------------------------------------------------


def test_normals_are_taken_as_they_are_stored(tmp_path: Path) -> None:
    pixels = np.array([[[128, 128, 255]]], np.uint8)
    found = bsdf(textured(pixels, tmp_path, normalTexture={"index": 0}, doubleSided=True), tmp_path)
    assert isinstance(found, m.TwoSided)
    assert isinstance(found.bsdf[0], m.NormalMap)
    normals = texels(found.bsdf[0].normalmap, tmp_path)
    assert normals.texels.tolist() == [[[128, 128, 255]]]


def test_the_scale_of_normals_makes_slopes_steeper(tmp_path: Path) -> None:
    pixels = np.array([[[255, 128, 255]]], np.uint8)
    found = bsdf(textured(pixels, tmp_path, normalTexture={"index": 0, "scale": 2.0}), tmp_path)
    assert isinstance(found, m.NormalMap)
    x, y, z = 2.0 * texels(found.normalmap, tmp_path).texels[0, 0].astype(np.float64) - 1.0
    assert x / z == pytest.approx(2.0, rel=5e-3)
    assert math.hypot(x, y, z) == pytest.approx(1.0, rel=5e-3)


@pytest.mark.parametrize(
    "transform",
    [
        {"rotation": 0.5},
        {"rotation": math.pi / 2, "offset": [0.25, 0.5]},
        {"scale": [-1, 1]},
        {"scale": [1, -2], "rotation": 2.0},
        {"scale": [2, 0.3]},
    ],
    ids=str,
)
@pytest.mark.parametrize("mirrored", [False, True])
def test_slopes_turn_with_the_texture_as_if_the_coordinates_were_turned(
    tmp_path: Path, transform: dict[str, Any], mirrored: bool
) -> None:
    """A mesh with transformed texture coordinates gives the same picture."""
    pixels = np.array([[[180, 150, 220], [90, 140, 230]], [[128, 190, 210], [128, 128, 255]]], np.uint8)
    angle, (width, height) = transform.get("rotation", 0.0), transform.get("scale", [1, 1])
    turn = np.array([[math.cos(angle), math.sin(angle)], [-math.sin(angle), math.cos(angle)]]) * [width, height]
    uvs = np.array([[0, 1], [1, 1], [1, 0], [0, 0]]) * [-1 if mirrored else 1, 1]
    images = []
    for given, uv in ((transform, uvs), ({}, uvs @ turn.T + transform.get("offset", [0, 0]))):
        use = {"index": 0, "extensions": {"KHR_texture_transform": given}}
        pbr = {"metallicFactor": 0, "roughnessFactor": 1}
        builder = textured(pixels, tmp_path, normalTexture=use, pbrMetallicRoughness=pbr)
        builder.json["textures"][0]["sampler"] = builder.add("samplers", {"magFilter": 9728})
        builder.json["nodes"] = [{"mesh": builder.mesh(SQUARE, [0, 1, 2, 0, 2, 3], material=0, TEXCOORD_0=uv)}]
        scene = et.load(builder.glb(tmp_path / "a.glb"), sky=0, sun=1)
        images.append(et.render(scene.with_(size=(16, 12)), spp=16, seed=1).image)
    assert images[0].any()
    np.testing.assert_allclose(images[0], images[1], rtol=0.002, atol=0.0002)


@pytest.mark.parametrize("scale", [1, -1])
def test_triangles_that_mirror_their_texture_have_green_turned_round(tmp_path: Path, scale: float) -> None:
    """Up in a normal map is up on the surface, whichever way round the texture lies on it."""
    builder = textured(np.array([[[128, 100, 255]]], np.uint8), tmp_path, normalTexture={"index": 0})
    square = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 0, 0], [1, 1, 0], [0, 1, 0]]
    upright, mirrored = [[0, 1], [1, 1], [1, 0]], [[0, 1], [-1, 0], [0, 0]]
    mesh = builder.mesh(square, material=0, TEXCOORD_0=upright + mirrored)
    builder.json["nodes"] = [{"mesh": mesh, "scale": [scale, 1, 1]}]
    scene = loaded(builder, tmp_path)
    greens = {}
    for shape in scene.model.shapes:
        assert isinstance(shape, m.Gltf)
        assert isinstance(shape.bsdf, m.NormalMap)
        greens[shape.filename.rsplit("/")[-1]] = texels(shape.bsdf.normalmap, tmp_path).texels[0, 0, 1]
    assert greens == ({"unmirrored": 100, "mirrored": 155} if scale > 0 else {"unmirrored": 155, "mirrored": 100})
    assert sorted(len(surface.faces) for surface in scene.surfaces()) == [1, 1]  # type: ignore[union-attr]


def test_emission_is_an_area_light(tmp_path: Path) -> None:
    builder = one_triangle(
        emissiveFactor=[1, 0.5, 0.25], extensions={"KHR_materials_emissive_strength": {"emissiveStrength": 8}}
    )
    emitter = loaded(builder, tmp_path).model.shapes[0].emitter
    assert isinstance(emitter, m.Area)
    assert emitter.radiance == (8, 4, 2)


def test_an_emissive_texture_is_nothing_without_a_factor(tmp_path: Path) -> None:
    pixels = np.array([[[255, 0, 0]]], np.uint8)
    assert loaded(textured(pixels, tmp_path, emissiveTexture={"index": 0}), tmp_path).model.shapes[0].emitter is None
    builder = textured(pixels, tmp_path, emissiveTexture={"index": 0}, emissiveFactor=[2, 2, 2])
    emitter = loaded(builder, tmp_path).model.shapes[0].emitter
    assert isinstance(emitter, m.Area)
    assert texels(emitter.radiance, tmp_path).texels.tolist() == [[[2, 0, 0]]]


def test_unlit_is_a_light_of_its_colour_that_reflects_nothing(tmp_path: Path) -> None:
    pbr = {"baseColorFactor": [0.1, 0.2, 0.3, 1]}
    builder = one_triangle(pbrMetallicRoughness=pbr, extensions={"KHR_materials_unlit": {}})
    shape = loaded(builder, tmp_path).model.shapes[0]
    assert shape.emitter is not None
    assert shape.emitter.radiance == (0.1, 0.2, 0.3)
    assert shape.bsdf == m.Diffuse(reflectance=(0, 0, 0), id="material_0")
    assert "an unlit material emits its colour" in warnings(builder, tmp_path)


@pytest.mark.parametrize(("mode", "light"), [("BLEND", [0.2, 0.8]), ("MASK", [0.0, 1.0]), ("OPAQUE", [1.0, 1.0])])
def test_what_is_not_there_sends_no_light(tmp_path: Path, mode: str, light: list[float]) -> None:
    pixels = np.array([[[255, 0, 255, 51], [255, 0, 255, 204]]], np.uint8)
    pbr = {"baseColorTexture": {"index": 0}}
    unlit = textured(pixels, tmp_path, pbrMetallicRoughness=pbr, alphaMode=mode, extensions={"KHR_materials_unlit": {}})
    glow = textured(pixels, tmp_path, pbrMetallicRoughness=pbr, alphaMode=mode, emissiveFactor=[1, 0, 1])
    for builder in (unlit, glow):
        emitter = loaded(builder, tmp_path).model.shapes[0].emitter
        assert emitter is not None
        if mode == "OPAQUE" and builder is glow:
            assert emitter.radiance == (1, 0, 1)
            continue
        found = texels(emitter.radiance, tmp_path).texels[0]
        scale = 255 if found.dtype == np.uint8 else 1
        np.testing.assert_allclose(found, scale * np.outer(light, [1, 0, 1]), atol=1e-3)


def test_a_constant_opacity_dims_emission_and_another_texture_is_told(tmp_path: Path) -> None:
    pbr: dict[str, Any] = {"baseColorFactor": [1, 1, 1, 0.25]}
    builder = one_triangle(alphaMode="BLEND", pbrMetallicRoughness=pbr, emissiveFactor=[1, 0.5, 0])
    emitter = loaded(builder, tmp_path).model.shapes[0].emitter
    assert emitter is not None
    assert emitter.radiance == (0.25, 0.125, 0)
    other = {"index": 0, "extensions": {"KHR_texture_transform": {"scale": [2, 2]}}}
    pixels = np.full((1, 1, 4), 128, np.uint8)
    glow = {"emissiveTexture": other, "emissiveFactor": [1, 1, 1], "alphaMode": "BLEND"}
    builder = textured(pixels, tmp_path, pbrMetallicRoughness={"baseColorTexture": {"index": 0}}, **glow)
    assert "transparent parts emit too" in warnings(builder, tmp_path)


def test_texels_that_are_not_finite_are_told(tmp_path: Path) -> None:
    strong = {"KHR_materials_emissive_strength": {"emissiveStrength": 1e38}}
    emission = {"emissiveTexture": {"index": 0}, "emissiveFactor": [1e3, 1, 1], "extensions": strong}
    with pytest.raises(et.SceneError, match=r"materials\[0\]: a texel of its radiance is not finite"):
        loaded(textured(np.full((1, 1, 3), 255, np.uint8), tmp_path, **emission), tmp_path)
