"""Every BSDF's sampler against the density that it states, from normal to grazing incidence.

Seeds are fixed. All χ² tests of this file together have a false-alarm rate of 0.1 %, shared equally (Šidák).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

from equaltime import _core
from equaltime._core import parts

from .charts import HalfVectorChart, SphereChart
from .chi2 import LEVEL, SAMPLES, Chart, Histogram, Masses, share, uniforms
from .worlds import direction

Array = NDArray[np.float64]
SILVER = ([0.16, 0.14, 0.13], [4.0, 3.2, 2.4], [0.9, 0.9, 0.9])


@dataclass(frozen=True)
class Subject:
    """A BSDF seen from one direction (degrees from the normal, degrees round it)."""

    distribution: str
    alpha_u: float
    alpha_v: float
    theta: float
    phi: float = 0.0
    chart: str = "half-vector"

    def __str__(self) -> str:
        alphas = f"{self.alpha_u:g},{self.alpha_v:g}" if self.alpha_u else ""
        return f"{self.distribution}({alphas})@{self.theta:g},{self.phi:g}" + ("-sphere" * (self.chart == "sphere"))

    @property
    def wo(self) -> Array:
        return direction(self.theta, self.phi)


ANGLES = (0.0, 60.0, 80.0, 89.9)
SUBJECTS = [
    *(Subject("diffuse", 0, 0, theta, 20.0, "sphere") for theta in (0.0, 89.9)),
    *(Subject(d, a, a, t, 35.0) for d in ("ggx", "beckmann") for a in (1.0, 0.1) for t in ANGLES),
    *(Subject(d, a, a, t) for d in ("ggx", "beckmann") for a in (0.01, 0.001) for t in (0.0, 70.0, 89.9)),
    *(Subject(d, a, a, 89.999, 35.0) for d in ("ggx", "beckmann") for a in (0.5, 0.1)),
    *(Subject(d, 0.5, 0.05, t, p) for d in ("ggx", "beckmann") for t, p in ((0, 0), (60, 0), (60, 70), (89, 45))),
    *(Subject(d, 0.002, 0.3, 75.0, 20.0) for d in ("ggx", "beckmann")),
    *(Subject(d, 0.3, 0.6, 50.0, 130.0, "sphere") for d in ("ggx", "beckmann")),
]
EACH = share(LEVEL, len(SUBJECTS))
TWINS = [
    Subject("diffuse", 0, 0, 40.0, 20.0, "sphere"),
    Subject("ggx", 0.1, 0.1, 60.0, 35.0),
    Subject("beckmann", 0.001, 0.001, 60.0),
    Subject("ggx", 0.5, 0.05, 80.0, 70.0),
    Subject("beckmann", 1.0, 1.0, 89.0),
]


@cache
def scene_of(distribution: str, alpha_u: float, alpha_v: float) -> _core.Scene:
    builder = _core.SceneBuilder()
    if distribution == "diffuse":
        builder.add_bsdf("diffuse", [0.8, 0.5, 0.2])
    else:
        builder.add_bsdf("roughconductor", distribution, alpha_u, alpha_v, *SILVER)
    builder.set_perspective(np.eye(4), 40.0)
    builder.set_film(1, 1, (0, 0, 1, 1), "box", 0.5)
    return builder.build()


class Trial:
    """A subject's samples and what its `eval` says of them."""

    def __init__(self, subject: Subject, samples: int = SAMPLES, seed: int = 1) -> None:
        self.subject = subject
        self.scene = scene_of(subject.distribution, subject.alpha_u, subject.alpha_v)
        wo = np.broadcast_to(subject.wo, (samples, 3))
        self.drawn = parts.sample_bsdf(self.scene, 0, wo, uniforms(samples, 3, seed))
        self.valid = self.drawn["valid"]
        self.wi = self.drawn["wi"][self.valid]

    def eval(self, wi: Array) -> dict[str, Array]:
        value: dict[str, Array] = parts.eval_bsdf(self.scene, 0, np.broadcast_to(self.subject.wo, wi.shape), wi)
        return value

    @property
    def chart(self) -> Chart:
        s = self.subject
        if s.chart == "sphere":
            return SphereChart(half=True)
        return HalfVectorChart(s.wo, s.distribution, s.alpha_u, s.alpha_v)

    @property
    def masses(self) -> Masses:
        return Masses(self.chart, lambda wi: self.eval(wi)["pdf"])

    @property
    def histogram(self) -> Histogram:
        return Histogram.of(self.chart, self.wi, len(self.valid))


