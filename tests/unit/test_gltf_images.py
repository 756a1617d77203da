"""Images of glTF files: what cannot be read is told when the scene is loaded."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import equaltime as et
from equaltime.scene import model as m

from .gltf_files import encoded, one_triangle
from .gltf_materials import bsdf, loaded, texels, textured


@pytest.mark.parametrize(
    ("image", "expected"),
    [
        ({"uri": "gone.png"}, "images[0].uri: no such file"),
        ({"uri": "../up.png"}, "images[0].uri: only files in this folder or below it"),
        ({"uri": "data:image/png;base64,AAAA"}, "images[0]: is no PNG, JPEG or WebP image"),
        ({}, "images[0]: needs a 'uri' or a 'bufferView'"),
    ],
)
def test_an_image_that_cannot_be_read_is_told_when_the_scene_is_loaded(
    tmp_path: Path, image: dict[str, Any], expected: str
) -> None:
    builder = one_triangle(emissiveFactor=[1, 1, 1], emissiveTexture={"index": 0})
    builder.json |= {"images": [image], "textures": [{"source": 0}]}
    with pytest.raises(et.SceneError) as caught:
        loaded(builder, tmp_path)
    assert expected in str(caught.value)
    assert "materials[0]" in str(caught.value)


def test_a_damaged_image_is_told(tmp_path: Path) -> None:
    builder = textured(
        np.zeros((64, 64, 3), np.uint8), tmp_path, emissiveFactor=[1, 1, 1], emissiveTexture={"index": 0}
    )
    view = builder.json["bufferViews"][0]
    view["byteLength"] //= 2
    with pytest.raises(et.SceneError, match=r"images\[0\]: cannot be read as an image"):
        loaded(builder, tmp_path)


def test_a_texture_without_an_image_is_told(tmp_path: Path) -> None:
    builder = one_triangle(normalTexture={"index": 0})
    builder.json["textures"] = [{"name": "empty"}]
    with pytest.raises(et.SceneError, match=r"textures\[0\]: has no 'source' that can be read"):
        loaded(builder, tmp_path)


@pytest.mark.parametrize("factor", [1.0, 0.5])
def test_sixteen_bits_of_a_channel_mean_what_eight_do(tmp_path: Path, factor: float) -> None:
    """Colours are encoded as sRGB, roughness is not."""
    for grey in (np.full((2, 2, 3), 128, np.uint8), np.full((2, 2, 3), 128 * 257, np.uint16)):
        use, colors = {"index": 0}, [factor, factor, factor, 1.0]
        pbr = {"baseColorTexture": use, "metallicRoughnessTexture": use, "baseColorFactor": colors}
        found = bsdf(textured(grey, tmp_path, pbrMetallicRoughness=pbr), tmp_path)
        assert isinstance(found, m.Principled)
        color, rough = texels(found.base_color, tmp_path), texels(found.roughness, tmp_path)
        assert rough.texels / (255 if rough.texels.dtype == np.uint8 else 1.0) == pytest.approx(128 / 255)
        if color.texels.dtype == np.uint8:
            assert color.srgb
            assert (color.texels == 128).all()
        else:
            assert not color.srgb
            assert color.texels == pytest.approx(0.21586 * factor, rel=1e-3)


def test_webp_stands_in_for_an_image_that_is_not_there(tmp_path: Path) -> None:
    builder = textured(np.zeros((2, 2, 3), np.uint8), tmp_path, emissiveFactor=[1, 1, 1], emissiveTexture={"index": 0})
    view = builder.view(encoded(np.full((16, 16, 3), 200, np.uint8), tmp_path, "webp"))
    second = builder.add("images", {"bufferView": view, "mimeType": "image/webp"})
    builder.json["textures"] = [{"extensions": {"EXT_texture_webp": {"source": second}}}]
    builder.json |= {"extensionsUsed": ["EXT_texture_webp"], "extensionsRequired": ["EXT_texture_webp"]}
    (shape,) = loaded(builder, tmp_path).model.shapes
    assert shape.emitter is not None
    assert texels(shape.emitter.radiance, tmp_path).texels == pytest.approx(200, abs=2)
