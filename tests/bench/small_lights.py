"""How much faster light sampling is than none as lamps shrink, the latter from its variance where nothing is found.

Montelight's complex scene, as in scenes/experiments/x3-light.toml, but with paths of at most six vertices and no
roulette. A path that is sampled from diffuse BSDFs has the product of the reflectances for a weight, whatever its
directions, and ends at a lamp: its contribution is that product times the lamp's radiance. So the *second moment* of
the contribution is the image of another scene, in which reflectances and radiances are the squares of these, and that
image can be rendered with light sampling however small the lamps are. The variance of a pixel is it less the squared
image.
Where the lamps are large enough, the same variance is measured in renders without light sampling, and printed beside.

Time to equal error is then variance x seconds of a sample, over relMSE x seconds of renders with light sampling.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
from measuring import SCENES, arguments, print_conditions
from numpy.typing import NDArray

import equaltime as et
from equaltime.experiments.run import reference
from equaltime.images.metrics import Reference, measure
from equaltime.rendering.core_subject import CoreSubject
from equaltime.statistics.intervals import Interval, mean_interval, ratio_interval

SCENE = SCENES / "montelight" / "complex.toml"
RADIUS, RADIANCE = 1.5, 400.0
SHRINKS = (1, 4, 16, 64, 256, 1024, 4096)
SQUARED = {
    "[0.75, 0.25, 0.25]": "[0.5625, 0.0625, 0.0625]",
    "[0.25, 0.25, 0.75]": "[0.0625, 0.0625, 0.5625]",
    "reflectance = 0.75": "reflectance = 0.5625",
    "reflectance = 0.799": "reflectance = 0.638401",
}
MEASURED_TO = 16
"""Lamps that are smaller by more are found too seldom to measure the variance in seconds."""


def main() -> None:
    parser = arguments(__doc__, repeats=6)
    parser.add_argument("--side", type=int, default=64, help="of the image, in pixels [%(default)s]")
    options = parser.parse_args()
    print_conditions(options)
    with tempfile.TemporaryDirectory() as folder:
        text = SCENE.read_text()
        for plain, squared in SQUARED.items():
            assert plain in text
            text = text.replace(plain, squared)
        (square := Path(folder) / "squared.toml").write_text(text)
        for shrink in SHRINKS:
            compare(shrink, square, options.side, options.repeats, options.threads)


def compare(shrink: int, square: Path, side: int, repeats: int, threads: int) -> None:
    """Print the variance without light sampling and the ratio of times for lamps of so many times less area."""
    radius, radiance = RADIUS / np.sqrt(shrink), RADIANCE * shrink
    scene, squared = loaded(SCENE, radius, radiance, side), loaded(square, radius, radiance**2, side)
    known = reference.render(scene, error=0.02, seconds=20.0, threads=threads).reference
    naive, mis, moment = (renderer(*pair, threads) for pair in ((scene, "bsdf"), (scene, "mis"), (squared, "mis")))
    costs, variances, found = [], [], []
    for seed in range(repeats):
        second = variance(moment(seed, 64)[0], known)
        image, seconds = naive(seed, 64)
        with_lights, mis_seconds = mis(seed, 16)
        variances.append(second)
        found.append(64.0 * relmse(image, known))
        costs.append((second * seconds / 64.0, relmse(with_lights, known) * mis_seconds))
    ratio = ratio_interval(*zip(*costs, strict=True))
    beside = f", measured {shown(mean_interval(found))}" if shrink <= MEASURED_TO else ""
    moment_says = f"variance a sample {shown(mean_interval(variances))}"
    print(f"  area 1/{shrink:<5} {moment_says}{beside}; mis is {shown(ratio)} x faster")


def loaded(path: Path, radius: float, radiance: float, side: int) -> et.Scene:
    scene = et.load(path, light_radius=float(radius), light_radiance=float(radiance))
    return scene.with_(size=(side, side), max_depth=6)


def renderer(scene: et.Scene, strategy: str, threads: int) -> Callable[[int, int], tuple[NDArray[np.float64], float]]:
    """Return a function of seed and samples a pixel that gives an image and its seconds."""
    subject = CoreSubject(strategy, et.Strategy.parse(strategy))
    subject.prepare(scene, threads)

    def render(seed: int, spp: int) -> tuple[NDArray[np.float64], float]:
        subject.prepare(scene, threads)
        checkpoint = next(subject.run(seed, (spp,)))
        return checkpoint.image.astype(np.float64), checkpoint.wall_s

    return render


def variance(second: NDArray[np.float64], known: Reference) -> float:
    """Return the relative variance of one sample from an image of second moments, less the reference's noise."""
    return float(np.mean((second - known.mean**2 + known.noise) / known.denominator))


def relmse(image: NDArray[np.float64], known: Reference) -> float:
    return measure(image, known, ("relmse",))["relmse"].value


def shown(interval: Interval) -> str:
    return f"{interval.value:.3g} [{interval.low:.3g}, {interval.high:.3g}]"


if __name__ == "__main__":
    main()
