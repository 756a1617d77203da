"""Mitsuba's mean of a scene with ledges depends on the unit of length, and equaltime's does not.

Mitsuba moves the origin of a ray that leaves a surface by 1500 * 2^-24 * (1 + the largest coordinate) along the normal.
A shadow ray then passes over the edge of a ledge that should stop it, so that shadows are too short. The 1 does not
scale with the scene. In this court, as in the Sponza atrium, Mitsuba's mean is 0.2 % too high where the unit is a
metre. It is 1.4 % higher still where all lengths are a hundredth.

Mitsuba computes the density of a small sphere light in float32, from 1 - cos, which cancels. `test_light_densities` has
the same test of equaltime's density.

The tests that expect agreement have together a false-alarm rate of 0.1 %.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import stats

import equaltime as et
from equaltime.hardcases.units import in_units
from equaltime.scene.export.plain import mitsuba_dict, with_transforms
from equaltime.statistics.agreement import LEVEL, ROUNDING, share

mi = pytest.importorskip("mitsuba")
pytestmark = pytest.mark.usefixtures("scalar_mitsuba")

Array = NDArray[np.float64]
EACH = share(LEVEL, 2)
SEEDS, PAIRS = 64, 16
OFFSET = 1500 * 2.0**-24
ONE_LEDGE = 2e-4
"""Bound of what Mitsuba's offset changes in the mean of the court with one wide ledge, in metres.

It is linear in the offset, which is 1 + 12 units there and 100 + 12 at a hundredth of the size, where the mean is
0.0012 higher: 1.6e-4.
"""
HALF_LENGTH, HALF_WIDTH, HEIGHT = 15.0, 4.0, 12.0


def block(low: tuple[float, float, float], high: tuple[float, float, float]) -> dict[str, Any]:
    half, middle = np.subtract(high, low) / 2, np.add(low, high) / 2
    return {
        "type": "cube",
        "to_world": [{"scale": half.tolist()}, {"translate": middle.tolist()}],
        "bsdf": {"type": "diffuse"},
    }


def court(ledges: int, pilasters: int, depth: float) -> et.Scene:
    """A long court under a point light, in metres: ledges and pilasters of some depth on both walls."""
    x, y, z = HALF_LENGTH, HEIGHT, HALF_WIDTH
    parts = [block((-x, -1, -z), (x, 0, z)), block((x, 0, -z), (x + 1, y, z))]
    for low, high, inner in ((-z - 1, -z, -z + depth), (z, z + 1, z - depth)):
        back, front = sorted((low if low > 0 else high, inner))
        parts.append(block((-x, 0, low), (x, y, high)))
        tops = np.linspace(0, y, ledges + 2)[1:-1].tolist()
        parts += [block((-x, top - 0.1, back), (x, top, front)) for top in tops]
        places = np.linspace(-x, x, pilasters + 2)[1:-1].tolist()
        parts += [block((place - 0.2, 0, back), (place + 0.2, y, front)) for place in places]
    view = {"look_at": {"origin": [-13, 8, 0], "target": [0, 5, 0], "up": [0, 1, 0]}}
    film = {"type": "hdrfilm", "width": 64, "height": 36, "rfilter": {"type": "box"}}
    return et.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "path", "max_depth": 2},
            "sensor": {"type": "perspective", "fov": 96.0, "fov_axis": "x", "to_world": [view], "film": film},
            "lamp": {"type": "point", "position": [0, 17, 0], "intensity": 500.0},
            **{f"part{number}": part for number, part in enumerate(parts)},
        }
    )


@cache
def courts() -> dict[str, et.Scene]:
    return {"narrow ledges": court(11, 9, 0.2), "one wide ledge": court(1, 1, 0.5)}


@cache
def ours(name: str, scale: float, seeds: int) -> Array:
    """Return the mean of each of our images of a court whose lengths are multiplied by `scale`."""
    scene = in_units(courts()[name], scale)
    return np.array([et.render(scene, spp=32, seed=seed).image.mean(dtype=np.float64) for seed in range(seeds)])


@cache
def theirs(name: str, scale: float, seeds: int) -> Array:
    """Return the mean of each of Mitsuba's images of the same court."""
    scene = in_units(courts()[name], scale)
    plain = mitsuba_dict(scene.model, scene.assets)
    plain["sensor"]["sampler"] = {"type": "multijitter"}
    plain["integrator"] = {"type": "path", "max_depth": 2}
    loaded = mi.load_dict(with_transforms(plain, mi.ScalarTransform4f))
    images = (np.array(mi.render(loaded, seed=seed, spp=16)) for seed in range(seeds))
    return np.array([image.mean(dtype=np.float64) for image in images])


