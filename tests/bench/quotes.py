"""What a quote foretells against what a render then takes: seconds over those quoted, pair by pair.

Half of the pairs run on an idle machine, half with one core taken by a loop, the same through a pair. Then the load
changes: quoted idle, rendered with a core taken; the seconds differ, those of the processors should not. It times, so
nothing else must run.
"""

from __future__ import annotations

import multiprocessing
import os
import time
from collections.abc import Iterator
from contextlib import contextmanager

from measuring import SCENES, arguments, print_conditions

import equaltime as et
from equaltime.bench import spread

CASES: dict[str, tuple[str, int, tuple[float, ...]]] = {
    "cornell-box": ("cornell-box.toml", 6, (0.05, 0.02)),
    "terrain": ("terrain/terrain.toml", 6, (0.05, 0.02, 0.01)),
    "opening": ("experiments/opening.toml", 6, (0.1, 0.05)),
    "stadium": ("hard/stadium.toml", 2, (0.02, 0.01)),
    "simple": ("montelight/simple.toml", 4, (0.1, 0.05)),
    "ball": ("experiments/ball.toml", 2, (0.01, 0.005)),
}
"""Path, depth and errors asked for."""
MOST_SECONDS = 120.0


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--size", type=int, default=128, help="pixels along each side [%(default)s]")
    parser.add_argument("--quick", action="store_true", help="1 seed, 64x64 pixels")
    options = parser.parse_args()
    if options.quick:
        options.seeds, options.size = 1, 64
    print_conditions(options)
    for taken in (False, True):
        print("one core taken" if taken else "idle")
        summary("seconds over quoted", list(pairs(options, taken, taken)))
    print("quoted idle, rendered with one core taken")
    summary("processor seconds over quoted", list(pairs(options, False, True, processor=True)))


def pairs(options: object, before: bool, during: bool, processor: bool = False) -> Iterator[tuple[float, bool]]:
    """Give, for each scene, target and seed, actual over quoted, and whether that is in the quote's interval."""
    values = vars(options)
    for name, (path, depth, targets) in CASES.items():
        scene = et.load(SCENES / path).with_(size=(values["size"], values["size"]), max_depth=depth)
        for target in targets:
            for seed in range(values["seeds"]):
                with load(before):
                    quote = et.quote(scene, error=target, seed=seed, threads=values["threads"])
                if quote.seconds.value > MOST_SECONDS:
                    continue
                with load(during):
                    begin = time.process_time()
                    result = et.render(scene, error=target, seed=seed, threads=values["threads"])
                    spent = time.process_time() - begin
                threads = result.stats.threads
                actual = spent / threads if processor else result.stats.seconds
                ratio = actual / quote.seconds.value
                print(f"  {name} {100 * target:.3g} %: {quote.seconds.value:.3g} s quoted, {ratio:.2f} of it taken")
                yield ratio, quote.seconds.low <= actual <= quote.seconds.high


def summary(what: str, found: list[tuple[float, bool]]) -> None:
    ratios = [ratio for ratio, _ in found]
    near = sum(1.0 / 1.2 <= ratio <= 1.2 for ratio in ratios)
    held = sum(inside for _, inside in found)
    middle = spread(ratios)
    print(
        f"{what}: median {middle.median:.3f} [{middle.low:.3f}, {middle.high:.3f}]; within 20 % in {near} of "
        f"{len(ratios)}; in the quote's interval in {held}"
    )


@contextmanager
def load(taken: bool) -> Iterator[None]:
    """Keep one core busy for as long as the context lasts, if asked to."""
    if not taken:
        yield
        return
    process = multiprocessing.Process(target=_spin, daemon=True)
    process.start()
    try:
        yield
    finally:
        process.terminate()
        process.join()


def _spin() -> None:
    parent = os.getppid()
    while os.getppid() == parent:
        sum(range(100_000))


if __name__ == "__main__":
    main()
