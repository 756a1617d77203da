"""Hard cases of paths that are long: rooms of any walls, roulette, mirrors, sheets (T1, T2, T5, T6, T14).

Each has its twin in it: the fix undone, which the same mark rejects.
"""

from __future__ import annotations

from collections.abc import Callable
from mmap import mmap
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import stats

import equaltime as et
from equaltime import _core
from equaltime.film.moments import squared_deviations
from equaltime.hardcases.cases import scenes_folder

from ..statistical.worlds import affine, build, estimate, looking, octahedron, render
from .fuzz.memory import TooMuchMemory, Watch

Array = NDArray[np.float64]
Sides = dict[str, Any]
Shape = Callable[[_core.SceneBuilder, Sides], object]
RHO = [0.5, 0.9, 0.99, 0.999]
DEPTH = 100
EYE, TARGET = (0.2, 0.1, 0.3), (0.5, -0.4, -0.2)


def ball(b: _core.SceneBuilder, sides: Sides) -> None:
    b.add_sphere([0, 0, 0], 1.0, flip_normals=True, **sides)


def cube(b: _core.SceneBuilder, sides: Sides) -> None:
    for n in (*np.eye(3), *-np.eye(3)):
        x = np.roll(n, 1)
        b.add_rectangle(affine(x, np.cross(n, x), n, -n), flip_normals=False, **sides)


def ball_of_triangles(b: _core.SceneBuilder, sides: Sides) -> None:
    vertices, faces = octahedron(2)
    b.add_mesh(vertices, faces[:, ::-1], **sides)


def dome(b: _core.SceneBuilder, sides: Sides) -> None:
    b.add_sphere([0, 0, -0.2], 1.0, flip_normals=True, **sides)
    b.add_disk(affine(*np.diag([1.5, 1.5, 1.0]), [0, 0, -0.4]), flip_normals=False, **sides)


def tube(b: _core.SceneBuilder, sides: Sides) -> None:
    b.add_cylinder([0, 0, -1], [0, 0, 1], 1.0, flip_normals=True, **sides)
    for s in (1.0, -1.0):
        b.add_disk(affine(*np.diag([1.5, 1.5 * s, s]), [0, 0, -s]), flip_normals=False, **sides)


SHAPES: list[Shape] = [ball, cube, ball_of_triangles, dome, tube]


def furnace(shape: Shape, wall: str, rho: float, glow: float = 1.0, thing: str = "") -> _core.Scene:
    """Return a room whose walls shine with what they do not reflect, and what stands in it."""

    def add(b: _core.SceneBuilder) -> None:
        diffuse, mirror = b.add_bsdf("diffuse", [rho] * 3), b.add_bsdf("conductor", [0] * 3, [1] * 3, [rho] * 3)
        bsdf = {"diffuse": diffuse, "mirror": mirror}.get(wall) or b.add_mixture(diffuse, mirror, 0.3)
        shape(b, {"front": bsdf, "back": None, "radiance": [glow * (1 - rho)] * 3})
        if thing == "glass":
            glass = b.add_bsdf("dielectric", 1.5, [1] * 3, [1] * 3)
            b.add_sphere([0.5, -0.4, 0.1], 0.2, flip_normals=False, front=glass, back=glass, radiance=None)
        elif thing == "pane":
            pane = b.add_bsdf("thindielectric", 1.5, [1] * 3, [1] * 3)
            upright = affine([0.3, 0, 0], [0, 0, 0.3], [0, -1, 0], [0.3, -0.2, 0])
            b.add_rectangle(upright, flip_normals=False, front=pane, back=pane, radiance=None)

    return build(add, camera=looking(EYE, TARGET), fov=60.0, size=(8, 8))


@pytest.mark.parametrize("rho", RHO)
@pytest.mark.parametrize("wall", ["diffuse", "mirror", "blend"])
@pytest.mark.parametrize("shape", SHAPES)
def test_T01_rooms_of_any_walls_glow_evenly_without_noise(shape: Shape, wall: str, rho: float) -> None:  # noqa: N802
    def off(glow: float) -> float:
        scene = furnace(shape, wall, rho, glow)
        image = render(scene, 2, technique="bsdf", roulette="none", max_depth=DEPTH)["mean"]
        return float(np.abs(image / (1.0 - rho**DEPTH) - 1).max())

    assert off(1.0) < 3e-6
    assert off(1.0 + 1e-5) > 3e-6, "the twin: a hundred-thousandth too bright"


@pytest.mark.parametrize("rho", RHO[:3])
@pytest.mark.parametrize("thing", ["glass", "pane"])
@pytest.mark.parametrize("shape", SHAPES)
def test_T01_rooms_with_glass_glow_evenly(shape: Shape, thing: str, rho: float) -> None:  # noqa: N802
    """Z-tests at 0.1 % together; paths without a limit, ended by roulette."""
    found = estimate(furnace(shape, "diffuse", rho, thing=thing), 64)
    level = 1e-3 / (len(SHAPES) * 2 * 3)
    assert found.p(1.0) > level, found
    assert found.p(1.2) < level, "the twin"


