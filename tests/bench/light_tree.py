"""The light tree from two lights to a hundred thousand: seconds and bytes to make it; nanoseconds a light sample by it,
by power and alike; and time, noise at equal samples and efficiency of a render by it over one by power.

Noise is the relMSE of one render, from the scatter over rounds with a seed each; efficiency is 1 / (noise x time). The
lamps are triangles in a hall, facing down or every way, of powers over a decade, the smaller the more there are.
"""

from __future__ import annotations

from itertools import product
from time import perf_counter
from typing import Any

import numpy as np
from measuring import arguments, noise, print_conditions, ratio, render_seconds, rounds, samples_for, text

from equaltime import _core
from equaltime._core import parts

COUNTS = (2, 4, 8, 16, 32, 100, 1_000, 10_000, 100_000)
PICKS = ("uniform", "power", "tree")
SAMPLES = 200_000
FLOOR = np.array([[4.0, 0, 0, 0], [0, 0, 4, 0], [0, -4, 0, 0], [0, 0, 0, 1]])
CAMERA = np.array([[1.0, 0, 0, 0], [0, 0.866, -0.5, 1.2], [0, 0.5, 0.866, -4.5], [0, 0, 0, 1]])
"""Looks down: lamps so small would be noise in whatever pixel shows them."""

DOWNWARDS = np.array([[0.0, 0, 0], [1, 0, 0], [0, 0, 1]])


def hall(lights: int, down: bool) -> _core.Scene:
    """Return a hall with so many lamps, whose power together is about the same."""
    rng, builder = np.random.default_rng(lights), _core.SceneBuilder()
    grey = builder.add_bsdf("diffuse", [0.6, 0.5, 0.4])
    builder.add_rectangle(FLOOR, flip_normals=False, front=grey, back=grey, radiance=None)
    for x in (-2.0, 0.0, 2.0):
        builder.add_sphere([x, 0.6, 0], 0.6, flip_normals=False, front=grey, back=None, radiance=None)
    size = 0.3 / lights**0.5
    for group in np.array_split(rng.uniform([-3.5, 1.3, -3.5], [3.5, 2.5, 3.5], (lights, 3)), min(lights, 10)):
        shapes = 2 * size * DOWNWARDS if down else rng.normal(0, size, (len(group), 3, 3))
        corners = group[:, None, :] + shapes
        faces = np.arange(3 * len(group), dtype=np.uint32).reshape(-1, 3)
        radiance = np.full(3, 40.0 * 10.0 ** rng.uniform(-0.5, 0.5))
        builder.add_mesh(corners.reshape(-1, 3), faces, front=None, back=None, radiance=radiance)
    builder.set_perspective(CAMERA, 50)
    builder.set_film(128, 96, (0, 0, 128, 96), "box", 0.5)
    return builder.build()


def main() -> None:
    parser = arguments(__doc__, repeats=9)
    parser.add_argument("--counts", type=int, nargs="+", default=list(COUNTS), help="of lights")
    options = parser.parse_args()
    print_conditions(options)
    for lights, down in product(options.counts, (True, False)):
        scene = hall(lights, down)
        print(f"\n{lights} lights {'facing down' if down else 'facing every way'}")
        making(scene)
        sampling(scene, options)
        rendering(scene, options)


def making(scene: _core.Scene) -> None:
    """Print what the first renderer that asks for the tree pays."""
    before, begin = scene.memory_bytes, perf_counter()
    _core.Renderer(scene, _core.Settings(lights="tree"))
    seconds = perf_counter() - begin
    print(f"  made in {seconds:.3g} s, {(scene.memory_bytes - before) / 2**20:.3g} MB")


def sampling(scene: _core.Scene, options: Any) -> None:
    """Print the time of one light sample at random places: array overhead, the same for all, is in it."""
    rng = np.random.default_rng(1)
    places = rng.uniform([-4, 0, -4], [4, 2.5, 4], (SAMPLES, 3))
    normals = rng.standard_normal((SAMPLES, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)

    def nanoseconds(lights: str, seed: int) -> float:
        begin = perf_counter()
        parts.sample_lights(scene, lights, places, seed, normals)
        return (perf_counter() - begin) / SAMPLES * 1e9

    times = rounds(PICKS, nanoseconds, options.repeats)
    print("  a sample: " + ", ".join(f"{lights} {np.median(times[lights]):.0f} ns" for lights in PICKS), end="")
    print(f"; tree over power {text(ratio(times['tree'], times['power']))}")


def rendering(scene: _core.Scene, options: Any) -> None:
    """Print the ratios of time, noise and efficiency of whole renders."""
    settings = {lights: _core.Settings(lights=lights, max_depth=4) for lights in PICKS}
    spp = min(64, samples_for(scene, settings["power"], options.threads, 0.3))
    images: dict[str, list[Any]] = {lights: [] for lights in PICKS}

    def seconds(lights: str, seed: int) -> float:
        time, renderer = render_seconds(scene, settings[lights], spp, options.threads, seed)
        images[lights].append(np.asarray(renderer.moments["mean"]).mean(axis=0))
        return time

    times = rounds(PICKS, seconds, options.repeats)
    slower, noisier = ratio(times["tree"], times["power"]), noise(images["tree"]) / noise(images["power"])
    print(
        f"  a render of {spp} spp, tree over power: time {text(slower)}, noise {noisier:.3g},"
        f" efficiency {1.0 / (slower.value * noisier):.3g}"
    )


if __name__ == "__main__":
    main()
