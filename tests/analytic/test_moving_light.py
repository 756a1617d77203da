"""Irradiance from lights that move, averaged over the shutter, against closed forms: by every technique.

Seeds are fixed. The z-tests of this file together have a false-alarm rate of 0.1 %.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import integrate, stats

import equaltime as et
from equaltime import _core
from equaltime.film.moments import squared_deviations
from equaltime.scene import transforms
from equaltime.scene.motion import animation, pose

from ..statistical.chi2 import LEVEL, share

Array = NDArray[np.float64]

TECHNIQUES = {
    "mis": {"technique": "mis"},
    "light": {"technique": "light"},
    "bsdf": {"technique": "bsdf"},
    "mixture": {"technique": "mixture"},
    "by the tree": {"technique": "mis", "lights": "tree"},
}
EACH = share(LEVEL, 5 * len(TECHNIQUES))
RADIANCE = 3.0
HEIGHT, REACH, RADIUS = 1.5, 2.0, 0.5


def rendered(shape: dict[str, Any], still: bool = False, **strategy: Any) -> tuple[float, float]:
    """Return the irradiance of the origin, which faces up, and its standard error."""
    view = {"look_at": {"origin": [0, -4, 0.5], "target": [0, 0, 0], "up": [0, 0, 1]}}
    closes = 0.0 if still else 1.0
    sensor = {"type": "perspective", "to_world": [view], "fov": 1e-3, "shutter_close": closes}
    floor = {"type": "rectangle", "to_world": [{"scale": 9}], "bsdf": {"type": "diffuse", "reflectance": 1.0}}
    lamp = {"emitter": {"type": "area", "radiance": RADIANCE}, "bsdf": {"type": "diffuse", "reflectance": 0.0}}
    other = {"type": "sphere", "center": [0, 0, -5], "radius": 0.1, "emitter": {"type": "area", "radiance": 1}}
    whole = {"type": "scene", "sensor": sensor, "integrator": {"type": "path", "max_depth": 2}}
    scene = et.load_dict(whole | {"floor": floor, "lamp": shape | lamp, "other": other}).with_(size=(16, 16))
    settings = _core.Settings(max_depth=2, sampler="independent", **strategy)
    renderer = _core.Renderer(scene.core, settings, seed=11, threads=1)
    assert renderer.advance(64)
    moments = renderer.moments
    count, mean, squares = moments["count"], moments["mean"], squared_deviations(moments)
    total = count.sum()
    center = (mean[..., 0] * count).sum() / total
    variance = (squares[..., 0] + count * (mean[..., 0] - center) ** 2).sum() / (total - 1)
    return float(np.pi * center), float(np.pi * np.sqrt(variance / total))


def polygon(corners: Array) -> float:
    """Irradiance of the origin, facing up, from a polygon of radiance 1 above it (Lambert 1760)."""
    unit = corners / np.linalg.norm(corners, axis=1, keepdims=True)
    total = 0.0
    for a, b in zip(unit, np.roll(unit, -1, axis=0), strict=True):
        edge = np.cross(a, b)
        total += np.arctan2(np.linalg.norm(edge), a @ b) * edge[2] / np.linalg.norm(edge)
    return 0.5 * abs(total)


def keys(*steps: list[dict[str, Any]]) -> tuple[dict[str, Any], Any]:
    """Return the animation as written, and as it is."""
    times = np.linspace(0.0, 1.0, len(steps)).tolist()
    written = {"animation": [{"time": t, "transform": s} for t, s in zip(times, steps, strict=True)]}
    return written, animation([(t, transforms.parse(s)) for t, s in zip(times, steps, strict=True)])


def sliding(shape: str) -> tuple[dict[str, Any], float]:
    """A ball, which is seen as by its centre: π L r² h / d³, whose mean along a line is L r² π / (h √(a² + h²))."""
    written, _ = keys([{"translate": [-REACH, 0, HEIGHT]}], [{"translate": [REACH, 0, HEIGHT]}])
    mean = np.pi * RADIANCE * RADIUS**2 / (HEIGHT * np.hypot(REACH, HEIGHT))
    return {"type": shape, "radius": RADIUS, "to_world": written}, mean


def tumbling(shape: str, corners: Array) -> tuple[dict[str, Any], float]:
    """A plate that turns, grows and goes past, seen by one face all the time."""
    down = {"rotate": {"axis": [1, 0, 0], "angle": 180}}
    written, moving = keys(
        [{"scale": [0.5, 0.25, 1]}, down, {"translate": [-1, 0.5, 1]}],
        [{"scale": [0.75, 0.25, 1]}, down, {"rotate": {"axis": [1, 1, 3], "angle": 70}}, {"translate": [1, 0, 1.25]}],
        [{"scale": [0.25, 0.5, 1]}, down, {"rotate": {"axis": [1, 0, 3], "angle": 100}}, {"translate": [0.5, 0, 0.75]}],
    )

    def at(time: float) -> float:
        matrix = pose(moving, time)
        return polygon(corners @ matrix[:3, :3].T + matrix[:3, 3])

    mean, error = integrate.quad(at, 0.0, 1.0, points=[0.5], limit=200)
    assert error < 1e-6 * mean
    return {"type": shape, "to_world": written}, RADIANCE * mean


def cases(name: str) -> tuple[dict[str, Any], float]:
    turn = np.linspace(0.0, 2.0 * np.pi, 721)[:-1]
    if name == "sphere":
        return sliding("sphere")
    if name == "written sphere":  # by hand, with few digits: scales along its axes differ by a thousandth
        shape, mean = sliding("sphere")
        back = {"translate": [0, 0, -40 * 1.0009]}
        for key in shape["to_world"]["animation"]:
            key["transform"] = [{"scale": [1, 1, 1.0009]}, back, *key["transform"]]
        return {**shape, "center": [0, 0, 40]}, mean * (2.0 + 1.0009**2) / 3.0
    if name == "disk":
        return tumbling("disk", np.stack([np.cos(turn), np.sin(turn), 0.0 * turn], axis=1))
    return tumbling("rectangle", np.array([[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]))


@pytest.mark.parametrize("technique", TECHNIQUES)
@pytest.mark.parametrize("name", ["sphere", "written sphere", "rectangle", "disk"])
def test_a_light_that_moves_lights_by_its_mean_over_time(name: str, technique: str) -> None:
    shape, exact = cases(name)
    mean, error = rendered(shape, **TECHNIQUES[technique])
    assert 2 * stats.norm.sf(abs(mean - exact) / (error + 2e-5 * exact)) > EACH
    if technique != "bsdf":
        assert 2 * stats.norm.sf(abs(1.04 * mean - exact) / error) < EACH, "the twin: four percent too bright"


@pytest.mark.parametrize("name", ["sphere", "rectangle", "disk"])
def test_a_light_that_stands_where_it_was_first_is_found_wrong(name: str) -> None:
    """The twin: a light that is sampled without regard to time."""
    shape, exact = cases(name)
    mean, error = rendered(shape, still=True, technique="light")
    assert 2 * stats.norm.sf(abs(mean - exact) / (error + 2e-5 * exact)) < EACH
