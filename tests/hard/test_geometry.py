"""Hard cases of geometry (G of the table in README.md): gaps, places far away, bad triangles, edges and corners.

Each test has its twin beside it: the bad formula, or the fix undone, which the same mark rejects.
"""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

import equaltime as et
from equaltime import _core
from equaltime._core import parts
from equaltime.hardcases.cases import scenes_folder

from ..statistical.worlds import affine, build, looking, octahedron, render

Array = NDArray[np.float64]
HARD = scenes_folder() / "hard"


@pytest.mark.parametrize("gap", [1e-3, 1e-4, 1e-5, 1e-6, 2e-7])
def test_G02_a_ball_is_seen_through_a_shell_that_hardly_clears_it(gap: float) -> None:  # noqa: N802
    """Scattered rays alone have no noise here: a single path that misses the ball, or is caught between, is seen.

    Of the rays that the ball scatters, the shell reflects all below its critical angle, 2 in 100,000. The seed is one
    where there is none.

    The mark is 1e-6. At 1e-7, the spacing of float32 numbers at the ball's radius, the two are one surface, and the
    ball is lost.
    """
    scene = et.load(HARD / "shell.toml", shell=1.0 + gap)
    image = et.render(scene, spp=32, seed=1, strategy="bsdf,roulette=none").image
    assert np.abs(image / 0.5 - 1.0).max() < 2e-6


def test_G02_a_start_moved_by_a_ten_thousandth_is_behind_the_ball() -> None:  # noqa: N802
    """The twin: with an absolute offset, the next surface that is met is the ball's far side, from within."""
    scene = et.load(HARD / "shell.toml", shell=1.0 + 1e-5).core
    start, down = np.array([[0.0, 0.0, 1.0 + 1e-5]]), np.array([[0.0, 0.0, -1.0]])
    near, far = (scene.intersect(start + offset * down, down)["t"][0] for offset in (2e-7, 1e-4))
    assert near < 1e-4
    assert far > 1.9


def squares(place: float) -> _core.Scene:
    """Return two triangles over a third, all written down so far away."""
    corners = np.array([[-1.3, -1, 0], [1.1, -1.2, 0.1], [0.2, 1.4, -0.1]])
    faces = np.array([[0, 1, 2]], dtype=np.uint32)

    def add(b: _core.SceneBuilder) -> None:
        grey = b.add_bsdf("diffuse", [0.5, 0.4, 0.3])
        b.add_mesh(corners + place, faces, front=grey, back=grey, radiance=None)
        b.add_mesh(0.3 * corners + [0, 0, 0.4] + place, faces, front=grey, back=grey, radiance=None)
        b.add_constant_environment([1, 1, 1])

    eye = np.array([0.3, -2.0, 1.5])
    camera = looking(eye, [0, 0, 0])
    camera[:3, 3] += place
    return build(add, camera=camera, size=(16, 16))


def test_G04_a_scene_a_million_away_looks_as_it_does_here() -> None:  # noqa: N802
    """Its numbers have 33 bits less behind the point in float64: of a pixel, some 1e-7 may change, and single paths."""
    near, far = (render(squares(place), 64)["mean"][0] for place in (0.0, 1e6))
    assert np.abs(near - far).mean() < 1e-4
    twin = render(squares(1e9), 64)["mean"][0]
    assert np.abs(near - twin).mean() < 1e-4, "float64 has room for more"


def test_G04_in_single_precision_it_would_be_another_scene() -> None:  # noqa: N802
    """The twin: vertices a million away, rounded to float32, are a sixteenth apart."""
    corners = np.array([[-1.3, -1, 0], [1.1, -1.2, 0.1], [0.2, 1.4, -0.1]]) + 1e6
    assert np.abs(corners.astype(np.float32).astype(np.float64) - corners).max() > 0.02


def ball(bad: bool, front: int, builder: _core.SceneBuilder) -> None:
    vertices, faces = octahedron(2)
    if bad:
        repeated = np.array([[0, 0, 1], [2, 2, 2], [3, 5, 3]] * 3, dtype=np.uint32)
        faces = np.concatenate([repeated[:4], faces, repeated[4:]])
    builder.add_mesh(vertices, faces, front=front, back=None, radiance=None)
    builder.add_mesh(vertices + np.array([3, 0, 0]), faces, front=None, back=None, radiance=[2, 3, 4])


def lit_ball(bad: bool) -> _core.Scene:
    """Return a ball that shines and one that does not, seven in a hundred of whose triangles may be bad."""

    def add(b: _core.SceneBuilder) -> None:
        ball(bad, b.add_bsdf("diffuse", [0.5, 0.5, 0.5]), b)
        b.add_constant_environment([1, 1, 1])

    return build(add, camera=looking([2, 3, 4], [0, 0, 0]), size=(16, 16))


@pytest.mark.parametrize("lights", ["power", "tree"])
def test_G08_triangles_without_area_change_nothing(lights: str) -> None:  # noqa: N802
    clean, dirty = lit_ball(bad=False), lit_ball(bad=True)
    assert dirty.dropped_triangles == 18
    assert clean.dropped_triangles == 0
    assert dirty.lights == clean.lights
    assert render(clean, 8, lights=lights).tobytes() == render(dirty, 8, lights=lights).tobytes()


