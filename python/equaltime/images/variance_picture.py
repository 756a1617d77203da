"""Picture of the variance of one sample of each pixel: grey on a logarithmic scale, darker where it is higher."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from equaltime.images import preview
from equaltime.images.log_scale import LogScale

__all__ = ["is_known", "of_colours", "scale_in_words", "scale_of", "write_variance"]

_DECADES: Final = (2.5, 6.0)
"""Shortest and longest scale in powers of ten: standard deviations of 1 to 18, or to 1000."""


def of_colours(variance: NDArray[Any]) -> NDArray[np.float64]:
    """Return one variance for each pixel, (H, W): the mean of R, G and B of ``variance`` (H, W, 3)."""
    return np.asarray(variance.mean(axis=-1), np.float64)


def scale_of(maps: Iterable[NDArray[Any]]) -> LogScale:
    """Return a common logarithmic scale for pictures of the variances in ``maps``, each (H, W)."""
    return LogScale.of(maps, *_DECADES)


def is_known(variance: NDArray[Any]) -> bool:
    """Tell whether ``variance`` is finite, that is known, for any pixel; a pixel with fewer than 3 samples has none."""
    return bool(np.isfinite(variance).any())


def scale_in_words(variance: NDArray[Any]) -> str:
    """Return a caption for the picture of ``variance`` (H, W, 3), which says what variances white and black mean."""
    low, _, high = scale_of([of_colours(variance)]).ticks
    return f"variance of one sample, from {low} (white) to {high} (black) on a log scale"


def write_variance(path: Path, variance: NDArray[Any], description: str = "", scene: str | None = None) -> None:
    """Write a grey picture of the variance of one sample, ``variance`` (H, W, 3), to a PNG file.

    The scale is logarithmic; darker is higher. The ends of the scale are added to ``description``. Pixels whose
    variance is unknown (infinite) are black. ``description`` and ``scene`` (the path of the scene file) become
    attributes of the file.

    Raises
    ------
    ImageError
        If the file cannot be written; an earlier file stays unchanged.
    """
    grey = of_colours(variance)
    pixels = np.round(255.0 * (1.0 - scale_of([grey]).position(grey))).astype(np.uint8)
    preview.write_grey(path, pixels, f"{scale_in_words(variance)}; {description}", scene)
