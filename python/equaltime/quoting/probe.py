"""Probe: some pixels of an image, rendered to the image's final sample count, to predict the error of the image.

The first few low-discrepancy samples do not show how fast the error falls. A power law that is extrapolated by a factor
of twenty in samples misses the needed count by a third. A probe extrapolates over pixels instead of samples: a few
hundred pixels predict the error of all. Each is drawn with a probability in proportion to its likely contribution
(Hansen and Hurwitz 1943). That contribution is error² in the pilot, averaged over the pixel's neighbourhood. A fraction
of the mean is added, since a pilot has not met all noise. The running sum of the contributions, row by row, is divided
into equal intervals, with one draw in each.

The samples are the ones that a render with the same seed will take. The samples of a pixel may be one net, a
low-discrepancy point set (`equaltime.rendering.core.nets`). Then every pixel of a probe has a second net, since one net
alone does not show its own error.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from equaltime.film.error import PixelStatistics, error_parts, expected_half_width, pixel_statistics
from equaltime.film.lamps import Lamps
from equaltime.film.sums import box_sum, error_floor, neighbours
from equaltime.quoting.law import Probed
from equaltime.rendering.core import bad_sample, make_renderer, nets
from equaltime.rendering.session import Session
from equaltime.scene import Scene
from equaltime.strategy import Strategy

__all__ = ["Probe"]

Floats = NDArray[np.float64]

_EVENLY = 0.4
"""Share of the draws that is spread evenly over the pixels."""
_LEAST_DOUBT = 0.04
"""Least standard deviation of log(error): effect of the pilot's noise on the denominators of squares (measured)."""
_LEAST_WIDTH = 0.01
"""Least logarithm of the upper limit over the estimate."""


