"""Textures: what colour they have at a place, against NumPy in float64.

A diffuse surface under an even white sky sends back its reflectance in every sample, so that one pixel of a camera that
looks at a point through a pinhole's narrowest view is the texture there.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray

from equaltime import _core

from ..statistical.worlds import affine, build, looking, render

Array = NDArray[np.float64]
PLACES = np.random.default_rng(5).uniform(-0.999, 0.999, (12, 2))
"""Points of the square [-1, 1]²."""


def seen(surface: Callable[[_core.SceneBuilder], object], point: ArrayLike, eye: ArrayLike) -> Array:
    """Return what one pixel, of a view about 1e-4 wide, has of the surface at the point."""
    camera = looking(eye, point, up=(0.3, 0.5, 0.8))
    scene = build(surface, lambda b: b.add_constant_environment([1.0, 1.0, 1.0]), camera=camera, fov=5e-3)
    mean: Array = render(scene, 1, technique="bsdf", max_depth=2)["mean"][0, 0, 0]
    return mean


def on_square(uv: ArrayLike, **bitmap: Any) -> Array:
    """Return the colour of a bitmap at uv; the square lies at z = 0."""

    def square(b: _core.SceneBuilder) -> None:
        bsdf = b.add_bsdf("diffuse", [0.0, 0.0, 0.0])
        b.bind(bsdf, "reflectance", b.add_bitmap(**bitmap))
        b.add_rectangle(np.eye(4), flip_normals=False, front=bsdf, back=None, radiance=None)

    x, y = 2.0 * np.asarray(uv) - 1.0
    return seen(square, (x, y, 0.0), (x, y, 1.0))


def texels(height: int, width: int, channels: int = 3) -> Array:
    return np.random.default_rng(7).uniform(0.0, 1.0, (height, width, channels))


def wrapped(index: int, count: int, wrap: str) -> int:
    if wrap == "repeat":
        return index % count
    if wrap == "clamp":
        return min(max(index, 0), count - 1)
    folded = index % (2 * count)
    return folded if folded < count else 2 * count - 1 - folded


def looked_up(image: Array, place: ArrayLike, bilinear: bool, wrap: str) -> Array:
    """Return the colour of an image (H, W, C) at a place, by the indices of the texels."""
    (height, width), (u, v) = image.shape[:2], np.asarray(place, dtype=float)
    if not bilinear:
        return np.asarray(
            image[wrapped(math.floor(v * height), height, wrap), wrapped(math.floor(u * width), width, wrap)]
        )
    x, y = u * width - 0.5, v * height - 0.5
    column, row = math.floor(x), math.floor(y)
    total = np.zeros(image.shape[2])
    for j, share_y in ((row, row + 1 - y), (row + 1, y - row)):
        for i, share_x in ((column, column + 1 - x), (column + 1, x - column)):
            total += share_x * share_y * image[wrapped(j, height, wrap), wrapped(i, width, wrap)]
    return total


@pytest.mark.parametrize("wrap", ["repeat", "mirror", "clamp"])
@pytest.mark.parametrize("filter_name", ["bilinear", "nearest"])
def test_a_bitmap_is_looked_up_with_its_filter_and_its_wrap(filter_name: str, wrap: str) -> None:
    image = texels(5, 7).astype(np.float32)
    to_uv = np.array([[2.5, 0.7, -0.3], [-0.4, -3.0, 1.2]])
    for uv in 0.5 * PLACES + 0.5:
        expected = looked_up(image.astype(float), to_uv @ [*uv, 1.0], filter_name == "bilinear", wrap)
        found = on_square(uv, texels=image, srgb=False, filter=filter_name, wrap=wrap, to_uv=to_uv)
        np.testing.assert_allclose(found, expected, atol=0.003 if filter_name == "bilinear" else 1e-6)


def test_the_first_texel_lies_at_the_origin_of_uv() -> None:
    image = np.zeros((2, 2, 3), np.float32)
    image[0, 0], image[0, 1], image[1, 0] = (1, 0, 0), (0, 1, 0), (0, 0, 1)
    at = {uv: on_square(uv, texels=image, srgb=False, filter="nearest").tolist() for uv in ((0.25, 0.25), (0.75, 0.25))}
    assert at == {(0.25, 0.25): [1, 0, 0], (0.75, 0.25): [0, 1, 0]}


@pytest.mark.parametrize("channels", [1, 3])
def test_bytes_are_decoded_from_srgb_unless_they_are_linear(channels: int) -> None:
    values = np.arange(1, 256, 17, dtype=np.uint8)[:, None, None] * np.ones((1, 1, channels), np.uint8)
    for row in range(len(values)):
        encoded = values[row, 0, 0] / 255.0
        decoded = encoded / 12.92 if encoded <= 0.04045 else ((encoded + 0.055) / 1.055) ** 2.4
        uv = (0.5, (row + 0.5) / len(values))
        for srgb, expected in ((True, decoded), (False, encoded)):
            found = on_square(uv, texels=values, srgb=srgb, filter="nearest")
            np.testing.assert_allclose(found, expected, rtol=2e-6)


def test_half_precision_is_exact_down_to_its_smallest_numbers() -> None:
    values = np.array([1.0, 0.3, 2.0**-14, 2.0**-20, 2.0**-24, 0.999], np.float16).reshape(1, 6, 1)
    for i in range(6):
        found = on_square(((i + 0.5) / 6, 0.5), texels=values, srgb=False, filter="nearest")
        assert found.tolist() == [float(values[0, i, 0])] * 3


def test_a_checkerboard_has_its_first_colour_where_both_halves_are_alike() -> None:
    def board(b: _core.SceneBuilder) -> None:
        bsdf = b.add_bsdf("diffuse", [0.0, 0.0, 0.0])
        b.bind(bsdf, "reflectance", b.add_checkerboard([0.8, 0.1, 0.1], [0.1, 0.1, 0.6], to_uv=[[2, 0, 0], [0, 3, 0]]))
        b.add_rectangle(np.eye(4), flip_normals=False, front=bsdf, back=None, radiance=None)

    for x, y in PLACES:
        u, v = x + 1.0, 1.5 * (y + 1.0)
        first = (u % 1.0 > 0.5) == (v % 1.0 > 0.5)
        expected = [0.8, 0.1, 0.1] if first else [0.1, 0.1, 0.6]
        np.testing.assert_allclose(seen(board, (x, y, 0.0), (x, y, 1.0)), expected, rtol=1e-6)


def test_as_a_number_the_squares_of_a_checkerboard_have_changed_places_as_in_mitsuba() -> None:
    def blend(b: _core.SceneBuilder) -> None:
        index = b.add_mixture(b.add_bsdf("diffuse", [0.8, 0.1, 0.1]), b.add_bsdf("diffuse", [0.1, 0.1, 0.6]), 0.5)
        b.bind(index, "weight", b.add_checkerboard([0, 0, 0], [1, 1, 1], to_uv=[[2, 0, 0], [0, 3, 0]]))
        b.add_rectangle(np.eye(4), flip_normals=False, front=index, back=None, radiance=None)

    for x, y in PLACES:
        u, v = x + 1.0, 1.5 * (y + 1.0)
        alike = (u % 1.0 > 0.5) == (v % 1.0 > 0.5)  # where a colour would be the first
        expected = [0.1, 0.1, 0.6] if alike else [0.8, 0.1, 0.1]
        np.testing.assert_allclose(seen(blend, (x, y, 0.0), (x, y, 1.0)), expected, rtol=1e-6)


RAMP = np.stack(np.meshgrid((np.arange(256) + 0.5) / 256, (np.arange(256) + 0.5) / 256), axis=-1)
RAMP = np.concatenate([RAMP, np.zeros((256, 256, 1))], axis=-1).astype(np.float32)
"""Whose colour at (u, v) is (u, v, 0), but for the outermost half texel."""


def test_a_sphere_has_azimuth_and_polar_angle_as_its_coordinates() -> None:
    pole, meridian = np.array([1.0, 2.0, 2.0]) / 3.0, np.array([2.0, 1.0, -2.0]) / 3.0

    def ball(b: _core.SceneBuilder) -> None:
        bsdf = b.add_bsdf("diffuse", [0.0, 0.0, 0.0])
        b.bind(bsdf, "reflectance", b.add_bitmap(RAMP, srgb=False))
        b.add_sphere(
            [1, 2, 3], 0.5, flip_normals=False, front=bsdf, back=None, radiance=None, pole=pole, meridian=meridian
        )

    for x, y in PLACES:
        u, v = 0.5 + 0.49 * x, 0.5 + 0.35 * y
        across = np.cos(2 * np.pi * u) * meridian + np.sin(2 * np.pi * u) * np.cross(pole, meridian)
        n = np.sin(np.pi * v) * across + np.cos(np.pi * v) * pole
        center = np.array([1.0, 2.0, 3.0])
        np.testing.assert_allclose(seen(ball, center + 0.5 * n, center + 2.0 * n), (u, v, 0), atol=2e-4)


def test_a_disk_has_radius_and_azimuth_as_its_coordinates() -> None:
    place = affine((0.5, 0, 0), (0, 1.5, 0), (0, 0, 1), (1, 2, 3))

    def disk(b: _core.SceneBuilder) -> None:
        bsdf = b.add_bsdf("diffuse", [0.0, 0.0, 0.0])
        b.bind(bsdf, "reflectance", b.add_bitmap(RAMP, srgb=False))
        b.add_disk(place, flip_normals=False, front=bsdf, back=None, radiance=None)

    for x, y in PLACES:
        r, turn = 0.5 + 0.49 * x, 0.5 + 0.49 * y
        point = place @ [r * np.cos(2 * np.pi * turn), r * np.sin(2 * np.pi * turn), 0.0, 1.0]
        np.testing.assert_allclose(seen(disk, point[:3], np.add(point[:3], (0, 0, 1))), (r, turn, 0), atol=2e-4)


@pytest.mark.parametrize("uvs", [None, [[0.1, 0.2], [0.9, 0.3], [0.4, 0.8]]])
def test_a_triangle_has_its_own_coordinates_or_barycentric_ones(uvs: list[list[float]] | None) -> None:
    vertices = np.array([[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]])

    def triangle(b: _core.SceneBuilder) -> None:
        bsdf = b.add_bsdf("diffuse", [0.0, 0.0, 0.0])
        b.bind(bsdf, "reflectance", b.add_bitmap(RAMP, srgb=False))
        b.add_mesh(vertices, [[0, 1, 2]], None, uvs, front=bsdf, back=None, radiance=None)

    corners = np.array(uvs or [[0, 0], [1, 0], [0, 1]])
    for b1, b2 in ((0.2, 0.3), (0.7, 0.1), (0.1, 0.85), (0.33, 0.33)):
        share = np.array([1 - b1 - b2, b1, b2])
        found = seen(triangle, share @ vertices, np.add(share @ vertices, (0, 0, 1)))
        np.testing.assert_allclose(found, [*(share @ corners), 0.0], atol=2e-4)


def test_a_texture_of_one_colour_calls_for_no_textures() -> None:
    def plain(b: _core.SceneBuilder) -> None:
        bsdf = b.add_bsdf("diffuse", [0.0, 0.0, 0.0])
        b.bind(bsdf, "reflectance", b.add_bitmap(np.full((64, 64, 3), 127, np.uint8), srgb=False))
        b.add_rectangle(np.eye(4), flip_normals=False, front=bsdf, back=None, radiance=None)

    scene = build(plain, lambda b: b.add_constant_environment([1.0, 1.0, 1.0]), eye=(0, 0, -1))
    assert not scene.effects()["textures"]
    np.testing.assert_allclose(seen(plain, (0, 0, 0), (0, 0, 1)), 127 / 255, rtol=1e-6)
    bound = build(lambda b: (plain(b), b.add_bitmap(texels(64, 64).astype(np.float32), srgb=False)), eye=(0, 0, -1))
    assert bound.memory_bytes - scene.memory_bytes > 64 * 64 * 12 - 8192
    assert scene.memory_bytes < 64 * 64 * 3


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"texels": np.zeros((2, 2, 2), np.uint8)}, "1 or 3 channels"),
        ({"texels": np.zeros((0, 2, 3), np.uint8)}, "at least one"),
        ({"texels": np.full((2, 2, 3), np.nan, np.float32)}, "texel 0 of a bitmap is not finite"),
        ({"texels": np.full((2, 2, 3), np.inf, np.float16)}, "texel 0 of a bitmap is not finite"),
        ({"texels": np.zeros((2, 2, 3))}, "uint8, float16 or float32"),
        ({"texels": np.zeros((2, 2, 3), np.uint8), "wrap": "border"}, '"clamp", not "border"'),
    ],
)
def test_a_bad_bitmap_is_refused(given: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        on_square((0.5, 0.5), **{"srgb": False, **given})


def test_a_binding_names_what_is_there() -> None:
    def bound(bsdf: int, parameter: str, texture: int) -> Callable[[_core.SceneBuilder], None]:
        def add(b: _core.SceneBuilder) -> None:
            b.add_bsdf("diffuse", [0.5, 0.5, 0.5])
            b.add_checkerboard([0, 0, 0], [1, 1, 1])
            b.bind(bsdf, parameter, texture)

        return add

    for given, message in (((1, "reflectance", 0), "no BSDF 1"), ((0, "reflectance", 1), "no texture 1")):
        with pytest.raises(ValueError, match=message):
            build(bound(*given))
    with pytest.raises(ValueError, match='no texture may give "colour"'):
        build(bound(0, "colour", 0))
