"""Limits of references by Mitsuba 3, in the words that every output uses."""

from __future__ import annotations

__all__ = ["CAVEAT", "FLOOR", "UNFIT_SAMPLERS", "fit_sampler", "is_mitsuba"]

FLOOR = 2e-3
"""Relative error of the mean that does not fall with samples, measured on Sponza: 0.0018 +- 0.0001.

Mitsuba's shadow rays start off the surface and pass over edges: 0.0013. Its density of a small sphere light, from 1 -
cos in float32, is too low: 0.0005. `tests/crosscheck/test_mitsuba_offsets.py` shows both on other scenes.
"""

CAVEAT = (
    f"a reference by Mitsuba 3 is worth no more than {100 * FLOOR:g} % where gaps or edges are small against the "
    "scene's extent from the origin, because Mitsuba moves the origin of each ray by 8.9e-5 (1 + its largest "
    "coordinate) along the normal; equaltime measured 0.18 % on Sponza"
)

UNFIT_SAMPLERS = {
    "ldsampler": "its mean of the Cornell box is 0.25 % too high, and more samples do not mend it",
    "stratified": "its mean of the Cornell box is 4 % too high at 4 samples a pixel and 0.5 % at 16",
}
"""Mitsuba's samplers with a biased mean, and the bias that equaltime measured: their images are never a reference."""

_FIT = "independent"


def fit_sampler(sampler: str) -> str:
    """Return Mitsuba's sampler for a reference of renders with `sampler`."""
    return _FIT if sampler in UNFIT_SAMPLERS else sampler


def is_mitsuba(software: str) -> bool:
    """Tell whether the software named by a file, or a peer's name, is Mitsuba."""
    return software.lower().startswith("mitsuba")
