"""Bodies that overlap: the one of the highest priority is there, and a path knows which bodies it begins in."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import equaltime as et
from equaltime import _core
from equaltime.errors import RenderError, SceneError
from equaltime.pricing import derive

from ...statistical.worlds import Add, affine, build, estimate, octahedron

SKY = np.array([0.5, 1.0, 2.0])
SIGMA = np.array([1.0, 2.0, 0.25])
SEEN = {"type": "scene", "sensor": {"type": "perspective"}}


def sky(b: _core.SceneBuilder) -> None:
    b.add_constant_environment(SKY)


def ball(
    b: _core.SceneBuilder,
    radius: float,
    bsdf: int,
    z: float = 3.0,
    priority: int | None = None,
    medium: int | None = None,
    mesh: bool = False,
    flip: bool = False,
) -> None:
    center = (0.0, 0.0, z)
    if mesh:
        vertices, faces = octahedron(3, radius, center)
        index = b.add_mesh(vertices, faces[:, ::-1] if flip else faces, front=bsdf, back=bsdf, radiance=None)
    else:
        index = b.add_sphere(center, radius, flip_normals=flip, front=bsdf, back=bsdf, radiance=None)
    if priority is not None:
        b.set_priority(index, priority)
    if medium is not None:
        b.set_media(index, exterior=None, interior=medium)


def absorbing(b: _core.SceneBuilder, factor: float) -> int:
    return b.add_medium((factor * SIGMA).tolist(), [0.0] * 3)


def seen(*add: Add, eye: float = 0.0) -> Any:
    return estimate(build(*add, sky, lambda b: b.cross_freely(), eye=(0.0, 0.0, eye), fov=1e-3), 16).mean


@pytest.mark.parametrize("mesh", [False, True])
@pytest.mark.parametrize(("first", "second"), [(2, 1), (1, 2)])
def test_where_media_overlap_the_higher_priority_is_there(mesh: bool, first: int, second: int) -> None:
    """Two balls of diameter 2 and 2 along the axis, one unit of which is in both: from 2 to 4 and from 3 to 5."""

    def add(b: _core.SceneBuilder) -> None:
        ball(b, 1.0, b.add_null(), 3.0, first, absorbing(b, 1.0), mesh)
        ball(b, 1.0, b.add_null(), 4.0, second, absorbing(b, 0.5), mesh)

    exact = 2.0 + 0.5 if first > second else 1.0 + 2 * 0.5
    np.testing.assert_allclose(seen(add), SKY * np.exp(-SIGMA * exact), rtol=1e-4)


@pytest.mark.parametrize("mesh", [False, True])
@pytest.mark.parametrize("flip", [False, True])
@pytest.mark.parametrize("priority", [None, 3])
def test_a_camera_within_a_medium_begins_in_it(mesh: bool, flip: bool, priority: int | None) -> None:
    """Also if the surface is inside out, and everything but the ball is its interior: T8."""

    def add(b: _core.SceneBuilder) -> None:
        ball(b, 1.0, b.add_null(), 0.25, priority, absorbing(b, 1.0), mesh, flip)

    if not flip:
        np.testing.assert_allclose(seen(add), SKY * np.exp(-SIGMA * 1.25), rtol=1e-4)
    else:
        assert (seen(add) == 0.0).all(), "no sky is seen through what has no end"
    outside = np.exp(-SIGMA * 2.0) if not flip else np.zeros(3)
    np.testing.assert_allclose(seen(add, eye=-9.0), SKY * outside, rtol=1e-4, atol=1e-12)


def test_the_innermost_of_nested_media_is_where_a_camera_begins() -> None:
    def add(b: _core.SceneBuilder) -> None:
        outer, inner = absorbing(b, 0.5), absorbing(b, 1.0)
        for radius, inside, outside in ((2.0, outer, None), (1.0, inner, outer)):
            index = b.add_sphere(
                (0, 0, 0), radius, flip_normals=False, front=(n := b.add_null()), back=n, radiance=None
            )
            b.set_media(index, exterior=outside, interior=inside)

    np.testing.assert_allclose(seen(add), SKY * np.exp(-SIGMA * 1.5), rtol=1e-4)
    np.testing.assert_allclose(seen(add, eye=-1.5), SKY * np.exp(-SIGMA * (0.5 * 0.5 + 2.0 + 0.5)), rtol=1e-4)


@pytest.mark.parametrize("mesh", [False, True])
@pytest.mark.parametrize("scale", [1.0, 0.01, -8.0])
@pytest.mark.parametrize("moving", [False, True])
def test_the_innermost_of_nested_media_is_found_in_a_group(moving: bool, scale: float, mesh: bool) -> None:
    """Of whatever scale and size in its own space: only the world's volumes can be compared."""

    def add(b: _core.SceneBuilder) -> None:
        outer, inner, nothing = absorbing(b, 0.5), absorbing(b, 1.0), b.add_null()
        own = 1.5 / abs(scale)
        if mesh:
            index = b.add_mesh(*octahedron(3, own), front=nothing, back=nothing, radiance=None)
        else:
            index = b.add_sphere((0, 0, 0), own, flip_normals=False, front=nothing, back=nothing, radiance=None)
        b.set_media(index, exterior=outer, interior=inner)
        group, places = b.add_group(index), np.array([affine(*scale * np.eye(3), (x, 0, 0)) for x in (0.0, 1e-6)])
        if moving:
            b.add_moving_instance(group, [0, 1], places)
        else:
            b.add_instance(group, places[0])
        index = b.add_sphere((0, 0, 0), 2.0, flip_normals=False, front=nothing, back=nothing, radiance=None)
        b.set_media(index, exterior=None, interior=outer)

    np.testing.assert_allclose(seen(add), SKY * np.exp(-SIGMA * (1.5 + 0.5 * 0.5)), rtol=1e-4)


