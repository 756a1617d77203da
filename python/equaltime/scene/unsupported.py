"""The error for plugins that a scene can describe but the core cannot render yet."""

from __future__ import annotations

from typing import TypeVar

from equaltime.scene.model import Plugin, Texture, TexturePlugin

__all__ = ["Unsupported", "constant"]

T = TypeVar("T")


class Unsupported(ValueError):
    """Raised for a plugin that the core cannot use yet. The caller adds the place of the plugin, `node`."""

    def __init__(self, node: Plugin, what: str = "") -> None:
        self.node = node
        super().__init__(what or f"the {node.kind} '{node.title}' is not supported yet")


def constant(value: Texture | T) -> T:
    """Return `value`, which must be a constant; raises `Unsupported` if `value` is a texture."""
    if isinstance(value, TexturePlugin):
        raise Unsupported(value)
    return value
