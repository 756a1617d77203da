"""Near and far, small and large, here and elsewhere: hit points, brightness and files (G4, G5, G6).

Each has its twin beside it: the usual formula in single precision, which the same mark rejects.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import equaltime as et
from equaltime import _core

from ..statistical.worlds import affine, build, looking, render, turned
from .exact import meet_plane, meet_sphere, roundings, textbook_sphere, traced

Array = NDArray[np.float64]
F = np.float32
AWAY = np.array([0.48, -0.6, 0.64])
"""Unit."""
TURN = turned([1, -2, 0.5], 50)
RATIOS = [1e-6, 1e-4, 1e-2, 0.5, 2.0, 1e2, 1e4, 1e6]
"""Radius over distance of the centre."""
GAPS = [1e-6, 1e-4, 1e-2]
"""Distance from the surface over radius."""
RAYS = 200


def rays_at(center: Array, radius: float) -> tuple[Array, Array]:
    """Return directions from the origin to places well within an outline; and as the core traces them."""
    rng = np.random.default_rng(4)
    spread = rng.normal(size=(RAYS, 3))
    spread *= 0.6 * rng.random((RAYS, 1)) / np.linalg.norm(spread, axis=1, keepdims=True)
    directions = center + radius * spread
    return directions, traced(directions)


def balls() -> list[tuple[Array, float]]:
    """Return centres and radii, of balls that the origin is outside, inside, and hardly outside of."""
    return [(AWAY, ratio) for ratio in RATIOS] + [((1 + gap) * 1e3 * AWAY, 1e3) for gap in GAPS]


def add_behind(builder: _core.SceneBuilder) -> None:
    """Add what makes the scene reach round the camera, so that places are counted from there."""
    builder.add_sphere(-AWAY, 0.1, flip_normals=False, front=None, back=None, radiance=None)


def off_balls(found: Array, directions: Array, center: Array, radius: float) -> Array:
    exact = np.array([meet_sphere(np.zeros(3), d, center, radius) for d in directions])
    slope = ((exact - center) / radius * directions).sum(axis=1)
    return roundings(found, exact, slope, 4.0 * max(radius, 1.0))


@pytest.mark.parametrize(("center", "radius"), balls())
def test_G06_hit_points_on_balls_of_any_size_are_the_exact_ones_rounded_once(center: Array, radius: float) -> None:  # noqa: N802
    directions, unit = rays_at(center, radius)

    def add(b: _core.SceneBuilder) -> None:
        b.add_sphere(center, radius, flip_normals=False, front=None, back=None, radiance=None)

    scene = build(add, add_behind) if radius < 1 else build(add)
    hits = scene.intersect(np.zeros_like(directions), directions)
    assert (hits["shape"] == 0).all()
    assert off_balls(hits["p"], unit, center, radius).max() <= 1.0


@pytest.mark.parametrize("ratio", RATIOS)
def test_G06_hit_points_on_disks_of_any_size_are_the_exact_ones_rounded_once(ratio: float) -> None:  # noqa: N802
    directions, unit = rays_at(AWAY, min(ratio, 0.3) * abs(AWAY @ TURN[:, 2]))
    u, v = ratio * TURN[:, :2].T
    disk = affine(u, v, TURN[:, 2], AWAY)
    scene = build(lambda b: b.add_disk(disk, flip_normals=False, front=None, back=None, radiance=None), add_behind)
    hits = scene.intersect(np.zeros_like(directions), directions)
    assert (hits["shape"] == 0).all()
    exact = np.array([meet_plane(np.zeros(3), d, [AWAY, AWAY + u, AWAY + v]) for d in unit])
    assert roundings(hits["p"], exact, unit @ TURN[:, 2], 4.0 * max(ratio, 1.0)).max() <= 1.0


@pytest.mark.parametrize(("center", "radius"), [(AWAY, 1e-4), ((1 + GAPS[0]) * 1e3 * AWAY, 1e3)])
def test_G06_the_mark_sees_a_sphere_solved_in_single_precision(center: Array, radius: float) -> None:  # noqa: N802
    """The twin. Where the discriminant is lost, there is no point at all."""
    unit = rays_at(center, radius)[1]
    off = off_balls(textbook_sphere(unit, center, radius), unit, center, radius)
    assert (~(off <= 1.0)).mean() > 0.5


@pytest.mark.parametrize("distance", 10.0 ** np.arange(8))
def test_G05_ground_in_the_sun_is_as_bright_from_any_distance(distance: float) -> None:  # noqa: N802
    """A point put a little behind the ground would be in its own shadow."""
    rho, cosine = 0.5, 1 / np.sqrt(1.25)
    eye = distance * np.array([0.6, 0.0, 0.8])
    scene = build(
        lambda b: b.add_rectangle(
            np.eye(4), flip_normals=False, front=b.add_bsdf("diffuse", [rho] * 3), back=None, radiance=None
        ),
        lambda b: b.add_directional_light([0.3, -0.4, -1.0], [np.pi] * 3),
        camera=looking(eye, [0, 0, 0]),
        fov=2.0 * np.degrees(np.arctan(0.3 / distance)),
        size=(16, 16),
    )
    image = render(scene, 16)["mean"]
    assert np.abs(image / (rho * cosine) - 1).max() < 1e-5


def test_G05_in_single_precision_half_of_it_would_be_behind_itself() -> None:  # noqa: N802
    """The twin: o + t d, from cameras about 1e7 away."""
    rng = np.random.default_rng(2)
    eyes = np.array([0.6, 0.0, 0.8]) * 10.0 ** rng.uniform(6.5, 7.5, (1000, 1))
    targets = np.column_stack([rng.uniform(-0.3, 0.3, (1000, 2)), np.zeros(1000)])
    distance = np.linalg.norm(targets - eyes, axis=1, keepdims=True)
    points = eyes.astype(F) + distance.astype(F) * ((targets - eyes) / distance).astype(F)
    assert 0.2 < (points[:, 2] < -1e-3).mean() < 0.8


TRIANGLES = np.array(
    [[-1.3, -1, 0], [1.1, -1.2, 0.1], [0.2, 1.4, -0.1], [-0.4, -0.3, 0.4], [0.3, -0.4, 0.43], [0, 0.4, 0.4]]
)


def seen(kind: str, place: float, folder: Path) -> Array:
    """Return the image of a triangle over another, written to a file as far from the origin as `place` says."""
    corners = TRIANGLES + place
    path = folder / f"mesh.{'obj' if kind == 'obj' else 'ply'}"
    if kind == "obj":
        lines = [*(f"v {x!r} {y!r} {z!r}" for x, y, z in corners.tolist()), "f 1 2 3", "f 4 5 6"]
        path.write_text("\n".join(lines) + "\n")
    else:
        axes = "".join(f"property {kind} {axis}\n" for axis in "xyz")
        faces = "element face 2\nproperty list uchar int vertex_indices\n"
        header = f"ply\nformat binary_little_endian 1.0\nelement vertex 6\n{axes}{faces}end_header\n"
        indices = np.array([(3, 0, 1, 2), (3, 3, 4, 5)], dtype="u1,<i4,<i4,<i4")
        content = corners.astype("<f8" if kind == "double" else "<f4").tobytes() + indices.tobytes()
        path.write_bytes(header.encode() + content)
    eye, target = np.array([0.3, -2.0, 1.5]) + place, np.full(3, place)
    view = {"look_at": {"origin": eye.tolist(), "target": target.tolist(), "up": [0, 0, 1]}}
    film = {"type": "hdrfilm", "width": 16, "height": 16, "rfilter": {"type": "box"}}
    grey = {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": 0.4}}
    mesh = {"type": path.suffix[1:], "filename": str(path), "bsdf": grey, "face_normals": True}
    camera = {"type": "perspective", "fov": 40, "to_world": [view], "film": film}
    scene = et.load_dict({"type": "scene", "camera": camera, "mesh": mesh, "sky": {"type": "constant"}})
    return et.render(scene, spp=64).image.astype(np.float64)


@pytest.mark.parametrize("kind", ["obj", "double"])
def test_G04_files_of_scenes_a_million_away_keep_their_digits(kind: str, tmp_path: Path) -> None:  # noqa: N802
    near, far = (seen(kind, place, tmp_path) for place in (0.0, 1e6))
    assert near.std() > 0.1
    assert np.abs(near - far).mean() < 1e-4


def test_G04_files_of_single_precision_have_none(tmp_path: Path) -> None:  # noqa: N802
    """The twin, which no reader can mend."""
    near, far = (seen("float", place, tmp_path) for place in (0.0, 1e6))
    assert np.abs(near - far).mean() > 1e-3
