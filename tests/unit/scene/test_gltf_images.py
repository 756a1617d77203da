"""Images of glTF files: what cannot be read is told when the scene is loaded."""

import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

import equaltime as et
from equaltime.scene import model as m

from .gltf_files import Builder, encoded, one_triangle
from .gltf_materials import UV, bsdf, loaded, texels, textured
from .picture_files import png_with


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


def embedded(content: bytes) -> Builder:
    """Return a document whose texture is this file."""
    builder = Builder()
    image = builder.add("images", {"bufferView": builder.view(content), "mimeType": "image/png"})
    texture = builder.add("textures", {"source": image})
    material = builder.add("materials", {"pbrMetallicRoughness": {"baseColorTexture": {"index": texture}}})
    builder.node(mesh=builder.mesh(material=material, TEXCOORD_0=UV))
    return builder


def png(path: Path, pixels: NDArray[np.uint8], **more: Any) -> bytes:
    Image.fromarray(pixels).save(path, **more)
    return path.read_bytes()


def test_images_are_as_they_are_stored_whatever_orientation_they_name(tmp_path: Path) -> None:
    """Texture coordinates begin at the upper left corner of what is stored; an orientation is told."""
    pixels = np.random.default_rng(1).integers(0, 256, (4, 6, 3), np.uint8)
    exif = Image.Exif()
    exif[0x0112] = 6
    builder = embedded(png(tmp_path / "a.png", pixels, exif=exif))
    found = bsdf(builder, tmp_path)
    assert isinstance(found, m.Principled)
    assert (texels(found.base_color, tmp_path).texels == pixels).all()
    expected = "images[0]: its orientation 6 is not used: images of glTF are as they are stored"
    assert [told for told in loaded(builder, tmp_path).warnings if expected in told]


def test_what_images_say_of_their_colour_space_is_ignored(tmp_path: Path) -> None:
    pixels = np.random.default_rng(1).integers(0, 256, (4, 6, 3), np.uint8)
    png(tmp_path / "a.png", pixels)
    linear = png_with(tmp_path / "a.png", b"gAMA", struct.pack(">I", 100000)).read_bytes()
    builder = embedded(linear)
    found = bsdf(builder, tmp_path)
    assert isinstance(found, m.Principled)
    color = texels(found.base_color, tmp_path)
    assert color.srgb
    assert (color.texels == pixels).all()
    assert not [told for told in loaded(builder, tmp_path).warnings if "images[0]" in told]


def test_what_else_is_in_an_image_is_told_once_however_many_materials_use_it(tmp_path: Path) -> None:
    frames = [Image.new("RGB", (6, 4), color) for color in ("red", "green")]
    frames[0].save(tmp_path / "b.webp", save_all=True, append_images=frames[1:], lossless=True)
    builder = embedded((tmp_path / "b.webp").read_bytes())
    use = {"index": 0}
    builder.json["materials"][0] |= {"emissiveFactor": [1, 1, 1], "emissiveTexture": use, "normalTexture": use}
    told = [line for line in loaded(builder, tmp_path).warnings if "images[0]" in line]
    assert told == [f"{tmp_path / 'a.glb'}: images[0]: the first of 2 images in the file is used"]
