"""All the words of the vocabulary: what is described is kept, and what the core cannot use yet is refused by place."""

from __future__ import annotations

from typing import Any

from equaltime.scene import load_dict
from equaltime.scene import model as m
from equaltime.scene.model.wrappers import BLACK, sides

BALL: dict[str, Any] = {"type": "sphere"}


def scene(**parts: Any) -> dict[str, Any]:
    return {"type": "scene", "sensor": {"type": "perspective"}} | parts


GROUP = {
    "group": {"type": "shapegroup", "part": BALL},
    "copy": {"type": "instance", "group": {"type": "ref", "id": "group"}},
}


def test_a_group_is_seen_where_an_instance_puts_it_and_nowhere_else() -> None:
    (shape,) = load_dict(scene(**GROUP)).model.shapes
    assert isinstance(shape, m.Instance)
    assert shape.shapegroup.shapes == (m.Sphere(id=None),)


def test_media_stand_where_their_names_say() -> None:
    (ball,) = load_dict(scene(fog={"type": "homogeneous"}, a=BALL | {"exterior": "fog"})).model.shapes
    assert isinstance(ball, m.Sphere)
    assert ball.interior is None
    assert ball.exterior == m.Homogeneous(id="fog")


def test_volumetric_paths_are_paths_where_there_is_no_medium() -> None:
    loaded = load_dict(scene(integrator={"type": "volpath", "max_depth": 7}, a=BALL))
    assert loaded.max_depth == 7
    assert loaded.core.shapes == 1
    assert loaded.with_(max_depth=3).max_depth == 3


def test_the_depth_of_an_integrator_inside_another_can_be_changed() -> None:
    loaded = load_dict(scene(integrator={"type": "moment", "inner": {"type": "path", "max_depth": 7}}, a=BALL))
    assert loaded.max_depth == 7
    assert loaded.core.shapes == 1
    assert loaded.with_(max_depth=3).model.integrator == m.Moment(
        id="integrator", integrators=(m.Path(id=None, max_depth=3),)
    )


def test_the_two_sides_of_a_surface_are_free_of_twosided() -> None:
    red, glass, plastic = m.Diffuse(reflectance=(1, 0, 0)), m.Dielectric(), m.Plastic()
    assert sides(red) == (red, None)
    assert sides(glass) == (glass, glass)
    assert sides(m.TwoSided(bsdf=(red,))) == (red, red)
    assert sides(m.TwoSided(bsdf=(red, plastic))) == (red, plastic)
    assert sides(m.TwoSided(bsdf=(red, BLACK))) == (red, None)


def test_a_hole_is_one_from_both_sides() -> None:
    red = m.Diffuse(reflectance=(1, 0, 0))
    masked = m.Mask(bsdf=red)
    assert sides(masked) == (masked, m.Mask(bsdf=BLACK))
    assert sides(m.Mask(bsdf=m.TwoSided(bsdf=(red,)))) == (masked, masked)


def test_a_blend_of_what_works_on_one_side_does_so_too() -> None:
    red, plastic, glass = m.Diffuse(reflectance=(1, 0, 0)), m.Plastic(), m.Dielectric()
    opaque = m.BlendBsdf(weight=0.5, bsdf=(red, plastic))
    assert sides(opaque) == (opaque, None)
    half = m.BlendBsdf(weight=0.5, bsdf=(red, glass))
    assert sides(half) == (half, m.BlendBsdf(weight=0.5, bsdf=(BLACK, glass)))
    bumpy = m.BumpMap(texture=m.Checkerboard(), bsdf=m.TwoSided(bsdf=(red, plastic)))
    assert [side and side.bsdf for side in sides(bumpy)] == [red, plastic]  # type: ignore[union-attr]
