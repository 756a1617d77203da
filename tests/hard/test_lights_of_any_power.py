"""Lights of any power: some that are off (S21), and dim ones beside some that are a billion times as bright (S22).

Which light was drawn is told by its direction: the dim ones are above the receiver, the bright one is below it. Seeds
are fixed; each test of chance rejects what is right once in a thousand choices of seeds. Its twin is the usual table:
sums in single precision, searched by a number of 24 bits.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import stats

import equaltime as et
from equaltime import _core
from equaltime._core import parts

from ..statistical.worlds import build
from .ground import ground

Array = NDArray[np.float64]
LEVEL = 1e-3
BRIGHT = np.array([0.0, 0.0, -1.0])
MANY = 100_000


def lit(powers: Array) -> _core.Scene:
    """Return point lights all round the origin, the first of them below it."""
    rng = np.random.default_rng(1)
    towards = rng.normal(size=(len(powers), 3))
    towards[:, 2] = np.abs(towards[:, 2]) + 0.1
    towards /= np.linalg.norm(towards, axis=1, keepdims=True)
    towards[0] = BRIGHT

    def add(b: _core.SceneBuilder) -> None:
        for place, power in zip(towards.tolist(), powers.tolist(), strict=True):
            b.add_point_light(place, [power] * 3)

    scene: _core.Scene = build(add)
    return scene


def drawn(scene: _core.Scene, lights: str, count: int, seed: int) -> tuple[Array, Array, Array]:
    """Return direction, radiance and probability of the dim lights that so many draws of any find."""
    found = []
    for part in range(-(-count // 1_000_000)):
        draws = parts.sample_lights(scene, lights, np.zeros((min(count, 1_000_000), 3)), seed + part)
        assert draws["valid"].all()
        dim = draws["wi"][:, 2] > 0
        found.append((draws["wi"][dim], draws["radiance"][dim, 0], draws["pdf"][dim]))
    wi, radiance, pdf = (np.concatenate(column) for column in zip(*found, strict=True))
    return wi, radiance, pdf


def usual_table(powers: Array, count: int) -> NDArray[np.int64]:
    """Return the lights that so many draws find by sums in single precision: the twin."""
    sums = np.cumsum(powers.astype(np.float32), dtype=np.float32)
    u = np.random.default_rng(2).integers(0, 2**24, count).astype(np.float32) * np.float32(2.0**-24)
    found: NDArray[np.int64] = np.searchsorted(sums, u * sums[-1], side="right")
    return found


def as_often_as(seen: int, count: int, share: float) -> bool:
    return bool(stats.binomtest(seen, count, share).pvalue > LEVEL)


def test_S22_a_hundred_thousand_dim_lights_beside_one_that_is_a_billion_times_as_bright() -> None:  # noqa: N802
    """The catalogue's numbers. By power, each draw of a dim light counts for the whole sum of all powers."""
    powers = np.ones(MANY + 1)
    powers[0] = 1e9
    count = 5_000_000
    wi, radiance, pdf = drawn(lit(powers), "power", count, 1)
    np.testing.assert_allclose(radiance, 1.0, rtol=1e-6)
    np.testing.assert_allclose(pdf, 1 / powers.sum(), rtol=1e-6)
    assert as_often_as(len(wi), count, MANY / powers.sum())
    assert len(np.unique(wi, axis=0)) > 0.98 * len(wi), "hardly any is drawn twice"
    dim = usual_table(powers, count)
    assert not as_often_as(int((dim > 0).sum()), count, MANY / powers.sum()), "the twin"


def spread(found: Array, dim: Array, count: int, share: float) -> float:
    """Return the p-value of how often dim lights of each decade of power are drawn, rare decades taken together."""
    expected = count * share * np.bincount(np.log10(dim).astype(int), dim) / dim.sum()
    seen = np.bincount(np.log10(found).astype(int), minlength=len(expected)).astype(float)
    rare = np.cumsum(expected) < 10
    seen, expected = (np.append(values[~rare], values[rare].sum()) for values in (seen, expected))
    expected, seen = np.append(expected, count * (1 - share)), np.append(seen, count - len(found))
    return float(stats.chi2.sf(((seen - expected) ** 2 / expected).sum(), len(seen) - 1))


def test_S22_dim_lights_of_seven_decades_beside_one_of_the_twelfth() -> None:  # noqa: N802
    """A light's power is the radiance that is found with it; of the dim ones, those of the first decade are 1e-11."""
    dim = 10.0 ** np.random.default_rng(3).uniform(0, 7, MANY)
    powers = np.append(1e12, dim)
    share, count = dim.sum() / powers.sum(), 4_000_000
    _, radiance, pdf = drawn(lit(powers), "power", count, 11)
    np.testing.assert_allclose(pdf, radiance / powers.sum(), rtol=1e-6)
    assert (radiance < 1e3).any()
    assert spread(radiance, dim, count, share) > LEVEL
    usual = powers[usual_table(powers, count)]
    assert spread(usual[usual < 1e12], dim, count, share) < LEVEL, "the twin"


@pytest.mark.parametrize("lights", ["uniform", "tree"])
def test_S22_the_light_of_the_dim_ones_adds_up_however_they_are_picked(lights: str) -> None:  # noqa: N802
    """A z-test of what all of them together send, the bright one's part left out."""
    powers = np.append(1e12, 10.0 ** np.random.default_rng(3).uniform(0, 7, MANY))
    scene, count = lit(powers), 1_000_000

    def p(exact: float) -> float:
        values = radiance / pdf
        mean = values.sum() / count
        error = np.sqrt((values**2).sum() / count - mean**2) / np.sqrt(count)
        return float(2 * stats.norm.sf(abs(mean - exact) / error))

    _, radiance, pdf = drawn(scene, lights, count, 21)
    assert len(radiance) > 1000
    assert p(powers[1:].sum()) > LEVEL
    assert p(1.05 * powers[1:].sum()) < LEVEL, "the twin"


def over_ground(lamps: int, radiance: float) -> et.Scene:
    """Return ground under a ball that shines, and as many lamps of four kinds beside it."""
    ball = {"type": "sphere", "center": [1, 1, 2], "radius": 0.5, "emitter": {"type": "area", "radiance": 5}}
    scene = ground(8, 8, 4, ball=ball)
    for i in range(lamps):
        at = [i % 100, i // 100, 5]
        kinds: list[dict[str, Any]] = [
            {"type": "point", "position": at, "intensity": radiance},
            {"type": "spot", "to_world": [{"translate": at}], "intensity": radiance},
            {"type": "directional", "direction": [0, 0.1, -1], "irradiance": radiance},
        ]
        scene[f"lamp{i}"] = kinds[i % 3]
    return et.load_dict(scene)


@pytest.mark.parametrize("lights", ["uniform", "power", "tree"])
def test_S21_ten_thousand_lamps_that_are_off_leave_nothing_behind(lights: str) -> None:  # noqa: N802
    """The same bits, by the same kernel, rays and memory, so that the time is the same without a clock."""

    def work(scene: et.Scene) -> tuple[Any, ...]:
        result = et.render(scene, spp=8, strategy=f"best,lights={lights}")
        counted = result.stats.rays, result.stats.shadow_rays, result.stats.kernel, result.stats.effects
        return result.image.tobytes(), counted, scene.core.lights, scene.core.memory_bytes

    alone = work(over_ground(0, 0.0))
    assert work(over_ground(10_000, 0.0)) == alone
    image, _, count, memory = work(over_ground(3, 0.01))
    assert image != alone[0], "the twin"
    assert (count, memory) > alone[2:], "the twin"
