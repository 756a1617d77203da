"""What a quote foretells against what a render then takes: samples and seconds over those quoted, pair by pair.

Half of the pairs run on an idle machine, half with one core taken by a loop, the same through a pair. Then the load
changes: quoted idle, rendered with a core taken; the seconds differ, those of the processors should not. It times, so
nothing else must run; the samples are the same beside anything (`--samples` measures these alone).
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from measuring import parsed
from uneven import CASES, case_arguments

import equaltime as et
from equaltime.statistics.intervals import Interval, median_interval

SCENES = ["cornell-box", "independent", "terrain", "opening", "stadium", "simple", "ball", "lens"]


@dataclass(frozen=True)
class Pair:
    """What one quote said of one thing, and what it turned out to be."""

    quoted: Interval
    actual: float

    @property
    def ratio(self) -> float:
        """Actual over quoted."""
        return self.actual / self.quoted.value

    @property
    def near(self) -> bool:
        """Whether it is within 20 %."""
        return 1.0 / 1.2 <= self.ratio <= 1.2

    @property
    def held(self) -> bool:
        """Whether it is in the interval."""
        return self.quoted.low <= self.actual <= self.quoted.high


def main() -> None:
    parser = case_arguments(__doc__, seeds=3, size=128, scenes=SCENES)
    parser.add_argument("--most", type=float, default=60.0, help="seconds that a render may be quoted [%(default)s]")
    parser.add_argument("--samples", action="store_true", help="only what needs no clock")
    options = parsed(parser, seeds=1, size=64, most=10.0)
    if options.samples:
        summary("samples over quoted", [spp for spp, _, _ in pairs(options, False, False)])
        return
    for taken in (False, True):
        print("one core taken" if taken else "idle")
        found = list(pairs(options, taken, taken))
        summary("samples over quoted", [spp for spp, _, _ in found])
        summary("seconds over quoted", [seconds for _, seconds, _ in found])
    print("quoted idle, rendered with one core taken")
    summary("processor seconds over quoted", [spent for _, _, spent in pairs(options, False, True)])


def pairs(options: argparse.Namespace, before: bool, during: bool) -> Iterator[tuple[Pair, Pair, Pair]]:
    """Give samples, seconds and processor seconds for each scene, target and seed, under these loads."""
    for name in options.scenes:
        case = CASES[name]
        scene = case.scene(options.size)
        for target in case.targets:
            for seed in range(options.seeds):
                with load(before):
                    quote = et.quote(scene, error=target, strategy=case.strategy, seed=seed, threads=options.threads)
                if quote.seconds.value > options.most:
                    continue
                with load(during):
                    begin = time.process_time()
                    result = et.render(scene, error=target, strategy=case.strategy, seed=seed, threads=options.threads)
                    spent = (time.process_time() - begin) / result.stats.threads
                found = (
                    Pair(quote.spp, result.spp),
                    Pair(quote.seconds, result.stats.seconds),
                    Pair(quote.seconds, spent),
                )
                ratios = ", ".join(f"{pair.ratio:.2f}" for pair in found)
                print(
                    f"  {name} {100 * target:.3g} %: {quote.spp.value:.0f} [{quote.spp.low:.0f}, {quote.spp.high:.0f}] "
                    f"spp, {quote.seconds.value:.3g} s quoted; over that {ratios}",
                    flush=True,
                )
                yield found


def summary(what: str, found: list[Pair]) -> None:
    middle = median_interval([pair.ratio for pair in found])
    print(
        f"{what}: median {middle.value:.3f} [{middle.low:.3f}, {middle.high:.3f}]; within 20 % in "
        f"{sum(pair.near for pair in found)} of {len(found)}; in the quote's interval in "
        f"{sum(pair.held for pair in found)}"
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
