"""Chooses the channels of a picture that hold its colour, by their names such as ``R`` or ``layer.R``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

__all__ = ["Choice", "choose", "rgb_of_luminance_chroma"]

ROLES: Final = {
    **{"r": "R", "red": "R", "g": "G", "green": "G", "b": "B", "blue": "B"},
    **{"a": "A", "alpha": "A", "y": "Y", "l": "Y", "lum": "Y", "luminance": "Y", "ry": "RY", "by": "BY"},
    **{"i": "Y", "gray": "Y", "grey": "Y", "x": "X", "z": "Z"},
}


@dataclass(frozen=True, slots=True)
class Choice:
    """The channels of a picture that hold its colour: the kind of colour, and the channels' positions in the file."""

    kind: Literal["colour", "XYZ", "luminance and chroma", "grey"]
    channels: tuple[int, ...]
    alpha: int | None
    """Position of the opacity's channel, or None."""
    named: bool
    """Whether `kind` is certain, from the channels' names or since there is only one channel."""


KINDS: Final[tuple[tuple[Literal["colour", "XYZ", "luminance and chroma", "grey"], str], ...]] = (
    ("colour", "R G B"),
    ("XYZ", "X Y Z"),
    ("luminance and chroma", "Y RY BY"),
    ("grey", "Y"),
)
"""Names of the channels of each kind of colour, preferred kinds first; X, Y, Z are CIE XYZ, as in Mitsuba."""


def choose(names: Sequence[str]) -> Choice:
    """Choose the channels that hold the colour, from the names of all channels of a picture.

    A layer is the part of a name before the last dot. The result is the first kind in `KINDS` of which any layer has
    all channels; channels without a layer are tried first. If no layer has any kind, the first channels are taken.
    """
    layers: dict[str, dict[str, int]] = {"": {}}
    for place, name in enumerate(names):
        layer, _, last = name.rpartition(".")
        role = ROLES.get(last.lower())
        if role is not None:
            layers.setdefault(layer, {}).setdefault(role, place)
    for kind, roles in KINDS:
        for found in layers.values():
            if all(role in found for role in roles.split()):
                return Choice(kind, tuple(found[role] for role in roles.split()), found.get("A"), True)
    alphas = {found["A"] for found in layers.values() if "A" in found}
    left = [place for place in range(len(names)) if place not in alphas] or [0]
    alpha = next(iter(sorted(alphas - {left[0]})), None)
    if len(left) >= 3:
        return Choice("colour", tuple(left[:3]), alpha, False)
    return Choice("grey", (left[0],), alpha, len(left) == 1)


def rgb_of_luminance_chroma(pixels: NDArray[np.float32], weights: Sequence[float]) -> NDArray[np.float32]:
    """Return the RGB image (H, W, 3) of an OpenEXR picture with luminance and chroma.

    The channels of `pixels` (H, W, 3) are Y, RY = (R - Y) / Y and BY = (B - Y) / Y. Y is the sum of R, G and B, each
    times its weight in `weights`.
    """
    luminance, over_red, over_blue = np.moveaxis(pixels.astype(np.float64), 2, 0)
    red, blue = luminance * (1.0 + over_red), luminance * (1.0 + over_blue)
    green = (luminance - weights[0] * red - weights[2] * blue) / weights[1]
    return np.stack([red, green, blue], axis=2).astype(np.float32)
