"""Lamps that lie in a surface: they are before it, on the side to which they emit, and all techniques see them there.

A statement that holds is rejected with a probability of 1e-4 a test, with fixed seeds.
"""

from __future__ import annotations

import time

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray

from equaltime import _core

from ..statistical.worlds import Add, Estimate, affine, build, estimate, looking, turned

Array = NDArray[np.float64]
LEVEL = 1e-4
RADIANCE = [1.0, 2.0, 4.0]
ASKEW = turned((1, 2, 3), 40.0)


def placed(matrix: Array) -> Array:
    """The same place in a frame in which no number is round."""
    frame = np.eye(4)
    frame[:3, :3] = ASKEW
    return frame @ matrix


def moved(x: float = 0.0, y: float = 0.0, z: float = 0.0, size: float = 1.0) -> Array:
    return placed(affine(*(size * np.eye(3)), (x, y, z)))


def rectangle(matrix: Array, radiance: ArrayLike | None = None, *, flip: bool = False, both: bool = True) -> Add:
    def add(b: _core.SceneBuilder) -> None:
        grey = b.add_bsdf("diffuse", [0.5] * 3)
        glow = None if radiance is None else np.asarray(radiance).tolist()
        b.add_rectangle(matrix, flip_normals=flip, front=grey, back=grey if both else None, radiance=glow)

    return add


def disk(matrix: Array, radiance: ArrayLike | None = None) -> Add:
    def add(b: _core.SceneBuilder) -> None:
        grey = b.add_bsdf("diffuse", [0.5] * 3)
        glow = None if radiance is None else np.asarray(radiance).tolist()
        b.add_disk(matrix, flip_normals=False, front=grey, back=grey, radiance=glow)

    return add


def mesh(matrix: Array, radiance: ArrayLike | None = None) -> Add:
    """Eight triangles, whose edges are not those of a rectangle."""
    ring = np.array([[np.cos(t), np.sin(t), 0.0] for t in np.arange(8) * np.pi / 4])
    vertices = np.concatenate([[[0.0, 0.0, 0.0]], ring]) @ matrix[:3, :3].T + matrix[:3, 3]
    faces = np.array([[0, 1 + k, 1 + (k + 1) % 8] for k in range(8)], dtype=np.uint32)

    def add(b: _core.SceneBuilder) -> None:
        grey = b.add_bsdf("diffuse", [0.5] * 3)
        glow = None if radiance is None else np.asarray(radiance).tolist()
        b.add_mesh(vertices, faces, front=grey, back=grey, radiance=glow)

    return add


def instance(matrix: Array) -> Add:
    """The wall as an instance, added last: shapes of a group come after all others."""

    def add(b: _core.SceneBuilder) -> None:
        grey = b.add_bsdf("diffuse", [0.5] * 3)
        wall = b.add_rectangle(np.eye(4), flip_normals=False, front=grey, back=grey, radiance=None)
        b.add_instance(b.add_group(wall), matrix)

    return add


def sliding(radiance: ArrayLike | None = None, size: float = 1.0, turn: float = 30.0) -> Add:
    """A square that slides and turns in its plane; at rest in the frame of its group it is smaller and mirrored."""
    way = [moved(x=-0.25, size=size), moved(x=0.25, y=0.1, size=size)]
    way[1][:3, :2] = way[1][:3, :2] @ turned((0, 0, 1), turn)[:2, :2]
    scale = np.diag([0.1, 0.1, -0.1, 1.0])
    inner = np.linalg.inv(scale)

    def add(b: _core.SceneBuilder) -> None:
        grey = b.add_bsdf("diffuse", [0.5] * 3)
        glow = None if radiance is None else np.asarray(radiance).tolist()
        square = b.add_rectangle(scale, flip_normals=False, front=grey, back=grey, radiance=glow)
        b.add_moving_instance(b.add_group(square), [0.0, 1.0], [matrix @ inner for matrix in way])

    return add


def sphere(center: ArrayLike, radius: float, radiance: ArrayLike | None = None) -> Add:
    def add(b: _core.SceneBuilder) -> None:
        grey = b.add_bsdf("diffuse", [0.5] * 3)
        glow = None if radiance is None else np.asarray(radiance).tolist()
        b.add_sphere(np.asarray(center).tolist(), radius, flip_normals=False, front=grey, back=grey, radiance=glow)

    return add


