"""Bitmaps of glTF materials: texels, computed on demand, and the parameters of the lookup.

The name of a bitmap, such as ``model.glb#/materials/2/roughness``, has the file, the material and the parameter.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Final

import numpy as np

from equaltime.scene.gltf.document import Document, Malformed
from equaltime.scene.gltf.extent import check_texels
from equaltime.scene.gltf.images import decode
from equaltime.scene.gltf.slots import Slot
from equaltime.scene.gltf.surfaces import look
from equaltime.scene.pictures import Texels

__all__ = ["MIRRORED", "bake", "bitmap_parameters"]

MIRRORED: Final = "_mirrored"
"""Suffix of the name of a normal map for triangles on which the texture appears mirrored."""
WRAPS: Final = {10497: "repeat", 33648: "mirror", 33071: "clamp"}
NEAREST: Final = 9728


def bake(document: Document, material: int, name: str) -> Texels:
    """Return the bitmap of the parameter `name` of material `material`.

    For a normal map, the suffix ``_mirrored`` of `name` inverts the green channel. Raises `Malformed` if the image is
    not valid, and KeyError if the parameter does not exist or has no texture.
    """
    slot = look(document.gltf.materials[material]).slots[name.removesuffix(MIRRORED)]
    if slot.texture is None:
        raise KeyError(name)
    source = _source(document, slot.texture.index)
    use = f"materials[{material}].{name}"
    pixels, told = decode(document, source, lambda count: check_texels(document, source, use, count))
    found = replace(slot.texels(pixels), told=told)
    if found.texels.dtype != np.uint8 and not np.isfinite(found.texels).all():
        raise Malformed((f"materials[{material}]", f"a texel of its {name} is not finite"))
    return _turned(found) if name.endswith(MIRRORED) else found


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
        raise Malformed((f"textures[{texture}]", "has no 'source' that can be read"))
    return int(source)


def bitmap_parameters(document: Document, slot: Slot) -> dict[str, Any]:
    """Return the parameters of the plugin `bitmap` for a material's parameter with a texture.

    The file name is not among the returned parameters.
    """
    use = slot.texture
    assert use is not None, "only textured parameters are given as bitmaps"
    result: dict[str, Any] = {"raw": slot.raw}
    if not np.array_equal(use.to_uv, np.eye(4)):
        result["to_uv"] = use.to_uv
    index = document.gltf.textures[use.index].sampler
    if index is not None:
        sampler = document.gltf.samplers[index]
        along_u, along_v = WRAPS[sampler.wrapS], WRAPS[sampler.wrapT]
        result["wrap_mode"] = along_u
        if along_u != along_v:
            document.note("the wrapping of u holds for v too where a sampler has two", f"samplers[{index}]")
        if sampler.magFilter == NEAREST:
            result["filter_type"] = "nearest"
    if slot.cutoff is not None:
        result["filter_type"] = "nearest"  # the interpolation was done before the cut
    return result
