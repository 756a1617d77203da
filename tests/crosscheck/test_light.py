"""The cross-check's images against closed forms of the light that a camera receives.

Fixed seeds; each statistical test has a false-alarm rate of 1e-4.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy import stats

import equaltime as et
from equaltime import crosscheck

Shape = dict[str, Any]
LEVEL = 1e-4
POINT_VIEW = {"type": "perspective", "fov": 1e-4, "film": {"type": "hdrfilm", "width": 1, "height": 1}}
"""One pixel that sees a single point."""


def grey(value: float) -> Shape:
    return {"type": "rgb", "value": [value] * 3}


def matte(reflectance: float) -> Shape:
    return {"type": "diffuse", "reflectance": grey(reflectance)}


def scene(max_depth: int, sensor: Shape, *objects: Shape) -> et.Scene:
    return et.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "path", "max_depth": max_depth},
            "sensor": sensor,
            **{f"object{i}": shape for i, shape in enumerate(objects)},
        }
    )


def look(origin: tuple[float, float, float], target: tuple[float, float, float]) -> list[Shape]:
    return [{"look_at": {"origin": origin, "target": target, "up": (0, 1, 0)}}]


def agrees(mean: np.ndarray, variance: np.ndarray, expected: float) -> bool:
    error = math.sqrt(variance[..., 0].sum()) / variance[..., 0].size
    difference = abs(mean[..., 0].mean() - expected)
    if error < 1e-9 * expected:  # nothing random in it
        return bool(difference < 1e-9 * expected)
    return bool(2.0 * stats.norm.sf(difference / error) > LEVEL)


def floor_below(light: Shape) -> et.Scene:
    """A point of a plane with albedo 0.7 at the origin, seen from the side, under a light."""
    plane = {"type": "rectangle", "bsdf": matte(0.7), "to_world": [{"rotate": {"axis": (1, 0, 0), "angle": -90}}]}
    return scene(2, {**POINT_VIEW, "to_world": look((3, 1, 2), (0, 0, 0))}, plane, light)


@pytest.mark.parametrize("depth", [1, 2, 3, 8])
@pytest.mark.parametrize("shape", ["sphere", "cube"])
def test_a_furnace_has_the_radiance_one_minus_albedo_to_the_depth(shape: str, depth: int) -> None:
    walls = {
        "type": shape,
        "flip_normals": True,
        "bsdf": matte(0.8),
        "emitter": {"type": "area", "radiance": grey(0.2)},
    }
    sensor = {"type": "perspective", "fov": 90, "film": {"type": "hdrfilm", "width": 8, "height": 8}}
    mean, variance = crosscheck.render(scene(depth, sensor, walls), 256, seed=depth)
    assert agrees(mean, variance, 1 - 0.8**depth)
    assert not agrees(mean, variance, 1 - 0.82**depth)


def test_a_furnace_without_limit_of_depth_has_the_radiance_one() -> None:
    walls = {
        "type": "cube",
        "flip_normals": True,
        "bsdf": matte(0.5),
        "emitter": {"type": "area", "radiance": grey(0.5)},
    }
    mean, variance = crosscheck.render(scene(-1, POINT_VIEW, walls), 2000, seed=1)
    assert agrees(mean, variance, 1.0)


def test_a_point_light_gives_intensity_times_cosine_over_squared_distance() -> None:
    loaded = floor_below({"type": "point", "position": [1, 2, 2], "intensity": grey(5)})
    mean, variance = crosscheck.render(loaded, 16)
    assert agrees(mean, variance, 0.7 / math.pi * 5 * (2 / 3) / 9)


def test_a_sphere_light_gives_what_a_point_light_in_its_centre_would() -> None:
    light = {"type": "sphere", "center": [1, 2, 2], "radius": 1.5, "emitter": {"type": "area", "radiance": grey(3)}}
    mean, variance = crosscheck.render(floor_below(light), 100_000, seed=2)
    assert agrees(mean, variance, 0.7 * 3 * (1.5 / 3) ** 2 * (2 / 3))
    assert not agrees(mean, variance, 1.02 * 0.7 * 3 * (1.5 / 3) ** 2 * (2 / 3))


def test_a_disk_light_overhead_gives_its_view_factor() -> None:
    turned = [{"rotate": {"axis": (1, 0, 0), "angle": 90}}, {"scale": 0.8}, {"translate": (0, 1.5, 0)}]
    light = {"type": "disk", "to_world": turned, "emitter": {"type": "area", "radiance": grey(3)}}
    mean, variance = crosscheck.render(floor_below(light), 100_000, seed=3)
    assert agrees(mean, variance, 0.7 * 3 * 0.8**2 / (0.8**2 + 1.5**2))


@pytest.mark.parametrize("kind", ["rectangle", "cube"])
def test_a_square_light_overhead_gives_its_view_factor(kind: str) -> None:
    """Of a cube, the face below and nothing else."""
    turned = [{"rotate": {"axis": (1, 0, 0), "angle": 90}}, {"translate": (0, 1.5 + (kind == "cube"), 0)}]
    light = {"type": kind, "to_world": turned, "emitter": {"type": "area", "radiance": grey(3)}}
    mean, variance = crosscheck.render(floor_below(light), 100_000, seed=4)
    a = 1 / 1.5  # four squares, each with a corner overhead
    factor = 4 / math.pi * a / math.sqrt(1 + a**2) * math.atan(a / math.sqrt(1 + a**2))
    assert agrees(mean, variance, 0.7 * 3 * factor)


def test_light_leaves_the_front_side_only_and_reaches_the_front_side_only() -> None:
    up = {"type": "rectangle", "to_world": [{"rotate": {"axis": (1, 0, 0), "angle": -90}}, {"translate": (0, 2, 0)}]}
    away = {**up, "emitter": {"type": "area", "radiance": grey(3)}}
    assert not crosscheck.render(floor_below(away), 1000)[0].any()
    below = {"type": "point", "position": [0, -1, 0], "intensity": grey(5)}
    assert not crosscheck.render(floor_below(below), 16)[0].any()


def test_a_thing_in_the_way_leaves_only_darkness() -> None:
    """A disk between a point and its light, however near to either."""
    for height in (1e-4, 1.0, 1.999):
        disk = {
            "type": "disk",
            "to_world": [{"rotate": {"axis": (1, 0, 0), "angle": 90}}, {"translate": (0, height, 0)}],
        }
        plane = {"type": "rectangle", "bsdf": matte(0.7), "to_world": [{"rotate": {"axis": (1, 0, 0), "angle": -90}}]}
        light = {"type": "point", "position": [0, 2, 0], "intensity": grey(5)}
        sensor = {**POINT_VIEW, "to_world": look((0.5, -0.5, 0), (0, 0, 0))}
        below = {**plane, "to_world": [{"rotate": {"axis": (1, 0, 0), "angle": 90}}]}
        shadowed = scene(2, {**POINT_VIEW, "to_world": look((3, 1e-5, 0), (0, 0, 0))}, plane, disk, light)
        assert not crosscheck.render(shadowed, 16)[0].any()
        assert not crosscheck.render(scene(2, sensor, below, plane, light), 16)[0].any()


@pytest.mark.parametrize("smooth", [False, True])
def test_a_convex_thing_under_a_uniform_sky_shows_its_albedo(smooth: bool) -> None:
    thing = {"type": "sphere" if smooth else "cube", "bsdf": matte(0.6)}
    sensor = {**POINT_VIEW, "to_world": look((3, 4, 5), (0, 0, 0))}
    mean, variance = crosscheck.render(
        scene(2, sensor, thing, {"type": "constant", "radiance": grey(2)}), 20_000, seed=5
    )
    assert agrees(mean, variance, 1.2)


def test_clear_glass_under_a_uniform_sky_is_invisible() -> None:
    glass = {"type": "sphere", "bsdf": {"type": "dielectric", "int_ior": 1.5, "ext_ior": 1.0}}
    sensor = {
        "type": "perspective",
        "fov": 40,
        "to_world": look((0, 0, 5), (0, 0, 0)),
        "film": {"type": "hdrfilm", "width": 8, "height": 8},
    }
    mean, _ = crosscheck.render(scene(-1, sensor, glass, {"type": "constant", "radiance": grey(2)}), 64, seed=6)
    np.testing.assert_allclose(mean, 2.0, rtol=1e-12)


def test_a_mirror_shows_what_it_reflects() -> None:
    mirror = {"type": "rectangle", "bsdf": {"type": "conductor", "specular_reflectance": grey(0.9)}}
    wall = {
        "type": "rectangle",
        "to_world": [{"rotate": {"axis": (0, 1, 0), "angle": 180}}, {"scale": 9}, {"translate": (0, 0, 9)}],
        "emitter": {"type": "area", "radiance": grey(2)},
    }
    sensor = {**POINT_VIEW, "to_world": look((0.1, 0.2, 5), (0, 0, 0))}
    mean, _ = crosscheck.render(scene(3, sensor, mirror, wall), 4)
    np.testing.assert_allclose(mean, 1.8, rtol=1e-12)
    assert not crosscheck.render(scene(1, sensor, mirror, wall), 4)[0].any()


def test_clip_planes_hide_what_is_outside() -> None:
    wall = {
        "type": "rectangle",
        "to_world": [{"rotate": {"axis": (0, 1, 0), "angle": 180}}, {"translate": (0, 0, 5)}],
        "emitter": {"type": "area"},
    }
    for clips, seen in (
        ({}, True),
        ({"near_clip": 5.1}, False),
        ({"far_clip": 4.9}, False),
        ({"near_clip": 4.9, "far_clip": 5.1}, True),
    ):
        mean, _ = crosscheck.render(scene(1, {**POINT_VIEW, **clips}, wall), 1)
        assert bool(mean.any()) is seen


def test_the_seed_decides_the_image_and_one_sample_has_no_variance() -> None:
    walls = {"type": "cube", "flip_normals": True, "bsdf": matte(0.5), "emitter": {"type": "area"}}
    loaded = scene(3, {"type": "perspective", "film": {"type": "hdrfilm", "width": 6, "height": 4}}, walls)
    first, again, other = (crosscheck.render(loaded, 8, seed)[0] for seed in (1, 1, 2))
    np.testing.assert_array_equal(first, again)
    assert (first != other).any()
    assert first.shape == (4, 6, 3)
    assert np.isnan(crosscheck.render(loaded, 1)[1]).all()
    assert crosscheck.render(loaded, 1, size=(3, 2))[0].shape == (2, 3, 3)


def test_the_variance_of_the_mean_is_what_the_means_of_many_seeds_have() -> None:
    walls = {"type": "cube", "flip_normals": True, "bsdf": matte(0.5), "emitter": {"type": "area"}}
    loaded = scene(3, {"type": "perspective", "film": {"type": "hdrfilm", "width": 8, "height": 8}}, walls)
    runs = [crosscheck.render(loaded, 64, seed) for seed in range(30)]
    between = np.var([mean for mean, _ in runs], axis=0, ddof=1)[..., 0].mean()
    within = np.mean([variance for _, variance in runs], axis=0)[..., 0].mean()
    assert between / within == pytest.approx(1.0, abs=4.0 * math.sqrt(2.0 / (29 * 64)))
