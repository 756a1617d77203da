"""Conversion to sRGB of images with other primaries, such as the primaries that an EXR header may name."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

__all__ = ["CIE_XYZ", "NAMED", "REC709", "luminance_weights", "to_srgb"]

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
        raise ValueError(f"its header has chromaticities that no colours have: {[round(c, 6) for c in chromaticities]}")
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
