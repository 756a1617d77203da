"""What the scripts of this folder share: rounds of repeats, medians of ratios, and the lines that a claim needs."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from equaltime import _core
from equaltime.machine import machine
from equaltime.statistics.intervals import Interval, median_interval

Floats = NDArray[np.float64]
SCENES = Path(__file__).resolve().parents[2] / "scenes"
SHIPPED = (
    SCENES / "cornell-box.toml",
    SCENES / "veach-mis.toml",
    SCENES / "montelight/simple.toml",
    SCENES / "montelight/complex.toml",
)


def arguments(description: str | None, repeats: int = 9, threads: int = 0) -> argparse.ArgumentParser:
    """Return a parser with the options that every script has."""
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--repeats", type=int, default=repeats, help="rounds of the measurement [%(default)s]")
    parser.add_argument("--threads", type=int, default=threads, help="worker threads; 0: one a processor [%(default)s]")
    return parser


def parsed(parser: argparse.ArgumentParser, **quick: Any) -> argparse.Namespace:
    """Read the command line, in which ``--quick`` sets these values, and print the conditions."""
    words = ", ".join(f"--{name} {value:g}" for name, value in quick.items())
    parser.add_argument("--quick", action="store_true", help=f"for a first look: {words}")
    options = parser.parse_args()
    if options.quick:
        vars(options).update(quick)
    print_conditions(options)
    return options


def print_conditions(options: argparse.Namespace) -> None:
    """Print machine, build and repeats: what every figure below holds for."""
    here, build = machine(), _core.build_info()
    print(f"machine  {here['cpu']}, {here['processors']} processors, {here['memory_bytes'] / 2**30:.0f} GB")
    print(f"system   {here['system']}, load {here['load_average']:.2f} before the run")
    print(f"build    equaltime {build['version']}, {build['compiler']}, {build['target']}, Embree {build['embree']}")
    print(f"repeats  {options.repeats}, threads {options.threads or here['processors']}; medians [95 % intervals]")


def defines(path: Path) -> dict[str, Any]:
    """Return values for the variables of a scene file that have no default that either renderer knows."""
    text = path.read_text(encoding="utf-8")
    return {"integrator": "volpath" if "<medium" in text else "path"} if "$integrator" in text else {}


def rounds(names: Iterable[str], measure: Callable[[str, int], float], repeats: int) -> dict[str, list[float]]:
    """Measure every name once a round, there and back; return what each gave.

    ``measure`` is told the name and the round, a number from 1 on. Round 0 is for files, caches and compilers: it is
    measured too, and thrown away.
    """
    results: dict[str, list[float]] = {name: [] for name in names}
    for number in range(repeats + 1):
        for name in list(results) if number % 2 == 0 else list(results)[::-1]:
            value = measure(name, number)
            if number > 0:
                results[name].append(value)
    return results


def ratio(above: Sequence[float], below: Sequence[float]) -> Interval:
    """Return the spread of the ratios within each round."""
    return median_interval([a / b for a, b in zip(above, below, strict=True)])


def relative_variance(images: Floats, mean: Floats | None = None) -> Floats:
    """Variance of each pixel of (seeds, H, W, 3) images, (H, W): relative to their mean, or to another."""
    reference = images.mean(axis=0) if mean is None else mean
    return np.asarray((images.var(axis=0, ddof=1) / (reference**2 + (0.1 * reference.mean()) ** 2)).mean(axis=-1))


def noise(images: Sequence[Floats], mean: Floats | None = None) -> float:
    """RelMSE of one image, from the scatter of all over their seeds."""
    return float(relative_variance(np.asarray(images), mean).mean()) if len(images) > 1 else float("nan")


def text(value: Interval, digits: int = 3) -> str:
    """Write ``1.52 [1.50, 1.53]``."""
    return f"{value.value:.{digits}g} [{value.low:.{digits}g}, {value.high:.{digits}g}]"


def render_seconds(
    scene: _core.Scene, settings: _core.Settings, samples: int, threads: int, seed: int = 0
) -> tuple[float, Any]:
    """Render without anything around it: return seconds and the renderer."""
    renderer = _core.Renderer(scene, settings, seed=seed, threads=threads)
    begin = perf_counter()
    renderer.advance(samples)
    return perf_counter() - begin, renderer


def samples_for(scene: _core.Scene, settings: _core.Settings, threads: int, seconds: float = 0.5) -> int:
    """Return how many samples a pixel take about so many seconds."""
    pilot = render_seconds(scene, settings, 2, threads)[0] / 2
    return max(2, min(round(seconds / pilot), 1024))
