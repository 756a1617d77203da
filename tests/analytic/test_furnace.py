"""Closed rooms whose walls all reflect rho and emit 1 - rho: whatever their shape, every path of up to N segments sees
1 - rho^N, and paths without limit see 1 (cases T1, T2, T11).

Seeds are fixed. The z-tests of this file together have a false-alarm rate of 0.1 %.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import stats

from equaltime import _core

from ..statistical.chi2 import LEVEL, share
from ..statistical.worlds import affine, build, estimate, looking, octahedron, render

Array = NDArray[np.float64]
RHO = np.array([0.5, 0.9, 0.2])
EYE, TARGET = (0.2, 0.1, 0.3), (0.5, -0.4, -0.2)


class Room:
    """What every wall is made of: reflectance `rho`, emission 1 - rho; walls may be mirrors."""

    def __init__(self, builder: _core.SceneBuilder, rho: Array, mirror: bool = False, glow: float = 1.0) -> None:
        self.builder = builder
        self.diffuse = builder.add_bsdf("diffuse", rho)
        self.mirror = builder.add_bsdf("conductor", [0] * 3, [1] * 3, rho) if mirror else self.diffuse
        self.radiance = glow * (1.0 - rho)

    def wall(self, number: int) -> dict[str, object]:
        return {"front": self.mirror if number % 2 else self.diffuse, "back": None, "radiance": self.radiance}


def sides() -> list[Array]:
    """The walls of a cube of side 2, seen from inside."""
    axes = [sign * axis for axis in np.eye(3) for sign in (1, -1)]
    return [affine(np.roll(n, 1), np.cross(n, np.roll(n, 1)), n, -n) for n in axes]


def rectangles(room: Room) -> None:
    for number, matrix in enumerate(sides()):
        room.builder.add_rectangle(matrix, flip_normals=False, **room.wall(number))


def cube(room: Room) -> None:
    """Twelve triangles, two meshes."""
    corners = np.array([[x, y, 0, 1] for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))], dtype=float)
    quads = [(corners @ matrix.T)[:, :3] for matrix in sides()]
    for part in (0, 1):
        faces = np.concatenate([[[4 * i, 4 * i + 1, 4 * i + 2], [4 * i, 4 * i + 2, 4 * i + 3]] for i in range(3)])
        room.builder.add_mesh(np.concatenate(quads[part::2]), faces, **room.wall(part))


def sphere(room: Room) -> None:
    room.builder.add_sphere([0, 0, 0], 1.0, flip_normals=True, **room.wall(0))


def dome(room: Room) -> None:
    """Half a sphere over a disk that reaches beyond it."""
    room.builder.add_sphere([0, 0, 0], 1.0, flip_normals=True, **room.wall(0))
    room.builder.add_disk(np.diag([1.2, 1.2, 1, 1]), flip_normals=False, **room.wall(1))


def ball(room: Room) -> None:
    """A subdivided octahedron, seen from inside."""
    vertices, faces = octahedron(1)
    room.builder.add_mesh(vertices, faces[:, ::-1], **room.wall(0))


def room_of(
    shape: Callable[[Room], None], rho: Array, mirror: bool = False, glow: float = 1.0, side: int = 16
) -> _core.Scene:
    camera = looking(EYE, TARGET)
    return build(lambda b: shape(Room(b, rho, mirror, glow)), camera=camera, fov=60.0, size=(side, side))


SHAPES = [rectangles, cube, sphere, dome, ball]
TECHNIQUES = ["uniform", "bsdf", "light", "mis", "mixture"]
DEPTHS = [1, 2, 5, -1]
EACH = share(LEVEL, len(SHAPES) * len(TECHNIQUES) * len(DEPTHS) + 20)


def walls(technique: str, depth: int) -> Array:
    """Return RHO, but for endless paths of a mixture, whose weights double: of finite variance below sqrt(1/2) only."""
    return np.minimum(RHO, 0.65) if technique == "mixture" and depth < 0 else RHO


def seen(depth: int, rho: Array) -> Array:
    return 1.0 - rho**depth if depth > 0 else np.ones_like(rho)


@pytest.mark.parametrize("depth", DEPTHS)
@pytest.mark.parametrize("technique", TECHNIQUES)
@pytest.mark.parametrize("shape", SHAPES)
def test_diffuse_rooms_glow_evenly(shape: Callable[[Room], None], technique: str, depth: int) -> None:
    rho = walls(technique, depth)
    got = estimate(room_of(shape, rho), 64, technique=technique, max_depth=depth)
    assert got.p(seen(depth, rho)) > EACH, got


@pytest.mark.parametrize("technique", TECHNIQUES)
@pytest.mark.parametrize("shape", [rectangles, cube, dome])
def test_rooms_with_mirrors_glow_evenly(shape: Callable[[Room], None], technique: str) -> None:
    for depth in (3, -1):
        rho = walls(technique, depth)
        got = estimate(room_of(shape, rho, mirror=True), 64, technique=technique, max_depth=depth)
        assert got.p(seen(depth, rho)) > EACH, got


@pytest.mark.parametrize("technique", TECHNIQUES)
@pytest.mark.parametrize("shape", SHAPES)
def test_some_light_too_much_is_seen(shape: Callable[[Room], None], technique: str) -> None:
    """A percent, or three by techniques that aim at lights as large as these and little else."""
    glow = 1.03 if technique in ("light", "mixture") else 1.01
    got = estimate(room_of(shape, RHO, glow=glow), 64, technique=technique, max_depth=5)
    assert got.p(seen(5, RHO)) < EACH, got


@pytest.mark.parametrize("shape", SHAPES)
def test_scattered_paths_without_roulette_see_it_without_any_noise(shape: Callable[[Room], None]) -> None:
    for depth in (1, 2, 7, 60):
        got = estimate(room_of(shape, RHO), 4, technique="bsdf", roulette="none", max_depth=depth)
        assert np.abs(got.least / seen(depth, RHO) - 1).max() < 1e-6
        assert np.abs(got.most / seen(depth, RHO) - 1).max() < 1e-6


@pytest.mark.parametrize("heuristic", ["balance", "power"])
@pytest.mark.parametrize("lights", ["uniform", "power", "tree"])
def test_every_heuristic_and_choice_of_lights_is_unbiased(heuristic: str, lights: str) -> None:
    """In a room with one wall brighter than the others."""
    rho = np.array([0.3, 0.5, 0.7])
    for shape in (rectangles, dome):
        scene = room_of(shape, rho, mirror=True)
        got = estimate(scene, 64, heuristic=heuristic, lights=lights, roulette_depth=1)
        assert got.p(seen(-1, rho)) > EACH, got


@pytest.mark.parametrize("roulette", ["none", "constant", "albedo", "throughput"])
def test_roulette_changes_no_expectation(roulette: str) -> None:
    """A constant of 0.95 keeps the variance finite: the square of the albedo is below it."""
    rho = np.array([0.9, 0.7, 0.8])
    for shape, mirror in ((rectangles, False), (dome, True)):
        scene = room_of(shape, rho, mirror)
        got = estimate(scene, 16, roulette=roulette, survival=0.95, roulette_depth=2, max_depth=120)
        assert got.p(seen(120, rho)) > EACH, got
        assert got.p(seen(9, rho)) < EACH, "the twin: paths cut where a roulette would end most"


def test_errors_fall_with_the_square_root_of_the_samples_for_bright_walls() -> None:
    """With roulette capped below 1, as many renderers have it, the variance at rho = 0.99 is infinite (case T2).

    An F-test of the errors of 64 means each, at 0.1 %, that the variance of four times the samples is a quarter.
    """
    scene = room_of(cube, np.full(3, 0.99), side=8)
    errors = {
        spp: np.array([render(scene, spp, seed, technique="bsdf")["mean"].mean() - 1.0 for seed in range(64)])
        for spp in (1, 4)
    }
    for values in errors.values():
        assert abs(values.mean()) < 3.3 * values.std() / 8
    ratio = (errors[1] ** 2).mean() / (errors[4] ** 2).mean()
    low, high = stats.f.ppf([0.0005, 0.9995], 64, 64)
    assert low < ratio / 4 < high


def test_a_closed_mirror_room_is_a_geometric_series() -> None:
    """A small lamp in a box of mirrors of rho = 0.999 (case T6): here the walls glow, and L = 1 for each path."""
    rho = np.full(3, 0.999)
    builder = _core.SceneBuilder()
    mirror = builder.add_bsdf("conductor", [0] * 3, [1] * 3, rho)
    for matrix in sides():
        builder.add_rectangle(matrix, flip_normals=False, front=mirror, back=None, radiance=1 - rho)
    builder.set_perspective(looking(EYE, TARGET), 60.0)
    builder.set_film(4, 4, (0, 0, 4, 4), "box", 0.5)
    scene = builder.build()
    for technique in TECHNIQUES:
        got = estimate(scene, 2, technique=technique, roulette="none", max_depth=3000)
        assert np.abs(got.mean - (1 - rho**3000)).max() < 1e-4
