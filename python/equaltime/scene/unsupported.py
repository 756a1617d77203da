"""The error for plugins that a scene can describe but the core cannot render yet."""

from __future__ import annotations

from typing import TypeVar

from equaltime.scene.model import Plugin, Texture, TexturePlugin

__all__ = ["Unsupported", "constant"]

T = TypeVar("T")


class Unsupported(ValueError):
    """Raised for the plugin `node`, which the core (the renderer in C++) cannot use yet.

    The caller adds the file and line of the plugin.
    """

    def __init__(self, node: Plugin, what: str = "") -> None:
        self.node = node
        super().__init__(what or f"the {node.kind} '{node.title}' is not supported yet")


def constant(value: Texture | T) -> T:
    """Return `value` unchanged if it is no texture; raises `Unsupported` for a texture."""
    if isinstance(value, TexturePlugin):
        raise Unsupported(value)
    return value
