"""Measures the noise of samplers at equal samples: each relMSE over that of the first, by scene and count.

A case is a sampler and how many nets share a pixel's samples, such as ``lattice:1``. Every seed is rendered once, and
looked at after each count. The relMSE comes from the scatter over seeds, against the mean of all cases, without the
0.5 % of pixels that scatter most in all cases together. Intervals are two standard deviations of the logarithm, by
leaving out one seed after the other. Nothing is timed.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
from measuring import SCENES, Floats, arguments, parsed, relative_variance

import equaltime as et
from equaltime import _core
from equaltime.experiments.peers.common import with_box_filter
from equaltime.rendering.core import core_settings

LEFT_OUT = 0.005
OURS = ("cornell-box.toml", "veach-mis.toml", "montelight/simple.toml", "montelight/complex.toml")


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--scenes", nargs="+", default=[str(SCENES / name) for name in OURS], help="files")
    parser.add_argument("--cases", nargs="+", default=["sobol:2", "lattice:2", "lattice:1"], help="the first is 1")
    parser.add_argument("--counts", type=int, nargs="+", default=[16, 24, 64, 100, 256], help="samples a pixel")
    parser.add_argument("--seeds", type=int, default=16, help="[%(default)s]")
    parser.add_argument("--first", type=int, default=1, help="the first seed [%(default)s]")
    parser.add_argument("--width", type=int, default=48, help="pixels a row; the shape of the picture stays")
    parser.add_argument("--max-depth", type=int, default=9, help="[%(default)s]")
    parser.add_argument("--strategy", default="best", help="beside the sampler [%(default)s]")
    options = parsed(parser, seeds=4, width=16)
    logs: dict[tuple[str, int], list[float]] = {}
    for path in options.scenes:
        images = {case: rendered(small(path, options), case, options) for case in options.cases}
        print(f"\n{Path(path).parent.name}/{Path(path).name}, {len(options.counts)} counts, {options.seeds} seeds")
        for number, count in enumerate(options.counts):
            taken = {case: found[:, number] for case, found in images.items()}
            base, errors = relative_errors(taken), spreads(taken)
            first = options.cases[0]
            for case in options.cases[1:]:
                logs.setdefault((case, count), []).append(math.log(base[case] / base[first]))
            ratios = "  ".join(
                f"{case} {base[case] / base[first]:.3f} +- {2 * errors[case] * base[case] / base[first]:.3f}"
                for case in options.cases[1:]
            )
            print(f"  {count:5d} spp: relMSE of {first} {base[first]:.4g}; {ratios}", flush=True)
    print("\ngeometric means over scenes")
    for (case, count), values in sorted(logs.items()):
        print(f"  {case} {count:5d} spp: {math.exp(np.mean(values)):.3f}, at most {math.exp(max(values)):.3f}")


def small(path: str, options: Any) -> et.Scene:
    """Load a scene with a box filter, so that pixels share no samples."""
    loaded = et.load(path, substitute=True)
    width, height = loaded.size
    size = options.width, max(1, round(options.width * height / width))
    return with_box_filter(loaded.with_(size=size, max_depth=options.max_depth))


def rendered(scene: et.Scene, case: str, options: Any) -> Floats:
    """Return images (seeds, counts, H, W, 3)."""
    sampler, nets = case.split(":")
    settings = core_settings(scene, et.Strategy.parse(f"{options.strategy},sampler={sampler}"))
    images = []
    for seed in range(options.first, options.first + options.seeds):
        renderer = _core.Renderer(scene.core, settings, seed=seed, threads=options.threads, replicates=int(nets))
        seen = []
        for count in options.counts:
            renderer.advance(count)
            moments = renderer.moments
            weights = np.asarray(moments["count"], dtype=np.float64)[..., None]
            seen.append((weights * np.asarray(moments["mean"])).sum(axis=0) / weights.sum(axis=0))
        images.append(np.stack(seen))
    return np.stack(images)


def relative_errors(images: dict[str, Floats]) -> dict[str, float]:
    """Return the relMSE of each case, of images (seeds, H, W, 3)."""
    mean = np.mean([found.mean(axis=0) for found in images.values()], axis=0)
    parts = {case: relative_variance(found, mean).ravel() for case, found in images.items()}
    together = np.sum(list(parts.values()), axis=0)
    kept = together <= np.quantile(together, 1.0 - LEFT_OUT)
    return {case: float(each[kept].mean()) for case, each in parts.items()}


def spreads(images: dict[str, Floats]) -> dict[str, float]:
    """Return the standard deviation of the logarithm of each case's ratio to the first, by the jackknife."""
    seeds = len(next(iter(images.values())))
    logs: dict[str, list[float]] = {case: [] for case in images}
    for seed in range(seeds):
        found = relative_errors({case: np.delete(each, seed, axis=0) for case, each in images.items()})
        first = next(iter(found.values()))
        for case, value in found.items():
            logs[case].append(math.log(value / first))
    return {case: math.sqrt((seeds - 1) * float(np.var(values))) for case, values in logs.items()}


if __name__ == "__main__":
    main()
