"""Peak memory of a process that renders.

The peak is not reached while paths are traced, but when the error is estimated, the file is written, or some pixels are
probed.
"""

from __future__ import annotations

from equaltime.film.error import Estimate

__all__ = ["peak_bytes"]

# Bytes per pixel: expected, least and most. Measured on four scenes, as films of 512x512 to 1024x1024 pixels less those
# of 16x16, plain and adaptive, saved as EXR with their moments. A render with an error target that quotes its price has
# a probe; one that does not quote has none.
_A_PIXEL = (330.0, 260.0, 410.0)
_A_PIXEL_IF_PROBED = (500.0, 260.0, 560.0)
# Bytes of code loaded on the way: quantiles, and the image writers.
_LOADED = (25e6, 10e6, 40e6)


def peak_bytes(before: int, pixels: int, probed: bool) -> Estimate:
    """Return the peak memory, in bytes, of a process that renders an image and saves it.

    Parameters
    ----------
    before
        Resident bytes with the scene loaded, without any film.
    probed
        Whether the render may be quoted by a probe (`equaltime.quoting.probe`).
    """
    each = _A_PIXEL_IF_PROBED if probed else _A_PIXEL
    value, low, high = (before + loaded + pixels * each_pixel for loaded, each_pixel in zip(_LOADED, each, strict=True))
    return Estimate(value, low, high, unit="MB")
