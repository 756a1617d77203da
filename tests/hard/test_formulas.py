"""Hard cases of formulas, transport and statistics (S, T, E and C of the table in README.md) that no other test has.

Each has its twin beside it: the bad formula in single precision, or the fix undone, which the same mark rejects.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

import equaltime as et
from equaltime import _core
from equaltime._core import parts
from equaltime.examples import scenes_folder

from ..statistical.worlds import affine, build, looking, render

Array = NDArray[np.float64]
F = np.float32
HARD = scenes_folder() / "hard"


@pytest.mark.parametrize("ratio", [1e-2, 1e-4, 1e-6, 1e-8])
def test_S05_a_small_ball_is_as_bright_as_its_solid_angle(ratio: float) -> None:  # noqa: N802
    image = et.render(et.load(HARD / "ball-lamp.toml", radius=ratio, radiance=ratio**-2), spp=64).image
    assert image.mean(dtype=np.float64) == pytest.approx(0.25, rel=3e-6 + ratio**2)


def test_S05_one_minus_a_cosine_loses_it() -> None:  # noqa: N802
    """The twin: what the solid angle of such a ball is in float32, over what it should be."""
    ratio = F(1e-4)
    assert abs((F(1) - np.sqrt(F(1) - ratio * ratio)) / (0.5e-8) - 1) > 0.5


def girard(corners: NDArray[np.float32]) -> float:
    """The sum of a spherical triangle's angles less pi, in float32."""
    a, b, c = (v / np.sqrt((v * v).sum(dtype=F)) for v in corners)
    total = F(0)
    for x, y, z in ((a, b, c), (b, c, a), (c, a, b)):
        n, m = np.cross(x, y), np.cross(x, z)
        cosine = (n @ m) / np.sqrt((n @ n) * (m @ m))
        total += np.arccos(np.clip(cosine, F(-1), F(1)))
    return float(total - F(math.pi))


@pytest.mark.parametrize("size", [1e-1, 1e-2, 1e-3, 1e-4])
def test_S09_small_triangles_light_by_their_solid_angle_and_not_by_girards(size: float) -> None:  # noqa: N802
    """The core by its irradiance from a lamp overhead, which is its solid angle; beside it the twin."""
    corners = np.array([[-1, -1, 0], [1.5, -0.5, 0], [0, 1.2, 0]]) * size + [0, 0, 1]
    area = np.linalg.norm(np.cross(corners[1] - corners[0], corners[2] - corners[0])) / 2

    def add(b: _core.SceneBuilder) -> None:
        b.add_mesh(corners, [[0, 2, 1]], front=None, back=None, radiance=[1, 1, 1])

    drawn = parts.sample_lights(build(add), "uniform", np.zeros((4096, 3)), 1)
    found = np.where(drawn["valid"], 1.0 / drawn["pdf"], 0.0).mean()
    assert found == pytest.approx(area, rel=2 * size**2 + 1e-4)
    if size <= 1e-3:
        assert abs(girard(corners.astype(F)) / area - 1) > 0.01


def test_S16_glass_of_an_index_next_to_one_is_hardly_there() -> None:  # noqa: N802
    def seen(ior: float) -> float:
        return float(et.render(et.load(HARD / "glass.toml", ior=ior), spp=16).image.mean())

    for off in (0.0, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2):
        assert seen(1 + off) == pytest.approx(1.0, abs=1e-6)
        assert seen(1 - off) == pytest.approx(1.0, abs=1e-6)


SKIES: dict[str, Callable[[_core.SceneBuilder, float], object]] = {
    "one texel": lambda b, on: b.add_image_environment(np.full((1, 1, 3), on, np.float32), 1.0, np.eye(4)),
    "scaled": lambda b, on: b.add_image_environment(np.ones((4, 8, 3), np.float32), on, np.eye(4)),
    "constant": lambda b, on: b.add_constant_environment([on] * 3),
}


def ball_in(sky: str, on: float) -> _core.Scene:
    def add(b: _core.SceneBuilder) -> None:
        b.add_sphere(
            [0, 0, 5], 1.0, flip_normals=False, front=b.add_bsdf("diffuse", [0.5] * 3), back=None, radiance=None
        )
        SKIES[sky](b, on)

    return build(add, size=(8, 8))


@pytest.mark.parametrize("sky", SKIES)
@pytest.mark.parametrize("technique", ["bsdf", "light", "mis", "mixture", "uniform"])
def test_S20_a_black_sky_is_black_and_calls_for_nothing(technique: str, sky: str) -> None:  # noqa: N802
    black, white = ball_in(sky, 0.0), ball_in(sky, 1.0)
    assert render(black, 8, technique=technique)["mean"].max() == 0.0
    assert not black.effects()["environment"]
    assert black.lights == 0
    assert render(white, 8, technique=technique)["mean"].max() > 0.9, "the twin"
    assert white.effects()["environment"]


def test_S20_shares_of_nothing_are_not_numbers() -> None:  # noqa: N802
    """The twin: the table that a black sky would have."""
    weights = np.zeros(4, F)
    with np.errstate(invalid="ignore"):
        assert np.isnan(weights / weights.sum()).all()