def gain(seeds: int = 48, **settings: Any) -> float:
    """Return by how much four times the samples divide the variance of bright rooms' means: 4, if it is finite."""
    scene = furnace(cube, "diffuse", 0.99)
    spread = {
        spp: np.var([render(scene, spp, seed, technique="bsdf", **settings)["mean"].mean() for seed in range(seeds)])
        for spp in (1, 4)
    }
    return float(spread[1] / spread[4])


def test_T02_a_roulette_that_lets_weights_grow_is_told_by_its_errors() -> None:  # noqa: N802
    """The capped roulette, run: with the same mark as the right one, an F-test at 0.1 %."""
    low, high = stats.f.ppf([0.0005, 0.9995], 47, 47)
    assert low < gain() / 4 < high
    capped = [gain(roulette="constant", survival=survival) / 4 for survival in (0.95, 0.9)]
    assert not all(low < ratio < high for ratio in capped), f"the twin: {capped}"


def test_T05_a_hundred_thousand_bounces_take_no_memory() -> None:  # noqa: N802
    """Nothing is kept of a bounce: neither 100 bytes each, which is the twin, nor a frame of the stack."""
    scene = et.load(scenes_folder() / "hard/furnace-mirrors.toml", max_depth=100_000).with_(size=(4, 4))
    subject = _core.Renderer(scene.core, _core.Settings(roulette="none", max_depth=100_000), threads=2)
    watch = Watch(4 << 20)
    subject.advance(1)
    with watch.within(0):
        subject.advance(2)
    assert np.abs(subject.moments["mean"] - 1).max() < 1e-4, "rounded a hundred thousand times"
    size = 100_000 * 100
    # of its own pages, since those that others have freed are there already
    with mmap(-1, size) as kept, pytest.raises(TooMuchMemory), watch.within(0):
        kept.write(b"\1" * size)


BRIGHT = float(np.float32(0.999))


def mirrors(technique: str, max_depth: int, **settings: Any) -> float:
    """Return what rays see that go to and fro between a small lamp and a wall, in a closed box of mirrors."""

    def add(b: _core.SceneBuilder) -> None:
        mirror = b.add_bsdf("conductor", [0] * 3, [1] * 3, [BRIGHT] * 3)
        cube(b, {"front": mirror, "back": None, "radiance": None})
        lamp = affine([0.05, 0, 0], [0, 0.05, 0], [0, 0, 1], [0.1, 0.2, -1 + 1e-6])
        b.add_rectangle(lamp, flip_normals=False, front=mirror, back=None, radiance=[1] * 3)

    camera = looking([0.1, 0.2, 0.3], [0.1, 0.2, -1], up=[1, 0, 0])
    film = render(
        build(add, camera=camera, fov=1e-4, size=(4, 4)), 4, technique=technique, max_depth=max_depth, **settings
    )
    return float(film["mean"].mean())


@pytest.mark.parametrize("technique", ["bsdf", "mis"])
@pytest.mark.parametrize("depth", [1, 2, 3, 999, 3000])
def test_T06_a_small_lamp_in_a_box_of_mirrors_is_seen_by_a_series(technique: str, depth: int) -> None:  # noqa: N802
    """L = 1 + rho² + rho⁴ + …, as often as the depth allows for."""
    square = BRIGHT**2
    exact = (1 - square ** ((depth + 1) // 2)) / (1 - square)
    assert mirrors(technique, depth, roulette="none") == pytest.approx(exact, rel=2e-5)
    short = mirrors(technique, min(depth, 1024), roulette="none")
    assert depth <= 1024 or short < 0.9 * exact, "the twin: where a table of 1024 dimensions ends"


def sheets(count: int, **settings: Any) -> tuple[float, float]:
    """Return mean and relative variance of a sample of a sky behind so many sheets, of which each lets 4/5 through."""

    def add(b: _core.SceneBuilder) -> None:
        sheet = b.add_bsdf("thindielectric", 1.0, [1] * 3, [0.8] * 3)
        for i in range(count):
            place = affine([9, 0, 0], [0, 9, 0], [0, 0, 1], [0, 0, 1 + 0.1 * i])
            b.add_rectangle(place, flip_normals=False, front=sheet, back=sheet, radiance=None)
        b.add_constant_environment([1] * 3)

    film = render(build(add, size=(64, 64)), 16, sampler="independent", **settings)
    count_of_all = film["count"].sum()
    mean = film["mean"][..., 0].mean()
    square = (
        squared_deviations(film)[..., 0] + film["count"] * (film["mean"][..., 0] - mean) ** 2
    ).sum() / count_of_all
    return float(mean), float(square / mean**2)


@pytest.mark.parametrize("count", [1, 4, 8, 16, 24])
def test_T14_many_sheets_cost_no_more_than_what_they_keep_back(count: int) -> None:  # noqa: N802
    """The curve: samples that are 0 or 1 have a relative variance of 1/T - 1, where T gets through."""
    through = 0.8**count
    mean, variance = sheets(count)
    assert mean == pytest.approx(through, rel=4 / np.sqrt(64 * 64 * 16 * through))
    assert variance < 1.2 * (1 / through - 1) + 1e-6
    if count == 16:
        assert sheets(count, roulette="constant", survival=0.5)[1] > 2 * (1 / through - 1), "the twin"
