"""What adaptive counts gain in seconds and in counted rays, what an oracle would, what deciding costs, and the mean.

Noise is relMSE over independent seeds; times seconds, or rays, even over adaptive: how many times less it takes to
equal error. Renders of both take turns, seed by seed, so that a machine that drifts hurts them alike; seconds want a
machine that does nothing else, rays do not. The oracle knows the variance of every pixel, averaged over 3x3, from
half of the seeds, and is judged by the other half: no rule that goes by the noise of pixels is far above it.

The last lines are a made-up light that two samples in a hundred find: the mean of many images by each metric, over the
truth, which is 1.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from time import perf_counter

import numpy as np
from measuring import Floats, noise, parsed, ratio, relative_variance
from uneven import CASES, case_arguments

import equaltime as et
from equaltime.film.adaptive import METRICS, PILOT, error_rates, pilot_statistics
from equaltime.film.error import PixelStatistics
from equaltime.rendering.core import make_renderer

UNEVEN = ("lens", "small lamps", "glossy plates", "cornell-box", "caustic", "opening")
EVEN = ("terrain", "stadium")


def main() -> None:
    parser = case_arguments(__doc__, seeds=48, size=96, scenes=[*UNEVEN, *EVEN])
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--images", type=int, default=10_000, help="made-up ones, for the bias [%(default)s]")
    options = parsed(parser, seeds=8, size=64, spp=32, images=300)
    gains: dict[bool, list[tuple[float, float]]] = {True: [], False: []}
    for name in options.scenes:
        scene = CASES[name].scene(options.size)
        gains[name not in EVEN].append(report(name, scene, options.spp, options.seeds, options.threads))
    for uneven, found in gains.items():
        if found:
            for of, parts in zip(("seconds", "rays"), zip(*found, strict=True), strict=True):
                mean = math.exp(sum(map(math.log, parts)) / len(parts))
                print(f"{'uneven' if uneven else 'even'}, {of}: geometric mean {mean:.3f}, least {min(parts):.3f}")
    for metric in ("error", "history", "cutoff"):
        mean, error = made_up(metric, options.images)
        print(f"mean of {options.images} images by {metric}: {mean:.4f} ± {error:.4f} of the truth")


@dataclass(frozen=True)
class Rendered:
    """Images of many seeds, and what they took."""

    images: list[Floats] = field(default_factory=list)
    seconds: list[float] = field(default_factory=list)
    rays: list[float] = field(default_factory=list)


def report(name: str, scene: et.Scene, spp: int, seeds: int, threads: int) -> tuple[float, float]:
    """Print the line of one scene and return its gains in seconds and in rays."""
    even, adaptive = in_turns(scene, spp, seeds, threads)
    less_noise = gain(np.stack(even.images), np.stack(adaptive.images))
    in_rays = less_noise * sum(even.rays) / sum(adaptive.rays)
    faster = ratio(even.seconds, adaptive.seconds)
    quarters = [(even.images[start::4], adaptive.images[start::4]) for start in range(4)]
    parts = [gain(np.stack(ours), np.stack(theirs)) for ours, theirs in quarters if len(ours) > 1]
    per_pixel, deciding = decided(scene, threads)
    best = oracle(np.stack(even.images), per_pixel)
    print(
        f"  {name:16} noise {less_noise:.3f} (quarters of the seeds {min(parts, default=math.nan):.3g} to "
        f"{max(parts, default=math.nan):.3g}), seconds {faster.value:.3f} [{faster.low:.3f}, {faster.high:.3f}]: "
        f"{less_noise * faster.value:.3f} in seconds, {in_rays:.3f} in rays, oracle {best:.3f}, "
        f"deciding {100 * deciding / float(np.median(adaptive.seconds)):.2g} % of the render",
        flush=True,
    )
    return less_noise * faster.value, in_rays


def in_turns(scene: et.Scene, spp: int, seeds: int, threads: int) -> tuple[Rendered, Rendered]:
    """Render all seeds with even counts and with adaptive ones."""
    found = {"best,adaptive=none": Rendered(), "best,adaptive=error": Rendered()}
    for seed in range(-1, seeds):  # the first is for caches, and thrown away
        for words in list(found) if seed % 2 == 0 else list(found)[::-1]:
            renderer = make_renderer(scene, et.Strategy.parse(words), max(seed, 0), threads)
            begin = perf_counter()
            renderer.advance(spp)
            seconds = perf_counter() - begin
            if seed >= 0:
                found[words].seconds.append(seconds)
                found[words].images.append(renderer.moments["mean"].mean(axis=0))
                found[words].rays.append(float(renderer.counters["rays"] + renderer.counters["shadow_rays"]))
    even, adaptive = found.values()
    return even, adaptive


def decided(scene: et.Scene, threads: int) -> tuple[Floats, float]:
    """Return the rays of a sample of each pixel, and the seconds that deciding takes."""
    pilot = make_renderer(scene, et.Strategy.parse("best,adaptive=error"), 0, threads)
    pilot.advance(PILOT)
    per_pixel = pilot.pixel_rays.astype(np.float64)
    took = []
    for _ in range(5):
        begin = perf_counter()
        error_rates(pilot_statistics(pilot.moments), per_pixel)
        took.append(perf_counter() - begin)
    return per_pixel / PILOT, float(np.median(took))


def gain(even: Floats, adaptive: Floats) -> float:
    """Return the ratio of noise, of both relative to one and the same mean."""
    mean = np.concatenate([even, adaptive]).mean(axis=0)
    return noise(list(even), mean) / noise(list(adaptive), mean)


def oracle(images: Floats, rays: Floats) -> float:
    """Return the gain of counts by the variance that half of the images have, as the other half sees it; both ways."""
    halves = [relative_variance(images[k::2], images.mean(axis=0)) for k in (0, 1)]
    found = []
    for known, judge in (halves, halves[::-1]):
        counts = np.sqrt(smoothed(known) / rays)
        counts = np.maximum(counts, 0.1 * counts.mean())
        counts *= rays.sum() / (counts * rays).sum()
        found.append(judge.mean() / (judge / counts).mean())
    return math.sqrt(found[0] * found[1])


def smoothed(values: Floats) -> Floats:
    padded = np.pad(values, 1, mode="edge")
    height, width = values.shape
    return np.asarray(sum(padded[y : y + height, x : x + width] for y in range(3) for x in range(3)) / 9.0)


def made_up(metric: str, count: int) -> tuple[float, float]:
    """Return the mean of images whose truth is 1, and its standard error; one sample in fifty is 50, others are 0."""
    rng = np.random.default_rng(5)
    means = []
    for _ in range(count):
        halves = rng.binomial(PILOT // 2, 0.02, (2, 32, 32)) * 50.0 / (PILOT // 2)
        both = np.repeat(halves[..., None], 3, axis=-1)
        pilot = PixelStatistics(both.mean(axis=0), np.square(both[0] - both[1]) / 4.0, np.full((32, 32), PILOT), 1.0)
        later = 2 * np.rint(3.5 * PILOT * METRICS[metric](pilot, np.ones((32, 32)))).astype(np.int64)
        found = 50.0 * rng.binomial(later, 0.02)
        means.append(float(((PILOT * halves.mean(axis=0) + found) / (PILOT + later)).mean()))
    return float(np.mean(means)), float(np.std(means, ddof=1) / math.sqrt(count))


if __name__ == "__main__":
    main()
