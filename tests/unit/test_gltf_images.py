"""Images of glTF files: what cannot be read is told when the scene is loaded."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import equaltime as et

from .gltf_files import one_triangle
from .gltf_materials import loaded, textured


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
