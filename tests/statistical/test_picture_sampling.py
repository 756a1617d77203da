"""Rectangles that shine by a texture: their points are drawn in proportion to it, with the density that is stated.

Seeds are fixed. All χ² tests of this file together have a false-alarm rate of 0.1 %, shared equally (Šidák).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from equaltime import _core

from .charts import RectangleChart
from .chi2 import LEVEL, share
from .pictures import (
    FAR,
    LARGE,
    NEAR,
    SCALED,
    SPOT,
    TURN,
    TURNED,
    UNEVEN,
    Trial,
    check_density,
    check_what_shines,
    floor_under,
)
from .worlds import Estimate, affine

Array = NDArray[np.float64]
X, Y = 2 * TURN[:, 0], TURN[:, 1]
"""The edges of the rectangle, whose corner is the origin."""
PLACE = affine(X / 2, Y / 2, TURN[:, 2], (X + Y) / 2)


@dataclass(frozen=True)
class Subject:
    name: str
    texels: Array
    receiver: tuple[float, float, float]
    """In the rectangle's own axes."""
    parameters: tuple[tuple[str, Any], ...] = ()

    def add(self, b: _core.SceneBuilder) -> None:
        shape = b.add_rectangle(PLACE, flip_normals=False, front=None, back=None, radiance=(1.0, 0.5, 2.0))
        b.bind_radiance(shape, b.add_bitmap(self.texels.astype(np.float32), srgb=False, **dict(self.parameters)))


SUBJECTS = [
    Subject("uneven, far", UNEVEN, FAR),
    Subject("uneven, near", UNEVEN, NEAR),
    Subject("steps, near", UNEVEN, NEAR, (("filter", "nearest"),)),
    Subject("a spot, near", SPOT, NEAR, (("wrap", "clamp"),)),
    Subject("a spot, far", SPOT, FAR, (("wrap", "clamp"),)),
    Subject("repeated", UNEVEN, NEAR, (("to_uv", SCALED),)),
    Subject("mirrored", UNEVEN, FAR, (("to_uv", SCALED), ("wrap", "mirror"))),
    Subject("turned", UNEVEN, NEAR, (("to_uv", TURNED),)),
    Subject("large", LARGE, NEAR),
]
EACH = share(LEVEL, len(SUBJECTS))
EVERYDAY = ("uneven, near", "a spot, far", "turned")
CASES = [pytest.param(s, id=s.name, marks=() if s.name in EVERYDAY else pytest.mark.slow) for s in SUBJECTS]


def trial(subject: Subject, **options: int) -> Trial:
    return Trial(subject.add, RectangleChart(np.zeros(3), X, Y, TURN @ subject.receiver), **options)


@pytest.mark.parametrize("subject", CASES)
def test_points_are_drawn_with_the_stated_density(subject: Subject) -> None:
    check_density(trial(subject), EACH)


@pytest.mark.parametrize("subject", CASES)
def test_whatever_shines_is_drawn_and_a_sample_states_the_density_that_a_ray_finds(subject: Subject) -> None:
    check_what_shines(trial(subject, samples=20000))


def lit(texels: Array, technique: str, height: float = 0.4, spp: int = 4096) -> Estimate:
    """What a floor sends back under the lamp."""

    def lamp(b: _core.SceneBuilder) -> None:
        place = affine((1, 0, 0), (0, -1, 0), (0, 0, -1), (0.2, 0.1, height))
        shape = b.add_rectangle(place, flip_normals=False, front=None, back=None, radiance=(1.0, 1.0, 1.0))
        b.bind_radiance(shape, b.add_bitmap(texels.astype(np.float32), srgb=False))

    return floor_under(lamp, technique, spp)


@pytest.mark.parametrize("height", [0.4, 5.0])
def test_techniques_agree_under_a_lamp_that_is_all_but_dark(height: float) -> None:
    by_light, mis = lit(SPOT, "light", height), lit(SPOT, "mis", height)
    by_bsdf = lit(SPOT, "bsdf", height, 1 << 18)
    for one in (by_light, mis):
        off = np.abs(one.mean - by_bsdf.mean) / np.hypot(one.error, by_bsdf.error)
        assert off.max() < 4.5
    assert (np.abs(1.1 * mis.mean - by_bsdf.mean) > 2.0 * by_bsdf.error).all(), "the twin"


@pytest.mark.parametrize(("height", "least"), [(0.4, 5.0), (5.0, 50.0)])
def test_a_bright_spot_is_worth_its_table(height: float, least: float) -> None:
    """Points drawn from the solid angle, or evenly, hit the spot one time in sixty-four: the bound of their variance.

    For a value of `m` that a share `p` of the lamp makes, it is at least m² (1/p - 1) a sample.
    """
    found = lit(SPOT, "light", height)
    share_lit = (2.0 / 8) ** 2  # bilinear: four cells of sixty-four
    even = found.mean**2 * (1 / share_lit - 1) / 4096
    assert (even / found.error**2 > least).all(), even / found.error**2


def test_an_even_picture_is_no_noisier_than_its_solid_angle() -> None:
    nearly = np.full((8, 8, 3), 1.0)
    nearly[3, 3] = 1.001
    by_picture, by_angle = lit(nearly, "light"), lit(np.full((8, 8, 3), 1.0), "light")
    assert 0 < by_picture.error.max() < 1.05 * by_angle.error.max()


def test_a_black_picture_is_no_light() -> None:
    black = np.zeros((2, 2, 3))
    assert (lit(black, "mis", spp=16).mean == 0).all()
