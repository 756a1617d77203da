"""A camera a million times as far away as the scene is large sees what stands behind each pixel (G5)."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

import equaltime as et
from equaltime import _core

from ..statistical.worlds import affine, build, looking, render

Array = NDArray[np.float64]
TILES, PIXELS = 8, 4
DISTANCES = [1e0, 1e2, 1e4, 1e6]
VIEW = np.array([0.48, -0.6, 0.64])
"""Where the camera looks, unit: along no axis."""
FRAME = looking((0.0, 0.0, 0.0), VIEW)


def radiance(row: int, column: int) -> tuple[float, float, float]:
    return (row + 1.0, column + 1.0, 1.0)


EXPECTED = np.array([[radiance(i, j) for j in range(TILES)] for i in range(TILES)])


def place(row: int, column: int) -> Array:
    """The middle of a tile; rows go down the picture, columns to the right, which is -x of the camera."""
    x, y = (TILES - 1) / 2.0 - column, (TILES - 1) / 2.0 - row
    return (x * FRAME[:3, 0] + y * FRAME[:3, 1]) / TILES


def add_rectangle(builder: _core.SceneBuilder, row: int, column: int) -> None:
    half = FRAME[:3, :3] * 0.5 / TILES
    to_world = affine(half[:, 0], half[:, 1], half[:, 2], place(row, column))
    builder.add_rectangle(to_world, flip_normals=True, front=None, back=None, radiance=radiance(row, column))


def add_disk(builder: _core.SceneBuilder, row: int, column: int) -> None:
    half = FRAME[:3, :3] * 0.5 / TILES
    to_world = affine(half[:, 0], half[:, 1], half[:, 2], place(row, column))
    builder.add_disk(to_world, flip_normals=True, front=None, back=None, radiance=radiance(row, column))


def add_ball(builder: _core.SceneBuilder, row: int, column: int) -> None:
    builder.add_sphere(
        place(row, column), 0.5 / TILES, flip_normals=False, front=None, back=None, radiance=radiance(row, column)
    )


KINDS = {"rectangles": add_rectangle, "disks": add_disk, "balls": add_ball}


def tiles(kind: str, distance: float) -> _core.Scene:
    """Return a board one wide that fills the picture of a camera so far from its middle."""
    camera = FRAME.copy()
    camera[:3, 3] = -distance * VIEW
    return build(
        *(lambda b, i=i, j=j: KINDS[kind](b, i, j) for i in range(TILES) for j in range(TILES)),
        camera=camera,
        fov=2.0 * np.degrees(np.arctan(0.5 / distance)),
        size=(TILES * PIXELS, TILES * PIXELS),
    )


def inner(image: Array) -> Array:
    """Return the pixels that do not touch the edge of a tile: (row, y, column, x, channel)."""
    cut: Array = image.reshape(TILES, PIXELS, TILES, PIXELS, 3)[:, 1:-1, :, 1:-1]
    return cut


@pytest.mark.parametrize("distance", DISTANCES)
@pytest.mark.parametrize("kind", KINDS)
def test_each_pixel_shows_its_tile(kind: str, distance: float) -> None:
    image = render(tiles(kind, distance), 16, max_depth=1)["mean"][0]
    seen = inner(image)
    if kind == "balls" and distance < 10:  # in perspective, balls off the middle are seen a little aside
        seen = seen[2:-2, :, 2:-2]
        np.testing.assert_allclose(seen, np.broadcast_to(EXPECTED[2:-2, None, 2:-2, None], seen.shape), rtol=1e-6)
    else:
        np.testing.assert_allclose(seen, np.broadcast_to(EXPECTED[:, None, :, None], seen.shape), rtol=1e-6)


@pytest.mark.parametrize("distance", DISTANCES)
def test_edges_cut_pixels_where_they_should(distance: float) -> None:
    """Tiles end on pixel borders: but for the rounding of directions, no pixel sees its neighbour's tile."""
    image = render(tiles("rectangles", distance), 64, max_depth=1)["mean"][0].reshape(TILES, PIXELS, TILES, PIXELS, 3)
    np.testing.assert_allclose(image, np.broadcast_to(EXPECTED[:, None, :, None], image.shape), rtol=1e-6)


def test_single_precision_at_the_camera_would_see_other_tiles() -> None:
    """The power twin: rays that are rounded where they start, a million away, miss most tiles' middles."""
    scene, eye = tiles("rectangles", 1e6), -1e6 * VIEW
    targets = np.array([place(i, j) for i in range(TILES) for j in range(TILES)])
    hits = scene.intersect(np.broadcast_to(eye, targets.shape), targets - eye)
    assert (hits["shape"] != np.arange(TILES**2)).mean() > 0.2


@pytest.mark.parametrize("size", [1e-13, 1e-14, 1e-16, 1e-20, 1e-30])
def test_a_camera_too_far_for_float64_is_refused_and_crashes_nothing(size: float) -> None:
    """The camera is 4 away: a cube of 1e-13 still renders, smaller ones are told to be too small."""
    view = {"look_at": {"origin": (0, 0, 4), "target": (0, 0, 0), "up": (0, 1, 0)}}
    film = {"type": "hdrfilm", "width": 8, "height": 8, "rfilter": {"type": "box"}}
    camera = {"type": "perspective", "fov": 45, "to_world": [view], "film": film}
    cube = {"type": "cube", "to_world": [{"scale": size}]}
    scene = et.load_dict({"type": "scene", "camera": camera, "cube": cube, "sky": {"type": "constant"}})
    if size >= 1e-13:
        assert et.render(scene, spp=4).image.mean() == 1.0
    else:
        with pytest.raises(et.SceneError, match="so far from the geometry"):
            et.render(scene, spp=4)
