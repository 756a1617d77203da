"""What a strategy costs and gains on a scene: time, noise at equal samples, and efficiency, each over the baseline's.

Noise is the relMSE of one render, from the scatter over rounds with a seed each; efficiency is 1 / (noise x time).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from measuring import SHIPPED, arguments, noise, print_conditions, ratio, render_seconds, rounds, samples_for, text

import equaltime as et
from equaltime.rendering.core import core_settings
from equaltime.strategy import Strategy

BASELINE = "best"
STRATEGIES = (
    "best,sampler=independent",
    "best,roulette=none",
    "best,lights=uniform",
    "best,heuristic=balance",
    "best,technique=light",
    "best,technique=bsdf",
)


def main() -> None:
    parser = arguments(__doc__, repeats=17)
    parser.add_argument("strategies", nargs="*", default=list(STRATEGIES), help="against 'best'")
    parser.add_argument("--scenes", nargs="+", default=list(map(str, SHIPPED)))
    parser.add_argument("--size", type=int, nargs=2, default=[128, 128])
    options = parser.parse_args()
    print_conditions(options)
    for path in options.scenes:
        compare(et.load(path).with_(size=tuple(options.size)), path, options)


def compare(scene: et.Scene, path: str, options: Any) -> None:
    """Render one scene with every strategy in turn, and print ratios."""
    # without roulette, paths of unlimited length end by absorption alone: a benchmark of patience
    strategies = [name for name in options.strategies if scene.max_depth >= 0 or "roulette=none" not in name]
    names = [BASELINE, *strategies]
    settings = {name: core_settings(scene, Strategy.parse(name)) for name in names}
    spp = min(64, samples_for(scene.core, settings[BASELINE], options.threads, 0.4))
    images: dict[str, list[Any]] = {name: [] for name in names}

    def seconds(name: str, seed: int) -> float:
        time, renderer = render_seconds(scene.core, settings[name], spp, options.threads, seed)
        images[name].append(np.asarray(renderer.moments["mean"]).mean(axis=0))
        return time

    times = rounds(images, seconds, options.repeats)
    print(
        f"\n{path}, {options.size[0]}x{options.size[1]}, {spp} spp; relMSE of {BASELINE}: {noise(images[BASELINE]):.4g}"
    )
    for name in strategies:
        slower, noisier = ratio(times[name], times[BASELINE]), noise(images[name]) / noise(images[BASELINE])
        efficiency = 1.0 / (slower.value * noisier)
        print(f"  {name:26} time {text(slower)}, noise {noisier:.3g}, efficiency {efficiency:.3g}")


if __name__ == "__main__":
    main()
