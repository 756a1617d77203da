"""What adaptive counts gain at equal counted rays, what an oracle would, what deciding costs, and that means are right.

Noise is relMSE over independent seeds times rays, even over adaptive: how many times fewer rays to equal error. It is
counted, not timed, so the machine may be busy. The oracle knows the variance of every pixel, averaged over 3x3, from
half of the seeds, and is judged by the other half: no rule that goes by the noise of pixels is far above it. Rays of
one kind take about the same time, so what is left to time is the deciding, which is timed by the processor's clock.

The last lines are a made-up light that two samples in a hundred find: the mean of many images by each metric, over the
truth, which is 1.
"""

from __future__ import annotations

import math
from time import process_time

import numpy as np
from measuring import Floats, noise, parsed, relative_variance
from uneven import CASES, case_arguments

import equaltime as et
from equaltime.adaptive import METRICS, PILOT, error_rates, pilot_statistics
from equaltime.bench import spread
from equaltime.core_renderer import make_renderer
from equaltime.error_estimate import PixelStatistics

UNEVEN = ("lens", "small lamps", "glossy plates", "cornell-box", "caustic", "opening")
EVEN = ("terrain", "stadium")


def main() -> None:
    parser = case_arguments(__doc__, seeds=48, size=96, scenes=[*UNEVEN, *EVEN])
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--images", type=int, default=10_000, help="made-up ones, for the bias [%(default)s]")
    options = parsed(parser, seeds=8, size=64, spp=32, images=300)
    gains: dict[bool, list[float]] = {True: [], False: []}
    for name in options.scenes:
        scene = CASES[name].scene(options.size)
        gains[name not in EVEN].append(report(name, scene, options.spp, options.seeds, options.threads))
    for uneven, found in gains.items():
        if found:
            mean = math.exp(sum(map(math.log, found)) / len(found))
            print(f"{'uneven' if uneven else 'even'}: geometric mean {mean:.3f}, least {min(found):.3f}")
    for metric in ("error", "history", "cutoff"):
        mean, error = made_up(metric, options.images)
        print(f"mean of {options.images} images by {metric}: {mean:.4f} ± {error:.4f} of the truth")


def report(name: str, scene: et.Scene, spp: int, seeds: int, threads: int) -> float:
    """Print the line of one scene and return its gain."""
    even, rays, per_pixel, _ = rendered(scene, "best", spp, seeds, threads)
    adaptive, adaptive_rays, _, deciding = rendered(scene, "best,adaptive=error", spp, seeds, threads)
    blocks = [list(range(start, seeds, 4)) for start in range(4)]
    ratios = [gain(even[block], adaptive[block]) * rays / adaptive_rays for block in blocks]
    found = gain(even, adaptive) * rays / adaptive_rays
    best = oracle(even, per_pixel)
    parts = spread(ratios)
    print(
        f"  {name:16} {found:.3f} (quarters of the seeds {parts.low:.3g} to {parts.high:.3g}), oracle {best:.3f}, "
        f"deciding {100 * deciding:.2g} % of the render"
    )
    return found


def rendered(scene: et.Scene, strategy: str, spp: int, seeds: int, threads: int) -> tuple[Floats, float, Floats, float]:
    """Return images (seeds, H, W, 3), rays of all, rays of a sample of each pixel, and the share of deciding."""
    images, rays, share = [], 0.0, 0.0
    parsed = et.Strategy.parse(strategy)
    for seed in range(seeds):
        renderer = make_renderer(scene, parsed, seed, threads)
        begin = process_time()
        renderer.advance(spp)
        spent = process_time() - begin
        images.append(renderer.moments["mean"].mean(axis=0))
        rays += renderer.counters["rays"] + renderer.counters["shadow_rays"]
    pilot = make_renderer(scene, et.Strategy.parse("best,adaptive=error"), 0, threads)
    pilot.advance(PILOT)
    per_pixel = pilot.pixel_rays.astype(np.float64)
    begin = process_time()
    error_rates(pilot_statistics(pilot.moments), per_pixel)
    share = (process_time() - begin) / spent
    return np.stack(images), rays, per_pixel / PILOT, share


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