def p_unmoved(before: Array, after: Array) -> float:
    """Return the p-value of equal expectations of means with the same seeds, up to rounding to float32."""
    difference = after - before
    excess = max(abs(difference.mean()) - ROUNDING * before.mean(), 0.0)
    error = difference.std(ddof=1) / np.sqrt(difference.size)
    return 2.0 * float(stats.t.sf(excess / error, difference.size - 1)) if excess > 0.0 else 1.0


def p_equal(first: Array, second: Array) -> float:
    """Return the p-value of equal expectations of independent means, up to what the offset does at one wide ledge."""
    low, high = (1 - ONE_LEDGE) * second, (1 + ONE_LEDGE) * second
    nearest = low if first.mean() < low.mean() else high if first.mean() > high.mean() else first
    return float(stats.ttest_ind(first, nearest, equal_var=False).pvalue)


@pytest.mark.parametrize("size", [0.0, 0.125, 13.0, 1300.0])
def test_mitsuba_starts_rays_off_their_surface_by_a_share_of_one_plus_the_largest_coordinate(size: float) -> None:
    """If this fails, Mitsuba has another offset, and what a reference by it is worth must be measured again."""
    it = mi.SurfaceInteraction3f()
    it.p, it.n = mi.Point3f(size, 0, 0), mi.Normal3f(0, 1, 0)
    moved = np.array(it.spawn_ray(mi.Vector3f(0.6, 0.8, 0)).o, dtype=np.float64) - (size, 0, 0)
    np.testing.assert_allclose(moved, (0, OFFSET * (1 + size), 0), rtol=1e-6)


def test_a_hundredth_of_the_size_changes_nothing_here() -> None:
    assert p_unmoved(ours("narrow ledges", 1.0, SEEDS)[:PAIRS], ours("narrow ledges", 0.01, PAIRS)) > EACH


def test_a_hundredth_of_the_size_makes_mitsuba_brighter_by_more_than_a_percent() -> None:
    """The power twin of the test before."""
    before, after = theirs("narrow ledges", 1.0, SEEDS)[:PAIRS], theirs("narrow ledges", 0.01, PAIRS)
    assert p_unmoved(before, after) < EACH
    assert p_unmoved(1.01 * before, after) < EACH
    assert after.mean() > 1.01 * before.mean()


@pytest.mark.parametrize("exponent", [-20, -7, 20])
def test_a_power_of_two_changes_no_bit_here(exponent: int) -> None:
    scene = courts()["narrow ledges"]
    images = [et.render(in_units(scene, 2.0**power), spp=2, seed=1).image for power in (0, exponent)]
    np.testing.assert_array_equal(*images)


def test_where_edges_are_few_and_far_apart_both_have_the_same_mean() -> None:
    """The standard error of the comparison is 0.01 %."""
    assert p_equal(theirs("one wide ledge", 1.0, SEEDS), ours("one wide ledge", 1.0, SEEDS)) > EACH


def test_where_ledges_are_narrow_mitsuba_is_brighter_in_metres_too() -> None:
    """The power twin of the test before."""
    theirs_in_metres, ours_in_metres = theirs("narrow ledges", 1.0, SEEDS), ours("narrow ledges", 1.0, SEEDS)
    assert p_equal(theirs_in_metres, ours_in_metres) < EACH
    assert theirs_in_metres.mean() > ours_in_metres.mean()


def test_mitsuba_s_density_of_a_small_sphere_is_too_low_in_the_mean() -> None:
    """The mean error is 0.05 % for a radius of 0.1 at distances near 14."""
    sphere = mi.load_dict({"type": "sphere", "radius": 0.1, "emitter": {"type": "area"}})
    it, light, products = mi.SurfaceInteraction3f(), sphere.emitter(), []
    for distance in np.random.default_rng(0).uniform(13.5, 14.5, 2000).astype(np.float32).astype(np.float64):
        it.p = mi.Point3f(distance, 0, 0)
        sine2 = (0.1 / distance) ** 2
        solid_angle = 2 * np.pi * sine2 / (1 + np.sqrt(1 - sine2))
        products.append(light.sample_direction(it, mi.Point2f(0.5, 0.5))[0].pdf * solid_angle)
    off = np.array(products) - 1.0
    assert stats.ttest_1samp(off, 0.0).pvalue < EACH
    assert -1e-3 < off.mean() < -1e-4