def tube(radiance: ArrayLike | None = None) -> Add:
    base, end = (ASKEW @ [x, 0.0, -1.0] for x in (-1.0, 1.0))

    def add(b: _core.SceneBuilder) -> None:
        grey = b.add_bsdf("diffuse", [0.5] * 3)
        glow = None if radiance is None else np.asarray(radiance).tolist()
        b.add_cylinder(base.tolist(), end.tolist(), 0.9, flip_normals=False, front=grey, back=grey, radiance=glow)

    return add


def floor(b: _core.SceneBuilder) -> None:
    white = b.add_bsdf("diffuse", [1.0] * 3)
    up = affine((10, 0, 0), (0, 0, -10), (0, 10, 0), (0.0, -1.2, 0.0))
    b.add_rectangle(placed(up), flip_normals=False, front=white, back=white, radiance=None)


TILT = np.eye(4)
TILT[:3, :3] = turned((1, 1, 0), 1e-6)
LAMP = rectangle(moved(), RADIANCE)
ALONE: dict[str, tuple[Add, Add]] = {
    "a wall of its size": (rectangle(moved()), LAMP),
    "a wide wall": (rectangle(moved(size=3.0)), LAMP),
    "a wall that covers half of it": (rectangle(moved(x=1.0)), LAMP),
    "a wall that is turned a little": (rectangle(placed(TILT)), LAMP),
    "a wall before it by rounding": (rectangle(moved(z=1e-8)), LAMP),
    "a wall that faces the other way": (rectangle(moved(), flip=True), LAMP),
    "a wall of one side": (rectangle(moved(), both=False), LAMP),
    "a disk": (disk(moved()), LAMP),
    "a mesh": (mesh(moved(size=2.0)), LAMP),
    "an instance": (instance(moved(size=2.0)), LAMP),
    "a disk on a wall": (rectangle(moved(size=2.0)), disk(moved(), RADIANCE)),
    "a mesh on a mesh": (mesh(moved(size=2.0)), mesh(moved(), RADIANCE)),
    "a mesh on the same mesh": (mesh(moved()), mesh(moved(), RADIANCE)),
    "a lamp that slides in a wall": (rectangle(moved(size=2.0)), sliding(RADIANCE)),
    "a wall that slides round a lamp": (sliding(size=2.0), LAMP),
    "a lamp that slides in what slides": (sliding(size=2.0, turn=-40.0), sliding(RADIANCE)),
    "a ball in a ball": (sphere(ASKEW @ [0.0, 0.0, -1.0], 1.0), sphere(ASKEW @ [0.0, 0.0, -1.0], 1.0, RADIANCE)),
    "a tube in a tube": (tube(), tube(RADIANCE)),
}
"""What each lamp lies in, and the lamp."""


def lit(*parts: Add, spp: int = 4096, **settings: object) -> Estimate:
    """A place of the floor by direct light."""
    camera = placed(looking((0.0, 0.5, 2.5), (0.0, -1.2, 0.8), (0.0, 1.0, 0.0)))
    return estimate(build(*parts, floor, camera=camera, fov=1.0, size=(8, 8)), spp, max_depth=2, **settings)


def seen(*parts: Add) -> Estimate:
    """The lamp itself."""
    camera = placed(looking((0.1, 0.2, 4.0), (0.1, 0.2, 0.0), (0.0, 1.0, 0.0)))
    return estimate(build(*parts, floor, camera=camera, fov=5.0, size=(8, 8)), 16, max_depth=1)


@pytest.mark.parametrize("order", [1, -1])
@pytest.mark.parametrize("name", ALONE)
def test_a_lamp_in_a_surface_is_seen(name: str, order: int) -> None:
    found = seen(*ALONE[name][::order])
    np.testing.assert_allclose([found.least, found.most], [RADIANCE, RADIANCE], rtol=1e-6)


@pytest.mark.parametrize("order", [1, -1])
@pytest.mark.parametrize("name", ALONE)
@pytest.mark.parametrize("technique", ["bsdf", "light", "mis", "mixture"])
def test_a_lamp_in_a_surface_lights_as_one_alone(name: str, order: int, technique: str) -> None:
    wall, lamp = ALONE[name]
    truth = lit(lamp, technique="mis", seed=2)
    found = lit(*(wall, lamp)[::order], technique=technique)
    both = Estimate(found.mean, np.hypot(found.error, truth.error), found.least, found.most)
    assert both.p(truth.mean) > LEVEL, (found, truth)
    assert both.p(0.9 * truth.mean) < LEVEL, "the twin: where a tenth of it is hidden"


