"""BSDFs of several lobes: each sampler against the density that it states, from normal to grazing incidence.

Sharp lobes are looked at by themselves, in a chart of half-vectors; what is left is looked at on the sphere. Samples of
discrete directions count as drawn and nowhere found: the density of the others integrates to what they leave. Seeds are
fixed. All χ² tests of this file together have a false-alarm rate of 0.1 %, shared equally (Šidák).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
import pytest
from numpy.typing import NDArray

from .charts import HalfVectorChart, SphereChart
from .chi2 import LEVEL, Chart, Histogram, Masses, share
from .leaves import LEAVES, Trial
from .lobes import Part, RefractionChart, stretched_slope
from .worlds import direction

Array = NDArray[np.float64]
BOTH: Final = ("mirrored", "refracted")
SHARP = {"ggx": 20.0, "beckmann": 3.0}
"""Where a sharp lobe is taken to end, in units of roughness."""


@dataclass(frozen=True)
class Subject:
    """A BSDF seen from one direction (degrees from the normal), on one of its sides; all of it or one part."""

    name: str
    theta: float
    front: bool = True
    part: Literal["all", "mirrored", "refracted", "rest"] = "all"

    def __str__(self) -> str:
        return f"{self.name}@{self.theta:g}{'' if self.front else ' from behind'} {self.part}"

    @property
    def wo(self) -> Array:
        return direction(self.theta, 35.0)

    def trial(self, samples: int = 1 << 18) -> Trial:
        return Trial(self.name, self.wo, self.front, samples)

    @property
    def chart(self) -> Chart:
        leaf, sphere = LEAVES[self.name], SphereChart(half=not LEAVES[self.name].transmits)
        if self.part == "all":
            return sphere
        eta = leaf.ior if self.front else 1.0 / leaf.ior

        def sharp(wi: Array) -> NDArray[np.bool_]:
            return stretched_slope(self.wo, wi, *leaf.alphas, eta) < SHARP[leaf.distribution]

        if self.part == "rest":
            return Part(sphere, lambda wi: ~sharp(wi))
        if self.part == "mirrored":
            return Part(
                HalfVectorChart(self.wo, leaf.distribution, *leaf.alphas), lambda wi: sharp(wi) & (wi[:, 2] > 0)
            )
        return Part(
            RefractionChart(self.wo, leaf.distribution, *leaf.alphas, eta), lambda wi: sharp(wi) & (wi[:, 2] < 0)
        )


SUBJECTS = [
    *(Subject("plastic", theta) for theta in (0.0, 60.0, 89.9)),
    *(Subject("deep plastic", theta) for theta in (45.0, 89.0)),
    Subject("bubble plastic", 40.0),
    *(Subject("glossy plastic", theta) for theta in (0.0, 75.0)),
    *(Subject("sharp plastic", theta, part=part) for theta in (0.0, 60.0, 85.0) for part in ("mirrored", "rest")),
    *(Subject("dull plastic", theta) for theta in (30.0, 89.0)),
    *(Subject("glazed plastic", theta, part=part) for theta in (40.0, 80.0) for part in ("mirrored", "rest")),
    Subject("dry plastic", 60.0),
    *(Subject("lacquered wood", theta) for theta in (30.0, 85.0)),
    *(Subject(name, theta) for name in ("plaster", "gravel", "plaster in short") for theta in (0.0, 80.0)),
    *(Subject("frosted glass", theta, front) for theta in (0.0, 70.0) for front in (True, False)),
    *(Subject("sharp glass", t, f, p) for t, f in ((0.0, True), (60.0, True), (30.0, False)) for p in BOTH),
    Subject("sharp glass", 60.0, False, "mirrored"),
    Subject("ground glass", 40.0),
    *(Subject("brushed glass", theta, front) for theta, front in ((75.0, True), (50.0, False))),
    *(Subject("sandy glass", theta, front) for theta, front in ((89.0, True), (89.0, False))),
    Subject("faint glass", 30.0, True, "refracted"),
    *(Subject(name, theta) for name in ("clay", "gold leaf", "lacquer", "amber") for theta in (30.0, 85.0)),
    *(Subject(name, 50.0, False) for name in ("amber", "everything")),
    *(Subject("polished", 60.0, part=part) for part in ("mirrored", "rest")),
    Subject("everything", 60.0),
]
TWINS = [
    *(Subject("frosted glass", 70.0, front) for front in (True, False)),
    Subject("everything", 60.0),
    Subject("sharp glass", 60.0, part="refracted"),
    Subject("plastic", 60.0),
    Subject("deep plastic", 45.0),
    Subject("dull plastic", 30.0),
    Subject("plaster", 80.0),
]
EACH = share(LEVEL, len(SUBJECTS))


def histogram(subject: Subject, trial: Trial) -> Histogram:
    chart = subject.chart
    wi = trial.wi[chart.inside(trial.wi)] if isinstance(chart, Part) else trial.wi
    return Histogram.of(chart, wi, len(trial.continuous))


def masses(subject: Subject, trial: Trial) -> Masses:
    return Masses(subject.chart, lambda wi: trial.eval(wi)["pdf"])


@pytest.mark.parametrize("subject", SUBJECTS, ids=str)
def test_directions_are_drawn_with_the_stated_density(subject: Subject) -> None:
    trial = subject.trial()
    seen = histogram(subject, trial)
    assert seen.p(masses(subject, trial)) > EACH, seen.looks


@pytest.mark.parametrize("subject", TWINS, ids=str)
def test_a_slightly_wrong_density_is_rejected(subject: Subject) -> None:
    """Scaled, tilted, and with a fifth too much in a ring next to the horizon."""
    trial, chart = subject.trial(1 << 20), subject.chart
    seen, right = histogram(subject, trial), masses(subject, trial)
    horizon = np.quantile(np.abs(trial.wi[:, 2]), 0.02)
    assert seen.p(right.changed(lambda pdf, wi: 1.02 * pdf)) < EACH
    assert seen.p(right.changed(lambda pdf, wi: (0.98 + 0.04 * chart.places(wi)[:, 0]) * pdf, keep_total=True)) < EACH
    if subject.part != "all":
        return
    ring = right.changed(lambda pdf, wi: np.where(np.abs(wi[:, 2]) < horizon, 1.2, 1.0) * pdf, keep_total=True)
    assert seen.p(ring) < EACH


# ---- what one call says of a direction, another must say too -------------------------------------------------------

ROUNDOFF = 2.0**-24


def disagreement(trial: Trial, scale: float = 1.0) -> float:
    """Return how far `eval` and `sample`, its values scaled, differ at most, in units of what float32 may do."""
    leaf = LEAVES[trial.name]
    # Close to total reflection Fresnel's factor is as steep as a square root.
    tolerance = np.full(len(trial.wi), (4096 if leaf.transmits else 256) * ROUNDOFF)
    if leaf.distribution:
        # A rounding of a direction moves the half-vector's slope, and D by up to 4 per unit of slope over roughness;
        # Beckmann's by twice the slope.
        eta = leaf.ior if trial.front else 1.0 / leaf.ior
        m = np.linalg.norm(trial.wo + trial.wi * np.where(trial.wi[:, 2] > 0, 1.0, eta)[:, None], axis=1)
        slope = stretched_slope(trial.wo, trial.wi, *leaf.alphas, eta)
        steep = 4.0 + (2.0 * np.minimum(slope, 6.0) if leaf.distribution == "beckmann" else 0.0)
        tolerance += 8 * ROUNDOFF * (steep / min(leaf.alphas) / m + 1.0 / np.abs(trial.wi[:, 2]))
    value, pdf = trial.eval(trial.wi), trial.drawn["pdf"][trial.continuous]
    f = scale * trial.drawn["weight"][trial.continuous] * pdf[:, None]
    seen = f.max(axis=1) > 0  # none where the interface reflects all
    apart = np.abs(value["f"] - f)[seen].max(axis=1) / f[seen].max(axis=1) / tolerance[seen]
    return max(float((np.abs(value["pdf"] / pdf - 1) / tolerance).max()), float(apart.max()))


@pytest.mark.parametrize("subject", [s for s in SUBJECTS if s.part in ("all", "rest")], ids=str)
def test_weight_times_density_is_the_value_and_both_calls_state_one_density(subject: Subject) -> None:
    trial = Trial(subject.name, direction(subject.theta, 20.0), subject.front, samples=20_000, seed=2)
    assert disagreement(trial) < 1.0
    if subject.part == "all":
        assert disagreement(trial, scale=1.001) > 1.0, "the twin"
