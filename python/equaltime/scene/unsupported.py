"""Nodes that can be described but not rendered yet."""

from __future__ import annotations

from typing import TypeVar

from equaltime.scene.model import Plugin, Texture, TexturePlugin

__all__ = ["Unsupported", "constant"]

T = TypeVar("T")


class Unsupported(ValueError):
    """A node that the core cannot use yet; the caller adds its place."""

    def __init__(self, node: Plugin, what: str = "") -> None:
        self.node = node
        super().__init__(what or f"the {node.kind} '{node.title}' is not supported yet")


def constant(value: Texture | T) -> T:
    """Return `value` where only a constant is supported so far; raises `Unsupported` if it is a texture."""
    if isinstance(value, TexturePlugin):
        raise Unsupported(value)
    return value
