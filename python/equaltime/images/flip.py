"""HDR-FLIP: the difference that a viewer sees when flipping between two images (Andersson et al. 2020, 2021)."""

from __future__ import annotations

import math
from importlib.util import find_spec

import numpy as np
from numpy.typing import ArrayLike

from equaltime.extras import optional

__all__ = ["available", "flip"]

_PACKAGE = "flip_evaluator"
_LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
# Luminance that the tone mapper (Narkowicz's fit to ACES) shows as 0.85 of white. FLIP's exposures map the brightest
# pixel and the median pixel to it.
_SHOWN = 2.1189
# Smallest median, relative to the brightest pixel, from which an exposure is derived: float32's precision, also the
# package's limit. An image with half of its pixels black has this median.
_DIMMEST = 2.0**-23
# Largest value after scaling: far beyond white at every exposure; its square is finite in float32 at the longest.
_BRIGHTEST = 2.0**30


def available() -> bool:
    """Tell whether the Python package ``flip-evaluator``, which computes FLIP, is installed."""
    try:
        return find_spec(_PACKAGE) is not None
    except ValueError:  # already imported, but disabled
        return False


def flip(image: ArrayLike, reference: ArrayLike) -> float:
    """Return HDR-FLIP between ``image`` and ``reference``, both (H, W, 3) in linear RGB, as its mean over pixels.

    The value is 0 for equal images, and 1 for the largest difference. NVIDIA's package ``flip-evaluator`` computes it,
    at the default of 67 pixels per degree. Negative pixel values count as black. FLIP takes its exposures from the
    reference, so a common factor of both images changes nothing. The package ends the process if a reference is dim.
    Both images are therefore scaled by a power of two, which brings the brightest luminance of the reference near 1.
    The package gets the exposures that it would derive itself.

    Raises
    ------
    EqualtimeError
        If the package is missing.
    """
    evaluate = optional(_PACKAGE).evaluate
    pixels, truth = (np.maximum(np.asarray(a, np.float64), 0.0) for a in (image, reference))
    luminance = np.sort((truth @ _LUMINANCE).ravel())
    highest, middle = float(luminance[-1]), float(luminance[luminance.size // 2])
    scale = math.ldexp(1.0, -math.frexp(highest)[1])
    exposures = (0.0, 0.0)
    if highest > 0.0:
        start = math.log2(_SHOWN / (highest * scale))
        exposures = (start, start + math.log2(highest / max(middle, _DIMMEST * highest)))
    parameters = dict(zip(("startExposure", "stopExposure"), exposures, strict=True))
    scaled = (np.minimum(a * scale, _BRIGHTEST).astype(np.float32, order="C") for a in (truth, pixels))
    return float(evaluate(*scaled, "HDR", applyMagma=False, parameters=parameters)[1])