def test_a_mesh_that_is_not_closed_encloses_nothing() -> None:
    def add(b: _core.SceneBuilder) -> None:
        vertices, faces = octahedron(2, 1.0)
        nothing = b.add_null()
        index = b.add_mesh(vertices, faces[1:], front=nothing, back=nothing, radiance=None)
        b.set_media(index, exterior=None, interior=absorbing(b, 1.0))

    np.testing.assert_allclose(seen(add), SKY, rtol=1e-6)


def test_a_camera_in_an_instance_of_a_medium_begins_in_it() -> None:
    def add(b: _core.SceneBuilder) -> None:
        nothing = b.add_null()
        index = b.add_sphere((0, 0, 0), 1.0, flip_normals=False, front=nothing, back=nothing, radiance=None)
        b.set_media(index, exterior=None, interior=absorbing(b, 1.0))
        place = np.diag([2.0, 2.0, 3.0, 1.0])
        place[2, 3] = 1.0
        b.add_instance(b.add_group(index), place)

    np.testing.assert_allclose(seen(add), SKY * np.exp(-SIGMA * 4.0), rtol=1e-4)


Glass = Callable[[_core.SceneBuilder, float], int]
SMOOTH: Glass = lambda b, ior: b.add_bsdf("dielectric", ior, (1.0, 1.0, 1.0), (1.0, 1.0, 1.0))  # noqa: E731
ROUGH: Glass = lambda b, ior: b.add_bsdf("roughdielectric", "ggx", 0.2, 0.2, ior, (1.0,) * 3, (1.0,) * 3)  # noqa: E731


def strange_sky(b: _core.SceneBuilder) -> None:
    rng = np.random.default_rng(3)
    b.add_image_environment(rng.uniform(0.1, 2.0, (8, 16, 3)).astype(np.float32), 1.0, np.eye(4))


def image(add: Add, seed: int = 1, spp: int = 64) -> Any:
    from ...statistical.worlds import render

    return render(build(add, strange_sky, fov=30.0, size=(8, 8)), spp, seed, max_depth=12)["mean"][0]


@pytest.mark.parametrize("glass", [SMOOTH, ROUGH], ids=["smooth", "rough"])
def test_water_in_glass_by_priority_is_water_whose_index_is_relative(glass: Glass) -> None:
    """T7: the inner ball's index by priority, against the quotient said by hand; and its twin, which forgets it."""

    def by_priority(b: _core.SceneBuilder) -> None:
        ball(b, 1.0, glass(b, 1.5), priority=1)
        ball(b, 0.6, glass(b, 4 / 3), priority=2)

    def by_hand(inner: float) -> Add:
        def add(b: _core.SceneBuilder) -> None:
            ball(b, 1.0, glass(b, 1.5))
            ball(b, 0.6, glass(b, inner))

        return add

    np.testing.assert_allclose(image(by_priority), image(by_hand(4 / 3 / 1.5)), rtol=2e-3)
    assert np.abs(image(by_priority) / image(by_hand(4 / 3)) - 1).max() > 0.05, "the twin"


def test_what_is_within_a_body_of_higher_priority_is_not_there() -> None:
    """T7: whatever it is, glass, a mirror or a lamp, to rays of all kinds."""

    def add(within: bool) -> Add:
        def parts(b: _core.SceneBuilder) -> None:
            ball(b, 1.0, SMOOTH(b, 1.5), priority=2)
            if within:
                ball(b, 0.7, SMOOTH(b, 1.2), priority=1)
                mirror = b.add_bsdf("conductor", [0.2] * 3, [3.0] * 3, [1.0] * 3)
                shape = b.add_sphere((0, 0, 3), 0.5, flip_normals=False, front=mirror, back=mirror, radiance=(9.0,) * 3)
                b.set_priority(shape, 0)

        return parts

    with_, without = (np.mean([image(add(w), seed) for seed in range(16)], axis=0) for w in (True, False))
    np.testing.assert_allclose(with_.mean(), without.mean(), rtol=0.02)


