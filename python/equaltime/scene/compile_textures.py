"""Hands textures to the core, the renderer in C++. Equal textures are added once, even under different names.

If a texture gives a parameter of a BSDF, the BSDF is first added with a placeholder value for this parameter. The
texture is then bound to the parameter by name.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np
from numpy.typing import NDArray

from equaltime.scene.assets import Assets
from equaltime.scene.core import SceneBuilder, Unsupported, constant
from equaltime.scene.model import Bitmap, Checkerboard, Color, MeshAttribute, Plugin, Texture, TexturePlugin

__all__ = ["Textures", "color", "number"]


class Textures:
    """The textures that were added to the core's scene builder; equal textures share one index."""

    def __init__(self, builder: SceneBuilder, assets: Assets) -> None:
        self._builder = builder
        self._assets = assets
        self._known: dict[Texture, int] = {}

    def index(self, texture: Texture) -> int:
        """Add `texture` if it is new, and return its index in the core; raises ValueError if its file is unusable."""
        if isinstance(texture, MeshAttribute) and texture.times is not None:
            raise Unsupported(texture, "'times' of a 'mesh_attribute' is for parameters of BSDFs")
        nameless = texture.model_copy(update={"id": None})
        if nameless not in self._known:
            self._known[nameless] = self._add(texture)
        return self._known[nameless]

    def bind(self, bsdf: int, name: str, value: object) -> None:
        """If `value` is a texture, let it give the parameter `name` of BSDF number `bsdf` in the core."""
        if isinstance(value, MeshAttribute) and value.times is not None:
            self._builder.bind(bsdf, name, self.index(_alone(value)), self.index(value.times))
        elif isinstance(value, Bitmap | Checkerboard | MeshAttribute):
            self._builder.bind(bsdf, name, self.index(value))

    def hand_over(self, shape: int, attributes: Mapping[str, NDArray[np.float64]], wanted: Iterable[Plugin]) -> None:
        """Give a shape's mesh attributes to the textures that read them.

        `shape` is the shape's number in the core. `attributes` are the mesh's arrays by name. The textures are the
        `MeshAttribute` plugins in `wanted`. Raises `Unsupported` for a texture whose attribute is missing.
        """
        looked_at = {self.index(_alone(node)): node for node in wanted if isinstance(node, MeshAttribute)}
        for index, texture in looked_at.items():
            values = attributes.get(texture.name)
            if values is None:
                raise Unsupported(texture, f"the shape has no attribute '{texture.name}'{_what_there_is(attributes)}")
            per_face = texture.name.startswith("face_")
            self._builder.set_attribute(shape, index, texture.numbers(values), per_face=per_face)

    def _add(self, texture: Texture) -> int:
        if isinstance(texture, Bitmap):
            image = self._assets.texture(texture)
            return self._builder.add_bitmap(
                image.texels,
                srgb=image.srgb and not texture.raw,
                filter=texture.filter_type,
                wrap=texture.wrap_mode,
                to_uv=texture.uv_rows,
            )
        if isinstance(texture, Checkerboard):
            colors = constant(texture.color0), constant(texture.color1)
            return self._builder.add_checkerboard(*colors, to_uv=texture.uv_rows)
        return self._builder.add_mesh_attribute()


def _alone(texture: MeshAttribute) -> MeshAttribute:
    """Return the attribute without the texture that multiplies it."""
    return texture.model_copy(update={"times": None})


def _what_there_is(attributes: Mapping[str, object]) -> str:
    return f"; it has {', '.join(map(repr, attributes))}" if attributes else ""


def color(value: Texture | Color) -> Color:
    """Return `value` if it is a constant colour; for a texture, return the placeholder (0.5, 0.5, 0.5)."""
    return (0.5, 0.5, 0.5) if isinstance(value, TexturePlugin) else value


def number(value: Texture | float) -> float:
    """Return `value` if it is a number; for a texture, return the placeholder 0.5."""
    return 0.5 if isinstance(value, TexturePlugin) else value
