"""What it is worth that a kernel has no code for what a scene lacks: time with the code of an effect over that without.

For each scene, the kernel that was derived takes turns with the cheapest that also covers one effect more, and with the
one for all. All make the same bits, which is checked. Times are those of the processors: others disturb them less.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
from measuring import SHIPPED, arguments, print_conditions, ratio, rounds, samples_for, text
from numpy.typing import NDArray

import equaltime as et
from equaltime import _core

GLASS = Path(__file__).resolve().parents[1] / "golden" / "glass.toml"


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--scenes", nargs="+", type=Path, default=[*SHIPPED, GLASS])
    options = parser.parse_args()
    print_conditions(options)
    for path in options.scenes:
        compare(path, options)


def compare(path: Path, options: argparse.Namespace) -> None:
    """Render a scene by all kernels that differ, in turn, and print what each costs over the derived one."""
    scene = et.load(path).with_(size=(256, 256))
    settings = _core.Settings(max_depth=scene.max_depth)
    spp = samples_for(scene.core, settings, options.threads)
    effects = list(scene.core.effects())
    kernels: dict[str, tuple[str, ...]] = {}  # each once, by what it takes to get it
    for also in ((), *((name,) for name in effects), tuple(effects)):
        kernels.setdefault(_core.Renderer(scene.core, settings, also=also).kernel, also)
    images: dict[str, NDArray[Any]] = {}

    def seconds(kernel: str, seed: int) -> float:
        renderer = _core.Renderer(scene.core, settings, seed, options.threads, also=kernels[kernel])
        begin = process_time()
        renderer.advance(spp)
        elapsed = process_time() - begin
        images[kernel] = np.array(renderer.moments["mean"])
        return elapsed

    times = rounds(kernels, seconds, options.repeats)
    derived, *others = times
    print(f"\n{path.stem}, {spp} spp: {derived}")
    for kernel in others:
        bits = "" if np.array_equal(images[kernel], images[derived]) else "  OTHER BITS"
        print(f"  {text(ratio(times[kernel], times[derived]))} x the time: {kernel}{bits}")


if __name__ == "__main__":
    main()
