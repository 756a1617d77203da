"""Environments: what they shine, by a float64 reference beside the test, and how they are sampled.

Seeds are fixed. All χ² tests of this file together have a false-alarm rate of 0.1 %, shared equally (Šidák).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import stats

from equaltime import _core
from equaltime._core import parts

from .charts import LatLongChart
from .chi2 import LEVEL, SAMPLES, Histogram, Masses, share
from .worlds import affine, build, turned

Array = NDArray[np.float64]
PLACE = np.zeros(3)
TWIN = 1.1
"""A density wrong by so much must be seen."""


def plain(rows: int, columns: int, seed: int = 1) -> Array:
    return np.random.default_rng(seed).uniform(0.1, 1.0, (rows, columns, 3)).astype(np.float32).astype(float)


def with_bright_texel(rows: int, columns: int, value: float) -> Array:
    pixels = plain(rows, columns)
    pixels[rows // 3, columns // 2] = [value, 0.5 * value, 0.25 * value]
    return pixels


def with_black_rows(rows: int, columns: int) -> Array:
    pixels = plain(rows, columns)
    pixels[: rows // 2] = 0.0
    pixels[-1] = 0.0
    pixels[:, columns // 4 : columns // 2] = 0.0
    return pixels


@dataclass(frozen=True, eq=False)
class Subject:
    name: str
    pixels: Array
    rotation: Array
    scale: float = 1.0

    def __str__(self) -> str:
        return self.name

    @property
    def scene(self) -> _core.Scene:
        matrix = affine(*self.rotation.T)
        return build(lambda b: b.add_image_environment(self.pixels.astype(np.float32), self.scale, matrix))

    @property
    def chart(self) -> LatLongChart:
        return LatLongChart(self.rotation)

    def radiance(self, directions: Array) -> Array:
        """Return the bilinear interpolation of the texels: row i at π·i/(H-1), column j's centre at (j + 1/2)/W."""
        rows, columns = self.pixels.shape[:2]
        down, right = self.chart.places(directions).T
        row, column = down * max(rows - 1, 1), right * columns - 0.5
        i, j = np.clip(np.floor(row).astype(int), 0, max(rows - 2, 0)), np.floor(column).astype(int)
        a, b = (row - i)[:, None], (column - j)[:, None]
        below = np.minimum(i + 1, rows - 1)
        top = self.pixels[i, j % columns] * (1 - b) + self.pixels[i, (j + 1) % columns] * b
        bottom = self.pixels[below, j % columns] * (1 - b) + self.pixels[below, (j + 1) % columns] * b
        return self.scale * np.asarray(top * (1 - a) + bottom * a)


UPRIGHT, TILTED = np.eye(3), turned([1, 2, -1], 130)
SUBJECTS = [
    Subject("one texel", plain(1, 1), UPRIGHT),
    Subject("two rows", plain(2, 1), TILTED),
    Subject("one row", plain(1, 4), UPRIGHT),
    Subject("few texels", plain(4, 6), UPRIGHT),
    Subject("few texels, tilted, dim", plain(4, 8), TILTED, 1e-6),
    Subject("bright texel", with_bright_texel(9, 24, 1e4), TILTED),
    Subject("blinding texel", with_bright_texel(25, 24, 1e12), UPRIGHT),
    Subject("black rows and columns", with_black_rows(13, 24), TILTED),
    Subject("many texels", plain(129, 256), UPRIGHT, 30.0),
]
EACH = share(LEVEL, 2 * len(SUBJECTS) + 2)


class Trial:
    def __init__(
        self, subject: Subject, scene: _core.Scene | None = None, samples: int = SAMPLES, sampling: str = "plain"
    ) -> None:
        self.chart, self.samples, self.scene = subject.chart, samples, scene or subject.scene
        self.sampling = sampling
        places = np.broadcast_to(PLACE, (samples, 3))
        self.drawn = parts.sample_lights(self.scene, "power", places, 1, environment=sampling)

    def eval(self, wi: Array) -> dict[str, Array]:
        places = np.broadcast_to(PLACE, wi.shape)
        value: dict[str, Array] = parts.eval_lights(self.scene, "power", places, wi, environment=self.sampling)
        return value

    @property
    def masses(self) -> Masses:
        return Masses(self.chart, lambda wi: self.eval(wi)["pdf"])

    @property
    def histogram(self) -> Histogram:
        return Histogram.of(self.chart, self.drawn["wi"][self.drawn["valid"]], self.samples)


@pytest.mark.parametrize(
    ("subject", "sampling"),
    [(s, "plain") for s in SUBJECTS] + [(s, "compensated") for s in SUBJECTS if s.name != "many texels"],
    ids=str,
)
def test_directions_are_drawn_with_the_stated_density(subject: Subject, sampling: str) -> None:
    trial = Trial(subject, sampling=sampling)
    assert trial.drawn["valid"].all()
    histogram = trial.histogram
    assert histogram.p(trial.masses) > EACH, histogram.looks


def test_the_constant_environment_is_drawn_with_the_stated_density() -> None:
    scene = build(lambda b: b.add_constant_environment([0.1, 0.2, 0.3]))
    trial = Trial(Subject("constant", plain(1, 1), TILTED), scene)
    histogram = trial.histogram
    assert histogram.p(trial.masses) > EACH, histogram.looks
    assert np.abs(trial.drawn["pdf"] * 4 * np.pi - 1).max() < 1e-6


