"""Throughput and variance per sample side by side with Mitsuba 3, on its own scene files.

Both render the same scene, size, depth and number of samples on the same threads, with a box filter: Mitsuba with its
`path` integrator and its multijitter sampler, without roulette; equaltime by ``--strategy``, without roulette and
adaptive counts unless one is given. The product of seconds and relMSE is what an error costs. They are the subjects of
equaltime's experiments: Mitsuba runs in a process of its own, clocks run while samples are taken, and what has to be
compiled first is not counted. Mitsuba needs LLVM for its llvm_ variants: if it does not find the library, set
DRJIT_LIBLLVM_PATH.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np
from measuring import SCENES, arguments, defines, noise, print_conditions, ratio, rounds, text
from numpy.typing import NDArray

import equaltime as et
from equaltime.experiments.peers.common import with_box_filter
from equaltime.experiments.peers.mitsuba import MitsubaPeer
from equaltime.rendering.core_subject import CoreSubject, Subject
from equaltime.statistics.intervals import median_interval

STRATEGY = "best,roulette=none,adaptive=none"
NO_ROULETTE = 10**6


def main() -> None:
    parser = arguments(__doc__)
    files = [str(SCENES / "mitsuba/cornell-box/scene.xml")]
    parser.add_argument("--scenes", nargs="+", default=files, help="files that Mitsuba reads [%(default)s]")
    parser.add_argument("--variants", nargs="+", default=["llvm_ad_rgb", "scalar_rgb"])
    parser.add_argument("--size", type=int, nargs=2, default=[256, 256])
    parser.add_argument("--max-depth", type=int, default=8)
    parser.add_argument("--spp", type=int, default=64, help="a square number, for multijitter [%(default)s]")
    parser.add_argument("--strategy", default=STRATEGY, help="[%(default)s]")
    parser.add_argument("--peer-python", default=sys.executable, help="a Python with mitsuba and equaltime [this one]")
    options = parser.parse_args()
    print_conditions(options)
    with ExitStack() as stack:
        peers = []
        for variant in options.variants:
            peer = MitsubaPeer(
                variant, variant, sampler="multijitter", rr_depth=NO_ROULETTE, python=options.peer_python
            )
            stack.callback(peer.close)
            peers.append(peer)
        subjects = (CoreSubject("equaltime", et.Strategy.parse(options.strategy)), *peers)
        for path in map(Path, options.scenes):
            compare(path, subjects, options)


def compare(path: Path, subjects: Sequence[Subject], options: Any) -> None:
    """Render one scene with everyone in turn, and print ratios."""
    loaded = et.load(path, substitute=True, **defines(path))
    scene = with_box_filter(loaded.with_(size=tuple(options.size), max_depth=options.max_depth))
    named = {subject.label: subject for subject in subjects}
    images: dict[str, list[NDArray[np.float64]]] = {who: [] for who in named}
    seconds: dict[str, list[float]] = {who: [] for who in named}
    for subject in subjects:
        subject.prepare(scene, options.threads)

    def render(who: str, seed: int) -> float:
        checkpoint = next(named[who].run(seed, (options.spp,), None))
        if seed > 0:
            images[who].append(checkpoint.image.astype(np.float64))
            seconds[who].append(checkpoint.wall_s)
        assert checkpoint.paths is not None, "both count them"
        return checkpoint.paths / checkpoint.wall_s

    rates = rounds(images, render, options.repeats)
    width, height = options.size
    print(f"\n{path.parent.name}/{path.stem}, {width}x{height}, {options.spp} spp, depth {options.max_depth}")
    for who, values in rates.items():
        print(
            f"  {who:14} {text(median_interval([v / 1e6 for v in values]))} M paths/s, relMSE {noise(images[who]):.4g}"
        )
    for peer in subjects[1:]:
        faster = ratio(rates["equaltime"], rates[peer.label])
        less = noise(images[peer.label]) / noise(images["equaltime"])
        products = [np.median(seconds[who]) * noise(images[who]) for who in ("equaltime", peer.label)]
        print(
            f"  equaltime over {peer.label}: {text(faster)} x the paths/s; "
            f"{peer.label} has {less:.3g} x the relMSE at equal samples; "
            f"seconds x relMSE over its: {products[0] / products[1]:.3g}"
        )


if __name__ == "__main__":
    main()
