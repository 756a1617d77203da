"""Where things stand, as `lint` sees it: what is in a group stands nowhere by itself, lights may stand askew, and not
all glass hides those that it is around.
"""

from __future__ import annotations

from equaltime.scene.lint import Finding

from .test_lint import GLASS, found, scene


def test_what_is_in_a_group_encloses_nothing() -> None:
    group = {"type": "shapegroup", "ball": {"type": "sphere", "radius": 20.0, "bsdf": GLASS}}
    copy = {"type": "instance", "shapegroup": {"type": "ref", "id": "group"}, "to_world": [{"translate": [0, 0, 90]}]}
    light = {"type": "point", "position": [0, 0, 1]}
    assert {"camera-enclosed", "lights-behind-glass"} & set(found(scene(group=group, copy=copy, light=light))) == set()
    alone = group["ball"]
    assert "lights-behind-glass" in found(scene(ball=alone, light=light)), "the twin"


def test_a_flat_light_that_stands_askew_is_turned_away_too() -> None:
    for flip in (True, False):
        place = [{"rotate": {"axis": [1, 0, 0], "angle": 180.0 + 30.0}}, {"translate": [0, 0, 40]}]
        lamp = {"type": "rectangle", "to_world": place, "flip_normals": flip, "emitter": {"type": "area"}}
        assert ("lights-turned-away" in found(scene(ball={"type": "sphere"}, lamp=lamp))) == flip


def test_lights_shine_through_thin_glass_where_paths_cross_it_freely() -> None:
    """What it reflects of them is left out all the same."""

    def lit(kind: str, bsdf: str) -> dict[str, Finding]:
        ball = {"type": "sphere", "bsdf": {"type": bsdf}}
        return found(scene(light={"type": "point"}, ball=ball, integrator={"type": kind}))

    assert "lights-behind-glass" not in lit("volpath", "thindielectric")
    assert "caustics-left-out" in lit("volpath", "thindielectric")
    for kind, bsdf in (("path", "thindielectric"), ("volpath", "dielectric")):
        assert "thindielectric" in lit(kind, bsdf)["lights-behind-glass"].advice, "the twin"


def test_lamps_inside_thin_glass_are_noisy_with_any_integrator() -> None:
    """Only lights without extent shine through thin glass: light samples of lamps do not, even with volpath."""

    def lit(kind: str, bsdf: str) -> dict[str, Finding]:
        lamp = {"type": "sphere", "radius": 0.1, "emitter": {"type": "area"}}
        return found(scene(lamp=lamp, ball={"type": "sphere", "bsdf": {"type": bsdf}}, integrator={"type": kind}))

    for kind in ("path", "volpath"):
        for bsdf in ("dielectric", "thindielectric"):
            assert "lamps-in-glass" in lit(kind, bsdf)
