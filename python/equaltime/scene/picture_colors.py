"""Colours of a picture: the channels that hold them, and the conversion of their primaries to sRGB.

Channels are chosen by their names, such as ``R`` or ``layer.R``. An EXR header, for example, may name other primaries.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "CIE_XYZ",
    "NAMED",
    "REC709",
    "Choice",
    "choose",
    "linear_of_srgb",
    "luminance_weights",
    "rgb_of_luminance_chroma",
    "to_srgb",
]

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
    """Index of the channel that holds the opacity; None without opacity."""
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
    """Return the channels that hold the colour of a picture, given the names of all its channels in `names`.

    A layer is the part of a name before the last dot. `KINDS` lists sets of channels, such as R, G, B, in order of
    preference. The result is the first set that is complete in one layer. Channels without a layer are tried first. If
    no set is complete, the result is the first channels of the picture.
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


def linear_of_srgb(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the linear values of sRGB-encoded `values`; the curve's straight part converts negative values too."""
    high = ((np.maximum(values, 0.0) + 0.055) / 1.055) ** 2.4
    linear: NDArray[np.float64] = np.where(values <= 0.04045, values / 12.92, high)
    return linear


# -- primaries ---------------------------------------------------------------------------------------------------------

REC709: Final = (0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329)
NAMED: Final = {
    "rec709": REC709,
    "ap0": (0.7347, 0.2653, 0.0, 1.0, 0.0001, -0.077, 0.32168, 0.33767),
    "ap1": (0.713, 0.293, 0.165, 0.83, 0.128, 0.044, 0.32168, 0.33767),
    "rec2020": (0.708, 0.292, 0.17, 0.797, 0.131, 0.046, 0.3127, 0.329),
    "p3d65": (0.68, 0.32, 0.265, 0.69, 0.15, 0.06, 0.3127, 0.329),
    "adobergb": (0.64, 0.33, 0.21, 0.71, 0.15, 0.06, 0.3127, 0.329),
}
"""Chromaticities of primaries by the name in a colour space: ``ap1`` in ``lin_ap1_scene``."""
CIE_XYZ: Final = (1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0 / 3.0, 1.0 / 3.0)
"""Chromaticities of the primaries for which RGB is CIE XYZ."""
TOLERANCE: Final = 1e-5
"""Largest difference at which two chromaticities count as equal, since files hold float32."""


def to_srgb(chromaticities: Sequence[float]) -> NDArray[np.float64] | None:
    """Return the matrix (3, 3) from linear RGB with other primaries to linear sRGB; None for sRGB's own primaries.

    White keeps its chromaticity, without adaptation, and may be tinted in sRGB. OpenEXR and Mitsuba do the same.

    Parameters
    ----------
    chromaticities
        x and y of red, green, blue and white, as OpenEXR writes them.

    Raises
    ------
    ValueError
        If the chromaticities are unusable: not finite, on one line, or with a y of 0.
    """
    if np.allclose(chromaticities, REC709, rtol=0.0, atol=TOLERANCE):
        return None
    try:
        matrix = np.asarray(np.linalg.solve(to_xyz(REC709), to_xyz(chromaticities)), np.float64)
    except np.linalg.LinAlgError:
        matrix = np.full((3, 3), np.nan)
    if not np.isfinite(matrix).all():
        raise ValueError(f"its header has impossible chromaticities: {[round(c, 6) for c in chromaticities]}")
    return matrix


def luminance_weights(chromaticities: Sequence[float]) -> tuple[float, float, float]:
    """Return the weights of red, green and blue in the luminance; the weights add up to 1.

    `chromaticities` are x and y of the primaries red, green and blue, and of white.
    """
    red, green, blue = to_xyz(chromaticities)[1].tolist()
    return red, green, blue


@np.errstate(divide="ignore", invalid="ignore", over="ignore")
def to_xyz(chromaticities: Sequence[float]) -> NDArray[np.float64]:
    """Return the matrix (3, 3) from linear RGB to CIE XYZ, for which white has the luminance 1.

    `chromaticities` are x and y of the primaries red, green and blue, and of white.
    """
    x, y = np.array(chromaticities, np.float64).reshape(4, 2).T
    xyz = np.array([x, y, 1.0 - x - y])
    primaries, white = xyz[:, :3], xyz[:, 3] / y[3]
    return primaries * np.linalg.solve(primaries, white)
