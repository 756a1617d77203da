"""glTF files of one material, and what is loaded of them."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import equaltime as et
from equaltime.scene import model as m
from equaltime.scene.gltf import Contents, split
from equaltime.scene.pictures import Texels

from .gltf_files import Builder, one_triangle

UV = [[0, 1], [1, 1], [0, 0]]  # of the triangle: v is downwards


def loaded(builder: Builder, folder: Path) -> et.Scene:
    return et.load(builder.glb(folder / "a.glb"))


def bsdf(builder: Builder, folder: Path) -> m.Bsdf:
    found = loaded(builder, folder).model.shapes[0].bsdf
    assert found is not None
    return found


def principled(folder: Path, **material: Any) -> m.Principled:
    found = bsdf(one_triangle(**material), folder)
    assert isinstance(found, m.Principled)
    return found


def warnings(builder: Builder, folder: Path) -> str:
    return "\n".join(loaded(builder, folder).warnings)


def textured(pixels: NDArray[Any], folder: Path, **textures: Any) -> Builder:
    """Return a document whose material has the texture 0, of these pixels, in the slots that `textures` describe."""
    builder = Builder()
    builder.image(pixels, folder)
    material = builder.add("materials", textures)
    builder.node(mesh=builder.mesh(material=material, TEXCOORD_0=UV))
    return builder


def texels(texture: object, folder: Path) -> Texels:
    assert isinstance(texture, m.Bitmap)
    file, fragment = split(texture.filename)
    assert fragment is not None
    found = Contents(folder / file, lambda name: folder / name).bitmap(fragment)
    assert found.texels.dtype != np.uint8 or texture.raw == (not found.srgb)
    return found