def test_G08_kept_they_would_have_no_normal() -> None:  # noqa: N802
    """The twin: the textbook's normal of the same triangles."""
    a, b, c = np.array([[0, 0, 0], [1, 1, 1], [1, 1, 1]], dtype=float)
    n = np.cross(b - a, c - a)
    with np.errstate(invalid="ignore"):
        assert np.isnan(n / np.linalg.norm(n)).all()


def coincident(first: float, second: float) -> _core.Scene:
    def add(b: _core.SceneBuilder) -> None:
        for rho in (first, second):
            b.add_rectangle(
                affine(*np.eye(3)), flip_normals=False, front=b.add_bsdf("diffuse", [rho] * 3), back=None, radiance=None
            )
        b.add_constant_environment([1, 1, 1])

    return build(add, camera=looking([1, 2, 4], [0, 0, 0]), fov=20, size=(16, 16))


def test_G10_of_two_squares_in_one_place_the_same_is_met_by_any_number_of_threads() -> None:  # noqa: N802
    scene = coincident(0.2, 0.8)
    images = [render(scene, 8, threads=threads, tile=tile) for threads, tile in ((1, 16), (2, 5), (3, 16))]
    assert all(image.tobytes() == images[0].tobytes() for image in images)
    other = render(coincident(0.8, 0.2), 8)
    assert other.tobytes() != images[0].tobytes(), "the twin: which is met is seen"


def test_G10_each_build_of_a_scene_meets_the_same_of_thousands_in_one_place() -> None:  # noqa: N802
    """Builds are made by several threads, whose order is never the same."""
    vertices, faces = octahedron(5)

    def add(b: _core.SceneBuilder) -> None:
        for rho in (0.2, 0.8):
            b.add_mesh(vertices, faces, front=b.add_bsdf("diffuse", [rho] * 3), back=None, radiance=None)
        b.add_constant_environment([1, 1, 1])

    camera = looking([1, 2, 4], [0, 0, 0])
    images = {render(build(add, camera=camera, fov=20, size=(64, 64)), 1).tobytes() for _ in range(8)}
    assert len(images) == 1


def inside(intersection: str) -> tuple[_core.Scene, Array, Array]:
    """Return a closed mesh turned out of all axes, its corners, and the middles of its edges."""
    vertices, faces = octahedron(4)
    turn = np.linalg.qr(np.random.default_rng(7).normal(size=(3, 3)))[0]
    vertices = vertices @ turn.T
    builder = _core.SceneBuilder()
    builder.add_mesh(vertices, faces, front=None, back=None, radiance=None)
    builder.set_perspective(affine(*np.eye(3)), 40.0)
    builder.set_film(1, 1, (0, 0, 1, 1), "box", 0.5)
    edges = np.unique(np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1), axis=0)
    t = np.random.default_rng(8).uniform(0.05, 0.95, (len(edges), 1))
    return builder.build(intersection), vertices, t * vertices[edges[:, 0]] + (1 - t) * vertices[edges[:, 1]]  # type: ignore[arg-type]


def escapes(scene: _core.Scene, targets: Array, origins: int = 40) -> tuple[int, int]:
    """Return how many rays from within towards the targets leave the mesh, and how many there were."""
    rng = np.random.default_rng(9)
    lost = 0
    for _ in range(origins):
        origin = rng.uniform(-0.4, 0.4, 3)
        start = np.broadcast_to(origin, targets.shape)
        lost += int(np.isinf(scene.intersect(start, targets - origin)["t"]).sum())
    return lost, origins * len(targets)


def test_G11_no_ray_escapes_between_two_triangles() -> None:  # noqa: N802
    scene, _, edges = inside("robust")
    lost, rays = escapes(scene, edges)
    assert rays > 100_000
    assert lost == 0


def test_G11_by_the_fast_test_of_triangles_rays_do_escape() -> None:  # noqa: N802
    """The twin."""
    scene, _, edges = inside("fast")
    assert escapes(scene, edges)[0] > 0


@pytest.mark.slow
def test_G11_of_ten_million_rays_none_escapes() -> None:  # noqa: N802
    """The mesh is black inside, and the sky outside is not."""

    def black(chink: bool) -> float:
        vertices, faces = octahedron(4)
        turn = np.linalg.qr(np.random.default_rng(7).normal(size=(3, 3)))[0]

        def add(b: _core.SceneBuilder) -> None:
            b.add_mesh(vertices @ turn.T, faces[chink:], front=None, back=None, radiance=None)
            b.add_constant_environment([1, 1, 1])

        camera = looking([0.1, 0.2, -0.3], vertices[faces[0]].mean(axis=0) @ turn.T)
        scene = build(add, camera=camera, fov=150, size=(100, 100))
        return float(render(scene, 1000, technique="bsdf", max_depth=1)["mean"].max())

    assert black(chink=False) == 0.0
    assert black(chink=True) > 0.0, "the twin: one triangle of 2048 is missing"


