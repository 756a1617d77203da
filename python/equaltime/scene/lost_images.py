"""Images that a scene names and that cannot be read, and what replaces them on request."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

__all__ = ["GREY", "Lost"]

GREY: Final = 0.5
"""Value that replaces the texels of a colour: half of the light is reflected, as by many surfaces."""


@dataclass(frozen=True, slots=True)
class Lost:
    """An image that is missing or cannot be decoded, as one parameter of a surface uses it, and its substitute."""

    image: str
    """The image in words, such as ``missing image 'wood.png'``."""
    value: tuple[float, ...] = (GREY,)
    """The constant that replaces the image: one number, or a colour in linear sRGB."""
    by: str = f"a grey of {GREY:g}"
    """The constant in words."""
    of_material: bool = False
    """Whether the value is a factor of the surface itself, which any parameter can take."""
