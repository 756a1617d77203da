"""Squared errors of renders against a reference, whose tails decide what can be trusted (`equaltime.film.tails`)."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from equaltime.film.tails import MOST_RATIO, Tail, tail_of
from equaltime.images.metrics import Reference

__all__ = ["MOST_RATIO", "Tail", "squared_errors", "tail_of"]


def squared_errors(images: Iterable[ArrayLike], reference: Reference) -> NDArray[np.float64]:
    """Return the relative squared error of each pixel of each image (H, W, 3): (K, pixels)."""
    denominator = np.maximum(reference.denominator, np.finfo(np.float64).tiny)
    squares = (np.square(np.asarray(image, np.float64) - reference.mean) / denominator for image in images)
    return np.stack([square.mean(axis=2).ravel() for square in squares])
