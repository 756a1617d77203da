"""Every light's sampler against the density that it states, from near, far, edge-on and within.

Seeds are fixed. All χ² tests of this file together have a false-alarm rate of 0.1 %, shared equally (Šidák).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest
from numpy.typing import NDArray

from equaltime import _core
from equaltime._core import parts

from .charts import ConeChart, CylinderChart, DiskChart, RectangleChart, SphereChart, TriangleChart
from .chi2 import LEVEL, SAMPLES, Chart, Histogram, Masses, share
from .worlds import Add, affine, build, octahedron, turned

Array = NDArray[np.float64]
WHITE = (1.0, 1.0, 1.0)
TURN = turned([1, 2, 3], 50)


@dataclass(frozen=True)
class Subject:
    name: str
    add: Add
    chart: Callable[[Array], Chart]
    """Of the directions from a receiver."""
    receiver: tuple[float, float, float]
    lights: str = "power"

    def __str__(self) -> str:
        return self.name


def rectangle(width: float, height: float, *receivers: tuple[float, float, float], turn: Array = TURN) -> list[Subject]:
    """A rectangle with a corner in the origin, width along x; receivers in the same frame, all turned together."""
    e1, e2 = turn[:, 0] * width, turn[:, 1] * height
    matrix = affine(e1 / 2, e2 / 2, turn[:, 2], e1 / 2 + e2 / 2)

    def add(builder: _core.SceneBuilder) -> None:
        builder.add_rectangle(matrix, flip_normals=False, front=None, back=None, radiance=WHITE)

    return [
        Subject(
            f"rectangle {width:g} by {height:g} from {place}",
            add,
            lambda p: RectangleChart(np.zeros(3), e1, e2, p),
            tuple(turn @ place),
        )
        for place in receivers
    ]


def nearly_touched() -> Subject:
    """Receiver so close that the rectangle is most of a hemisphere: its area would be a bad chart."""
    rectangles = rectangle(2, 1, (1, 0.5, 0.01))[0]
    return replace(rectangles, chart=lambda p: SphereChart(half=True, pole=-TURN[:, 2]))


def triangle(corners: list[tuple[float, float]], *receivers: tuple[float, float, float]) -> list[Subject]:
    """A triangle in the plane z = 0, facing up; receivers in the same frame, all turned together."""
    a, b, c = (TURN @ (*corner, 0.0) for corner in corners)

    def add(builder: _core.SceneBuilder) -> None:
        builder.add_mesh(np.stack([a, b, c]), [[0, 1, 2]], front=None, back=None, radiance=WHITE)

    return [
        Subject(
            f"triangle {corners} from {place}",
            add,
            lambda p: TriangleChart(a, b - a, c - a, p),
            tuple(TURN @ place),
        )
        for place in receivers
    ]


def disk(*receivers: tuple[float, float, float]) -> list[Subject]:
    """An ellipse with half axes 1 and 0.5."""
    u, v = TURN[:, 0], 0.5 * TURN[:, 1]
    matrix = affine(u, v, TURN[:, 2])

    def add(builder: _core.SceneBuilder) -> None:
        builder.add_disk(matrix, flip_normals=False, front=None, back=None, radiance=WHITE)

    return [
        Subject(f"disk from {place}", add, lambda p: DiskChart(np.zeros(3), u, v, p), tuple(TURN @ place))
        for place in receivers
    ]


def sphere(radius: float, *receivers: tuple[float, float, float], inward: bool = False) -> list[Subject]:
    def add(builder: _core.SceneBuilder) -> None:
        builder.add_sphere([0, 0, 0], radius, flip_normals=inward, front=None, back=None, radiance=WHITE)

    return [
        Subject(
            f"{'inside ' * inward}sphere {radius:g} from {place}",
            add,
            lambda p: SphereChart() if inward else ConeChart(-p, radius),
            place,
        )
        for place in receivers
    ]


def cylinder(*receivers: tuple[float, float, float], inward: bool = False) -> list[Subject]:
    """A tube of radius 0.5 round z, from z = -1 to 1; receivers in the same frame, all turned together."""

    def add(builder: _core.SceneBuilder) -> None:
        axis = TURN[:, 2]
        builder.add_cylinder(-axis, axis, 0.5, flip_normals=inward, front=None, back=None, radiance=WHITE)

    return [
        Subject(
            f"{'inside ' * inward}cylinder from {place}",
            add,
            lambda p: CylinderChart(TURN[:, 2], 0.5, p, inward),
            tuple(TURN @ place),
        )
        for place in receivers
    ]


def add_ball(builder: _core.SceneBuilder) -> None:
    """A mesh of 128 emissive triangles, half of which show the receiver their backs."""
    builder.add_mesh(*octahedron(2), front=None, back=None, radiance=WHITE)


def add_everything(builder: _core.SceneBuilder) -> None:
    """One light of each kind, of different colours and powers, behind one another in part."""
    builder.add_sphere([0, 0, -3], 0.8, flip_normals=False, front=None, back=None, radiance=[5, 1, 1])
    builder.add_rectangle(
        affine([1, 0, 0], [0, 0, 2], [0, -1, 0], [0.5, 3, 0]),
        flip_normals=False,
        front=None,
        back=None,
        radiance=[1, 5, 1],
    )
    builder.add_disk(
        affine([0, 1, 0], [0, 0, 1], [1, 0, 0], [-2, 0, 0.5]),
        flip_normals=False,
        front=None,
        back=None,
        radiance=[1, 1, 0.2],
    )
    builder.add_mesh(
        [[3, -1, -1], [2, 1, -1], [2, -1, 1.5]], [[0, 2, 1], [0, 1, 2]][:1], front=None, back=None, radiance=[0, 9, 9]
    )
    builder.add_sphere([0, 4, 0.5], 0.5, flip_normals=False, front=None, back=None, radiance=[8, 0, 8])
    builder.add_constant_environment([0.1, 0.2, 0.3])


SUBJECTS = [
    *rectangle(2, 1, (1, 0.5, 0.5), (0.3, 1.3, 0.2), (-2, 3, 4), (1.9, -0.6, 0.001), (1, 0.5, 2.2)),
    nearly_touched(),
    # Exact in binary, so that float32 keeps them rectangles: others so thin become two triangles.
    *rectangle(1, 2.0**-16, (0.25, 0.125, 0.375), (0.5, 0.0, 3.0), turn=np.eye(3)),
    *triangle([(0, 0), (1, 0), (0.2, 0.8)], (0.3, 0.3, 0.3), (0.3, 0.3, 0.003), (2, 1, 3), (0.8, 0.7, 0.05)),
    *triangle([(0, 0), (1, 0), (0.5, 0.001)], (0.5, 0.2, 0.3), (2.0, 0.0, 1.0)),
    *triangle([(0, 0), (1, 0), (0.2, 0.8)], (1.1, 0.9, 0.001)),
    *disk((0.2, 0.1, 0.5), (3, 1, 2), (0.9, 0.4, 0.1)),
    *sphere(1.0, (0, 0, 1.001), (1, 1, 1), (30, 20, -10)),
    *sphere(0.001, (5, 3, 1)),
    *sphere(1.0, (0.0, 0.0, 0.0), (0.3, 0.5, 0.7), inward=True),
    *cylinder((0.7, 0.1, 0.3), (0.2, 0.9, 1.6)),
    *cylinder((0.1, 0.2, 0.0), (0.01, 0.02, 1.5), (0.4, 0.5, 1.3), inward=True),
    *(
        Subject(f"ball of triangles, {lights}", add_ball, lambda p: ConeChart(-p, 1.0), (1.5, 0.5, 1.0), lights)
        for lights in ("uniform", "power", "tree")
    ),
    *(
        Subject(f"all kinds, {lights}", add_everything, lambda p: SphereChart(), (0.0, 0.0, 0.0), lights)
        for lights in ("uniform", "power", "tree")
    ),
]
EACH = share(LEVEL, len(SUBJECTS))


class Trial:
    """A light as a receiver samples it, and what rays from the receiver say of it."""

    def __init__(self, subject: Subject, samples: int = SAMPLES, seed: int = 1) -> None:
        self.lights = subject.lights
        self.scene = build(subject.add, eye=subject.receiver)
        self.receiver = np.array(subject.receiver)
        self.chart = subject.chart(self.receiver)
        self.samples = samples
        drawn = parts.sample_lights(self.scene, self.lights, self._from(samples), seed)
        # What stands in front of the light is another light: such a sample is no sample of that direction's radiance.
        met = self.eval(drawn["wi"])
        self.seen = drawn["valid"] & met["valid"] & (drawn["radiance"] == met["radiance"]).all(axis=1)
        self.wi, self.pdf, self.met_pdf = drawn["wi"][self.seen], drawn["pdf"][self.seen], met["pdf"][self.seen]
        self.valid = drawn["valid"]

    def _from(self, samples: int) -> Array:
        return np.broadcast_to(self.receiver, (samples, 3))

    def eval(self, wi: Array) -> dict[str, Array]:
        value: dict[str, Array] = parts.eval_lights(self.scene, self.lights, self._from(len(wi)), wi)
        return value

    @property
    def masses(self) -> Masses:
        return Masses(self.chart, lambda wi: self.eval(wi)["pdf"])

    @property
    def histogram(self) -> Histogram:
        return Histogram.of(self.chart, self.wi, self.samples)


@pytest.mark.parametrize("subject", SUBJECTS, ids=str)
def test_directions_are_drawn_with_the_stated_density(subject: Subject) -> None:
    trial = Trial(subject)
    histogram = trial.histogram
    assert histogram.p(trial.masses) > EACH, histogram.looks


@pytest.mark.parametrize(
    "name",
    [
        *("rectangle 2 by 1 from (1, 0.5, 0.01)", "disk", "sphere 0.001", "cylinder", "inside cylinder"),
        *("ball", "all kinds"),
    ],
)
def test_a_slightly_wrong_density_is_rejected(name: str) -> None:
    trial = Trial(next(s for s in SUBJECTS if s.name.startswith(name)))
    histogram, masses = trial.histogram, trial.masses
    assert histogram.p(masses) > EACH
    rim = np.quantile(trial.chart.places(trial.wi)[:, 0], 0.95)
    wrong = {
        "scaled": masses.changed(lambda pdf, wi: 1.02 * pdf),
        "tilted": masses.changed(lambda pdf, wi: (0.98 + 0.04 * trial.chart.places(wi)[:, 0]) * pdf, keep_total=True),
        "rimmed": masses.changed(
            lambda pdf, wi: np.where(trial.chart.places(wi)[:, 0] > rim, 1.2, 1.0) * pdf, keep_total=True
        ),
    }
    for kind, subject in wrong.items():
        assert histogram.p(subject) < EACH, (kind, histogram.looks)
