"""Light that no sample has found: the light that black pixels may hide, and small lamps (`equaltime.film.lamps`).

A pixel whose samples were all black has no variance, so its error bar would say that it is certainly black. But an
event that N samples have not met may still have a probability of 3/N (the rule of three: ``(1 - 3/N)^N`` is 5 %). The
light of such an event is at most the result of next-event estimation without shadow rays. So the radiance of a black
pixel is below ``-ln(p) · bound / N`` with a confidence of 1 - p. This limit tells the largest amount that the pixel may
add to the image's error².

N is the number of samples in the whole 7x7 neighbourhood, and the bound is the largest in it. Pixels count only if the
whole neighbourhood is black. Elsewhere some neighbours have met light, and their variance covers the black pixels too.
A pixel is certainly dark, and does not count, if its paths meet no surface, or only surfaces that no light faces. Light
that may be hidden widens the upper limit of an image's error, and never moves the estimate.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import cache, cached_property, partial, reduce
from typing import Any

import numpy as np
from numpy.typing import NDArray

from equaltime.film.error import PixelStatistics, error_and_brightest
from equaltime.film.focus import Focus
from equaltime.film.lamps import Lamps
from equaltime.film.sums import RADIUS, box_sum, error_floor, unshadowed, window_around
from equaltime.film.tails import averaged_out
from equaltime.machine import worker_threads
from equaltime.statistics.intervals import Interval

__all__ = ["FAR_APART", "Unseen", "stated", "stated_error"]

FAR_APART = 1e12
"""Largest ratio of the radiances of two lights for which tests show that the dimmer light is not lost (``tests/hard``,
S22)."""

Floats = NDArray[np.float64]

_STEP = 2
"""Step in pixels: the bound is computed for every second pixel of a neighbourhood along each side."""
_ANYTHING = 1e150
"""Radiance above any light: with it, a pixel hides all that it can, which is 1 of its own part of error²."""


class Unseen:
    """Light that the samples of one render may have missed, which raises the upper limit of the render's error.

    The object is callable. Its arguments are ``pixels``, the statistics of the image, and ``level``, a confidence level
    in (0, 1). It returns an upper limit, at this confidence level, of the error² due to missed light.

    Parameters
    ----------
    possible
        Callable that takes pixels ``y * width + x``, (N,), and returns the largest radiance that a sample of each pixel
        could have seen, (N, 3).
    known
        Results of ``possible`` that are known already, (H, W, 3); NaN for all other pixels. None if no result is known.
    lamps
        Callable that returns the lamps that the camera sees.
    focus
        Callable that returns the light that specular surfaces focus.
    """

    def __init__(
        self,
        possible: Callable[[NDArray[np.uint32]], Floats],
        known: Floats | None = None,
        lamps: Callable[[], Lamps] = Lamps.none,
        focus: Callable[[], Focus] = Focus.none,
    ) -> None:
        self._possible = possible
        self._known = known
        self._find_lamps, self._find_focus = lamps, focus

    @classmethod
    def of(cls, scene: Any, settings: Any, seed: int, threads: int, surfaces: Callable[[], str] = str) -> Unseen:
        """Return the light that the samples of a render of the core's scene may miss.

        ``settings`` are the core's settings of the render, and ``seed`` is its seed. ``threads`` is the number of
        threads of the searches for such light; 0 is one for each processor. A search runs when its result is first
        needed. ``surfaces`` returns the kinds of the scene's specular surfaces in words; empty if unknown.
        """
        threads = worker_threads(threads)
        focus = cache(partial(Focus.of, scene, settings, seed, threads, surfaces=surfaces))

        def lamps() -> Lamps:
            return Lamps.of(scene, settings, seed, threads, focus().possible)

        return cls(partial(unshadowed, scene, settings, seed=seed, threads=threads), lamps=lamps, focus=focus)

    @classmethod
    def together(cls, parts: Sequence[Mapping[str, NDArray[np.float32]]], focus: Focus | None = None) -> Unseen:
        """Return the light that may be missing from an image merged from several renders.

        Each entry of ``parts`` is the dict of images that `Unseen.parts` returned for one render. ``focus`` is the
        light that specular surfaces focus. A pixel that is black in the merged image is black in every render, so every
        render has stored a bound of its hidden light. Pixels without a bound may hide any amount of light. A lamp
        counts if at least one render has stored it.
        """
        found = [part["unseen"].astype(np.float64) for part in parts if "unseen" in part]
        known = np.clip(reduce(np.fmax, found), 0.0, _ANYTHING) if found else None
        lamps = Lamps.from_channels(*(part["lamps"] for part in parts if "lamps" in part))
        return cls(
            lambda pixels: np.full((len(pixels), 3), _ANYTHING), known, lambda: lamps, lambda: focus or Focus.none()
        )

    @cached_property
    def lamps(self) -> Lamps:
        """Lamps that the camera sees. The search for them runs at the first access."""
        return self._find_lamps()

    @cached_property
    def focus(self) -> Focus:
        """Light that specular surfaces focus and that samples may have missed, estimated at the first access."""
        return self._find_focus()

    def parts(self, height: int, width: int) -> dict[str, NDArray[np.float32]]:
        """Return images of this object's numbers, by name, which a file of the render stores for `Unseen.together`.

        H is ``height`` and W is ``width``, in pixels. Images without content are left out. ``unseen`` (H, W, 3) holds
        the largest radiance that black pixels may hide, and NaN where it was not computed. ``lamps`` (H, W, 4) holds
        the light that small lamps add to each pixel, and the share of the pixel's samples that meet a lamp.
        """
        parts = {}
        if self._known is not None and not np.isnan(self._known).all():
            parts["unseen"] = np.minimum(self._known, np.finfo(np.float32).max).astype(np.float32)
        if self.lamps.pixels.size:
            parts["lamps"] = self.lamps.channels(height, width)
        return parts

    def __call__(self, pixels: PixelStatistics, level: float) -> float:
        """Return the upper limit of the error² due to light that samples may have missed, at a confidence level.

        ``pixels`` are the statistics of the image, and ``level`` is the confidence level, in (0, 1).
        """
        return self.lasting(pixels, level) + self.lamps.outshone(pixels)

    def lasting(self, pixels: PixelStatistics, level: float) -> float:
        """Return an upper limit of the error² due to missed light, without the part that a few more samples remove.

        ``pixels`` are the statistics of the image, and ``level`` is the confidence level. The part left out is due to
        small lamps that samples happened to meet too soon.
        """
        return self._by_black(pixels, level) + self.lamps.missed(pixels)

    def _by_black(self, pixels: PixelStatistics, level: float) -> float:
        m = float(pixels.mean.mean())
        black = np.asarray(~(pixels.mean.any(axis=-1) | pixels.variance.any(axis=-1)))
        if not black.any():
            return 0.0
        near = window_around(black)  # pixels beyond the window contribute nothing
        hidden = _around(~black[near]) == 0.0
        if not hidden.any():
            return 0.0
        asked = np.zeros_like(black)
        asked[near] = black[near] & (_around(hidden) > 0.0)
        largest = _largest_around(self._find(asked)[near])[hidden]
        samples = _around(pixels.samples[near])[hidden, None]
        square = np.square(math.log(2.0 / (1.0 - level)) * largest / samples)
        whole = square + error_floor(m)
        return float(np.divide(square, whole, out=np.zeros_like(whole), where=whole > 0.0).sum()) / pixels.mean.size

    def _find(self, asked: NDArray[np.bool_]) -> Floats:
        """Return the bounds of the asked pixels, (H, W, 3); each bound is computed once in a render."""
        if self._known is None:
            self._known = np.full((*asked.shape, 3), np.nan)
        lattice = np.zeros_like(asked)
        lattice[::_STEP, ::_STEP] = True
        unknown = np.flatnonzero(asked & lattice & np.isnan(self._known[..., 0])).astype(np.uint32)
        if unknown.size:
            self._known.reshape(-1, 3)[unknown] = self._possible(unknown)
        return np.where(asked[..., None], np.nan_to_num(self._known), 0.0)


def stated_error(
    pixels: PixelStatistics,
    unseen: Unseen | None = None,
    level: float = 0.95,
    lasting: bool = False,
    brightest: float = 0.0,
) -> Interval:
    """Return the relative error that a render estimates of its own image, with its interval; 0.02 is 2 %.

    Outputs show this error, files store it, and the render's error limit is compared with it.

    Parameters
    ----------
    pixels
        Mean, variance and sample count of every pixel.
    unseen
        Light that the samples may have missed, which raises the upper limit; None leaves it out.
    level
        Confidence level of the interval, in (0, 1).
    lasting
        Leave out the part of ``unseen`` that a few more samples would remove (`Unseen.lasting`).
    brightest
        Largest brightness of a path that `stated` returned at earlier estimates during the render; 0 if there are none.
        It tells whether a bright path has averaged out, which is a reason to doubt the error.
    """
    return stated(pixels, unseen, level, lasting, brightest)[0]


def stated(
    pixels: PixelStatistics,
    unseen: Unseen | None = None,
    level: float = 0.95,
    lasting: bool = False,
    brightest: float = 0.0,
) -> tuple[Interval, float]:
    """Return the relative error that a render estimates of its own image, and the brightness of its brightest path.

    The error is the result of `stated_error`. The brightness is the share of error² that the most outstanding pixel
    makes, times error² and the square of the samples per pixel. As long as one path makes that share, more samples do
    not change the brightness. Give the largest brightness so far as ``brightest`` to later estimates of the same
    render.

    Parameters
    ----------
    pixels
        Mean, variance and sample count of every pixel.
    unseen
        Light that the samples may have missed, which raises the upper limit; None leaves it out.
    level
        Confidence level of the interval, in (0, 1).
    lasting
        Leave out the part of ``unseen`` that a few more samples would remove (`Unseen.lasting`).
    brightest
        Largest brightness that this function returned at earlier estimates during the render; 0 if there are none.
    """
    if unseen is None:
        found, share = error_and_brightest(pixels, level)
    else:
        hidden, least = unseen.lasting if lasting else unseen, unseen.lamps.least(*pixels.samples.shape)
        found, share = error_and_brightest(pixels, level, hidden, least)
    if not found.known:
        return found, 0.0
    samples, square = float(pixels.samples.mean()), found.value**2
    focused = unseen.focus.doubt(samples, found.value, float(pixels.mean.mean())) if unseen is not None else ""
    doubt = focused or averaged_out(brightest, samples, square, share)
    return (found.doubted(doubt) if doubt else found), share * square * samples**2


def _around(values: NDArray[Any]) -> Floats:
    """Return the sum over the 7x7 neighbourhood of each pixel."""
    return box_sum(values[..., None].astype(np.float64))[..., 0]


def _largest_around(values: Floats) -> Floats:
    """Return the largest of nonnegative values over the 7x7 neighbourhood of each pixel."""
    for axis in (0, 1):
        line = np.moveaxis(values, axis, 0)
        found = line.copy()
        for step in range(1, RADIUS + 1):
            np.maximum(found[step:], line[:-step], out=found[step:])
            np.maximum(found[:-step], line[step:], out=found[:-step])
        values = np.moveaxis(found, 0, axis)
    return values
