"""Lamps that shine by a picture: what their tests share, whatever the picture lies on."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from equaltime import _core
from equaltime._core import parts

from .charts import RectangleChart, TriangleChart
from .chi2 import SAMPLES, Histogram, Masses
from .worlds import Estimate, build, estimate, looking, turned

Array = NDArray[np.float64]
Lamp = Callable[[_core.SceneBuilder], None]
TURN = turned([1, 2, 3], 50)
UNEVEN = np.random.default_rng(4).uniform(0.0, 1.0, (3, 5, 3)) ** 4 * 8
SPOT = np.zeros((8, 8, 3))
SPOT[2, 5] = (3.0, 2.0, 1.0)
LARGE = np.random.default_rng(5).uniform(0.0, 1.0, (700, 1100, 1)) ** 2
TURNED = np.array([[0.8, 0.6, 0.1], [-0.6, 0.8, 0.2]])
SCALED = np.array([[3.0, 0, 0.3], [0, -2.0, 0.1]])
FAR, NEAR = (-2.0, 3.0, 4.0), (0.7, 0.4, 0.3)
"""Receivers, in the lamp's own axes."""


class Trial:
    """Light samples of one lamp, taken from where the chart looks at it."""

    def __init__(self, lamp: Lamp, chart: RectangleChart | TriangleChart, samples: int = SAMPLES) -> None:
        self.chart, self.scene = chart, build(lamp, eye=chart.receiver)
        self.drawn = parts.sample_lights(self.scene, "power", self._from(samples), 1)

    def _from(self, samples: int) -> Array:
        return np.broadcast_to(self.chart.receiver, (samples, 3))

    def met(self, wi: Array) -> dict[str, Array]:
        """Return what rays in these directions find."""
        found: dict[str, Array] = parts.eval_lights(self.scene, "power", self._from(len(wi)), wi)
        return found


def check_density(trial: Trial, each: float) -> None:
    """Hold the samples to the stated density by χ², and two densities that are a little wrong to fail it."""
    masses, wi = Masses(trial.chart, lambda wi: trial.met(wi)["pdf"]), trial.drawn["wi"][trial.drawn["valid"]]
    histogram = Histogram.of(trial.chart, wi, SAMPLES)
    assert histogram.p(masses) > each, histogram.looks
    assert histogram.p(masses.changed(lambda pdf, wi: 1.02 * pdf)) < each, "the twin, scaled"
    place = trial.chart.places(wi)[:, 0]

    def lean(wi: Array) -> Array:
        return np.asarray(np.clip((trial.chart.places(wi)[:, 0] - place.mean()) / place.std(), -2, 2))

    tilted = masses.changed(lambda pdf, wi: (1 + 0.02 * lean(wi)) * pdf, keep_total=True)
    assert histogram.p(tilted) < each, "the twin, tilted"


def check_what_shines(trial: Trial) -> None:
    """Whatever shines can be drawn, and a sample states the density that a ray finds."""
    directions, _ = trial.chart.directions(np.random.default_rng(2).random((20000, 2)))
    met = trial.met(directions)
    assert (met["pdf"][met["radiance"].any(axis=1)] > 0).all()
    some = trial.drawn["valid"].nonzero()[0]
    again = trial.met(trial.drawn["wi"][some])
    off = np.abs(again["pdf"] / trial.drawn["pdf"][some] - 1)
    assert np.quantile(off, 0.99) < 1e-3, "but at the borders of cells, which rounding may cross"


def floor_under(lamp: Lamp, technique: str, spp: int) -> Estimate:
    """Return what one place of a grey floor sends back."""

    def floor(b: _core.SceneBuilder) -> None:
        large = np.diag([9.0, 9.0, 1.0, 1.0])
        b.add_rectangle(large, flip_normals=False, front=b.add_bsdf("diffuse", [0.5] * 3), back=None, radiance=None)

    scene = build(lamp, floor, camera=looking((0.1, -0.5, 0.3), (0.1, -0.2, 0.0), up=(0, 1, 0)), fov=0.01)
    return estimate(scene, spp, technique=technique, max_depth=2)
