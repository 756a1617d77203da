"""HDR-FLIP: how much a viewer would see when flipping between two images (Andersson et al. 2020, 2021)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from equaltime.cost.extras import optional

__all__ = ["flip"]

_LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
_CLOSEST_STOPS = 1e-3


def flip(image: ArrayLike, reference: ArrayLike) -> float:
    """Return the mean HDR-FLIP of an image (H, W, 3) in linear RGB: 0 is equal, 1 is as far as can be.

    By NVIDIA's ``flip-evaluator``, at its default of 67 pixels per degree, with the exposures that it derives from the
    reference. Negative values are shown as black. The package ends the process if a reference calls for no range of
    exposures (all one luminance); such a reference is seen at the single exposure that its luminance calls for.
    """
    pixels, truth = (np.maximum(np.asarray(a, np.float32), 0.0) for a in (image, reference))
    luminance = truth.astype(np.float64) @ _LUMINANCE
    highest, middle = float(luminance.max()), float(np.median(luminance))
    parameters = {}
    if middle > 0.0 and math.log2(highest / middle) < _CLOSEST_STOPS:
        parameters = dict.fromkeys(("startExposure", "stopExposure"), -math.log2(highest))
    elif highest == 0.0:
        parameters = {"startExposure": 0.0, "stopExposure": 0.0}
    evaluate = optional("flip_evaluator").evaluate
    contiguous = (np.ascontiguousarray(a) for a in (truth, pixels))
    return float(evaluate(*contiguous, "HDR", applyMagma=False, parameters=parameters)[1])
