"""Bitmaps of glTF materials: images decoded by OpenImageIO, texels computed on demand, parameters of the lookup.

The name of a bitmap, such as ``model.glb#/materials/2/roughness``, has the file, the material and the parameter.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from equaltime.errors import ImageError
from equaltime.images.reading import excess
from equaltime.scene.gltf.document import Document, Malformed, Unreadable
from equaltime.scene.gltf.extent import check_texels
from equaltime.scene.gltf.schema import BASIS, UNREADABLE
from equaltime.scene.gltf.slots import Slot, TextureUse
from equaltime.scene.gltf.surfaces import look
from equaltime.scene.lost_images import GREY, Lost
from equaltime.scene.picture_colors import REC709, luminance_weights, rgb_of_luminance_chroma
from equaltime.scene.pictures import Stored, Texels, largest, read_stored
from equaltime.words import shortened

__all__ = ["MIRRORED", "bake", "bitmap_parameters", "lost"]

MIRRORED: Final = "_mirrored"
"""Suffix of the name of a normal map for triangles on which the texture appears mirrored."""
WRAPS: Final = {10497: "repeat", 33648: "mirror", 33071: "clamp"}
NEAREST: Final = 9728


def bake(document: Document, material: int, name: str) -> Texels:
    """Return the bitmap of the parameter `name` of material `material` in `document`.

    If `name` has the suffix ``_mirrored``, as for normal maps, the green channel is inverted. Raises `Malformed` if the
    image is not valid, and KeyError if the parameter does not exist or has no texture.
    """
    slot = look(document.gltf.materials[material]).slots[name.removesuffix(MIRRORED)]
    if slot.texture is None:
        raise KeyError(name)
    source = _source(document, slot.texture.index)
    use = f"materials[{material}].{name}"
    pixels, told = _decode(document, source, lambda count: check_texels(document, source, use, count))
    found = replace(slot.texels(pixels, *_lookup(document, slot.texture)), told=told)
    if found.texels.dtype != np.uint8 and not np.isfinite(found.texels).all():
        raise Malformed((f"materials[{material}]", f"a texel of its {name} is not finite"))
    return _turned(found) if name.endswith(MIRRORED) else found


def lost(document: Document, material: int, name: str) -> Lost | None:
    """Return what replaces the bitmap of a parameter whose image cannot be read; None if the image can be read.

    The parameter is `name` of material `material`. Its factor alone replaces the bitmap, times 0.5 for a base colour.
    Raises `Malformed` and KeyError as `bake` does.
    """
    try:
        bake(document, material, name)
    except Unreadable as error:
        seen = look(document.gltf.materials[material])
        slot = seen.slots[name.removesuffix(MIRRORED)]
        colored = name == "base_color" or (seen.unlit and name == "radiance")
        value = tuple((GREY if colored else 1.0) * number for number in slot.constant)
        by = f"a grey of {GREY:g} times the factor" if colored else "the factor alone"
        return Lost(_image(document, slot, error), value, by, of_material=True)
    return None


def _image(document: Document, slot: Slot, error: Unreadable) -> str:
    """Return a lost image in words: ``missing image 'wood.png'``."""
    assert slot.texture is not None
    with suppress(Unreadable):
        index = _source(document, slot.texture.index)
        uri = document.gltf.images[index].uri
        if uri is None or uri.startswith("data:"):
            return f"unreadable image 'images[{index}]'"
        return f"{'missing' if document.size_of(uri) == 0 else 'unreadable'} image '{shortened(uri, 60)[1:-1]}'"
    return f"unreadable image 'textures[{slot.texture.index}]'"


def _turned(normals: Texels) -> Texels:
    """Return normals with their second component (green) inverted."""
    texels = normals.texels.copy()
    texels[..., 1] = (255 if texels.dtype == np.uint8 else 1) - texels[..., 1]
    return replace(normals, texels=texels)


def _source(document: Document, texture: int) -> int:
    """Return the image of a texture; the image of EXT_texture_webp counts only if there is no other."""
    found = document.gltf.textures[texture]
    webp = (found.extensions or {}).get("EXT_texture_webp", {})
    source = webp.get("source") if found.source is None else found.source
    if source is None:
        stored = f"the data is stored by {BASIS}, which is not supported: {UNREADABLE[BASIS]}"
        basis = BASIS in (found.extensions or {})
        raise Unreadable((f"textures[{texture}]", stored if basis else "has no 'source' that can be read"))
    return int(source)


def bitmap_parameters(document: Document, slot: Slot) -> dict[str, Any]:
    """Return the parameters of the plugin `bitmap` for `slot`, a material's parameter with a texture.

    The file name is not among the returned parameters. If the texture's wrap modes cannot be kept, `document` gets a
    note for the user.
    """
    use = slot.texture
    assert use is not None, "only textured parameters are given as bitmaps"
    result: dict[str, Any] = {"raw": slot.raw}
    if not np.array_equal(use.to_uv, np.eye(4)):
        result["to_uv"] = use.to_uv
    index = document.gltf.textures[use.index].sampler
    if index is not None:
        sampler = document.gltf.samplers[index]
        result["wrap_mode"], filter_type = _lookup(document, use)
        if sampler.wrapS != sampler.wrapT:
            document.note("v is wrapped like u, though the sampler wraps them differently", f"samplers[{index}]")
        if filter_type == "nearest":
            result["filter_type"] = filter_type
    if slot.cutoff is not None:
        result["filter_type"] = "nearest"  # the interpolation was done before the cut
    return result


def _lookup(document: Document, use: TextureUse) -> tuple[str, str]:
    """Return ``wrap_mode`` and ``filter_type`` of the plugin `bitmap` for a texture, as its sampler says."""
    index = document.gltf.textures[use.index].sampler
    if index is None:
        return "repeat", "bilinear"
    sampler = document.gltf.samplers[index]
    return WRAPS[sampler.wrapS], "nearest" if sampler.magFilter == NEAREST else "bilinear"


# -- images ------------------------------------------------------------------------------------------------------------

SUFFIXES: Final = {b"\x89PNG": ".png", b"\xff\xd8\xff": ".jpg", b"RIFF": ".webp"}
MOST_PIXELS: Final = 1 << 28
IGNORED: Final = (
    *("oiio:ColorSpace", "oiio:Gamma", "chromaticities", "ICCProfile", "ICCProfile:profile_description"),
    "PixelAspectRatio",
)
"""Image attributes that readers must ignore, as the specification says: materials define the encoding of textures."""
Check = Callable[[int], object]


def _decode(document: Document, index: int, check: Check) -> tuple[NDArray[Any], tuple[str, ...]]:
    """Return the pixels of image `index`, and notes on features of the image file that are not used.

    The pixels (H, W, 4) are uint8, uint16 or float32, with opacity not premultiplied. `check` is called with the number
    of pixels before they are read, and may raise `Malformed`. Raises `Malformed` if the image cannot be read.
    """
    image, place = document.gltf.images[index], f"images[{index}]"
    if image.bufferView is not None:
        try:
            content = bytes(document.view(image.bufferView))
        except Malformed as error:
            raise Unreadable(*error.problems) from error
        return _from_bytes(content, place, check)
    if image.uri is None:
        raise Unreadable((place, "needs a 'uri' or a 'bufferView'"))
    try:
        if image.uri.startswith("data:"):
            return _from_bytes(document.resource(image.uri, f"{place}.uri"), place, check)
        path = document.locate(document.relative(image.uri, f"{place}.uri"))
    except Malformed as error:
        raise Unreadable(*error.problems) from error
    except ValueError as error:
        raise Unreadable((f"{place}.uri", str(error))) from error
    return _from_file(path, place, check)


def _from_bytes(content: bytes, place: str, check: Check) -> tuple[NDArray[Any], tuple[str, ...]]:
    """Decode bytes through a private file, because OpenImageIO's Python module reads files only."""
    suffix = next((suffix for magic, suffix in SUFFIXES.items() if content.startswith(magic)), None)
    if suffix is None:
        raise Unreadable((place, "is no PNG, JPEG or WebP image"))
    with tempfile.TemporaryDirectory(prefix="equaltime-") as folder:
        path = Path(folder) / f"image{suffix}"
        path.write_bytes(content)
        return _from_file(path, place, check)


