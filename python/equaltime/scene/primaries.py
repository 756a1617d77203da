"""Colours of images whose primaries are not those of sRGB: the header of an EXR file may name others."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

__all__ = ["to_srgb"]

REC709: Final = (0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329)
TOLERANCE: Final = 1e-5
"""Files hold float32."""


def to_srgb(chromaticities: Sequence[float]) -> NDArray[np.float64] | None:
    """Return the matrix (3, 3) to linear sRGB from linear RGB of other primaries; None if they are the same.

    White keeps its chromaticity, so that it may not be grey in sRGB: what OpenEXR itself makes of it, and Mitsuba.

    Parameters
    ----------
    chromaticities
        x and y of red, green, blue and white, as OpenEXR writes them.

    Raises
    ------
    ValueError
        If they are no primaries: not finite, in one line, or with a y of 0.
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


@np.errstate(divide="ignore", invalid="ignore", over="ignore")
def to_xyz(chromaticities: Sequence[float]) -> NDArray[np.float64]:
    """Return the matrix (3, 3) to CIE XYZ, in which white has a luminance of 1."""
    x, y = np.array(chromaticities, np.float64).reshape(4, 2).T
    xyz = np.array([x, y, 1.0 - x - y])
    primaries, white = xyz[:, :3], xyz[:, 3] / y[3]
    return primaries * np.linalg.solve(primaries, white)
