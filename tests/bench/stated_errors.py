"""Whether stated errors are the realised ones, intervals hold them, and doubts are said where intervals miss.

Every seed of a scene is rendered to each count of samples. True errors are realised ones, against the mean of all
*other* seeds' last images, joined with a reference if ``--reference`` gives its samples; the noise of either is
subtracted. Nothing is timed: run it beside anything, nice.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from measuring import arguments, parsed
from numpy.typing import NDArray
from trial_scenes import TRIALS, realised_square, reference, trial_scene, wilson

import equaltime as et
from equaltime.film.second_nets import statistics_so_far
from equaltime.film.sums import box_sum
from equaltime.film.unseen import Unseen, stated_error
from equaltime.images.metrics import Reference, divided
from equaltime.rendering.core import core_settings, make_renderer
from equaltime.statistics.intervals import Interval

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Stated:
    """What a render stated, and what was true."""

    estimate: Interval
    true: float

    @property
    def above(self) -> bool:
        """Whether the true error is above the interval."""
        return self.true > self.estimate.high

    @property
    def below(self) -> bool:
        """Whether the true error is below the interval."""
        return self.true < self.estimate.low


def main() -> None:
    parser = arguments(__doc__, threads=1)
    parser.add_argument("--scenes", nargs="+", choices=TRIALS, default=[*TRIALS], help="[all]")
    parser.add_argument("--size", type=int, default=32, help="pixels along each side [%(default)s]")
    parser.add_argument("--seeds", type=int, default=60, help="[%(default)s]")
    parser.add_argument("--first", type=int, default=700_000, help="the first seed [%(default)s]")
    parser.add_argument("--counts", nargs="+", type=int, default=[2, 8, 42, 122], help="samples a pixel [%(default)s]")
    parser.add_argument("--strategy", default="best", help="[%(default)s]")
    parser.add_argument("--reference", type=int, default=0, help="samples of a reference; 0: none [%(default)s]")
    options = parsed(parser, seeds=4, size=8)
    print("scene      spp    true  stated/true [5 %, 95 %]  inside  above [95 %]       doubt  above, no doubt")
    for name in options.scenes:
        strategy = et.Strategy.parse(options.strategy)
        seeds = range(options.first, options.first + options.seeds)
        images, stated = rendered(trial_scene(name, options.size), strategy, seeds, options.counts, options.threads)
        known = reference(name, options.size, options.reference) if options.reference else None
        for index, count in enumerate(options.counts):
            truths = [
                math.sqrt(max(realised_square(images[seed, index], truth), 0.0))
                for seed in range(len(seeds))
                for truth in [others(images[:, -1], seed, known)]
            ]
            rows = [Stated(each[index], true) for each, true in zip(stated, truths, strict=True)]
            print(f"{name:9s} {count:4d}  {line(rows)}", flush=True)


def rendered(
    scene: et.Scene, strategy: et.Strategy, seeds: range, counts: list[int], threads: int
) -> tuple[Floats, list[list[Interval]]]:
    """Return images (seed, count, H, W, 3), and what each render states."""
    images, stated = [], []
    for seed in seeds:
        renderer = make_renderer(scene, strategy, seed, threads)
        unseen = Unseen.of(scene.core, core_settings(scene, strategy), seed, threads)
        found, said = [], []
        for count in counts:
            renderer.advance(count)
            pixels = statistics_so_far(renderer)
            found.append(pixels.mean)
            said.append(stated_error(pixels, unseen))
        images.append(np.stack(found))
        stated.append(said)
    return np.stack(images), stated


def others(last: Floats, seed: int, known: Reference | None) -> Reference:
    """Return the truth for one seed: the other seeds' last images and the reference.

    Each is weighed by the noise that the other one has in the 7x7 pixels around.
    """
    rest = np.delete(last, seed, axis=0)
    mean, noise = rest.mean(axis=0), rest.var(axis=0, ddof=1) / len(rest)
    if known is None:
        return Reference(mean, noise)
    own, theirs = (box_sum(divided(one, known.denominator)).mean(axis=-1)[..., None] for one in (noise, known.variance))
    share = np.divide(theirs, own + theirs, out=np.full_like(own, 0.5), where=own + theirs > 0.0)
    return Reference(share * mean + (1.0 - share) * known.mean, share**2 * noise + (1.0 - share) ** 2 * known.variance)


def line(rows: list[Stated]) -> str:
    """Return what is printed of one scene and count."""
    ratios = [row.estimate.value / row.true for row in rows if row.true > 0.0]
    low, middle, high = np.percentile(ratios, [5, 50, 95])
    above = sum(row.above for row in rows)
    inside = len(rows) - above - sum(row.below for row in rows)
    doubted = sum(bool(row.estimate.doubt) for row in rows)
    silent = sum(row.above and not row.estimate.doubt for row in rows)
    least, most = wilson(above, len(rows))
    true = np.median([row.true for row in rows])
    return (
        f"{true:6.4f}  {middle:5.2f} [{low:5.2f}, {high:5.2f}]     {inside / len(rows):.2f}"
        f"    {above / len(rows):.2f} [{least:.2f}, {most:.2f}]  {doubted / len(rows):.2f}   {silent / len(rows):.2f}"
    )


if __name__ == "__main__":
    main()
