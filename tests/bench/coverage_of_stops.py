"""Whether renders that stop at an error are there, what they spend, and whether stated intervals hold the truth.

Every seed of a scene is rendered once, as far as the strictest target's stop; what a render to each target would have
looked at, and where it would have stopped, is read off on the way (samples are the same ones, and looks depend on
counts alone; for the first seed the command's own render is compared). True errors are realised ones, against the mean
of all *other* seeds' last images, whose noise is subtracted. The oracle spends, for each target, the least number of
samples at which 95 % of the seeds are there. Nothing is timed: run it beside anything, nice.
"""

from __future__ import annotations

import csv
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from measuring import parsed
from numpy.typing import NDArray
from uneven import CASES, Case, case_arguments

import equaltime as et
from equaltime.film.second_nets import statistics_so_far
from equaltime.film.unseen import Unseen, stated
from equaltime.rendering.budget import FIRST_LOOK, Looks, next_look
from equaltime.rendering.core import core_settings, make_renderer
from equaltime.statistics.intervals import Interval

Image = NDArray[np.float64]
GRID = 1.15
"""Between the counts at which true errors are known."""


@dataclass(frozen=True)
class Seen:
    """An image on the way, with what its render states of its error."""

    samples: int
    image: Image
    stated: Interval
    stops: tuple[float, ...]
    """The targets for which the render ends here."""


@dataclass(frozen=True)
class Row:
    """What a seed's image turned out to be."""

    scene: str
    seed: int
    samples: int
    stops: str
    value: float
    low: float
    high: float
    true: float
    trusted: bool
    """Whether the render trusts its own upper limit."""

    @property
    def holds(self) -> bool:
        """Whether the stated interval holds the true error."""
        return self.low <= self.true <= self.high


def main() -> None:
    parser = case_arguments(__doc__, seeds=100, size=32, threads=1)
    parser.add_argument("--paths", type=float, default=4e7, help="at most, of a render [%(default)s]")
    parser.add_argument("--first", type=int, default=0, help="the first seed [%(default)s]")
    parser.add_argument("--records", type=Path, help="a CSV file for every image")
    options = parsed(parser, seeds=12, size=16, paths=4e5)
    everything: list[Row] = []
    for name in options.scenes:
        case = CASES[name]
        most = 2 * math.ceil(options.paths / options.size**2 / 2)
        seeds = range(options.first, options.first + options.seeds)
        seen = {seed: trajectory(case, options.size, seed, options.threads, most) for seed in seeds}
        compare_with_a_render(case, options.size, options.first, seen[options.first], options.threads)
        rows = judged(name, seen)
        everything += rows
        report(name, case, rows)
        if options.records is not None:
            write(options.records, everything)
    pooled = [row for row in everything if math.isfinite(row.high)]
    print(
        f"intervals at fixed counts and stops hold the truth: {share([row.holds for row in pooled])} of {len(pooled)}"
    )
    trusted = [row for row in pooled if row.trusted]
    print(f"of those that are not said to be in doubt: {share([row.holds for row in trusted])} of {len(trusted)}")
    stopped = [row for row in everything if row.stops]
    print(f"of those at stops: {share([row.holds for row in stopped])} of {len(stopped)}")


def trajectory(case: Case, side: int, seed: int, threads: int, most: int) -> list[Seen]:
    """Render one seed until its strictest target is met and a quarter more, or ``most`` samples a pixel."""
    scene = case.scene(side)
    strategy = et.Strategy.parse(case.strategy)
    renderer = make_renderer(scene, strategy, seed, threads)
    unseen = Unseen.of(scene.core, core_settings(scene, strategy), seed, threads)
    looks, targets = Looks(), list(case.targets)
    grid, seen, samples = FIRST_LOOK, list[Seen](), 0
    while samples < most:
        samples = min(most, grid, next_look(samples))
        renderer.advance(samples)
        pixels, stops = statistics_so_far(renderer), list[float]()
        error, brightest = stated(pixels, unseen, brightest=looks.brightest)
        if looks.due(samples):
            looks.look(error, samples, brightest)
            stops = [target for target in targets if looks.met(target)]
            targets = [target for target in targets if target not in stops]
            most = most if targets else min(most, 2 * math.ceil(0.625 * samples))
        if samples == grid:
            grid = 2 * math.ceil(grid * GRID / 2)
        seen.append(Seen(samples, pixels.mean, error, tuple(stops)))
    return seen


