"""The price list is right: each scene is built so that one effect makes a share of the variance known in closed form.

Of every scene, `LISTS` price lists with seeds of their own; an interval at 95 % covers the truth in all but one of
twenty. That fewer than `COVERED` of 8 cover is a false alarm of one in 2700, of one in 400 for all scenes together.
"""

import math
from typing import Any, NamedTuple

import numpy as np
import pytest

import equaltime as et
from equaltime.statistics.intervals import Interval

PIXELS = 24
STRATEGY = "best,sampler=independent,lights=uniform"
LISTS, COVERED = 8, 5
BLACK = {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.0] * 3}}


class Case(NamedTuple):
    effect: str
    scene: dict[str, Any]
    share: float
    """Of the variance."""
    wrong: float
    """What it would be if what makes it were a fifth stronger or weaker, or worse."""


def share_beside_one(variance: float) -> float:
    """Return the share of a variance beside another, independent one of 1."""
    return variance / (1.0 + variance)


def chance(value: float, probability: float) -> float:
    """Return the variance of what has a value with some probability, and else is 0."""
    return value**2 * probability * (1.0 - probability)


def placed(*diagonal: float, z: float = 0.0, x: float = 0.0) -> list[list[float]]:
    matrix = np.diag([*diagonal, 1.0])
    matrix[0, 3], matrix[2, 3] = x, z
    return matrix.tolist()


def facing_camera(**objects: Any) -> dict[str, Any]:
    """A camera that sees the unit square of z = 0 by parallel rays."""
    film = {"type": "hdrfilm", "width": PIXELS, "height": PIXELS, "rfilter": {"type": "box"}}
    sensor = {"type": "orthographic", "to_world": placed(-1.0, 1.0, -1.0, z=2.0), "film": film}
    return {"type": "scene", "integrator": {"type": "path", "max_depth": 4}, "sensor": sensor, **objects}


def squares(scale: float = PIXELS) -> dict[str, Any]:
    """Light of 3 and 1, each on half of every pixel: its variance is 1."""
    to_uv = placed(scale, scale, 1.0)
    return {"type": "checkerboard", "color0": [3.0] * 3, "color1": [1.0] * 3, "to_uv": to_uv}


def shining(radiance: Any) -> dict[str, Any]:
    return {"type": "area", "radiance": radiance}


def veil(opacity: float, z: float = 0.5, **more: Any) -> dict[str, Any]:
    mask = {"type": "mask", "opacity": opacity, "bsdf": BLACK}
    return {"type": "rectangle", "to_world": placed(1.0, 1.0, 1.0, z=z), "bsdf": mask, **more}


def masked(light: float, opacity: float) -> Case:
    """A veil that shines itself, with squares, lets a lamp be seen through it by chance; an opaque one never does."""
    lamp = {"type": "rectangle", "bsdf": BLACK, "emitter": shining({"type": "rgb", "value": [light] * 3})}
    scene = facing_camera(lamp=lamp, veil=veil(opacity, emitter=shining(squares())))
    seen, too_much = 1.0 - opacity, 0.8 * (1.0 - opacity)
    return Case("masks", scene, share_beside_one(chance(light, seen)), share_beside_one(chance(light, too_much)))


def under_a_sky(light: float, opacity: float) -> Case:
    """The same veil before the sky."""
    sky = {"type": "constant", "radiance": {"type": "rgb", "value": [light] * 3}}
    scene = facing_camera(sky=sky, veil=veil(opacity, emitter=shining(squares())))
    return masked(light, opacity)._replace(effect="environment", scene=scene)


def behind_two_veils(light: float, opacity: float) -> Case:
    """Every veil crossed makes a path longer: the lamp behind two is seen by long paths alone."""
    lamp = {"type": "rectangle", "bsdf": BLACK, "emitter": shining({"type": "rgb", "value": [light] * 3})}
    scene = facing_camera(lamp=lamp, near=veil(opacity, emitter=shining(squares())), far=veil(opacity, z=0.25))
    both = (1.0 - opacity) ** 2
    return Case(
        "long_paths", scene, share_beside_one(chance(light, both)), share_beside_one(chance(light, 1.0 - opacity))
    )


def glowing_floor_in_the_sun(radiance: float) -> Case:
    """Of the floor's own squares and the sun, one is picked: what the sun brings is doubled or nothing."""
    sun = {"type": "directional", "direction": [0, 0, -1], "irradiance": {"type": "rgb", "value": [math.pi] * 3}}
    grey = {"type": "diffuse", "reflectance": {"type": "rgb", "value": [radiance] * 3}}
    floor = {"type": "rectangle", "bsdf": grey, "emitter": shining(squares())}
    share, wrong = (share_beside_one(chance(2.0 * r, 0.5)) for r in (radiance, 1.2 * radiance))
    return Case("point_lights", facing_camera(floor=floor, sun=sun), share, wrong)


