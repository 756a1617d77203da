"""A stop that looks at its own image selects images; a count that a pilot chose does not, and its images are unbiased.

Of two lamps one is small and bright: one path of a thousand meets it, and it makes a fifth of the light. Most images of
8x8 pixels have not met it when they are looked at first. The test is on the mean of all light over renders of many
seeds, at a false-alarm rate of 0.1 %, and rejects the stop that looks. The truth is rendered by aiming at the lamps.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import equaltime as et
from equaltime.rendering.budget import StopRule

RUNS = 150
ERROR = 0.5
MOST = 1024
"""Samples a pixel, whatever a pilot asks for: a limit that is given beforehand biases nothing."""
LEVEL_Z = 3.29
"""Of a false-alarm rate of 0.1 %, on both sides."""


def facing_down(size: float, height: float, radiance: float, kind: str) -> dict[str, Any]:
    placed = [{"scale": size}, {"rotate": {"axis": [1, 0, 0], "angle": 90}}, {"translate": [0, height, 0]}]
    return {"type": kind, "to_world": placed, "emitter": {"type": "area", "radiance": radiance}}


@pytest.fixture(scope="module")
def scene() -> et.Scene:
    camera = {"origin": [0, 0.5, 1.5], "target": [0, 0, 0], "up": [0, 1, 0]}
    film = {"type": "hdrfilm", "width": 8, "height": 8, "rfilter": {"type": "box"}}
    floor = [{"rotate": {"axis": [1, 0, 0], "angle": -90}}, {"scale": 4}]
    return et.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "path", "max_depth": 2},
            "sensor": {"type": "perspective", "fov": 10, "to_world": [{"look_at": camera}], "film": film},
            "floor": {"type": "rectangle", "to_world": floor, "bsdf": {"type": "diffuse", "reflectance": 0.5}},
            "ceiling": facing_down(1.0, 1.0, 1.0, "rectangle"),
            "bright": facing_down(0.0316, 0.99, 140.0, "disk"),
        }
    )


def z(scene: et.Scene, stop: StopRule) -> float:
    """Return how far the mean light of images is from the truth, in standard errors."""
    truth = float(et.render(scene, spp=16384, strategy="light", seed=2**60).image.mean(dtype=np.float64))
    runs = [
        et.render(scene, spp=MOST, error=ERROR, strategy="bsdf,sampler=independent", seed=seed, threads=1, stop=stop)
        for seed in range(RUNS)
    ]
    light = np.array([run.image.mean(dtype=np.float64) for run in runs])
    return float((light.mean() - truth) / (light.std(ddof=1) / math.sqrt(RUNS)))


def test_images_whose_count_a_pilot_chose_have_the_right_mean(scene: et.Scene) -> None:
    assert abs(z(scene, "fixed")) < LEVEL_Z


def test_the_same_test_rejects_images_that_stop_when_they_look_good(scene: et.Scene) -> None:
    assert z(scene, "look") < -LEVEL_Z
