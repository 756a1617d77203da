"""Extensions of glTF materials as parameters of the principled BSDF, each with what it keeps and what it loses."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import equaltime as et
from equaltime.scene import model as m
from equaltime.scene.gltf import MAPPING
from equaltime.scene.gltf.schema import MATERIAL_EXTENSIONS

from .gltf_files import TRIANGLE, Builder, one_triangle
from .gltf_materials import bsdf, loaded, principled, texels, textured, warnings


def extended(folder: Path, name: str, /, **fields: Any) -> m.Principled:
    pbr = {"metallicFactor": 0.0, "roughnessFactor": 0.5}
    return principled(folder, pbrMetallicRoughness=pbr, extensions={f"KHR_materials_{name}": fields})


def f0(eta: float | None) -> float:
    assert eta is not None
    return ((eta - 1) / (eta + 1)) ** 2


def test_ior_and_specular_say_how_much_is_reflected_head_on(tmp_path: Path) -> None:
    assert extended(tmp_path, "ior", ior=1.33).eta == 1.33
    assert extended(tmp_path, "ior", ior=0).eta == 1000  # all of it
    assert f0(extended(tmp_path, "specular", specularFactor=0.25).eta) == pytest.approx(0.01)
    assert f0(extended(tmp_path, "specular", specularColorFactor=[2, 2, 2]).eta) == pytest.approx(0.08)
    assert extended(tmp_path, "specular", specularFactor=0).eta == 1


@pytest.mark.parametrize(("ior", "eta"), [(0.5, 1), (5000, 1000), (0, 1000), (1, 1), (1000, 1000)])
def test_an_index_of_refraction_that_none_has_is_told(tmp_path: Path, ior: float, eta: float) -> None:
    builder = one_triangle(extensions={"KHR_materials_ior": {"ior": ior}})
    found = bsdf(builder, tmp_path)
    assert isinstance(found, m.Principled)
    assert found.eta == eta
    expected = f"an index of refraction of {ior:g} counts as {eta:g}: it is from 1 to 1000 (materials[0])"
    assert (expected in warnings(builder, tmp_path)) == (ior in (0.5, 5000))


def test_thin_walls_let_light_straight_through(tmp_path: Path) -> None:
    pbr = {"metallicFactor": 0.25, "roughnessFactor": 0.0, "baseColorFactor": [0.9, 0.5, 0.5, 1.0]}
    extension = {"KHR_materials_transmission": {"transmissionFactor": 0.8}}
    found = bsdf(one_triangle(pbrMetallicRoughness=pbr, extensions=extension, doubleSided=True), tmp_path)
    assert isinstance(found, m.BlendBsdf)
    assert found.weight == pytest.approx(0.8 * 0.75)  # metal lets nothing through
    assert isinstance(found.bsdf[0], m.TwoSided)
    assert isinstance(found.bsdf[1], m.ThinDielectric)
    assert found.bsdf[1].specular_transmittance == (0.9, 0.5, 0.5)


def test_metal_is_opaque(tmp_path: Path) -> None:
    assert principled(tmp_path, extensions={"KHR_materials_transmission": {"transmissionFactor": 1}}).spec_trans == 0


def test_a_volume_refracts_and_takes_light_on_the_way(tmp_path: Path) -> None:
    extensions = {
        "KHR_materials_transmission": {"transmissionFactor": 1},
        "KHR_materials_ior": {"ior": 1.33},
        "KHR_materials_volume": {"thicknessFactor": 2, "attenuationDistance": 4, "attenuationColor": [0.25, 1, 1]},
    }
    found = principled(tmp_path, pbrMetallicRoughness={"metallicFactor": 0}, extensions=extensions, doubleSided=True)
    assert (found.spec_trans, found.eta) == (1, 1.33)
    assert found.base_color == (1, 1, 1)
    scene = et.load(tmp_path / "a.glb")
    (inside,) = {shape.interior for shape in scene.model.shapes if isinstance(shape, m.Solid)}
    assert inside is not None
    assert inside.sigma_t == pytest.approx((math.log(4) / 4, 0, 0))
    assert inside.albedo == (0, 0, 0)
    assert isinstance(scene.model.integrator, m.VolPath)
    assert scene.core.effects()["media"]


def test_an_attenuation_distance_of_0_is_told(tmp_path: Path) -> None:
    volume = {"thicknessFactor": 1, "attenuationDistance": 0, "attenuationColor": [0.5, 1, 1]}
    extensions = {"KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_volume": volume}
    builder = one_triangle(pbrMetallicRoughness={"metallicFactor": 0}, extensions=extensions)
    assert "an attenuation distance of 0 is not used: the volume absorbs nothing" in warnings(builder, tmp_path)


def test_an_unlit_material_is_only_its_colour(tmp_path: Path) -> None:
    others = {
        "KHR_materials_transmission": {"transmissionFactor": 1.0},
        "KHR_materials_clearcoat": {"clearcoatFactor": 1.0},
        "KHR_materials_volume": {"thicknessFactor": 1, "attenuationDistance": 1, "attenuationColor": [0.5] * 3},
    }
    pbr = {"baseColorFactor": [0.2, 0.3, 0.4, 1], "metallicFactor": 0}
    both = one_triangle(pbrMetallicRoughness=pbr, extensions={"KHR_materials_unlit": {}, **others})
    plain = one_triangle(pbrMetallicRoughness=pbr, extensions={"KHR_materials_unlit": {}})
    assert loaded(both, tmp_path).model == loaded(plain, tmp_path).model
    assert warnings(both, tmp_path) == warnings(plain, tmp_path)


def test_clear_coat_has_the_same_alpha(tmp_path: Path) -> None:
    found = extended(tmp_path, "clearcoat", clearcoatFactor=0.5, clearcoatRoughnessFactor=0.2)
    assert found.clearcoat == 0.5
    assert isinstance(found.clearcoat_gloss, float)
    assert 0.1 + (0.001 - 0.1) * found.clearcoat_gloss == pytest.approx(0.04)
    assert extended(tmp_path, "clearcoat", clearcoatRoughnessFactor=0.2).clearcoat == 0  # no factor, no coat


def test_sheen_is_as_strong_as_its_brightest_channel(tmp_path: Path) -> None:
    assert extended(tmp_path, "sheen", sheenColorFactor=[0.1, 0.7, 0.2]).sheen == 0.7


@pytest.mark.parametrize("strength", [0.1, 0.5, 0.7])
def test_anisotropy_has_the_same_two_alphas(tmp_path: Path, strength: float) -> None:
    found = extended(tmp_path, "anisotropy", anisotropyStrength=strength)
    assert isinstance(found.roughness, float)
    assert isinstance(found.anisotropic, float)
    aspect = math.sqrt(1 - 0.9 * found.anisotropic)
    narrow = 0.25
    wide = narrow + (1 - narrow) * strength**2
    assert found.roughness**2 / aspect == pytest.approx(wide)
    assert found.roughness**2 * aspect == pytest.approx(narrow)


def test_anisotropy_beyond_the_models_reach_is_the_most_there_is(tmp_path: Path) -> None:
    pbr = {"metallicFactor": 0.0, "roughnessFactor": 0.1}
    extensions = {"KHR_materials_anisotropy": {"anisotropyStrength": 1.0}}
    found = principled(tmp_path, pbrMetallicRoughness=pbr, extensions=extensions)
    assert found.anisotropic == pytest.approx(1.0)


def test_anisotropy_follows_a_texture_of_the_roughness(tmp_path: Path) -> None:
    rough = np.zeros((2, 2, 3), np.uint8)
    rough[..., 1] = [[0, 51], [128, 255]]
    builder = textured(
        rough,
        tmp_path,
        pbrMetallicRoughness={"metallicRoughnessTexture": {"index": 0}},
        extensions={"KHR_materials_anisotropy": {"anisotropyStrength": 0.5}},
    )
    found = bsdf(builder, tmp_path)
    assert isinstance(found, m.Principled)
    mean, stretch = (texels(texture, tmp_path).texels.astype(float) for texture in (found.roughness, found.anisotropic))
    aspect = np.sqrt(1 - 0.9 * stretch)
    narrow = (rough[..., 1:2] / 255.0) ** 2
    wide = narrow + (1 - narrow) * 0.25
    np.testing.assert_allclose(mean**2 / aspect, wide, rtol=2e-3)
    np.testing.assert_allclose(mean**2 * aspect, np.maximum(narrow, 0.1 * wide), rtol=5e-3)


def test_specular_glossiness_becomes_metalness_and_roughness(tmp_path: Path) -> None:
    name = "pbrSpecularGlossiness"
    plastic = extended(
        tmp_path, name, diffuseFactor=[0.5, 0.4, 0.3, 1], specularFactor=[0.04] * 3, glossinessFactor=0.7
    )
    assert plastic.metallic == pytest.approx(0, abs=1e-9)
    assert plastic.base_color == pytest.approx((0.5, 0.4, 0.3))
    assert plastic.roughness == pytest.approx(0.3)
    gold = extended(tmp_path, name, diffuseFactor=[0, 0, 0, 1], specularFactor=[1.0, 0.8, 0.3])
    assert gold.metallic == pytest.approx(1)
    assert gold.base_color == pytest.approx((1.0, 0.8, 0.3))


def test_a_diffuse_texture_of_a_metal_is_told(tmp_path: Path) -> None:
    old = {"diffuseTexture": {"index": 0}, "specularFactor": [0.9, 0.8, 0.3]}
    extensions = {"KHR_materials_pbrSpecularGlossiness": old}
    metal = textured(np.full((2, 2, 3), 9, np.uint8), tmp_path, extensions=extensions)
    assert "the diffuse texture of KHR_materials_pbrSpecularGlossiness is not used" in warnings(metal, tmp_path)
    old["specularFactor"] = [0.04, 0.04, 0.04]
    assert "the diffuse texture" not in warnings(metal, tmp_path)


def test_what_is_not_exact_is_told_with_its_materials(tmp_path: Path) -> None:
    builder = Builder()
    for _ in range(5):
        material = {"extensions": {"KHR_materials_sheen": {"sheenColorFactor": [1, 1, 1]}}}
        builder.node(mesh=builder.mesh(TRIANGLE, material=builder.add("materials", material)))
    text = warnings(builder, tmp_path)
    assert "white, of one roughness (materials[0], materials[1], materials[2] and 2 more)" in text


def test_an_extension_that_is_not_read_is_told(tmp_path: Path) -> None:
    builder = one_triangle()
    builder.json["extensionsUsed"] = ["KHR_materials_iridescence", "KHR_materials_ior"]
    told = warnings(builder, tmp_path)
    assert "the extension 'KHR_materials_iridescence' is not used" in told
    assert "KHR_materials_ior" not in told


def test_every_extension_that_is_read_is_written_down() -> None:
    assert {name for name in MAPPING if "materials" in name} == MATERIAL_EXTENSIONS.keys()