def test_glass_of_the_index_around_it_is_invisible() -> None:
    """T7, S16: also rough glass, whose facets turn nothing."""

    def add(*inner: Glass) -> Add:
        def parts(b: _core.SceneBuilder) -> None:
            ball(b, 1.0, SMOOTH(b, 1.5), priority=1)
            for glass in inner:
                ball(b, 0.6, glass(b, 1.5), priority=2)

        return parts

    plain = np.mean([image(add(), seed) for seed in range(16)], axis=0)
    for glass in (SMOOTH, ROUGH):
        found = np.mean([image(add(glass), seed) for seed in range(16)], axis=0)
        np.testing.assert_allclose(found.mean(), plain.mean(), rtol=0.02)


def test_the_kernel_for_all_effects_makes_the_bits_of_the_derived_one() -> None:
    def add(b: _core.SceneBuilder) -> None:
        ball(b, 1.0, SMOOTH(b, 1.5), priority=1, medium=absorbing(b, 0.5))
        ball(b, 0.6, ROUGH(b, 1.3), 2.5, priority=2)

    core = build(add, strange_sky, lambda b: b.cross_freely(), fov=30.0, size=(8, 8))
    settings = _core.Settings(max_depth=8)
    derived, full = (_core.Renderer(core, settings, 3, 1, also=names) for names in ((), tuple(core.effects())))
    assert derived.kernel != full.kernel
    for renderer in (derived, full):
        renderer.advance(8)
    assert np.array_equal(derived.moments["mean"], full.moments["mean"])


def test_a_furnace_of_bodies_that_overlap_is_even() -> None:
    def add(b: _core.SceneBuilder) -> None:
        for i, (z, ior) in enumerate(((2.6, 1.5), (3.2, 1.33), (3.6, 1.8), (2.9, 1.0))):
            ball(b, 0.8, SMOOTH(b, ior), z, priority=i)

    found = estimate(build(add, sky, fov=30.0, size=(16, 16)), 64, roulette="none", max_depth=200)
    np.testing.assert_allclose(found.mean, SKY, rtol=1e-4)


@pytest.mark.parametrize("kind", ["sphere", "cube"])
def test_priorities_of_what_does_not_touch_call_for_nothing(kind: str) -> None:
    def scene(x: float) -> et.Scene:
        def glass(x: float, priority: int) -> dict[str, Any]:
            body = {"type": kind, "bsdf": {"type": "dielectric"}, "priority": priority}
            return body | {"to_world": [{"translate": [x, 0, 0]}]}

        film = {"type": "hdrfilm", "width": 4, "height": 4}
        camera = {"type": "perspective", "film": film, "to_world": [{"translate": [0, 0, -5]}]}
        return et.load_dict({"type": "scene", "sensor": camera, "a": glass(4.0, 1), "b": glass(4.0 + x, 2)})

    assert not scene(2.5).core.effects()["media"]
    assert "media" not in derive(scene(2.5))
    assert scene(0.5).core.effects()["media"]
    assert [str(reason) for reason in derive(scene(0.5))["media"]] == [f"a: shape '{kind}'", f"b: shape '{kind}'"]


def loaded(**shape: Any) -> et.Scene:
    return et.load_dict(SEEN | {"a": {"type": "sphere", **shape}, "b": {"type": "sphere", "priority": 1}})


def test_a_priority_that_makes_no_sense_is_refused_with_its_place() -> None:
    with pytest.raises(SceneError, match=r"a\.priority: "):
        loaded(priority="high")
    with pytest.raises(SceneError, match=r"a: a priority is for what has an inside: meshes and spheres"):
        _ = loaded(type="cylinder", priority=1).core
    with pytest.raises(SceneError, match=r"a: a priority is for smooth and rough dielectrics"):
        _ = loaded(priority=1, bsdf={"type": "thindielectric"}).core
    group = {"type": "shapegroup", "ball": {"type": "sphere", "priority": 1}}
    with pytest.raises(SceneError, match="the shapes of a group have no priority"):
        et.load_dict(SEEN | {"g": group, "i": {"type": "instance", "g": {"type": "ref", "id": "g"}}})
    many = {f"s{i}": {"type": "sphere", "priority": i} for i in range(65)}
    with pytest.raises(SceneError, match="s64: no more than 64 shapes that overlap have priorities"):
        _ = et.load_dict(SEEN | many).core


def test_the_cross_check_refuses_priorities_by_name() -> None:
    from equaltime.crosscheck.tracer import check

    with pytest.raises(RenderError, match="the cross-check cannot trace 'priority'"):
        check(loaded().model)
