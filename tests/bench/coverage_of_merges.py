"""Whether merged renders state their errors rightly: stated over realised error, and how often intervals hold it.

Every group renders the parts of a plan with seeds of its own and merges their files. ``32`` in one go stands beside the
plans of 32 samples a pixel. True errors are realised ones, against a reference of independent samples whose own noise
is subtracted. ``variance`` is the root of the stated variance of pixels over the realised error, both by the
denominators of the reference: it tells how merging does apart from how a render guesses its denominators. Nothing is
timed: run it beside anything, nice.
"""

from __future__ import annotations

import math
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from measuring import arguments, parsed
from trial_scenes import TRIALS, realised_square, reference, trial_scene, wilson

import equaltime as et
from equaltime.film.parts_of_merge import statistics_of
from equaltime.images.metrics import Reference

PLANS: Mapping[str, Sequence[int]] = {
    "32": [32],
    "16+16": [16, 16],
    "28+4": [28, 4],
    "31+1": [31, 1],
    "8 of 4": [4] * 8,
    "4 of 3": [3] * 4,
    "3+5+7": [3, 5, 7],
    "16 of 2": [2] * 16,
    "16 of 1": [1] * 16,
}
"""Samples a pixel of the parts."""
FIRST_SEED = 1 << 40
"""Of the first group: seeds of different groups, and of their parts, are different ones."""


def main() -> None:
    parser = arguments(__doc__, threads=1)
    parser.add_argument("--groups", type=int, default=80, help="merged renders of each plan [%(default)s]")
    parser.add_argument("--first", type=int, default=0, help="first group: each has other seeds [%(default)s]")
    parser.add_argument("--size", type=int, default=32, help="pixels along each side [%(default)s]")
    parser.add_argument("--reference", type=int, default=16384, help="its samples a pixel [%(default)s]")
    parser.add_argument("--sampler", default="lattice", choices=["sobol", "lattice", "stratified", "independent"])
    parser.add_argument("--scenes", nargs="*", default=["flat", "cornell"], choices=list(TRIALS))
    options = parsed(parser, groups=6, size=16, reference=2048)
    print("half width: upper limit over the value, less 1; below, above: the realised error lies outside, there")
    print(f"{'scene':8} {'parts':8} {'realised':>9} {'stated':>7} {'ratio':>6} {'variance':>8} {'holds':>17}", end="")
    print(f" {'below':>6} {'above':>6} {'half width':>11} {'degrees':>8}")
    for name in options.scenes:
        scene, truth = trial_scene(name, options.size), reference(name, options.size, options.reference)
        for plan, parts in PLANS.items():
            with tempfile.TemporaryDirectory() as folder:
                made = [
                    merged(scene, parts, f"best,sampler={options.sampler}", group, options.threads, Path(folder))
                    for group in range(options.first, options.first + options.groups)
                ]
            print(f"{name:8} {plan:8} {judged(made, truth)}", flush=True)


def merged(scene: et.Scene, parts: Sequence[int], strategy: str, group: int, threads: int, folder: Path) -> et.Result:
    """Render and merge the parts of one group."""
    files, first = [folder / f"{i}.exr" for i in range(len(parts))], FIRST_SEED + 100 * group
    for i, (file, spp) in enumerate(zip(files, parts, strict=True)):
        result = et.render(scene, spp=spp, seed=first + i, threads=threads, strategy=strategy)
        if len(parts) == 1:
            return result
        result.save(file, overwrite=True)
    return et.merge(files)


def judged(made: Sequence[et.Result], truth: Reference) -> str:
    """Return a row of the table; rates have their Wilson intervals."""
    squares = np.array([realised_square(result.image.astype(np.float64), truth) for result in made])
    found = np.sqrt(np.maximum(squares, 0.0))
    values, lows, highs = (np.array([getattr(r.error, of) for r in made]) for of in ("value", "low", "high"))
    realised, stated = math.sqrt(max(squares.mean(), 0.0)), math.sqrt(np.square(values).mean())
    below, above = found < lows, found > highs
    holds = int((~below & ~above).sum())
    least, most = wilson(holds, len(made))
    rate = f"{holds / len(made):.2f} [{least:.2f}, {most:.2f}]"
    ratios = [of / realised if realised > 0.0 else math.inf for of in (stated, variance_stated(made, truth))]
    width = float(np.median(highs / values)) - 1.0
    row = f"{realised:9.4f} {stated:7.4f} {ratios[0]:6.3f} {ratios[1]:8.3f} {rate:>17}"
    return f"{row} {below.mean():6.2f} {above.mean():6.2f} {width:11.3f} {np.median([r.degrees for r in made]):8.1f}"


def variance_stated(made: Sequence[et.Result], truth: Reference) -> float:
    """Return the error that the variances of pixels make by the denominators of the reference."""
    denominator = np.square(truth.mean) + (0.1 * truth.mean.mean()) ** 2
    found = [statistics_of(result.moments, result.parts).variance for result in made if result.moments is not None]
    return math.sqrt(float(np.mean(np.array(found) / denominator)))


if __name__ == "__main__":
    main()
