"""Whether stops that look at their own error select images, and what a count costs that a pilot chose instead.

Every seed of a scene is rendered twice to one error: by a stop that looks at the image's own error (``look``), and to
the count that a pilot with other samples chose (``fixed``). The bias is that of the mean light of the delivered images
over that of a reference, less 1. Errors are realised ones, against the reference, whose noise is subtracted. Samples
are those of the image and of the pilot together. Nothing is timed: run it beside anything, nice.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, get_args

import numpy as np
from measuring import arguments, parsed
from trial_scenes import realised_square, reference, trial_scene, wilson

import equaltime as et
from equaltime.images.metrics import Reference
from equaltime.rendering.budget import StopRule

ORDERS: Mapping[str, float] = {"caustic": 0.2, "mis": 0.4, "flat": 0.02, "cornell": 0.2, "door": 0.9}
"""The error that is asked for."""


@dataclass(frozen=True)
class Run:
    """A render that was asked for an error."""

    light: float
    """Mean over pixels and channels."""
    error: float
    """Realised."""
    samples: int
    """A pixel, with the pilot's."""
    pilot: int

    @classmethod
    def of(cls, result: et.Result, truth: Reference) -> Run:
        """Judge one image."""
        image = result.image.astype(np.float64)
        realised = math.sqrt(max(realised_square(image, truth), 0.0))
        pilot = 0 if result.stop is None or result.stop.pilot_spp is None else result.stop.pilot_spp
        return cls(float(image.mean()), realised, int(result.spp) + pilot, pilot)


def main() -> None:
    parser = arguments(__doc__, threads=1)
    parser.add_argument("--seeds", type=int, default=120, help="[%(default)s]")
    parser.add_argument("--first", type=int, default=9_000_000, help="the first seed [%(default)s]")
    parser.add_argument("--size", type=int, default=16, help="pixels along each side [%(default)s]")
    parser.add_argument("--most", type=int, default=16384, help="samples a pixel, whatever a stop says [%(default)s]")
    parser.add_argument("--reference", type=int, default=16_000, help="its samples a pixel [%(default)s]")
    parser.add_argument("--scenes", nargs="+", default=[*ORDERS], choices=ORDERS)
    options = parsed(parser, seeds=20, reference=4_000)
    print("scene      error  stop   bias, %                 order reached       samples: median   mean   pilot   /look")
    for name in options.scenes:
        scene, truth = trial_scene(name, options.size), reference(name, options.size, options.reference)
        seeds = range(options.first, options.first + options.seeds)
        looking: list[Run] = []
        for stop in get_args(StopRule):
            asked: dict[str, Any] = {
                "error": ORDERS[name],
                "spp": options.most,
                "threads": options.threads,
                "stop": stop,
            }
            runs = [Run.of(et.render(scene, seed=seed, **asked), truth) for seed in seeds]
            looking = looking or runs
            print(
                f"{name:9} {100 * ORDERS[name]:4.3g} %  {stop:6}{judged(runs, looking, ORDERS[name], truth)}",
                flush=True,
            )


def judged(runs: Sequence[Run], looking: Sequence[Run], error: float, truth: Reference) -> str:
    """Return a row of the table; biases have their 95 % intervals, and rates those of Wilson."""
    light = np.array([run.light for run in runs]) / truth.mean.mean() - 1.0
    noise = math.sqrt(truth.variance.sum()) / truth.mean.sum()
    half = 1.96 * math.hypot(light.std(ddof=1) / math.sqrt(len(runs)), noise)
    bias = f"{100 * light.mean():+6.2f} [{100 * (light.mean() - half):+.2f}, {100 * (light.mean() + half):+.2f}]"
    hits = sum(run.error <= error for run in runs)
    least, most = wilson(hits, len(runs))
    rate = f"{hits / len(runs):.3f} [{least:.3f}, {most:.3f}]"
    samples, others = ([run.samples for run in each] for each in (runs, looking))
    spent = f"{np.median(samples):8.0f} {np.mean(samples):6.0f} {np.median([run.pilot for run in runs]):7.0f}"
    return f"{bias:>25} {rate:>22} {spent:>30} {np.median(samples) / np.median(others):7.2f}"


if __name__ == "__main__":
    main()
