"""MIS against its two parts over roughness and size of the light: variance per sample, and rays.

Each cell is a scene of scenes/experiments/mis-grid.toml. Variance is the mean over pixels and channels of a sample's
variance over R^2 + (0.1 m)^2, as in relMSE, from independent samples; "over the better" divides by the smaller of those
of `bsdf` and `light`. Rays are those of one sample, shadow rays among them, over the better part's.
"""

from __future__ import annotations

import tomllib
from typing import Any

import numpy as np
from measuring import SCENES, arguments, print_conditions

import equaltime as et
from equaltime import _core
from equaltime.film.moments import squared_deviations

GRID = SCENES / "experiments" / "mis-grid.toml"
PARTS = ("bsdf", "light")
COMBINED: dict[str, dict[str, Any]] = {
    "mis, power": {"technique": "mis", "heuristic": "power"},
    "mis, balance": {"technique": "mis", "heuristic": "balance"},
    "mixture": {"technique": "mixture"},
}


def main() -> None:
    parser = arguments(__doc__, repeats=1)
    parser.add_argument("--spp", type=int, default=1024)
    parser.add_argument("--size", type=int, nargs=2, default=[48, 32])
    options = parser.parse_args()
    print_conditions(options)
    print(f"{'':28}{'bsdf':>10}{'light':>10}" + "".join(f"{name + ' / better (rays)':>30}" for name in COMBINED))
    worst = dict.fromkeys(COMBINED, 0.0)
    for cell in tomllib.loads(GRID.read_text())["scenes"]:
        defined = {key: str(value) for key, value in cell["define"].items()}
        scene = et.load(GRID.parent / cell["path"], **defined).with_(size=tuple(options.size))
        found = {name: per_sample(scene, options, technique=name) for name in PARTS}
        better = min(found.values())
        line = f"{cell['name']:28}" + "".join(f"{found[name][0]:10.4g}" for name in PARTS)
        for name, settings in COMBINED.items():
            variance, rays = per_sample(scene, options, **settings)
            worst[name] = max(worst[name], variance / better[0])
            line += f"{variance / better[0]:22.3f} ({rays / better[1]:.2f})"
        print(line, flush=True)
    print("worst: " + ", ".join(f"{name} {value:.3f}" for name, value in worst.items()))


def per_sample(scene: et.Scene, options: Any, **settings: Any) -> tuple[float, float]:
    """Return a sample's relative variance and how many rays it takes."""
    chosen = _core.Settings(**settings, roulette="none", sampler="independent", max_depth=scene.max_depth)
    renderer = _core.Renderer(scene.core, chosen, seed=1, threads=options.threads)
    renderer.advance(options.spp)
    moments = renderer.moments
    mean, count = np.asarray(moments["mean"]).mean(axis=0), moments["count"].sum(axis=0)[..., None]
    variance = squared_deviations(moments).sum(axis=0) / (count - len(moments))
    counters = renderer.counters
    rays = (counters["rays"] + counters["shadow_rays"]) / counters["paths"]
    return float((variance / (mean**2 + (0.1 * mean.mean()) ** 2)).mean()), float(rays)


if __name__ == "__main__":
    main()