@pytest.mark.parametrize("subject", SUBJECTS, ids=str)
def test_directions_are_drawn_with_the_stated_density(subject: Subject) -> None:
    trial = Trial(subject)
    histogram = trial.histogram
    assert histogram.p(trial.masses) > EACH, histogram.looks


def scaled(trial: Trial) -> Masses:
    return trial.masses.changed(lambda pdf, wi: 1.02 * pdf)


def tilted(trial: Trial) -> Masses:
    """2 % more at one end of the chart, 2 % less at the other."""
    return trial.masses.changed(lambda pdf, wi: (0.98 + 0.04 * trial.chart.places(wi)[:, 0]) * pdf, keep_total=True)


def ringed(trial: Trial) -> Masses:
    """A fifth too much in the ring next to the horizon in which 2 % of the directions lie."""
    horizon = np.quantile(trial.wi[:, 2], 0.02)
    return trial.masses.changed(lambda pdf, wi: np.where(wi[:, 2] < horizon, 1.2, 1.0) * pdf, keep_total=True)


@pytest.mark.parametrize("subject", TWINS, ids=str)
def test_a_slightly_wrong_density_is_rejected(subject: Subject) -> None:
    trial = Trial(subject)
    histogram = trial.histogram
    assert histogram.p(trial.masses) > EACH
    for wrong in (scaled, tilted, ringed):
        assert histogram.p(wrong(trial)) < EACH, (wrong.__name__, histogram.looks)


# What one call says of a direction, another must say too.

ROUNDOFF = 2.0**-24


def disagreement(trial: Trial, scale: float = 1.0) -> float:
    """Return how far `eval` and `sample`, its values scaled, differ at most, in units of what float32 may do."""
    value, pdf = trial.eval(trial.wi), trial.drawn["pdf"][trial.valid]
    f = scale * trial.drawn["weight"][trial.valid] * pdf[:, None]
    tolerance = 8.0 * ROUNDOFF * (4.0 + _conditioning(trial))
    return max(
        float((np.abs(value["pdf"] - pdf) / (tolerance * pdf)).max()),
        float((np.abs(value["f"] - f) / (tolerance[:, None] * f)).max()),
    )


@pytest.mark.parametrize("subject", SUBJECTS, ids=str)
def test_weight_times_density_is_the_value_and_both_calls_state_one_density(subject: Subject) -> None:
    assert disagreement(Trial(subject, samples=50_000, seed=2)) <= 1.0


@pytest.mark.parametrize("subject", [s for s in SUBJECTS if s.alpha_u in (0, 0.1, 1.0) and s.theta <= 80], ids=str)
def test_values_wrong_by_a_thousandth_are_seen(subject: Subject) -> None:
    assert disagreement(Trial(subject, samples=50_000, seed=2), scale=1.001) > 1.0


def _conditioning(trial: Trial) -> Array:
    """How much a rounding of a direction changes the density, relatively.

    It moves the half-vector's slope, and D changes by up to 4 per unit of slope over roughness (more where Beckmann's
    D is next to nothing); shadowing changes with the cosine.
    """
    s = trial.subject
    if s.distribution == "diffuse":
        return np.zeros(len(trial.wi))
    m = trial.wi + s.wo
    return np.asarray(4.0 / min(s.alpha_u, s.alpha_v) / np.linalg.norm(m, axis=1) + 1.0 / trial.wi[:, 2])


def test_rejected_samples_come_with_a_density_that_integrates_to_less_than_one() -> None:
    """The share of rejected samples is tested above; here, that there are some to test it with."""
    shares = {str(s): float(Trial(s, 1 << 16).valid.mean()) for s in SUBJECTS}
    assert min(shares.values()) < 0.9
    assert all(share == 1.0 for name, share in shares.items() if name.startswith("diffuse"))
