"""What a kernel for the effects of a scene is worth: time of the kernel for all effects over that of the derived one.

Both make the same bits, which is checked.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from time import perf_counter

import numpy as np
from measuring import SHIPPED, arguments, print_conditions, ratio, rounds, samples_for, text

import equaltime as et
from equaltime import _core

GLASS = Path(__file__).resolve().parents[1] / "golden" / "glass.toml"


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--scenes", nargs="+", type=Path, default=[*SHIPPED, GLASS])
    options = parser.parse_args()
    print_conditions(options)
    for path in options.scenes:
        print(compare(path, options))


def compare(path: Path, options: argparse.Namespace) -> str:
    """Render a scene by both kernels in turn, and say what the full one costs."""
    scene = et.load(path).with_(size=(256, 256))
    settings = _core.Settings(max_depth=scene.max_depth)
    spp = samples_for(scene.core, settings, options.threads)
    images = {}

    def seconds(name: str, seed: int) -> float:
        renderer = _core.Renderer(scene.core, settings, seed, options.threads, full_kernel=name == "full")
        begin = perf_counter()
        renderer.advance(spp)
        elapsed = perf_counter() - begin
        images[name] = np.array(renderer.moments["mean"])
        return elapsed

    times = rounds(("derived", "full"), seconds, options.repeats)
    kernel = _core.Renderer(scene.core, settings).kernel
    same = "same bits" if np.array_equal(images["derived"], images["full"]) else "OTHER BITS"
    cost = text(ratio(times["full"], times["derived"]))
    return f"{path.stem:16} full over derived: {cost} x the time, {same}; kernel: {kernel}"


if __name__ == "__main__":
    main()
