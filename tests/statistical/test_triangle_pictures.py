"""Triangles that shine by a texture: each is picked, and its points are drawn, in proportion to it.

Seeds are fixed. All χ² tests of this file together have a false-alarm rate of 0.1 %, shared equally (Šidák).
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from equaltime import _core
from equaltime._core import parts

from ..analytic.test_textures import looked_up
from .charts import TriangleChart
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
from .worlds import Estimate, affine, build

Array = NDArray[np.float64]
CORNERS = np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.5, 1.0, 0.0]]) @ TURN.T
UVS = np.array([[0.1, 0.2], [0.9, 0.3], [0.4, 0.95]])
WHITE = (1.0, 1.0, 1.0)


@dataclass(frozen=True)
class Subject:
    name: str
    texels: Array
    receiver: tuple[float, float, float]
    """In the triangle's own axes."""
    parameters: tuple[tuple[str, Any], ...] = ()
    uvs: Array | None = None
    flipped: bool = False

    def add(self, b: _core.SceneBuilder) -> None:
        face = [[0, 2, 1]] if self.flipped else [[0, 1, 2]]
        uvs = UVS if self.uvs is None else self.uvs
        shape = b.add_mesh(CORNERS, face, None, uvs, front=None, back=None, radiance=(1.0, 0.5, 2.0))
        b.bind_radiance(shape, b.add_bitmap(self.texels.astype(np.float32), srgb=False, **dict(self.parameters)))


BELOW = (0.7, 0.4, -0.3)
SUBJECTS = [
    Subject("uneven, far", UNEVEN, FAR),
    Subject("uneven, near", UNEVEN, NEAR),
    Subject("steps, near", UNEVEN, NEAR, (("filter", "nearest"),)),
    Subject("a spot, far", SPOT, FAR, (("wrap", "clamp"),), uvs=2.0 * UVS - 0.5),
    Subject("repeated", UNEVEN, NEAR, (("to_uv", SCALED),)),
    Subject("mirrored, from below", UNEVEN, BELOW, (("to_uv", SCALED), ("wrap", "mirror")), flipped=True),
    Subject("turned", UNEVEN, NEAR, (("to_uv", TURNED),)),
    Subject("large", LARGE, NEAR),
    Subject("one place of the texture", UNEVEN, FAR, uvs=np.full((3, 2), 0.37)),
    Subject("along a line of the texture", UNEVEN, FAR, uvs=np.array([[0.1, 0.4], [0.9, 0.4], [0.3, 0.4]])),
    Subject("endlessly often", UNEVEN, FAR, uvs=UVS * 1e5),
]
EACH = share(LEVEL, len(SUBJECTS))
EVERYDAY = ("uneven, near", "a spot, far", "mirrored, from below")
CASES = [pytest.param(s, id=s.name, marks=() if s.name in EVERYDAY else pytest.mark.slow) for s in SUBJECTS]


def trial(subject: Subject, **options: int) -> Trial:
    chart = TriangleChart(CORNERS[0], CORNERS[1] - CORNERS[0], CORNERS[2] - CORNERS[0], TURN @ subject.receiver)
    return Trial(subject.add, chart, **options)


@pytest.mark.parametrize("subject", CASES)
def test_points_are_drawn_with_the_stated_density(subject: Subject) -> None:
    check_density(trial(subject), EACH)


@pytest.mark.parametrize("subject", CASES)
def test_whatever_shines_is_drawn_and_a_sample_states_the_density_that_a_ray_finds(subject: Subject) -> None:
    check_what_shines(trial(subject, samples=20000))


# ---- meshes ----------------------------------------------------------------------------------------------------------


def mesh(side: int) -> tuple[Array, NDArray[np.uint32], Array]:
    """Return vertices, faces and texture coordinates of the square [0, 1]², in twice side² triangles."""
    line = np.arange(side + 1) / side
    uvs = np.stack(np.meshgrid(line, line), axis=-1).reshape(-1, 2)
    first = (np.arange(side)[:, None] * (side + 1) + np.arange(side)).reshape(-1, 1)
    corners = np.array([[0, 1, side + 2], [0, side + 2, side + 1]])
    faces = np.concatenate([first + corner for corner in corners]).astype(np.uint32)
    return np.pad(uvs, ((0, 0), (0, 1))), faces, uvs


@pytest.mark.parametrize("filter_name", ["bilinear", "nearest"])
def test_triangles_are_picked_in_proportion_to_what_they_send(filter_name: str) -> None:
    """Against the texture in NumPy, looked up at many points; the core's sums are exact."""
    vertices, faces, uvs = mesh(2)
    texels = np.random.default_rng(11).uniform(0.0, 1.0, (7, 9, 3)) ** 6
    texels[:, :3] = 0.0

    def lamp(b: _core.SceneBuilder) -> None:
        shape = b.add_mesh(vertices, faces, None, uvs, front=None, back=None, radiance=WHITE)
        b.bind_radiance(shape, b.add_bitmap(texels.astype(np.float32), srgb=False, filter=filter_name))

    receiver = np.array([0.3, 0.2, 30.0])
    scene, rng, n = build(lamp, eye=receiver), np.random.default_rng(5), 3000
    places = (np.arange(n) + rng.random(n)) / n, rng.permutation(np.arange(n) + rng.random(n)) / n
    sent, picked = [], []
    for corners in faces:
        s, y = np.sqrt(places[0]), places[1]
        weights = np.stack([1 - s, s * (1 - y), s * y], axis=1)
        at = weights @ uvs[corners]
        sent.append(np.mean([looked_up(texels, uv, filter_name == "bilinear", "repeat") for uv in at]))
        a, b, c = vertices[corners]
        directions, jacobian = TriangleChart(a, b - a, c - a, receiver).directions(np.stack(places, axis=1))
        found = parts.eval_lights(scene, "power", np.broadcast_to(receiver, directions.shape), directions)
        picked.append(float((found["pdf"] * jacobian).mean()))
    assert sum(picked) == pytest.approx(1.0, abs=5e-3)
    np.testing.assert_allclose(picked, np.array(sent) / sum(sent), atol=6e-3)
    assert 5.0 * min(picked) < max(picked)
    assert np.abs(np.array(picked) - 1 / len(faces)).max() > 0.08, "the twin: all alike"


