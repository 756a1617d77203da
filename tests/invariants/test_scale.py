"""No absolute epsilon: a shipped scene in other units, or with other lights, gives the same image to the bit.

Lengths and brightness change by powers of two, which rounding does not see. Images are brought back exactly.
"""

from __future__ import annotations

from functools import cache
from typing import Any, Final

import pytest

import equaltime as et
from equaltime import _core
from equaltime.film.moments import deviations, stored

from ..statistical.changed import changed
from .shipped import FILES, Moments, renderer, same_bits, shipped

SAMPLES: Final = 8
LENGTHS: Final = [2.0**-20, 2.0**-7, 2.0, 2.0**20]
LIGHTS: Final = [2.0**-40, 0.5, 2.0**40]
STRATEGIES: Final[dict[str, dict[str, Any]]] = {
    "best": {},
    "bsdf": {"technique": "bsdf"},
    "light": {"technique": "light"},
    "naive": {"technique": "uniform", "roulette": "albedo", "sampler": "independent"},
    "mixture": {"technique": "mixture", "roulette": "constant"},
    "lights by the tree": {"lights": "tree", "sampler": "stratified"},
    "lattice": {"sampler": "lattice"},
}


def rendered(core: _core.Scene, light: float = 1.0, **strategy: Any) -> Moments:
    """Return the moments, brought back from lights `light` times as bright."""
    subject = renderer(core, **strategy)
    assert subject.advance(SAMPLES)
    assert not subject.nonfinite
    moments = subject.moments.copy()
    moments["mean"] /= light
    moments["deviation"] = stored(deviations(moments) / light)
    return moments


@cache
def reference(file: str, strategy: str = "best") -> Moments:
    moments = rendered(shipped(file).core, **STRATEGIES[strategy])
    assert moments["mean"].mean() > 0.01
    return moments


@pytest.mark.parametrize("file", FILES)
def test_a_builder_that_changes_nothing_gives_the_scene_itself(file: str) -> None:
    assert same_bits(rendered(changed(shipped(file))), reference(file))


@pytest.mark.parametrize("strategy", STRATEGIES)
@pytest.mark.parametrize("file", FILES)
def test_lengths_times_a_power_of_two_change_no_bit(file: str, strategy: str) -> None:
    for s in LENGTHS:
        assert same_bits(
            rendered(changed(shipped(file), length=s), **STRATEGIES[strategy]), reference(file, strategy)
        ), s


@pytest.mark.parametrize("strategy", STRATEGIES)
@pytest.mark.parametrize("file", FILES)
def test_lights_times_a_power_of_two_scale_the_image_exactly(file: str, strategy: str) -> None:
    for s in LIGHTS:
        bright = rendered(changed(shipped(file), light=s), s, **STRATEGIES[strategy])
        assert same_bits(bright, reference(file, strategy)), s


@pytest.mark.parametrize("light", [2.0**-40, 2.0**40])
@pytest.mark.parametrize("length", [2.0**-20, 2.0**20])
@pytest.mark.parametrize("file", FILES)
def test_both_at_their_extremes_change_no_bit(file: str, length: float, light: float) -> None:
    assert same_bits(rendered(changed(shipped(file), length=length, light=light), light), reference(file))


@pytest.mark.parametrize("file", FILES)
def test_what_is_no_power_of_two_is_seen(file: str) -> None:
    """The twin."""
    assert not same_bits(rendered(changed(shipped(file), length=3.0)), reference(file))
    assert not same_bits(rendered(changed(shipped(file), light=3.0), 3.0), reference(file))


def bulb(position: tuple[float, float, float]) -> et.Scene:
    floor = {"type": "rectangle", "bsdf": {"type": "diffuse", "reflectance": [0.6, 0.5, 0.4]}}
    ball = {"type": "sphere", "radius": 0.4, "center": [0.2, -0.1, 0.3], "bsdf": {"type": "dielectric"}}
    light = {"type": "point", "position": list(position), "intensity": [3, 4, 5]}
    sky = {"type": "constant", "radiance": [0.1, 0.2, 0.3]}
    view = {"look_at": {"origin": (0.5, -4, 2), "target": (0, 0, 0), "up": (0, 0, 1)}}
    camera = {"type": "perspective", "fov": 40, "to_world": [view], "near_clip": 4.2, "far_clip": 5.0}
    scene = et.load_dict({"type": "scene", "camera": camera, "f": floor, "b": ball, "l": light, "s": sky})
    return scene.with_(size=(24, 16), max_depth=8)


def test_point_lights_skies_and_clips_scale_too() -> None:
    """None of the shipped scenes has all of them."""
    scene = bulb((0.3, -0.8, 2.0))
    plain = rendered(scene.core)
    assert plain["mean"].mean() > 0.01
    for length, light in ((2.0**-20, 2.0**40), (2.0**20, 2.0**-40)):
        assert same_bits(rendered(changed(scene, length=length, light=light), light), plain)
    assert not same_bits(rendered(bulb((0.3, -0.8, 2.0 + 1e-6)).core), plain), "the twin: a light a millionth off"
