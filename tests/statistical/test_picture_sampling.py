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
from equaltime._core import parts

from .charts import RectangleChart
from .chi2 import LEVEL, SAMPLES, Histogram, Masses, share
from .worlds import Estimate, affine, build, estimate, looking, turned

Array = NDArray[np.float64]
TURN = turned([1, 2, 3], 50)
X, Y = 2 * TURN[:, 0], TURN[:, 1]
"""The edges of the rectangle, whose corner is the origin."""
PLACE = affine(X / 2, Y / 2, TURN[:, 2], (X + Y) / 2)
UNEVEN = np.random.default_rng(4).uniform(0.0, 1.0, (3, 5, 3)) ** 4 * 8
SPOT = np.zeros((8, 8, 3))
SPOT[2, 5] = (3.0, 2.0, 1.0)
LARGE = np.random.default_rng(5).uniform(0.0, 1.0, (700, 1100, 1)) ** 2
TURNED = np.array([[0.8, 0.6, 0.1], [-0.6, 0.8, 0.2]])
SCALED = np.array([[3.0, 0, 0.3], [0, -2.0, 0.1]])


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


FAR, NEAR = (-2.0, 3.0, 4.0), (0.7, 0.4, 0.3)
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


class Trial:
    def __init__(self, subject: Subject, samples: int = SAMPLES) -> None:
        self.receiver = TURN @ subject.receiver
        self.scene = build(subject.add, eye=self.receiver)
        self.chart = RectangleChart(np.zeros(3), X, Y, self.receiver)
        self.drawn = parts.sample_lights(self.scene, "power", self._from(samples), 1)

    def _from(self, samples: int) -> Array:
        return np.broadcast_to(self.receiver, (samples, 3))

    def met(self, wi: Array) -> dict[str, Array]:
        found: dict[str, Array] = parts.eval_lights(self.scene, "power", self._from(len(wi)), wi)
        return found

    @property
    def masses(self) -> Masses:
        return Masses(self.chart, lambda wi: self.met(wi)["pdf"])

    @property
    def histogram(self) -> Histogram:
        return Histogram.of(self.chart, self.drawn["wi"][self.drawn["valid"]], SAMPLES)


@pytest.mark.parametrize("subject", CASES)
def test_points_are_drawn_with_the_stated_density(subject: Subject) -> None:
    trial = Trial(subject)
    histogram, masses = trial.histogram, trial.masses
    assert histogram.p(masses) > EACH, histogram.looks
    assert histogram.p(masses.changed(lambda pdf, wi: 1.02 * pdf)) < EACH, "the twin, scaled"
    place = trial.chart.places(trial.drawn["wi"][trial.drawn["valid"]])[:, 0]

    def lean(wi: Array) -> Array:
        return np.asarray(np.clip((trial.chart.places(wi)[:, 0] - place.mean()) / place.std(), -2, 2))

    tilted = masses.changed(lambda pdf, wi: (1 + 0.02 * lean(wi)) * pdf, keep_total=True)
    assert histogram.p(tilted) < EACH, "the twin, tilted"


@pytest.mark.parametrize("subject", CASES)
def test_whatever_shines_is_drawn_and_a_sample_states_the_density_that_a_ray_finds(subject: Subject) -> None:
    trial = Trial(subject, 20000)
    rng = np.random.default_rng(2)
    directions, _ = trial.chart.directions(rng.random((20000, 2)))
    met = trial.met(directions)
    assert (met["pdf"][met["radiance"].any(axis=1)] > 0).all()
    some = trial.drawn["valid"].nonzero()[0]
    again = trial.met(trial.drawn["wi"][some])
    off = np.abs(again["pdf"] / trial.drawn["pdf"][some] - 1)
    assert np.quantile(off, 0.99) < 1e-3, "but at the borders of cells, which rounding may cross"


def lit(texels: Array, technique: str, height: float = 0.4, spp: int = 4096) -> Estimate:
    """What a floor sends back under the lamp."""

    def lamp(b: _core.SceneBuilder) -> None:
        place = affine((1, 0, 0), (0, -1, 0), (0, 0, -1), (0.2, 0.1, height))
        shape = b.add_rectangle(place, flip_normals=False, front=None, back=None, radiance=(1.0, 1.0, 1.0))
        b.bind_radiance(shape, b.add_bitmap(texels.astype(np.float32), srgb=False))

    def floor(b: _core.SceneBuilder) -> None:
        large = np.diag([9.0, 9.0, 1.0, 1.0])
        b.add_rectangle(large, flip_normals=False, front=b.add_diffuse([0.5] * 3), back=None, radiance=None)

    scene = build(lamp, floor, camera=looking((0.1, -0.5, 0.3), (0.1, -0.2, 0.0), up=(0, 1, 0)), fov=0.01)
    return estimate(scene, spp, technique=technique, max_depth=2)


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
