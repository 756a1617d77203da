"""Known errors of reference images that Mitsuba 3 rendered, with the words by which outputs warn of them."""

from __future__ import annotations

__all__ = ["CAVEAT", "FLOOR", "UNFIT_SAMPLERS", "fit_sampler", "is_mitsuba"]

FLOOR = 2e-3
"""Relative error of Mitsuba's mean that more samples do not reduce, measured on Sponza as 0.0018 +- 0.0001.

Shadow rays cause 0.0013 of it: they start off the surface and pass over edges. The density of a small sphere light
causes 0.0005: it is computed from 1 - cos in float32, and is too low. `tests/crosscheck/test_mitsuba_offsets.py` shows
both errors on other scenes.
"""

CAVEAT = (
    f"a reference by Mitsuba 3 may be wrong by {100 * FLOOR:g} % where gaps or edges are small against the "
    "scene's extent from the origin, because Mitsuba moves the origin of each ray by 8.9e-5 (1 + its largest "
    "coordinate) along the normal; equaltime measured 0.18 % on Sponza"
)

UNFIT_SAMPLERS = {
    "ldsampler": "its mean of the Cornell box is 0.25 % too high, and more samples do not mend it",
    "stratified": "its mean of the Cornell box is 4 % too high at 4 samples a pixel and 0.5 % at 16",
}
"""Mitsuba's samplers with a biased mean, and the measured bias. Their images are never used as references."""

_FIT = "independent"


def fit_sampler(sampler: str) -> str:
    """Return the name of the Mitsuba sampler to use for rendering a reference.

    The name is `sampler` itself, or ``independent`` if the images of `sampler` are biased (`UNFIT_SAMPLERS`).
    """
    return _FIT if sampler in UNFIT_SAMPLERS else sampler


def is_mitsuba(software: str) -> bool:
    """Tell whether an image was written by Mitsuba; `software` is the name of the program in the image file."""
    return software.lower().startswith("mitsuba")