@pytest.mark.parametrize("name", ["few texels", "bright texel", "black rows and columns"])
def test_a_slightly_wrong_density_is_rejected(name: str) -> None:
    trial = Trial(next(s for s in SUBJECTS if s.name == name))
    histogram, masses, chart = trial.histogram, trial.masses, trial.chart
    assert histogram.p(masses) > EACH
    wrong = {
        "scaled": masses.changed(lambda pdf, wi: 1.02 * pdf),
        "half a texel off": Masses(chart, lambda wi: trial.eval(wi @ turned(chart.axes[:, 1], 180 / 24).T)["pdf"]),
    }
    if name != "bright texel":  # which holds nearly all samples in one place
        wrong["tilted"] = masses.changed(lambda pdf, wi: (0.98 + 0.04 * chart.places(wi)[:, 1]) * pdf, keep_total=True)
    for kind, subject in wrong.items():
        assert histogram.p(subject) < EACH, (kind, histogram.looks)


@pytest.mark.parametrize("subject", SUBJECTS, ids=str)
def test_radiance_is_the_bilinear_interpolation_of_the_texels(subject: Subject) -> None:
    rng = np.random.default_rng(2)
    wi = rng.standard_normal((50_000, 3))
    wi = (wi / np.linalg.norm(wi, axis=1, keepdims=True)).astype(np.float32).astype(float)
    got, expected = Trial(subject, samples=1).eval(wi)["radiance"], subject.radiance(wi)
    # A direction is rounded to 2^-24; between texels W apart, that moves radiance by the texels' contrast.
    steepness = max(subject.pixels.shape[:2]) / np.maximum(np.hypot(*(wi @ subject.rotation)[:, [0, 2]].T), 1e-3)
    tolerance = 2.0**-22 * (expected + steepness[:, None] * subject.scale * subject.pixels.max())
    assert (np.abs(got - expected) <= tolerance).all()
    assert (np.abs(1.001 * got - expected) > tolerance).any() or subject.pixels.max() > 1e3, "the twin"


@pytest.mark.parametrize("subject", SUBJECTS, ids=str)
def test_samples_carry_the_radiance_and_density_of_their_direction(subject: Subject) -> None:
    trial = Trial(subject, samples=100_000)
    met = trial.eval(trial.drawn["wi"])
    ratio = trial.drawn["pdf"] / met["pdf"]
    assert (np.abs(ratio - 1.0) > 1e-6).mean() < 1e-4, "a rounded direction may fall into the next cell"
    estimates = trial.drawn["radiance"] / trial.drawn["pdf"][:, None]
    expected = met["radiance"] / met["pdf"][:, None]
    share_off = (np.abs(estimates - expected) > 1e-3 * np.abs(expected)).any(axis=1).mean()
    assert share_off < 1e-3


@pytest.mark.parametrize("sampling", ["plain", "compensated"])
def test_each_of_many_cells_is_drawn_as_often_as_its_density_says(sampling: str) -> None:
    """Cells of the image itself: the steps of a compensated density are too many for quadrature over others."""
    subject = next(s for s in SUBJECTS if s.name == "many texels")
    trial, rows, columns = Trial(subject, samples=1_000_000, sampling=sampling), 128, 256
    down, right = trial.chart.places(trial.drawn["wi"]).T
    cell = np.clip((down * rows).astype(int), 0, rows - 1), np.floor(right * columns - 0.5).astype(int) % columns
    counts = np.zeros((rows, columns))
    np.add.at(counts, cell, 1)
    i, j = np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij")
    middles = np.stack([(i + 0.5) / rows, (j + 1.0) / columns % 1.0], axis=-1).reshape(-1, 2)
    density = trial.eval(trial.chart.directions(middles)[0])["pdf"].reshape(rows, columns)
    bands = -np.diff(np.cos(np.pi * np.arange(rows + 1) / rows)) * 2 * np.pi / columns
    expected = trial.samples * density * bands[:, None]
    assert counts[density == 0].sum() == 0
    assert expected.sum() == pytest.approx(trial.samples, rel=1e-6)
    often = expected > 5
    p = [
        stats.chi2.sf(((counts - e)[often] ** 2 / e[often]).sum(), often.sum() - 1) for e in (expected, TWIN * expected)
    ]
    assert p[0] > EACH
    assert p[1] < EACH, "the twin"


def test_a_compensated_density_is_what_exceeds_the_mean_and_nothing_elsewhere() -> None:
    """Cell by cell, by the mean of its corners, as the plain density has it too."""
    subject = next(s for s in SUBJECTS if s.name == "few texels, tilted, dim")
    wi = subject.chart.directions(np.random.default_rng(3).random((20_000, 2)))[0]
    plain, compensated = (Trial(subject, samples=1, sampling=s).eval(wi)["pdf"] for s in ("plain", "compensated"))
    even = 1 / (4 * np.pi)
    assert (compensated[plain < 0.999 * even] == 0).all()
    above = plain > 1.001 * even
    ratio = compensated[above] / (plain[above] - even)
    assert 0.2 < above.mean() < 0.8
    assert ratio.std() < 1e-3 * ratio.mean()
    assert ratio.mean() > 1.5, "the twin: no more than before"


def test_an_even_sky_is_compensated_by_nothing() -> None:
    even = Trial(Subject("even", np.ones((4, 8, 3)), TILTED), samples=1000, sampling="compensated")
    assert even.drawn["pdf"] == pytest.approx(1 / (4 * np.pi), rel=1e-6)


def test_all_radiance_lies_where_the_density_is_positive() -> None:
    """Interpolation spreads a texel over the four cells around it: each must be reachable."""
    pixels = np.zeros((7, 8, 3))
    pixels[2, 3] = 1.0
    trial = Trial(Subject("lonely texel", pixels, TILTED), samples=1)
    square = np.random.default_rng(3).random((100_000, 2))
    value = trial.eval(trial.chart.directions(square)[0])
    lit = value["radiance"].max(axis=1) > 0
    assert 0.01 < lit.mean() < 0.2
    assert (value["pdf"][lit] > 0).all()