def lamps(dark: int) -> _core.Scene:
    def add(b: _core.SceneBuilder) -> None:
        b.add_rectangle(
            affine([2, 0, 0], [0, 2, 0], [0, 0, 1], [0, 0, 0]),
            flip_normals=False,
            front=b.add_bsdf("diffuse", [0.5] * 3),
            back=None,
            radiance=None,
        )
        b.add_sphere([0.3, 0.2, 1], 0.2, flip_normals=False, front=None, back=None, radiance=[3, 3, 3])
        for i in range(dark):
            b.add_sphere(
                [3 + i % 100, 0, 9 + i // 100], 0.4, flip_normals=False, front=None, back=None, radiance=[0] * 3
            )

    return build(add, camera=looking([0.1, 0.2, 3], [0, 0, 0]), fov=20, size=(8, 8))


@pytest.mark.parametrize("lights", ["uniform", "power", "tree"])
def test_S21_ten_thousand_lamps_that_are_off_are_no_lights(lights: str) -> None:  # noqa: N802
    """They stand aside, and change neither a bit of the image nor a ray of its cost."""
    few, many = lamps(1), lamps(10_000)
    assert few.lights == many.lights == 1
    cost = {}
    for scene in (few, many):
        renderer = _core.Renderer(scene, _core.Settings(technique="light", lights=lights), seed=1)
        renderer.advance(8)
        cost[scene] = renderer.counters | {"moments": renderer.moments.tobytes()}
    assert cost[few] == cost[many]


@pytest.mark.parametrize("lights", ["uniform", "power", "tree"])
def test_S21_lamps_that_are_off_leave_the_image_as_it_is(lights: str) -> None:  # noqa: N802
    """Were they picked like others, one of two hundred samples would find the lamp that is on."""
    one = render(lamps(0), 32, technique="light", lights=lights)["mean"]
    many = render(lamps(200), 32, technique="light", lights=lights)["mean"]
    assert one.mean() > 0.01
    assert many.mean() == pytest.approx(one.mean(), rel=0.02)
    assert many.std() < 1.5 * one.std(), "the twin: 200 times as few samples have 14 times the noise"


def frisvad(n: NDArray[np.float32]) -> NDArray[np.float32]:
    a = F(1) / (F(1) + n[2])
    return np.array([F(1) - n[0] * n[0] * a, -n[0] * n[1] * a, -n[0]], F)


def test_S24_frames_next_to_the_south_pole_lose_their_length_by_the_usual_formula() -> None:  # noqa: N802
    """The twin of the test of frames in cpp/tests/math/test_math.cpp, which asks for 1e-6."""
    n = np.array([3e-4, 4e-4, -1.0], F)
    n /= np.sqrt((n * n).sum(dtype=F))
    assert abs(float(np.linalg.norm(frisvad(n).astype(np.float64))) - 1) > 1e-3


def test_S26_paths_of_five_thousand_segments_keep_their_energy() -> None:  # noqa: N802
    scene = et.load(HARD / "furnace-mirrors.toml", max_depth=5000)
    exact = 1.0 - (1.0 - 2.0**-10) ** 5000
    image = et.render(scene, spp=2, strategy="best,roulette=none").image
    assert np.abs(image / exact - 1).max() < 2e-6
    short = et.render(scene.with_(max_depth=1024), spp=2, strategy="best,roulette=none").image
    assert np.abs(short / exact - 1).min() > 0.3, "the twin: where a table of 1024 dimensions ends"


def test_T08_radiance_within_glass_is_as_many_times_larger_as_its_index_squared() -> None:  # noqa: N802
    inside = et.load(HARD / "glass.toml", ior=1.5, shape="sphere", eye=[-0.1, 0.2, 0.3])
    outside = et.load(HARD / "glass.toml", ior=1.5, shape="sphere")
    assert np.abs(et.render(inside, spp=16).image / 1.5**2 - 1).max() < 2e-6
    assert np.abs(et.render(outside, spp=16).image - 1).max() < 2e-6, "the twin: not so outside"


@pytest.mark.parametrize("index", [0.0, -1.5, float("nan"), float("inf")])
def test_T12_an_index_that_is_none_is_refused_with_its_value(index: float) -> None:  # noqa: N802
    ball = {"type": "sphere", "bsdf": {"type": "dielectric", "int_ior": index}}
    with pytest.raises(et.SceneError, match="int_ior"):
        et.load_dict({"type": "scene", "sensor": {"type": "perspective"}, "ball": ball})


@pytest.mark.parametrize("albedo", [1.0000001, 2.0, -0.1])
def test_T12_more_light_than_came_in_is_refused_with_its_value(albedo: float) -> None:  # noqa: N802
    ball = {"type": "sphere", "bsdf": {"type": "diffuse", "reflectance": albedo}}
    with pytest.raises(et.SceneError, match="reflectance"):
        et.load_dict({"type": "scene", "sensor": {"type": "perspective"}, "ball": ball})
    ball["bsdf"] = {"type": "diffuse", "reflectance": 1.0}
    et.load_dict({"type": "scene", "sensor": {"type": "perspective"}, "ball": ball})
    assert sum(2.0**bounce for bounce in range(100)) > 1e29, "the twin: what a furnace of two would make of a hundred"


def test_E01_a_million_equal_samples_have_their_own_value_for_a_mean() -> None:  # noqa: N802
    scene = et.load(HARD / "one-pixel.toml")
    assert (et.render(scene, spp=1_000_000).image == F(0.1)).all()


def test_E01_a_sum_in_single_precision_stops_growing() -> None:  # noqa: N802
    """The twin: float32 counts to 2^24."""
    assert F(2**24) + F(1) == F(2**24)
    total = np.add.accumulate(np.full(1_000_000, 0.1, F), dtype=F)[-1]
    assert abs(total / 1e5 - 1) > 1e-3
