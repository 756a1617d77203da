"""What moves, against the cross-check: brute force, another still scene for each sample.

Seeds are fixed; the test would fail for one choice of them in a thousand. All pixels of the cross-check share their
times, so that errors are told from many seeds.
"""

from __future__ import annotations

from typing import Any

import numpy as np

import equaltime as et
from equaltime import crosscheck
from equaltime.scene.motion import still
from equaltime.statistics.agreement import LEVEL, equality_test

VIEW = {"look_at": {"origin": [0, -4, 1.5], "target": [0, 0, 0.5], "up": [0, 0, 1]}}
DOWN = {"rotate": {"axis": [1, 0, 0], "angle": 180}}


def animated(*transforms: Any) -> dict[str, Any]:
    return {"animation": [{"time": float(t), "transform": list(x)} for t, x in enumerate(transforms)]}


def scene() -> et.Scene:
    """A rod that spins and a ball that falls past a lamp that swings, seen by a camera that pans."""
    turn = {"rotate": {"axis": [0, 0, 1], "angle": 140}}
    first, last = {"scale": [0.9, 0.1, 0.1]}, {"scale": [0.9, 0.1, 0.2]}
    rod = animated([first, {"translate": [0, 0, 0.5]}], [last, turn, {"translate": [0, 0.2, 0.7]}])
    ball = animated([{"translate": [0.6, -0.5, 1.2]}], [{"translate": [0.6, -0.5, 0.3]}])
    lamp = animated(
        [{"scale": 0.4}, DOWN, {"translate": [-1.2, 0, 2]}], [{"scale": 0.4}, DOWN, {"translate": [1, 0, 2]}]
    )
    pan = animated([VIEW], [VIEW, {"rotate": {"axis": [0, 0, 1], "angle": 6}}])
    red = {"type": "diffuse", "reflectance": [0.8, 0.3, 0.2]}
    return et.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "path", "max_depth": 3},
            "sensor": {"type": "perspective", "fov": 40, "to_world": pan, "shutter_open": 0.25, "shutter_close": 1},
            "floor": {"type": "rectangle", "to_world": [{"scale": 3}]},
            "rod": {"type": "cube", "to_world": rod, "bsdf": red},
            "ball": {"type": "sphere", "radius": 0.25, "to_world": ball, "bsdf": red},
            "lamp": {"type": "rectangle", "to_world": lamp, "emitter": {"type": "area", "radiance": 8}},
        }
    ).with_(size=(24, 16))


def agreement(moving: et.Scene, core: et.Scene) -> float:
    ours = (et.render(core, spp=16, seed=seed).image.astype(np.float64) for seed in range(24))
    theirs = (crosscheck.render(moving, 6, seed=seed)[0] for seed in range(24))
    return equality_test(ours, theirs)


def test_what_moves_agrees_with_the_cross_check() -> None:
    assert agreement(scene(), scene()) > LEVEL


def test_what_stands_at_the_shutters_centre_does_not() -> None:
    moving = scene()
    assert agreement(moving, moving.replaced(still(moving.model))) < LEVEL
