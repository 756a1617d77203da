"""Measures what `best` gains by deciding: relMSE times rays over those of fixed choices, pilots included.

Fixed choices are paths that are split or not (`roulette`) and sample counts that are even or follow the noise
(`adaptive`). What `best` decides is asked of the core; its image has the bits of the fixed choice that it decided for
(a test holds that), so that only its pilot is rendered besides. The relMSE comes from the scatter over seeds. Squared
errors of a pixel of one image are cut off at the quantile 0.9998 of all of a scene's; what they are without this stands
in brackets. Rows are printed as they come, and `--keep FOLDER` keeps images, so that a run can be stopped and taken up.
Nothing is timed.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
from measuring import SCENES, Floats, arguments, defines, parsed

import equaltime as et
from equaltime.rendering.core import make_renderer

FIXED = {
    "plain": "roulette=throughput,adaptive=none",
    "split": "roulette=efficiency,adaptive=none",
    "error": "roulette=throughput,adaptive=error",
    "split+error": "roulette=efficiency,adaptive=error",
}
"""The first is what the others are compared with."""
DECIDED = {"throughput": "error", "efficiency": "split+error"}
"""The fixed choice whose bits `best` has, by its roulette."""
OURS = (
    *("cornell-box.toml", "veach-mis.toml", "montelight/simple.toml", "montelight/complex.toml"),
    *("experiments/opening.toml", "experiments/lens.toml", "experiments/caustic.toml", "terrain/terrain.toml"),
)
TAIL = 2e-4


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--scenes", nargs="+", default=[str(SCENES / name) for name in OURS], help="files")
    parser.add_argument("--sampler", default="lattice", help="[%(default)s]")
    parser.add_argument("--spp", type=int, default=64, help="[%(default)s]")
    parser.add_argument("--seeds", type=int, default=10, help="[%(default)s]")
    parser.add_argument("--side", type=int, default=256, help="root of the number of pixels [%(default)s]")
    parser.add_argument(
        "--part",
        type=float,
        default=1.0,
        help="of width and height, in the middle; of the pilot its share [%(default)s]",
    )
    parser.add_argument("--max-depth", type=int, default=9, help="[%(default)s]")
    parser.add_argument("--keep", type=Path, help="folder for images")
    options = parsed(parser, seeds=3, side=64, spp=16)
    over_plain, over_best = [], []
    for path in options.scenes:
        products, whole = measured(path, options)
        cells = "  ".join(f"{name} {products[name]:.3f} ({whole[name]:.3f})" for name in products)
        print(f"{Path(path).parent.name}/{Path(path).stem:16} {cells}", flush=True)
        over_plain.append(products["best"])
        over_best.append(products["best"] / min(1.0, *(products[name] for name in FIXED)))
    mean = math.exp(sum(map(math.log, over_plain)) / len(over_plain))
    print(f"best over plain: geometric mean {mean:.3f}")
    print(f"best over the best fixed choice: mean {np.mean(over_best):.3f}, worst {max(over_best):.3f}")


def measured(path: str, options: Any) -> tuple[dict[str, float], dict[str, float]]:
    """Return relMSE times rays over those of the first fixed choice, by choice: with the tail cut off, and whole."""
    scene = middle(sized(path, options.side, options.max_depth), options.part)
    found = {name: images(scene, words, options) for name, words in FIXED.items()}
    errors = squared_errors({name: each for name, (each, _) in found.items()})
    most = float(np.quantile(np.stack(list(errors.values())), 1.0 - TAIL))
    rays = {name: each for name, (_, each) in found.items()}
    roulette, pilot = decision(scene, options)
    chosen = DECIDED[roulette]
    errors["best"], rays["best"] = errors[chosen], rays[chosen] + (pilot if roulette == "throughput" else 0.0)
    cut, whole = (
        {name: float(np.minimum(each, limit).mean()) * rays[name] for name, each in errors.items()}
        for limit in (most, math.inf)
    )
    return {name: cut[name] / cut["plain"] for name in cut}, {name: whole[name] / whole["plain"] for name in whole}


def sized(path: str, side: int, max_depth: int) -> et.Scene:
    """Load a scene with about side² pixels and no fewer, in the shape of its picture."""
    loaded = et.load(path, substitute=True, **defines(Path(path)))
    width, height = loaded.size
    across = math.ceil(side * math.sqrt(width / height))
    scene = loaded.with_(size=(across, math.ceil(side * side / across)))
    return scene.with_(max_depth=max_depth) if not 0 <= scene.max_depth <= max_depth else scene


def middle(scene: et.Scene, part: float) -> et.Scene:
    """Return the scene with a window in the middle of its film: splitting goes by the whole, counts by the window."""
    width, height = scene.size
    across, down = math.ceil(part * width), math.ceil(part * height)
    return scene.with_(crop=((width - across) // 2, (height - down) // 2, across, down))


def decision(scene: et.Scene, options: Any) -> tuple[str, float]:
    """Return the roulette that `best` decides for, and the rays of its pilot."""
    words = f"best,roulette=automatic,adaptive=none,sampler={options.sampler}"
    renderer = make_renderer(scene, et.Strategy.parse(words), 0, options.threads)
    renderer.advance(1)
    assert renderer.decision is not None
    return renderer.decision["roulette"], options.part**2 * renderer.decision["rays"]


def images(scene: et.Scene, words: str, options: Any) -> tuple[Floats, float]:
    """Return images (seeds, H, W, 3) and the mean of their rays."""
    each = [image(scene, words, seed, options) for seed in range(options.seeds)]
    return np.stack([found for found, _ in each]), float(np.mean([rays for _, rays in each]))


def image(scene: et.Scene, words: str, seed: int, options: Any) -> tuple[Floats, float]:
    """Render an image and count its rays, or read them where they are kept."""
    name = f"{scene.digest[:12]}-{words.replace('=', '-')}-{options.sampler}-{options.spp}-{seed}.npz"
    kept = None if options.keep is None else options.keep / name
    if kept is not None and kept.exists():
        with np.load(kept) as file:
            return file["image"].astype(np.float64), float(file["rays"])
    strategy = et.Strategy.parse(f"best,{words},sampler={options.sampler}")
    renderer = make_renderer(scene, strategy, seed, options.threads)
    renderer.advance(options.spp)
    counts = renderer.moments["count"][..., None].astype(np.float64)
    found = (counts * renderer.moments["mean"]).sum(axis=0) / counts.sum(axis=0)
    rays = renderer.counters["rays"] + renderer.counters["shadow_rays"]
    rays -= (1.0 - options.part**2) * (0 if renderer.decision is None else renderer.decision["rays"])
    if kept is not None:
        kept.parent.mkdir(parents=True, exist_ok=True)
        np.savez_compressed(kept, image=found.astype(np.float32), rays=rays)
    return found, float(rays)


def squared_errors(found: dict[str, Floats]) -> dict[str, Floats]:
    """Return relative squared deviations from the mean over seeds, (seeds, H, W), free of bias."""
    mean = np.mean([each.mean(axis=0) for each in found.values()], axis=0)
    scale = 1.0 / (np.square(mean) + (0.1 * mean.mean()) ** 2)
    return {
        name: (np.square(each - each.mean(axis=0)) * scale).mean(axis=-1) * len(each) / (len(each) - 1)
        for name, each in found.items()
    }


if __name__ == "__main__":
    main()
