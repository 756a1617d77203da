"""Masks, blends and nothing, where the light that they let pass is known in closed form, by every technique.

A statement that holds is rejected with a probability of 1e-4 a test, with fixed seeds; the twins at the end show what
such a test sees.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from equaltime import _core

from ..statistical.worlds import Add, Estimate, build, estimate, looking

LEVEL = 1e-4
TECHNIQUES = ("uniform", "bsdf", "light", "mis", "mixture")
SKY = (0.5, 1.0, 2.0)


def sky(b: _core.SceneBuilder) -> None:
    b.add_constant_environment(SKY)


def shell(radius: float, opacity: float, reflectance: float = 0.0) -> Add:
    """A sphere round everything, of which both sides are a mask."""

    def add(b: _core.SceneBuilder) -> None:
        mask = b.add_mixture(b.add_null(), b.add_bsdf("diffuse", [reflectance] * 3), opacity)
        b.add_sphere([0.1, 0.2, 0.3], radius, flip_normals=False, front=mask, back=mask, radiance=None)

    return add


def tile(reflectance: float) -> Add:
    return lambda b: b.add_rectangle(
        np.diag([50.0, 50.0, 1.0, 1.0]),
        flip_normals=False,
        front=b.add_bsdf("diffuse", [reflectance] * 3),
        back=None,
        radiance=None,
    )


VIEW = looking((0.0, 0.0, 1.0), (0.1, 0.2, 0.0))


@pytest.mark.parametrize("technique", TECHNIQUES)
def test_a_light_shines_through_a_mask_with_what_is_not_opaque(technique: str) -> None:
    found = estimate(build(tile(0.6), shell(100.0, 0.3), sky, camera=VIEW), 4096, technique=technique, max_depth=3)
    assert found.p(0.6 * 0.7 * np.array(SKY)) > LEVEL


@pytest.mark.parametrize("technique", ["bsdf", "light", "mis"])
def test_what_is_crossed_multiplies(technique: str) -> None:
    scene = build(tile(0.6), shell(100.0, 0.3), shell(200.0, 0.5), sky, camera=VIEW)
    assert estimate(scene, 4096, technique=technique, max_depth=4).p(0.6 * 0.7 * 0.5 * np.array(SKY)) > LEVEL


@pytest.mark.parametrize("technique", ["bsdf", "light", "mis"])
@pytest.mark.parametrize("depth", [1, 2, 3, 4])
def test_each_crossing_is_a_vertex_of_the_path(technique: str, depth: int) -> None:
    scene = build(tile(1.0), shell(100.0, 0.0), shell(200.0, 0.0), sky, camera=VIEW)
    found = estimate(scene, 64, technique=technique, max_depth=depth)
    np.testing.assert_allclose(found.mean, np.array(SKY) if depth == 4 else 0.0, rtol=0.2)


def lamp_behind(opacity: float) -> _core.Scene:
    def add(b: _core.SceneBuilder) -> None:
        mask = b.add_mixture(b.add_null(), b.add_bsdf("diffuse", [0.0] * 3), opacity)
        b.add_rectangle(np.eye(4), flip_normals=False, front=mask, back=None, radiance=None)
        place = np.diag([2.0, 2.0, 1.0, 1.0])
        place[2, 3] = -1.0
        b.add_rectangle(place, flip_normals=False, front=None, back=None, radiance=SKY)

    return build(add, camera=looking((0, 0, 1), (0.1, 0.2, 0)), fov=10.0)


@pytest.mark.parametrize("technique", ["bsdf", "mis"])
@pytest.mark.parametrize("opacity", [0.25, 0.9])
def test_a_lamp_is_seen_through_a_mask(technique: str, opacity: float) -> None:
    assert estimate(lamp_behind(opacity), 4096, technique=technique).p((1 - opacity) * np.array(SKY)) > LEVEL


def test_an_opaque_mask_is_what_it_masks_and_an_open_one_nothing() -> None:
    opaque, clear = lamp_behind(1.0), lamp_behind(0.0)
    assert not opaque.effects()["masks"]
    assert estimate(opaque, 16).most.max() == 0.0
    assert clear.effects()["masks"]
    assert estimate(clear, 16).mean.tolist() == list(SKY)


@pytest.mark.parametrize("technique", TECHNIQUES)
def test_a_white_mask_that_is_lit_from_all_around_is_not_seen(technique: str) -> None:
    scene = build(shell(5.0, 0.4, 1.0), sky, camera=VIEW)
    found = estimate(scene, 2048, technique=technique, roulette="none", max_depth=200)
    assert found.p(SKY) > LEVEL


def blended(weight: float, texture: bool = False) -> _core.Scene:
    def add(b: _core.SceneBuilder) -> None:
        index = b.add_mixture(b.add_bsdf("diffuse", [0.2, 0.2, 0.2]), b.add_bsdf("diffuse", [0.8, 0.8, 0.8]), weight)
        if texture:  # half of its squares have twice the weight, the others none
            b.bind(index, "weight", b.add_checkerboard([2 * weight] * 3, [0.0] * 3, to_uv=[[400, 0, 0], [0, 400, 0]]))
        b.add_rectangle(np.diag([50.0, 50.0, 1.0, 1.0]), flip_normals=False, front=index, back=None, radiance=None)

    return build(add, sky, camera=VIEW)


@pytest.mark.parametrize("texture", [False, True])
@pytest.mark.parametrize("technique", TECHNIQUES)
def test_a_blend_reflects_as_much_as_its_parts_by_their_weights(technique: str, texture: bool) -> None:
    found = estimate(blended(0.25, texture), 8192, technique=technique, max_depth=2)
    assert found.p((0.75 * 0.2 + 0.25 * 0.8) * np.array(SKY)) > LEVEL


@pytest.mark.parametrize(("cutoff", "share"), [(0.2, 1.0), (0.25, 1.0), (0.26, 0.5), (0.5, 0.5), (0.51, 0.0)])
def test_a_cutoff_makes_a_weight_all_or_nothing(cutoff: float, share: float) -> None:
    """The weight is a product of two textures: 0.5 times 0.5 or 1."""

    def add(b: _core.SceneBuilder) -> None:
        index = b.add_mixture(b.add_bsdf("diffuse", [0.2] * 3), b.add_bsdf("diffuse", [0.8] * 3), 0.0, cutoff)
        squares = b.add_checkerboard([1.0] * 3, [0.5] * 3, to_uv=[[400, 0, 0], [0, 400, 0]])
        b.bind(index, "weight", squares, b.add_checkerboard([0.5] * 3, [0.5] * 3))
        b.add_rectangle(np.diag([50.0, 50.0, 1.0, 1.0]), flip_normals=False, front=index, back=None, radiance=None)

    found = estimate(build(add, sky, camera=VIEW), 8192, technique="bsdf", max_depth=2)
    assert found.p((0.2 + 0.6 * share) * np.array(SKY)) > LEVEL


def test_the_parts_of_a_blend_of_blends_are_picked_by_the_products_of_their_weights() -> None:
    def add(b: _core.SceneBuilder) -> None:
        red, green, blue = (b.add_bsdf("diffuse", c) for c in ([0.9, 0, 0], [0, 0.9, 0], [0, 0, 0.9]))
        index = b.add_mixture(b.add_mixture(red, green, 0.3), b.add_mixture(blue, red, 0.6), 0.2)
        b.add_rectangle(np.diag([50.0, 50.0, 1.0, 1.0]), flip_normals=False, front=index, back=None, radiance=None)

    found = estimate(build(add, sky, camera=VIEW), 8192, technique="bsdf", max_depth=2)
    assert found.p(0.9 * np.array([0.8 * 0.7 + 0.2 * 0.6, 0.8 * 0.3, 0.2 * 0.4]) * SKY) > LEVEL


WRONG: dict[str, Callable[[], tuple[Estimate, float]]] = {
    "a mask two percent too opaque": lambda: (
        estimate(build(tile(0.6), shell(100.0, 0.314), sky, camera=VIEW), 32768, technique="bsdf", max_depth=3),
        0.6 * 0.7,
    ),
    "a blend with five percent too much of one part": lambda: (
        estimate(blended(0.2625), 32768, technique="bsdf", max_depth=2),
        0.75 * 0.2 + 0.25 * 0.8,
    ),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_is_a_little_wrong_is_found(name: str) -> None:
    found, expected = WRONG[name]()
    assert found.p(expected * np.array(SKY)) < LEVEL


@pytest.mark.parametrize(
    ("add", "message"),
    [
        (lambda b: b.add_mixture(0, 0, 0.5), "BSDF 0: a mixture follows its parts"),
        (lambda b: b.add_mixture(b.add_null(), 7, 0.5), "BSDF 1: a mixture follows its parts"),
        (lambda b: b.add_mixture(b.add_null(), 0, 1.5), r"lies in \[0, 1\]"),
        (lambda b: b.add_mixture(b.add_null(), b.add_null(), 0.5, -1.0), "cutoff of a mixture is at least 0"),
    ],
)
def test_a_bad_mixture_is_refused(add: Add, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        build(add)