def test_G12_at_a_corner_of_many_triangles_a_ray_in_a_thousand_may_escape() -> None:  # noqa: N802
    """Aimed exactly at a corner, which no sampled ray is: Embree's robust test is watertight along edges alone.

    The signs of the edges round a corner are rounded one by one, so that all may turn alike: then no triangle of the
    fan holds the ray (embree #174, #181, #381). What a second look would find again, the wall behind hides.
    """
    scene, corners, _ = inside("robust")
    lost, rays = escapes(scene, corners)
    print(f"{lost} of {rays} rays at corners escape")
    assert lost <= rays * 1e-3
    fast, _ = escapes(inside("fast")[0], corners)
    assert fast > 5 * lost, "the twin"


def test_G12_rays_at_nothing_in_particular_do_not_escape() -> None:  # noqa: N802
    scene, _, _ = inside("robust")
    rng = np.random.default_rng(11)
    assert escapes(scene, rng.normal(size=(20_000, 3)), 20)[0] == 0
    near = inside("robust")[1]
    jittered = near + rng.normal(size=near.shape) * 1e-6
    lost, rays = escapes(scene, jittered)
    print(f"{lost} of {rays} rays a millionth beside a corner escape")
    assert lost == 0


def test_G14_a_wall_that_is_lit_from_behind_is_black_however_its_normals_are_bent() -> None:  # noqa: N802
    corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], dtype=float)
    faces = np.array([[0, 1, 2], [0, 2, 3]], dtype=np.uint32)
    bent = np.array([[0.9, 0, 0.436], [-0.9, 0, 0.436], [0, 0.9, 0.436], [0, -0.9, 0.436]])

    def seen(lamp: float, technique: str) -> float:
        def add(b: _core.SceneBuilder) -> None:
            grey = b.add_bsdf("diffuse", [0.5, 0.5, 0.5])
            b.add_mesh(corners, faces, bent, front=grey, back=grey, radiance=None)
            b.add_sphere([0.8, 0.3, lamp], 0.3, flip_normals=False, front=None, back=None, radiance=[9, 9, 9])

        scene = build(add, camera=looking([-0.5, 0.2, 3], [0, 0, 0]), fov=20, size=(8, 8))
        return float(render(scene, 64, technique=technique)["mean"].max())

    for technique in ("bsdf", "light", "mis", "mixture"):
        assert seen(-0.6, technique) == 0.0
        assert seen(0.6, technique) > 0.1, "the twin: the lamp before the wall"
    to_lamp = np.array([0.8, 0.3, -0.6]) - corners
    assert ((to_lamp * bent).sum(axis=1) > 0).any(), "the twin: by the bent normals alone, it would be before it"


def test_G16_the_shadow_on_wide_ground_is_that_on_narrow_ground() -> None:  # noqa: N802
    """A z-test at 5 standard errors: once in 1.7 million seeds."""
    images = {
        half: np.array(
            [et.render(et.load(HARD / "stadium.toml", half_width=half), spp=64, seed=s).image for s in range(8)]
        )
        for half in (1e1, 1e6)
    }
    means = {half: stack.mean(axis=(1, 2, 3)) for half, stack in images.items()}
    error = np.sqrt(sum(m.var(ddof=1) / len(m) for m in means.values()))
    assert abs(means[1e1].mean() - means[1e6].mean()) < 5 * error
    assert abs(means[1e1].mean() - 1.02 * means[1e6].mean()) > 5 * error, "the twin: two per cent"
    assert np.spacing(np.float32(1e6)) > 1e-3, "the twin: an offset by the ground's coordinates spans the disk"


DIRECTIONS = [
    [x, y, z] for x in (0.0, -0.0, 1e-40, -1e-310) for y in (0.0, -0.0, 1e-42) for z in (1.0, -1.0)
]  # along an axis, but for signs of zeros and numbers that float32 cannot or hardly hold


def test_G19_rays_along_an_axis_meet_the_faces_of_a_box() -> None:  # noqa: N802
    def add(b: _core.SceneBuilder) -> None:
        for sign in (1.0, -1.0):
            axes = affine([1, 0, 0], [0, sign, 0], [0, 0, sign], [0, 0, sign])
            b.add_rectangle(axes, flip_normals=False, front=None, back=None, radiance=None)

    scene = build(add, eye=[0, 0, 0.5])
    for roll in range(3):
        directions = np.array(DIRECTIONS)
        origins = np.tile([0.25, 1.0 if roll == 1 else -0.5, 0.0], (len(directions), 1))
        parts.take_faults()
        hits = scene.intersect(origins, directions)
        assert parts.take_faults() == ""
        np.testing.assert_array_equal(hits["t"], 1.0)
        np.testing.assert_array_equal(hits["p"][:, 2], directions[:, 2])


def test_G19_the_textbook_s_slabs_know_nothing_of_such_rays() -> None:  # noqa: N802
    """The twin: a ray in the plane of a slab's face, along it."""
    with np.errstate(divide="ignore", invalid="ignore"):
        assert np.isnan((np.float32(1.0) - np.float32(1.0)) / np.float32(0.0))
