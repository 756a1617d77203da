"""Renders golden images anew, all or the named ones: `python -m tests.golden.make_golden [NAME …]` at the top level.

It takes some minutes each. The renders differ from those of the test in all that a strategy may choose: the numbers are
independent, sources are picked uniformly, the weights are those of the balance heuristic, and no path is ended early.
"""

from __future__ import annotations

import sys
import time

import equaltime as et

from .golden import SCENES, Golden, load_scene

RENDERS, SPP, FIRST_SEED = 64, 512, 1_000_000
STRATEGY = "best,sampler=independent,lights=uniform,heuristic=balance,roulette=none,adaptive=none"


def main(names: list[str]) -> None:
    for name in names or SCENES:
        begin, scene = time.perf_counter(), load_scene(name)
        renders = (et.render(scene, spp=SPP, seed=FIRST_SEED + i, strategy=STRATEGY).image for i in range(RENDERS))
        golden = Golden.of(renders)
        path = golden.save(name)
        seconds, size = time.perf_counter() - begin, path.stat().st_size / 1000.0
        print(f"{path.name}: error {100.0 * golden.relative_error:.2f} %, {size:.0f} kB, {seconds:.0f} s")


if __name__ == "__main__":
    main(sys.argv[1:])