def lit(texels: Array, technique: str, side: int, spp: int = 4096, height: float = 0.4, **bitmap: Any) -> Estimate:
    """What a floor sends back under a lamp of triangles that is 2 by 2."""
    vertices, faces, uvs = mesh(side)

    def lamp(b: _core.SceneBuilder) -> None:
        place = affine((2, 0, 0), (0, -2, 0), (0, 0, -1), (-0.8, 1.1, height))
        corners = vertices @ place[:3, :3].T + place[:3, 3]
        shape = b.add_mesh(corners, faces, None, uvs, front=None, back=None, radiance=WHITE)
        b.bind_radiance(shape, b.add_bitmap(texels.astype(np.float32), srgb=False, **bitmap))

    return floor_under(lamp, technique, spp)


def from_polygon(corners: Array, receiver: Array) -> float:
    """Return the form factor of a polygon over a floor with its normal along z (Lambert 1760)."""
    v = corners - receiver
    v = v / np.linalg.norm(v, axis=1, keepdims=True)
    after = np.roll(v, -1, axis=0)
    turn = np.cross(v, after)
    angle = np.arctan2(np.linalg.norm(turn, axis=1), (v * after).sum(axis=1))
    return abs(float((angle * turn[:, 2] / np.linalg.norm(turn, axis=1)).sum())) / (2 * np.pi)


@pytest.mark.parametrize("technique", ["light", "mis", "bsdf"])
@pytest.mark.parametrize("side", [1, 5])
def test_a_floor_has_what_lamberts_formula_says(technique: str, side: int) -> None:
    """Texels with steps are squares of one colour each, whatever triangles they lie on; a chance of 1 in 1e5 each."""
    texels = np.random.default_rng(3).uniform(0.0, 4.0, (3, 4, 3)) ** 2
    height, receiver = 0.7, np.array([0.1, -0.2, 0.0])
    expected = np.zeros(3)
    for row in range(3):
        for column in range(4):
            u, v = np.array([0, 1, 1, 0]) / 4 + column / 4, np.array([0, 0, 1, 1]) / 3 + row / 3
            corners = np.stack([2 * u - 0.8, 1.1 - 2 * v, np.full(4, height)], axis=1)
            expected += 0.5 * texels[row, column] * from_polygon(corners, receiver)
    found = lit(texels, technique, side, 1 << 16, height, filter="nearest")
    assert found.p(expected) > 1e-5
    assert found.p(1.02 * expected) < 1e-5, "the twin"


@pytest.mark.parametrize(("side", "least"), [(1, 12.0), (16, 12.0)])
def test_a_bright_spot_is_worth_its_picture(side: int, least: float) -> None:
    """A spot that makes a share `p` of an evenly drawn lamp has a variance of at least m² (1/p - 1) a sample."""
    found = lit(SPOT, "light", side, height=5.0)
    even = found.mean**2 * (1 / (2.0 / 8) ** 2 - 1) / 4096
    assert (even / found.error**2 > least).all(), even / found.error**2


def test_a_spot_that_no_grid_of_points_would_see_is_lit() -> None:
    tiny = np.zeros((512, 512, 3))
    tiny[301, 77] = 5000.0
    by_light, mis = (lit(tiny, technique, side, 1 << 16, 5.0) for technique, side in (("light", 1), ("mis", 4)))
    center = np.array([2 * 77.5 / 512 - 0.8, 1.1 - 2 * 301.5 / 512, 5.0]) - [0.1, -0.2, 0.0]
    square = center @ center
    expected = 0.5 * 5000.0 * (2 / 512) ** 2 * (center[2] ** 2 / square) / square / np.pi
    for found in (by_light, mis):
        assert found.p([expected] * 3) > 1e-5
        assert found.p([1.3 * expected] * 3) < 1e-5, "the twin"
        assert (found.error < 0.05 * found.mean).all()


@pytest.mark.parametrize("far", [1e5, 1e20, 3e30])
@pytest.mark.parametrize("spread", [[0, 0, 0], [1, 1, 1], [1e12, 1e12, 1e12], [1e30, 0, 0], [1e30, 1, 1e4]])
def test_texture_coordinates_far_from_0_take_no_longer(far: float, spread: list[float]) -> None:
    """Points between three corners near 1e20 that are one point may still be 1e13 texels apart, by rounding."""
    uvs = far + np.array(spread)[:, None] * UVS
    subject = Subject("far", np.random.default_rng(1).random((16, 16, 3)), NEAR, uvs=uvs)
    begin = time.process_time()
    build(subject.add, camera=np.eye(4))
    assert time.process_time() - begin < 5