def test_of_two_lamps_in_one_place_the_later_is_seen_and_lights() -> None:
    other = rectangle(moved(), [4.0, 2.0, 1.0])
    for pair, radiance in (((LAMP, other), [4.0, 2.0, 1.0]), ((other, LAMP), RADIANCE)):
        np.testing.assert_allclose(seen(*pair).most, radiance, rtol=1e-6)
        truth = lit(pair[1], seed=2)
        for technique in ("bsdf", "light", "mis"):
            found = lit(*pair, technique=technique)
            both = Estimate(found.mean, np.hypot(found.error, truth.error), found.least, found.most)
            assert both.p(truth.mean) > LEVEL, (technique, found, truth)


def test_two_lamps_back_to_back_are_each_seen_from_their_side() -> None:
    back = rectangle(moved(), [4.0, 2.0, 1.0], flip=True)
    np.testing.assert_allclose(seen(LAMP, back).least, RADIANCE, rtol=1e-6)
    behind = placed(looking((0.1, 0.2, -4.0), (0.1, 0.2, 0.0), (0.0, 1.0, 0.0)))
    found = estimate(build(LAMP, back, camera=behind, fov=5.0, size=(8, 8)), 16, max_depth=1)
    np.testing.assert_allclose(found.least, [4.0, 2.0, 1.0], rtol=1e-6)


def test_a_mesh_that_emits_twice_from_one_place_is_refused() -> None:
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], dtype=float)
    b = _core.SceneBuilder()
    b.add_mesh(vertices, np.array([[0, 1, 2], [0, 1, 2]], dtype=np.uint32), front=None, back=None, radiance=RADIANCE)
    with pytest.raises(ValueError, match=r"shape 0: its triangles \d and \d emit from one place"):
        b.build()


def test_hundreds_of_lamps_in_one_place_are_refused() -> None:
    with pytest.raises(ValueError, match=r"shape \d+: too many emitters lie in one place"):
        build(*[LAMP] * 300)
    build(*[LAMP] * 20)


def height_of_the_lamp(*walls: Add) -> float:
    """Where a ray from the back meets the lamp, which is described first."""
    scene = build(LAMP, *walls)
    origin, up = ASKEW @ [0.1, 0.2, -4.0], ASKEW @ [0.0, 0.0, 1.0]
    hits = scene.intersect(origin[None, :], up[None, :])
    assert hits["shape"][0] == 0
    return float(hits["t"][0]) - 4.0


def test_lamps_that_lie_in_no_surface_stay_where_they_are() -> None:
    """Before a wall at some distance, behind one, and in a hole that is as large as the lamp, edge to edge."""
    around = [rectangle(moved(x, y)) for x in (-2.0, 0.0, 2.0) for y in (-2.0, 0.0, 2.0) if (x, y) != (0.0, 0.0)]
    for walls in ([rectangle(moved(z=-1e-4, x=1.5))], [rectangle(moved(z=1e-4))], around):
        assert height_of_the_lamp(*walls) == pytest.approx(0.0, abs=1e-6)


def test_a_lamp_in_a_wall_moves_by_millionths_of_the_scene() -> None:
    assert 1e-6 < height_of_the_lamp(rectangle(moved(x=1.5))) < 3e-5


def test_many_lamps_and_many_triangles_take_no_longer_than_their_sum() -> None:
    """Each lamp against each triangle would be 4e10 pairs: minutes."""
    side = 450
    x, y = np.meshgrid(np.arange(side, dtype=float), np.arange(side, dtype=float))
    vertices = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    corner = (np.arange(side - 1)[:, None] * side + np.arange(side - 1)[None, :]).ravel()
    faces = np.concatenate([corner[:, None] + [0, 1, side], corner[:, None] + [1, side + 1, side]]).astype(np.uint32)
    b = _core.SceneBuilder()
    b.add_mesh(vertices, faces, front=None, back=None, radiance=None)
    b.add_mesh(vertices, faces, front=None, back=None, radiance=[1.0] * 3)
    begin = time.process_time()
    b.build()
    assert time.process_time() - begin < 20.0
