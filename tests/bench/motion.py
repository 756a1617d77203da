"""What motion costs: processor time of scenes in which something moves, over that of the same scenes at rest.

Boxes and a ball that move, a camera that turns, and keys that are all alike. A mesh that deforms is a wavy ground of a
hundred thousand triangles, and beside its ratio stands Embree's own, on the very rays of the same renders.
"""

from __future__ import annotations

import argparse
from time import process_time
from typing import Any

import numpy as np
from measuring import SCENES, arguments, print_conditions, ratio, rounds, samples_for, text

import equaltime as et
from equaltime import _core

CORNELL, MOTION = SCENES / "cornell-box.toml", SCENES / "experiments" / "motion.toml"
GRID = 224
"""Squares along a side of the ground."""


def main() -> None:
    parser = arguments(__doc__, threads=1)
    options = parser.parse_args()
    print_conditions(options)
    compare(
        "Cornell box",
        {
            "at rest": et.load(CORNELL),
            "equal keys": boxes(0.0, 0.0),
            "a box moves": boxes(0.3, 0.0, "short_box"),
            "both boxes move": boxes(0.3, 0.0),
            "both move and turn": boxes(0.3, 30.0),
        },
        options,
    )
    compare(
        "montelight's complex room",
        {
            "at rest": et.load(MOTION),
            "a ball rolls": et.load(MOTION, ball=20.0),
            "a lamp swings": et.load(MOTION, lamp=20.0),
            "the camera turns": et.load(MOTION, turn=5.0),
        },
        options,
    )
    deformation(options)


def boxes(way: float, angle: float, *names: str) -> et.Scene:
    """Return the Cornell box with boxes, or both, that move a way to the right and turn by degrees."""
    room = et.load(CORNELL).to_dict()
    turn = [{"rotate": {"axis": [0, 1, 0], "angle": angle}}, {"translate": [way, 0, 0]}]
    for name in names or ("short_box", "tall_box"):
        place = {"matrix": room[name]["to_world"]}
        keys = [{"time": 0, "transform": [place]}, {"time": 1, "transform": [place, *turn]}]
        room[name]["to_world"] = {"animation": keys}
    room["sensor"]["shutter_close"] = 1.0
    return et.load_dict(room)


def compare(name: str, scenes: dict[str, et.Scene], options: argparse.Namespace) -> None:
    """Render the scenes in turn, and print each one's time over the first one's."""
    small = {what: scene.with_(size=(256, 256), max_depth=8) for what, scene in scenes.items()}
    settings = _core.Settings(max_depth=8)
    still = next(iter(small))
    spp = samples_for(small[still].core, settings, options.threads)

    def seconds(what: str, seed: int) -> float:
        renderer = _core.Renderer(small[what].core, settings, seed, options.threads)
        begin = process_time()
        renderer.advance(spp)
        return process_time() - begin

    times = rounds(small, seconds, options.repeats)
    print(f"\n{name}, {spp} spp")
    for what in small:
        print(f"  {text(ratio(times[what], times[still]))} x the time at rest: {what}")


def deformation(options: argparse.Namespace) -> None:
    """Render the ground at rest and deforming, and Embree alone on the rays of both, and print ratios."""
    settings = _core.Settings(max_depth=8)
    grounds = {False: ground(deforms=False), True: ground(deforms=True)}
    spp = samples_for(grounds[False], settings, options.threads)
    pairs: dict[bool, list[Any]] = {False: [], True: []}
    for number in range(options.repeats):
        for deforms in pairs if number % 2 else reversed(pairs):
            found = _core.measure_limit(grounds[deforms], settings, number, options.threads, samples=spp, pairs=1)
            pairs[deforms] += found["pairs"]
    print(f"\na ground that deforms, {spp} spp")
    for what, key in (("render", "render_seconds"), ("Embree alone", "replay_seconds")):
        still, moving = ([pair[key] for pair in pairs[deforms]] for deforms in (False, True))
        print(f"  {text(ratio(moving, still))} x the time at rest: {what}")


def ground(*, deforms: bool) -> Any:
    """Build a wavy ground under a sky, whose waves turn over if it deforms."""
    x, y = np.meshgrid(np.linspace(-1.0, 1.0, GRID + 1), np.linspace(-1.0, 1.0, GRID + 1))
    waves = 0.05 * np.sin(25.0 * x) * np.cos(20.0 * y)
    rest, turned = (np.stack([x, y, sign * waves], axis=-1).reshape(-1, 3) for sign in (1.0, -1.0))
    corner = (np.arange(GRID)[:, None] * (GRID + 1) + np.arange(GRID)).ravel()
    low = np.stack([corner, corner + 1, corner + GRID + 2], axis=-1)
    high = np.stack([corner, corner + GRID + 2, corner + GRID + 1], axis=-1)
    builder = _core.SceneBuilder()
    grey = builder.add_bsdf("diffuse", (0.7, 0.7, 0.7))
    mesh = builder.add_mesh(rest, np.concatenate([low, high]), None, None, front=grey, back=grey, radiance=None)
    if deforms:
        builder.deform_mesh(mesh, turned[None])
    builder.add_constant_environment((1.0, 1.0, 1.0))
    camera = np.array([[-1, 0, 0, 0], [0, 0.7, 0.7, -2], [0, 0.7, -0.7, 2], [0, 0, 0, 1.0]])
    builder.set_perspective(camera, 40.0)
    builder.set_film(256, 256, (0, 0, 256, 256), "box", 0.5)
    return builder.build()


if __name__ == "__main__":
    main()