def compare_with_a_render(case: Case, side: int, seed: int, seen: list[Seen], threads: int) -> None:
    """Check that `equaltime.render` stops where the trajectory says: then its image has the trajectory's bits."""
    stop = next((image for image in seen if image.stops), None)
    if stop is not None:
        found = et.render(case.scene(side), error=max(stop.stops), strategy=case.strategy, seed=seed, threads=threads)
        np.testing.assert_array_equal(found.image, stop.image.astype(np.float32))


def judged(name: str, seen: dict[int, list[Seen]]) -> list[Row]:
    """Compare every image with the mean of the other seeds' last ones."""
    weights = np.array([images[-1].samples for images in seen.values()], np.float64)
    last = np.stack([images[-1].image for images in seen.values()])
    rows = []
    for index, (seed, images) in enumerate(seen.items()):
        others = np.delete(weights, index) / np.delete(weights, index).sum()
        rest = np.delete(last, index, axis=0)
        truth = np.tensordot(others, rest, 1)
        noise = np.tensordot(np.square(others), np.square(rest - truth), 1) * len(rest) / (len(rest) - 1)
        denominator = np.square(truth) + (0.1 * truth.mean()) ** 2
        for image in images:
            square = float(np.mean((np.square(image.image - truth) - noise) / denominator))
            true = math.sqrt(max(square, 0.0))
            stops = " ".join(map(str, image.stops))
            stated = image.stated
            rows.append(
                Row(name, seed, image.samples, stops, stated.value, stated.low, stated.high, true, stated.trusted)
            )
    return rows


def report(name: str, case: Case, rows: list[Row]) -> None:
    """Print the lines of one scene."""
    ratios = [row.value / row.true for row in rows if row.true > 0.0]
    held = share([row.holds for row in rows])
    doubted = 100.0 * sum(not row.trusted for row in rows) / len(rows)
    print(
        f"{name}: intervals hold {held} of {len(rows)}, {doubted:.0f} % of them said to be in doubt; "
        f"stated over true, median {np.median(ratios):.3f}",
        flush=True,
    )
    for target in case.targets:
        stopped = [row for row in rows if str(target) in row.stops.split()]
        seeds = len({row.seed for row in rows})
        if len(stopped) < 0.9 * seeds:
            print(f"  {100 * target:4.3g} %: {len(stopped)} of {seeds} renders got there")
            continue
        best = oracle(rows, target)
        spent = float(np.median([row.samples for row in stopped]))
        print(
            f"  {100 * target:4.3g} %: true error at most that in {share([row.true <= target for row in stopped])}, "
            f"median spp {spent:.4g}, oracle {best:.4g}, ratio {spent / best:.3g}"
        )


def oracle(rows: list[Row], target: float) -> float:
    """Return the least samples at which 95 % of seeds have a true error of at most the target, between counts."""
    seeds = len({row.seed for row in rows})
    before = None
    for samples in sorted({row.samples for row in rows}):
        found = [row.true for row in rows if row.samples == samples]
        if len(found) < seeds:
            continue
        tail = float(np.quantile(found, 0.95))
        if tail <= target:
            if before is None:
                return float(samples)
            steps = math.log(samples / before[0]) / math.log(before[1] / tail)
            return before[0] * math.exp(steps * math.log(before[1] / target))
        before = (samples, tail)
    return math.nan


def share(holds: list[bool]) -> str:
    """Write a share with its 95 % interval (Wilson 1927)."""
    n, k, z = len(holds), sum(holds), 1.96
    if n == 0:
        return "none"
    middle, half = (k + z * z / 2) / (n + z * z), z * math.sqrt(k * (n - k) / n + z * z / 4) / (n + z * z)
    return f"{100 * k / n:.1f} % [{100 * (middle - half):.1f}, {100 * (middle + half):.1f}]"


def write(path: Path, rows: list[Row]) -> None:
    """Write every image's numbers."""
    with path.open("w", newline="") as file:
        table = csv.DictWriter(file, fieldnames=list(vars(rows[0])))
        table.writeheader()
        table.writerows(map(vars, rows))


if __name__ == "__main__":
    main()