def reflected_by_glass(light: float) -> Case:
    """A pane shines with squares, lets a black sky be seen, and by chance a lamp, in its reflection."""
    once = (0.5 / 2.5) ** 2
    reflected = 2.0 * once / (1.0 + once)
    lamp = {
        "type": "rectangle",
        "to_world": placed(1.0, -1.0, -1.0, z=3.0),
        "bsdf": BLACK,
        "emitter": shining({"type": "rgb", "value": [light] * 3}),
    }
    glass = {"type": "thindielectric", "int_ior": 1.5, "ext_ior": 1.0}
    pane = {"type": "rectangle", "bsdf": glass, "emitter": shining(squares())}
    share, wrong = (share_beside_one(chance(light, r)) for r in (reflected, once))
    return Case("specular", facing_camera(lamp=lamp, pane=pane), share, wrong)


def out_of_focus(blur: float) -> Case:
    """Every pixel is cut in the middle by the edge of a stripe, and points become disks of `blur` / 2 pixels.

    A ray through the lens sees another stripe than one through its middle with a probability of E|x| over the pixel, x
    the way across a disk of radius R, whose mean is 4 R / (3 π). By that the values 3 and 1 lose their correlation.
    """
    distance, focus, wide = 4.0, 2.0, 1.0
    pixel = wide / PIXELS
    film = {"type": "hdrfilm", "width": PIXELS, "height": PIXELS, "rfilter": {"type": "box"}}
    sensor = {
        "type": "thinlens",
        "to_world": placed(-1.0, 1.0, -1.0, z=distance),
        "fov": math.degrees(2.0 * math.atan(0.5 * wide / distance)),
        "focus_distance": focus,
        "aperture_radius": 0.5 * blur * pixel / (distance / focus - 1.0),
        "film": film,
    }
    stripes = squares() | {"to_uv": placed(PIXELS, 0.25, 1.0)}
    lamp = {"type": "rectangle", "to_world": placed(1.0, 1.0, 1.0, x=0.5 * pixel), "bsdf": BLACK}
    scene = facing_camera(lamp=lamp | {"emitter": shining(stripes)}) | {"sensor": sensor}
    share, wrong = (2.0 * 4.0 * 0.5 * r / (3.0 * math.pi) for r in (blur, 1.2 * blur))
    return Case("lens", scene, share, wrong)


def moving_curtains(travel: float) -> Case:
    """Every pixel is cut in the middle by the edge of a black curtain, which moves by so much of a pixel.

    At a time it covers what it does not at the shutter's centre, or the other way, with a probability of travel / 4.
    """
    pixel = 2.0 / PIXELS

    def curtain(middle: float) -> dict[str, Any]:
        ends = ((time, middle + (time - 0.5) * travel * pixel) for time in (0.0, 1.0))
        small = {"scale": [0.5 * pixel, 2.0, 1.0]}
        keys = [{"time": time, "transform": [small, {"translate": [x, 0.0, 0.5]}]} for time, x in ends]
        return {"type": "rectangle", "bsdf": BLACK, "to_world": {"animation": keys}}

    curtains = {f"curtain{i}": curtain((2 * i + 1) * pixel - 1.0) for i in range(PIXELS // 2)}
    lamp = {"type": "rectangle", "bsdf": BLACK, "emitter": shining({"type": "rgb", "value": [1.0] * 3})}
    scene = facing_camera(lamp=lamp, **curtains)
    scene["sensor"] |= {"shutter_open": 0.0, "shutter_close": 1.0}
    return Case("motion", scene, 0.5 * travel, 0.6 * travel)


CASES = {
    "mask": masked(2.0, 0.25),
    "sky behind a mask": under_a_sky(2.0, 0.25),
    "long paths": behind_two_veils(3.0, 0.5),
    "sun": glowing_floor_in_the_sun(0.5),
    "glass": reflected_by_glass(5.0),
    "lens": out_of_focus(0.75),
    "motion": moving_curtains(0.8),
}


def covers(interval: Interval, truth: float) -> bool:
    return interval.low <= truth <= interval.high


@pytest.mark.parametrize("case", CASES.values(), ids=CASES.keys())
def test_reported_shares_cover_the_closed_form_and_not_that_of_another_scene(case: Case) -> None:
    scene = et.load_dict(case.scene)
    shares = []
    for number in range(LISTS):
        found = et.effects(scene, quick=True, strategy=STRATEGY, seed=1000 * number, threads=1)
        (share,) = (price.variance for price in found.prices if price.kind.name == case.effect)
        assert share is not None
        shares.append(share)
    assert sum(covers(share, case.share) for share in shares) >= COVERED, (case.share, shares)
    assert sum(covers(share, case.wrong) for share in shares) < COVERED, (case.wrong, shares)
