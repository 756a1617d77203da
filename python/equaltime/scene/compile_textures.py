"""Hands textures to the core: each once, however often it is used and whatever it is called.

A BSDF is added with a stand-in where a texture gives a parameter; then the texture is bound to it by the parameter's
name.
"""

from __future__ import annotations

from equaltime.scene.assets import Assets
from equaltime.scene.builder import Builder
from equaltime.scene.model import Bitmap, Bsdf, Checkerboard, Color, MeshAttribute, Texture, TexturePlugin
from equaltime.scene.unsupported import Unsupported, constant

__all__ = ["Textures", "color", "number"]


class Textures:
    """The textures that a builder has been given; equal ones share one index."""

    def __init__(self, builder: Builder, assets: Assets) -> None:
        self._builder = builder
        self._assets = assets
        self._known: dict[Texture, int] = {}

    def index(self, texture: Texture) -> int:
        """Return the core's index of `texture`; raises ValueError if its file cannot be used."""
        nameless = texture.model_copy(update={"id": None})
        if nameless not in self._known:
            self._known[nameless] = self._add(texture)
        return self._known[nameless]

    def bind(self, bsdf: Bsdf, index: int) -> None:
        """Bind those parameters of `bsdf`, the core's `index`, that are textures."""
        for name in type(bsdf).model_fields:
            value = getattr(bsdf, name)
            if isinstance(value, Bitmap | Checkerboard | MeshAttribute):
                self._builder.bind(index, name, self.index(value))

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
        raise Unsupported(texture)


def color(value: Texture | Color) -> Color:
    """Return a colour that is the same everywhere; a stand-in for a texture, which is bound later."""
    return (0.5, 0.5, 0.5) if isinstance(value, TexturePlugin) else value


def number(value: Texture | float) -> float:
    """Return a number that is the same everywhere; a stand-in for a texture, which is bound later."""
    return 0.5 if isinstance(value, TexturePlugin) else value
