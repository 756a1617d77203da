"""What short passes cost beside long ones: the time of a sample in the first tenths of a second, over that later.

On a machine that nothing else uses, then with processors taken, one by one, by a loop each. Threads that were asleep
come late, and caches are cold; quotes, which are made of pilots of as little as some hundredths of a second, allow for
it (`equaltime.quoting.law`). The processors that the process had are told too. It times, so nothing else must run.
"""

from __future__ import annotations

import argparse
import os
import time
from contextlib import ExitStack
from dataclasses import dataclass

import numpy as np
from measuring import parsed
from quotes import load
from uneven import CASES, case_arguments

import equaltime as et
from equaltime.rendering.core import make_renderer
from equaltime.scene import Scene

SCENES = ["cornell-box", "terrain", "opening", "stadium", "simple", "ball", "lens"]
ENDS = (0.03, 0.06, 0.1, 0.2, 0.5, 1.5)
"""Seconds at which parts of a render end that are told apart; the last is what the others are compared with."""


@dataclass(frozen=True)
class Pass:
    """One pass of a render."""

    begin: float
    """Seconds since the first sample."""
    seconds: float
    """A sample of the image."""
    processors: float
    """That the process had, on average."""


def main() -> None:
    options = parsed(case_arguments(__doc__, seeds=9, size=128, scenes=SCENES), seeds=2, size=64)
    for taken in range((os.cpu_count() or 1) + 1):
        print(f"{taken} processors taken")
        with ExitStack() as loads:
            for _ in range(taken):
                loads.enter_context(load(True))
            for name in options.scenes:
                report(name, CASES[name].scene(options.size), options)


def report(name: str, scene: Scene, options: argparse.Namespace) -> None:
    found = [each for seed in range(options.seeds) for each in passes(scene, seed, options.threads)]
    groups = [
        [each for each in found if begin <= each.begin < end] for begin, end in zip((0.0, *ENDS), ENDS, strict=False)
    ]
    later = np.mean([each.seconds for each in groups[-1]])
    for end, group in zip(ENDS, groups, strict=True):
        if group:
            seconds = np.array([each.seconds for each in group]) / later
            processors = np.mean([each.processors for each in group])
            print(
                f"  {name}, passes begun before {end:g} s: {seconds.mean():.3f} times as long a sample as later, "
                f"a pass varies by {seconds.std():.3f}; {processors:.2f} processors",
                flush=True,
            )


def passes(scene: Scene, seed: int, threads: int) -> list[Pass]:
    """Render for as long as is told apart, by short passes first, as a render does."""
    renderer, samples, found = make_renderer(scene, et.Strategy(), seed, threads), 0, list[Pass]()
    time.sleep(0.05)  # threads of the render before are asleep, as they are before a first one
    begin = time.perf_counter()
    while (since := time.perf_counter() - begin) < ENDS[-1]:
        step = min(max(samples, 2), 16)
        samples, before, spent = samples + step, time.perf_counter(), time.process_time()
        renderer.advance(samples)
        seconds = time.perf_counter() - before
        found.append(Pass(since, seconds / step, (time.process_time() - spent) / seconds))
    return found


if __name__ == "__main__":
    main()