def _from_file(path: Path, place: str, check: Check) -> tuple[NDArray[Any], tuple[str, ...]]:
    def checked(spec: Any) -> None:
        if spec.width * spec.height > MOST_PIXELS:
            raise Malformed((place, f"{spec.width}x{spec.height} pixels; the limit is {MOST_PIXELS} in all"))
        if wrong := excess(spec, path):
            raise Malformed((place, wrong))
        check(spec.width * spec.height)

    try:
        stored = read_stored(path, ("uint8", "uint16"), checked)
    except ImageError as error:
        message = str(error).removeprefix(f"{path}: ").replace(str(path), path.name)  # the path may be a private file
        raise Unreadable((place, f"cannot be read as an image: {message}")) from error
    for name in IGNORED:
        stored.account.attribute(name)
    if (number := stored.account.attribute("Orientation", 1)) is not None:
        stored.account.note(f"its orientation {number} is not used: images of glTF are as they are stored")
    return _rgba(stored), tuple(f"{place}: {told}" for told in stored.account.told())


def _rgba(stored: Stored) -> NDArray[Any]:
    """Return grey, grey with opacity, RGB or RGBA as RGBA."""
    colors, alpha = stored.colors, stored.alpha
    if stored.choice.kind == "luminance and chroma":
        colors = rgb_of_luminance_chroma(colors, luminance_weights(REC709))
    height, width, channels = colors.shape
    color = colors if channels == 3 else np.repeat(colors, 3, axis=2)
    if alpha is None:
        alpha = np.full((height, width, 1), largest(colors), colors.dtype)
    return np.concatenate([color, alpha], axis=2)