class Probe:
    """Render of some pixels of an image to later sample counts, to predict the image's error at these counts.

    Parameters
    ----------
    scene, strategy, seed
        Scene, strategy and seed of the image's render, whose samples the probe renders earlier.
    threads
        Number of threads; 0 is one for each processor.
    pilot
        Statistics of the whole image after the pilot, the short render of all pixels.
    rates
        (H, W): sample count of each pixel divided by the mean count, at the end of the render.
    draws
        Number of draws. A pixel with a large part of the error may be drawn more than once, and is rendered once.
    lamps
        Lamps that the camera sees; small ones widen the upper limit of the image's error.

    Raises
    ------
    RenderError
        If there is not enough memory for a second film.
    """

    def __init__(
        self,
        scene: Scene,
        strategy: Strategy,
        seed: int,
        threads: int,
        pilot: PixelStatistics,
        rates: Floats,
        draws: int,
        lamps: Lamps,
    ) -> None:
        self._scene, self._strategy, self._seed, self._pilot = scene, strategy, seed, pilot
        self._rates, self._lamps = rates, lamps
        self._mean = float(pilot.mean.mean())
        self._least = lamps.least(*pilot.samples.shape)
        around = _around(error_parts(pilot, self._mean, self._least).value[..., None])
        self._sizes = ((1.0 - _EVENLY) * around + _EVENLY * around.mean()).ravel()
        self._drawn = _draw(self._sizes, draws, np.random.default_rng(seed))
        chosen = np.zeros(rates.shape, np.float32)
        chosen.flat[self._drawn] = 1.0
        local, self._picture = _without_noise(pilot)
        self._scale = 1.0 / (np.square(local) + error_floor(self._mean))
        even = strategy.model_copy(update={"adaptive": "none"})
        beside = 1 if nets(scene, even) == 1 else 0
        self._cost = (1 + beside) * float((chosen * rates).sum())
        self._renderer = make_renderer(scene, even, seed, threads, second_net=beside)
        self._renderer.set_sample_rates(0, (chosen * rates).astype(np.float32))
        self._samples = 0

    @classmethod
    def of(cls, session: Session, samples: int, draws: int) -> Probe:
        """Return a probe of the render in ``session``: pixels chosen by ``draws`` random draws.

        ``samples`` is the final sample count per pixel of the render. The samples rendered so far decide the
        probability with which each pixel is drawn.
        """
        return cls(
            session.job.scene,
            session.decided,
            session.job.seed,
            session.job.threads,
            session.statistics(),
            session.rates(samples),
            draws,
            session.lamps,
        )

    @property
    def taken(self) -> float:
        """Number of samples that the probe has taken, over all its pixels.

        The samples of a pixel may be one net (low-discrepancy point set). A second, independent net then tells the
        variance, and its samples are counted too.
        """
        return self._samples * self._cost

    def most_samples(self, taken: float) -> int:
        """Return the largest sample count per pixel, an even number, to which the drawn pixels can be rendered.

        ``taken`` is the number of samples, over all drawn pixels, that the probe may render for it.
        """
        return 2 * math.floor(0.5 * taken / self._cost)

    def advance(self, samples: int) -> Probed | None:
        """Render the drawn pixels up to ``samples`` per pixel; return the predicted error of the image at that count.

        The result is None if the drawn pixels have no noise: too few were drawn for a prediction.

        Raises
        ------
        SampleError
            If a sample is NaN or infinite, or raised a floating-point fault.
        """
        self._renderer.advance(samples)
        self._samples = samples
        if self._renderer.nonfinite:
            raise bad_sample(self._scene, self._strategy, self._seed, self._renderer)
        together = self._together(self._found())
        parts = error_parts(together, self._mean, self._least)
        drawn = parts.value.ravel()[self._drawn]
        counts = drawn / self._sizes[self._drawn]
        if not counts.any():
            return None
        square = float(counts.mean() * self._sizes.mean())
        doubt = math.hypot(0.5 * float(counts.std(ddof=1) / counts.mean()) / math.sqrt(len(counts)), _LEAST_DOUBT)
        missed = self._lamps.missed(replace(together, samples=np.rint(samples * self._rates).astype(np.int64)))
        high = math.hypot(self._high(parts.cautious), math.sqrt(missed))
        return Probed(samples, math.sqrt(square), doubt, max(math.log(high / math.sqrt(square)), _LEAST_WIDTH))

    def _found(self) -> PixelStatistics:
        """Return the statistics of the drawn pixels: with two nets, the variance is that of one of them."""
        found, beside = pixel_statistics(self._renderer.moments), self._renderer.second_moments
        if not beside.size:
            return found
        other = pixel_statistics(beside).mean
        return replace(found, mean=0.5 * (found.mean + other), variance=0.5 * np.square(found.mean - other))

    def _high(self, cautious: Floats) -> float:
        """Return the upper limit of the error, by the cautious parts of the drawn pixels."""
        drawn = cautious.ravel()[self._drawn]
        counts = drawn / self._sizes[self._drawn]
        square = float(counts.mean() * self._sizes.mean())
        squares = float((counts * drawn).mean() * self._sizes.mean()) / square**2
        return math.sqrt(square) * math.exp(expected_half_width(squares, cautious.size, self._pilot.degrees))

    def _together(self, found: PixelStatistics) -> PixelStatistics:
        """Return the picture of the pilot with the probe's pixels in it, as if all pixels had gone as far.

        The variance of the other pixels is the pilot's, reduced by the factor by which that of the drawn ones has
        fallen.
        """
        pilot, there = self._pilot, (found.samples > 0)[..., None]
        variance = np.where(there, found.variance, pilot.variance)
        before, now = (
            float(((each * self._scale).mean(axis=-1).ravel() / self._sizes)[self._drawn].sum())
            for each in (pilot.variance, variance)
        )
        variance = np.where(there, variance, variance * (now / before if before > 0.0 else 0.0))
        mean = np.where(there, found.mean, self._picture)
        return PixelStatistics(mean, variance, np.where(there[..., 0], found.samples, pilot.samples), pilot.degrees)


def _without_noise(pixels: PixelStatistics) -> tuple[Floats, Floats]:
    """Return local means, and a picture that scatters about them as the image does, less the noise (Lee 1980)."""
    local, noise = _around(pixels.mean), _around(pixels.variance)
    scatter = np.maximum(_around(np.square(pixels.mean - local)), np.finfo(np.float64).tiny)
    return local, local + (pixels.mean - local) * np.sqrt(1.0 - np.minimum(noise / scatter, 1.0))


def _around(values: Floats) -> Floats:
    """Average over the 7x7 neighbourhood of each pixel."""
    return np.asarray(box_sum(values) / neighbours(*values.shape[:2]))


def _draw(sizes: Floats, draws: int, random: np.random.Generator) -> NDArray[np.intp]:
    """Return indices, in proportion to their sizes: one from each of ``draws`` equal parts of the sum."""
    sums = sizes.cumsum()
    marks = (np.arange(draws) + random.random(draws)) * (sums[-1] / draws)
    return np.asarray(np.minimum(np.searchsorted(sums, marks), sizes.size - 1))
