"""How often the errors that records state hold the realised ones, and what they would without what may be hidden.

Every seed is a run as experiments make it: one image that grows from count to count, with the error that its record
states at each. Realised errors are those against a long reference of independent samples, whose noise is subtracted.
A rate of 95 % is held to be reached where the lower end of its interval (Wilson 1927) is at least 90 %. Nothing is
timed.
"""

from __future__ import annotations

import math
from collections import defaultdict

from measuring import arguments, parsed
from trial_scenes import TRIALS, realised_square, reference, trial_scene, wilson

import equaltime as et
from equaltime.film.second_nets import statistics_so_far
from equaltime.film.unseen import stated_error
from equaltime.rendering.core import make_renderer
from equaltime.rendering.core_subject import CoreSubject
from equaltime.statistics.intervals import Interval

Case = tuple[Interval, float]
"""What a record states, and the true error."""
FIRST_SEED = 410_000


def main() -> None:
    parser = arguments(__doc__, threads=1)
    parser.add_argument("--seeds", type=int, default=100, help="[%(default)s]")
    parser.add_argument("--first", type=int, default=FIRST_SEED, help="seed [%(default)s]")
    parser.add_argument("--size", type=int, default=32, help="pixels along each side [%(default)s]")
    parser.add_argument("--spp", type=int, nargs="*", default=[8, 42, 92])
    parser.add_argument("--reference", type=int, default=16384, help="its samples a pixel [%(default)s]")
    parser.add_argument("--scenes", nargs="*", default=["tinylamp"], choices=list(TRIALS))
    options = parsed(parser, seeds=12, size=16, reference=2048)
    for name in options.scenes:
        scene, truth = trial_scene(name, options.size), reference(name, options.size, options.reference)
        subject = CoreSubject(name, et.Strategy())
        subject.prepare(scene, options.threads)
        records: dict[int, list[Case]] = defaultdict(list)
        bare: dict[int, list[Case]] = defaultdict(list)
        for seed in range(options.first, options.first + options.seeds):
            renderer = make_renderer(scene, et.Strategy(), seed, options.threads)
            for point in subject.run(seed, options.spp):
                true = math.sqrt(max(realised_square(point.image, truth), 0.0))
                assert point.estimate is not None
                records[point.spp].append((point.estimate, true))
                renderer.advance(point.spp)
                bare[point.spp].append((stated_error(statistics_so_far(renderer)), true))
        for spp in options.spp:
            print(f"{name}, {spp} spp: records {rates(records[spp])}; without what is hidden {rates(bare[spp])}")


def rates(found: list[Case]) -> str:
    """Write how often the true error is in the interval, and how often it is below the upper limit."""
    held = sum(said.low <= true <= said.high for said, true in found)
    below = sum(true <= said.high for said, true in found)
    return f"hold {share(held, len(found))}, at most the upper limit {share(below, len(found))}"


def share(hits: int, runs: int) -> str:
    low, high = wilson(hits, runs)
    return f"{hits / runs:.2f} [{low:.2f}, {high:.2f}]"


if __name__ == "__main__":
    main()
