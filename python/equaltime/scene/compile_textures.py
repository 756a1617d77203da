"""Hands textures to the core: each once, however often it is used."""

from __future__ import annotations

from equaltime.scene.assets import Assets
from equaltime.scene.builder import Builder
from equaltime.scene.model import Texture
from equaltime.scene.unsupported import Unsupported

__all__ = ["Textures"]


class Textures:
    """The textures that a builder has been given."""

    def __init__(self, builder: Builder, assets: Assets) -> None:
        self._builder = builder
        self._assets = assets

    def index(self, texture: Texture) -> int:
        """Return the core's index of `texture`."""
        raise Unsupported(texture)
