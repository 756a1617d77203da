"""What memory a process that renders takes at its peak.

That is not while paths are traced, but where the error is estimated, the file is written, or some pixels are probed.
"""

from __future__ import annotations

from equaltime.film.error import Estimate

__all__ = ["peak_bytes"]

# Bytes, what is expected and from least to most: of films of 512x512 to 1024x1024 pixels, plain and adaptive, saved as
# EXR with their moments, over those of 16x16 (measured on four scenes). A render that is asked for an error and tells
# its price has a probe; one that does not tell has none.
_A_PIXEL = (330.0, 260.0, 410.0)
_A_PIXEL_IF_PROBED = (500.0, 260.0, 560.0)
# Loaded on the way: quantiles, and what writes images.
_LOADED = (25e6, 10e6, 40e6)


def peak_bytes(before: int, pixels: int, probed: bool) -> Estimate:
    """Return the most that a process will have which renders an image and saves it.

    Parameters
    ----------
    before
        What it has with the scene loaded, without any film.
    probed
        Whether it may quote the render by a probe (`equaltime.quoting.probe`).
    """
    each = _A_PIXEL_IF_PROBED if probed else _A_PIXEL
    value, low, high = (before + loaded + pixels * each_pixel for loaded, each_pixel in zip(_LOADED, each, strict=True))
    return Estimate(value, low, high, unit="MB")
