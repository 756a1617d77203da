"""The parts of an image's error² by plain formulas for the whole image, which the core computes by bands of rows."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from equaltime.film.sums import box_sum, neighbours

Floats = NDArray[np.float64]
Counts = NDArray[np.int64]


def plain_errors(variance: Floats, samples: Counts) -> Floats:
    """Give the variance of one sample by the mean of the known ones around, over a pixel's own samples; its root."""
    counts, known = samples[..., None].astype(float), np.isfinite(variance[..., :1])
    around = np.maximum(box_sum(known.astype(float)), 1.0)
    one = box_sum(np.where(known, variance, 0.0) * counts) / around
    return np.where(known, np.sqrt(one / np.maximum(counts, 1.0)), np.inf)


def others(values: Floats) -> Floats:
    """Mean over the 7x7 neighbourhood without the pixel itself."""
    counts = np.maximum(neighbours(*values.shape[:2]) - 1.0, 1.0)
    return np.asarray((box_sum(values) - values) / counts)


def part_sums(values: Floats) -> Floats:
    """Sum the pixels around each one by parts, (5, H, W, C): halves above, below, left, right, then the eight next."""
    height, width = values.shape[:2]
    rows, columns = np.indices((height, width))
    sums = np.zeros((5, *values.shape))
    for y, x in np.ndindex(height, width):
        down, right = rows - y, columns - x
        far, next_to = np.maximum(abs(down), abs(right)), np.maximum(abs(down), abs(right)) == 1
        window = (far <= 3) & (far > 0)
        parts = [window & side for side in (down <= 0, down >= 0, right <= 0, right >= 0)]
        sums[:, y, x] = [values[part].sum(axis=0) for part in (*parts, next_to)]
    return sums


def local_means(mean: Floats, variance: Floats) -> tuple[Floats, Floats, Floats]:
    """Weigh the halves' means by their likelihood to be the mean of the next pixels (Lee 1981, for the halves)."""
    counts, means, variances = (part_sums(values) for values in (np.ones_like(mean), mean, variance))
    with np.errstate(divide="ignore", invalid="ignore"):
        apart = means[:4] / counts[:4] - means[4] / counts[4]
        noise = variances[:4] / counts[:4] ** 2 + variances[4] / counts[4] ** 2
        distances = np.where(apart == 0.0, 0.0, np.minimum(apart**2 / noise, 1e300))
    distances = np.where(counts[:4] > 0.0, distances, np.inf)
    least = np.where(np.isfinite(distances.min(axis=0)), distances.min(axis=0), 0.0)
    weights = np.exp(-0.5 * (distances - least))
    total, sums = (weights * counts[:4]).sum(axis=0), (weights * means[:4]).sum(axis=0)
    local = np.where(
        total > 0.0, (sums + weights.sum(axis=0) * mean) / np.maximum(total + weights.sum(axis=0), 1), mean
    )
    brightest = np.divide(means[:4], counts[:4], out=np.zeros_like(means[:4]), where=counts[:4] > 0.0).argmax(axis=0)
    best_mean, best_variance, best_count = (
        np.take_along_axis(values[:4], brightest[None], axis=0)[0] for values in (means, variances, counts)
    )
    surely = (best_mean + mean - 2.0 * np.sqrt(best_variance + variance)) / (best_count + 1.0)
    outside = np.divide(sums, total, out=np.zeros_like(sums), where=total > 0.0)
    return local, outside, np.maximum(local, surely)


def whole_means(mean: Floats, variance: Floats) -> tuple[Floats, Floats, Floats]:
    """Give means of the whole neighbourhood, which reach across edges; the wrong formula, for tests of tests."""
    local = box_sum(mean) / neighbours(*mean.shape[:2])
    return local, others(mean), local


def share(noise: Floats, scatter: Floats) -> Floats:
    """Weight of the local mean: the part of the scatter that is noise (Lee 1980)."""
    return np.where(scatter > 0.0, np.minimum(noise / np.where(scatter > 0.0, scatter, 1.0), 1.0), 1.0)


def plain_parts(
    mean: Floats,
    variance: Floats,
    samples: Counts,
    floor: float,
    least: Floats | float = 0.0,
    lean: float = 0.5,
    means: Callable[[Floats, Floats], tuple[Floats, Floats, Floats]] = local_means,
) -> tuple[Floats, dict[str, float]]:
    around, deviation = neighbours(*samples.shape), np.sqrt(variance)
    local, local_outside, brightest = means(mean, variance)
    scatter = (mean - local) ** 2
    with_it, without = share(box_sum(variance), box_sum(scatter)), share(others(variance), others(scatter))
    noise = np.minimum(deviation / np.maximum(mean, np.finfo(float).tiny), 1.0)
    worst = np.minimum(deviation / np.maximum(mean - deviation, np.finfo(float).tiny), 1.0)

    def reference(local: Floats, leaning: Floats, share: Floats) -> Floats:
        own = np.maximum(mean - leaning * deviation, 0.0)
        return np.maximum(local + (own - local) * (1.0 - share), least)

    inside, lenient = (reference(by, lean * noise, with_it) for by in (local, brightest))
    outside, cautious = (reference(local_outside, by, without) for by in (noise, worst))
    above, below = inside**2 + floor, outside**2 + floor
    weight = 0.2 + 0.5 * np.maximum(without, noise)
    parts = variance / (above ** (1.0 - weight) * below**weight)
    errors = plain_errors(variance, samples)
    slope = parts * ((1.0 - weight) / above + weight / below)
    moved = 2.0 * parts * ((1.0 - weight) * with_it * inside / above + weight * without * outside / below)
    by_local, by_mean = (box_sum(moved / around) * errors).mean(axis=-1), errors.mean(axis=-1)
    sums = {
        "slopes": slope.sum(),
        "locals_squared": (by_local**2).sum(),
        "crossed": (by_local * by_mean).sum(),
        "means_squared": (by_mean**2).sum(),
    }
    limits = [variance / (by**2 + floor) for by in (lenient, cautious)]
    found = np.stack([part.mean(axis=-1) for part in (parts, *limits)])
    return found, {name: float(value) for name, value in sums.items()}
