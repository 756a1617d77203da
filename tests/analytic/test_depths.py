"""What paths of a limited length see, in Mitsuba's counting, and what a lamp alone looks like."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from equaltime import _core

from ..statistical.worlds import affine, build, estimate, looking, octahedron, turned

Array = NDArray[np.float64]
WHITE = (1.0, 1.0, 1.0)
TECHNIQUES = ["uniform", "bsdf", "light", "mis", "mixture"]


def add_floor(builder: _core.SceneBuilder) -> None:
    diffuse = builder.add_bsdf("diffuse", [0.5] * 3)
    builder.add_rectangle(np.eye(4), flip_normals=False, front=diffuse, back=None, radiance=None)


def add_point(builder: _core.SceneBuilder) -> None:
    builder.add_point_light([0, 0, 2], [np.pi] * 3)


def add_sky(builder: _core.SceneBuilder) -> None:
    builder.add_constant_environment(WHITE)


def add_mirror(builder: _core.SceneBuilder) -> None:
    """Between a camera that looks up and the sky: what it shows is the floor."""
    mirror = builder.add_bsdf("conductor", [0] * 3, [1] * 3, WHITE)
    above = affine([3, 0, 0], [0, -3, 0], [0, 0, -1], [0, 0, 1.5])
    builder.add_rectangle(above, flip_normals=False, front=mirror, back=None, radiance=None)


DOWN, UP = looking([0, 0, 1], [0, 0, 0], up=[0, 1, 0]), looking([0, 0, 1], [0, 0, 2], up=[0, 1, 0])


def seen(camera: Array, depth: int, technique: str, *add: object) -> float:
    scene = build(*add, camera=camera, fov=0.01)
    return float(estimate(scene, 4096, max_depth=depth, technique=technique).mean[0])


@pytest.mark.parametrize("technique", TECHNIQUES)
def test_one_segment_sees_emission_two_see_direct_light_three_see_it_mirrored(technique: str) -> None:
    direct = 0.5 / np.pi * np.pi / 4  # reflectance/π times intensity over squared distance
    assert seen(DOWN, 1, technique, add_floor, add_point) == 0.0
    assert seen(DOWN, 2, technique, add_floor, add_point) == pytest.approx(direct, rel=1e-6)
    assert seen(UP, 1, technique, add_floor, add_point, add_mirror) == 0.0
    assert seen(UP, 2, technique, add_floor, add_point, add_mirror) == 0.0


@pytest.mark.parametrize("technique", TECHNIQUES)
def test_the_sky_is_seen_by_one_segment_and_lights_with_two(technique: str) -> None:
    assert seen(UP, 1, technique, add_floor, add_sky) == 1.0
    assert seen(DOWN, 1, technique, add_floor, add_sky) == 0.0
    # 4096 samples of a standard deviation below 1: a z-test at 0.1 %.
    assert seen(DOWN, 2, technique, add_floor, add_sky) == pytest.approx(0.5, abs=3.3 / 64)
    assert seen(DOWN, 5, "bsdf", add_floor, add_sky) == 0.5


@pytest.mark.parametrize(("freely", "depths"), [(False, (0.0, 1.0, 1.0)), (True, (0.96 / 1.04, 1.0, 1.0))])
@pytest.mark.parametrize("technique", TECHNIQUES)
def test_thin_glass_is_gone_through_for_nothing_where_crossings_are_no_vertices(
    technique: str, freely: bool, depths: tuple[float, ...]
) -> None:
    """As in Mitsuba's `volpath`: a pane of index 1.5 lets 1 - 2 R / (1 + R) pass, R = 0.04; what it reflects counts."""

    def add(builder: _core.SceneBuilder) -> None:
        if freely:
            builder.cross_freely()
        glass = builder.add_bsdf("thindielectric", 1.5, WHITE, WHITE)
        above = affine([3, 0, 0], [0, 3, 0], [0, 0, 1], [0, 0, 1.5])
        builder.add_rectangle(above, flip_normals=False, front=glass, back=glass, radiance=None)

    for depth, expected in enumerate(depths, start=1):
        # 4096 samples of a standard deviation below 0.27: a z-test at 0.01 %; what both ways see is exact.
        assert seen(UP, depth, technique, add, add_sky) == pytest.approx(
            expected, abs=3.9 * 0.27 / 64 if depth == 1 else 1e-6
        )


LAMPS = ["rectangle", "disk", "triangle", "sphere", "ball of triangles"]


@pytest.mark.parametrize("turn", [turned([0, 0, 1], 0), turned([1, 2, 3], 50), turned([3, 1, -2], 111)])
@pytest.mark.parametrize("technique", TECHNIQUES)
@pytest.mark.parametrize("lamp", LAMPS)
def test_a_lamp_that_reflects_does_not_light_itself(lamp: str, technique: str, turn: Array) -> None:
    """Its points are rounded, half of them to the front of their plane, from where the lamp would fill half a world."""
    origin = np.array([0.1, 0.2, 0.3])

    def add(builder: _core.SceneBuilder) -> None:
        sides = {"front": builder.add_bsdf("diffuse", [0.8] * 3), "back": None, "radiance": WHITE}
        if lamp == "rectangle":
            builder.add_rectangle(affine(*turn.T, origin), flip_normals=False, **sides)
        elif lamp == "disk":
            builder.add_disk(affine(*turn.T, origin), flip_normals=False, **sides)
        elif lamp == "triangle":
            corners = np.array([[-2, -2, 0], [4, -2, 0], [-2, 4, 0]]) @ turn.T + origin
            builder.add_mesh(corners, [[0, 1, 2]], **sides)
        elif lamp == "sphere":
            builder.add_sphere(origin, 1.0, flip_normals=False, **sides)
        else:
            vertices, faces = octahedron(2, 1.0)
            builder.add_mesh(vertices @ turn.T + origin, faces, **sides)

    camera = looking(origin + 3 * turn[:, 2], origin, up=turn[:, 0])
    got = estimate(build(add, camera=camera, fov=20.0, size=(16, 16)), 64, technique=technique)
    assert (got.least == 1.0).all()
    assert (got.most == 1.0).all()
