"""How often upper limits hold: images that a test makes up, against a truth that it knows."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from equaltime.film.error import PixelStatistics, image_error
from equaltime.film.unseen import Unseen

__all__ = ["IMAGES", "limits_that_hold"]

IMAGES = 200


def limits_that_hold(
    render: Callable[[int], PixelStatistics], truth: NDArray[np.float64], hidden: Unseen | None
) -> int:
    """Count, of the images of `IMAGES` seeds, the upper limits above the error against the truth."""
    denominator = np.square(truth) + (0.1 * truth.mean()) ** 2
    found = 0
    for seed in range(IMAGES):
        pixels = render(seed)
        error = math.sqrt((np.square(pixels.mean - truth) / denominator).mean())
        found += image_error(pixels, hidden=hidden).high >= error
    return found
