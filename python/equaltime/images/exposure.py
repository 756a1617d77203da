"""Exposure of pictures for viewing, in stops: linear values are multiplied by 2 to the power of the stops.

The automatic exposure is a whole number of stops, so that two previews of one scene mostly have the same exposure. It
is 0 unless the picture would then be nearly black or nearly white. Files with linear data (EXR) are never scaled.
"""

from __future__ import annotations

import math
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "AUTO",
    "MOST_STOPS",
    "Exposure",
    "automatic_stops",
    "beside_automatic",
    "checked_exposure",
    "exposure_in_words",
    "white_share",
]

Exposure = float | Literal["auto"]
"""Exposure in stops, positive for brighter; or ``auto``, which chooses the stops from the picture."""
AUTO: Final = "auto"
MOST_STOPS: Final = 150.0
"""Largest exposure in stops, of either sign: it lifts the smallest float32 above 1."""
_TOLERANCE: Final = 2.0
"""Stops by which a picture may be too dark or too bright without a change of its exposure."""
_BRIGHT: Final = 90.0
"""Percentile of the pixels that are to be bright, but not white: half a stop below 1."""


def automatic_stops(pixels: NDArray[Any], shown: float = 0.0) -> float:
    """Return the automatic exposure of linear RGB pixels (..., 3), in whole stops.

    The exposure makes the 90th percentile of the pixels bright but not white. ``shown`` is the exposure of an earlier
    picture of the scene, in stops. The function returns ``shown`` instead of the new exposure if the two differ by less
    than 2 stops, so that pictures of one scene keep their exposure. It also returns ``shown`` if the pixels have no
    light. Pixels that are not finite are left out.
    """
    grey = np.asarray(pixels, np.float64).mean(axis=-1)
    grey = grey[np.isfinite(grey)]
    bright = float(np.percentile(grey, _BRIGHT)) if grey.size else 0.0
    if bright <= 0.0:
        return shown
    wanted = -math.log2(bright) - 0.5
    return shown if abs(wanted - shown) < _TOLERANCE else float(np.clip(round(wanted), -MOST_STOPS, MOST_STOPS))


def checked_exposure(exposure: Exposure) -> Exposure:
    """Return ``exposure``; raise ValueError if it is neither ``auto`` nor a number of at most `MOST_STOPS` stops."""
    if exposure == AUTO:
        return exposure
    if isinstance(exposure, str | bool) or not isinstance(exposure, int | float | np.number):
        raise ValueError(f"exposure is 'auto' or a number of stops, found {exposure!r}")
    if not abs(exposure) <= MOST_STOPS:
        raise ValueError(f"an exposure has at most {MOST_STOPS:g} stops, found {exposure:g}")
    return float(exposure)


def exposure_in_words(stops: float) -> str:
    """Return an exposure as text, such as ``2 stops brighter`` or ``1 stop darker``; empty for 0."""
    if stops == 0.0:
        return ""
    return f"{abs(stops):g} stop{'' if abs(stops) == 1.0 else 's'} {'brighter' if stops > 0.0 else 'darker'}"


def white_share(pixels: NDArray[Any], stops: float) -> float:
    """Return the share of linear RGB pixels (..., 3) that are white in a picture with this exposure, in [0, 1].

    A pixel is white if all its colours are 1 or more.
    """
    return float((np.asarray(pixels, np.float64) >= 2.0**-stops).all(axis=-1).mean())


def beside_automatic(stops: float, automatic: float) -> str:
    """Return a sentence that compares an exposure that was asked for with the automatic one; empty if they are equal.

    Users take the automatic picture for exposure 0, which is the scene's own values.
    """
    if stops == automatic:
        return ""
    more = abs(stops - automatic)
    how = f"{more:g} stop{'s' * (more != 1.0)} {'brighter' if stops > automatic else 'darker'}"
    return f"exposures are counted from the scene's own values (0): auto would be {automatic:g}, and {stops:g} is {how}"
