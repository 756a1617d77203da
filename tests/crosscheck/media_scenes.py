"""Small scenes with media, as the volumetric integrator of Mitsuba sees them.

Where extinction is not grey, Mitsuba's is the integrator that minds colours: weights of the other have tails that no
number of seeds shows. The near clip is given: Mitsuba's rays, and with them its media, begin there, a hundredth away if
nothing is said.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from .scene_parts import Dict, at, ball, box, copies, floor, lamp, point, rgb, rough, scene, spot, window

__all__ = ["EVERYDAY_MEDIA", "MEDIA"]

EVERYDAY_MEDIA = ("a ball of coloured fog", "air and dust everywhere", "lights without extent behind thin glass")
NOTHING: Dict = {"type": "null"}
DUSTY: Dict = {
    "type": "blendphase",
    "weight": 0.6,
    "air": {"type": "rayleigh"},
    "dust": {"type": "blendphase", "weight": 0.25, "fine": {"type": "hg", "g": 0.7}, "coarse": {"type": "isotropic"}},
}
DUSTY_BY_VOLUME = DUSTY | {"weight": {"type": "constvolume", "value": 0.6}}
GREY, RUST = 0.9, (0.9, 0.5, 0.2)


def color(*values: float) -> Any:
    return values[0] if len(values) == 1 else rgb(*values)


def fog(g: float = 0.0, albedo: tuple[float, ...] = (GREY,), sigma_t: tuple[float, ...] = (0.4,), **more: Any) -> Dict:
    phase: Dict = {"type": "hg", "g": g} if g else {"type": "isotropic"}
    return {"type": "homogeneous", "albedo": color(*albedo), "sigma_t": color(*sigma_t), "phase": phase, **more}


def even(value: Any) -> Dict:
    return {"type": "constvolume", "value": value}


def volume(*objects: Dict, depth: int = 5, medium: Dict | None = None, integrator: str = "volpath") -> Dict:
    made = scene(*objects, near_clip=1e-3, **({} if medium is None else {"medium": medium}))
    return made | {"integrator": {"type": integrator, "max_depth": depth}}


def lit(*objects: Dict, depth: int = 5) -> Dict:
    return volume(floor(), lamp(), window(), *objects, depth=depth, integrator="volpathmis")


def everywhere(medium: Dict) -> Dict:
    """Fog on all sides of everything."""
    inside = {"exterior": medium}
    return volume(floor() | inside, lamp() | inside, box(**inside), point(-1, 2, -3), medium=medium)


def in_one_another() -> Dict:
    thin = fog(0.5)
    return lit(
        {"type": "cube", "to_world": at(0, 0, 0, [1.2, 0.9, 1.2]), "bsdf": NOTHING, "interior": thin},
        {"type": "sphere", "radius": 0.5, "bsdf": NOTHING, "interior": fog(0, (0.5,), scale=9.0), "exterior": thin},
    )


def half_there(opacity: float) -> Dict:
    return {"type": "mask", "opacity": opacity, "bsdf": {"type": "twosided", "bsdf": {"type": "diffuse"}}}


def behind_glass() -> Dict:
    """Panes of all kinds over a floor and a ball, below a point, a spot, a sun and a window."""
    glass: Dict = {"type": "thindielectric", "specular_transmittance": rgb(0.9, 0.8, 0.7)}
    squares = {"type": "checkerboard", "color0": rgb(0.9, 0.8, 0.3), "color1": rgb(0.2, 0.5, 0.9)}
    kinds = (
        glass,
        {"type": "mask", "opacity": 0.6, "bsdf": glass},
        {"type": "blendbsdf", "weight": 0.3, "glass": glass, "grain": {"type": "diffuse"}},
        {"type": "thindielectric", "int_ior": 2.0, "specular_transmittance": squares},
    )
    places = [at(1.1 * i - 1.6, 1.2 + 0.2 * i, 0.2, 0.6, -60 - 20 * i, (1, 0, 0)) for i in range(len(kinds))]
    panes = [{"type": "rectangle", "to_world": to, "bsdf": b} for to, b in zip(places, kinds, strict=True)]
    sun = {"type": "directional", "direction": [0.2, -1, -0.1], "irradiance": rgb(2, 2, 1)}
    lamps = (point(-1, 4, 1), spot((2, 4, 0), (0.5, -1, 0)), sun, window())
    return volume(floor(), ball(NOTHING, interior=fog(0.3)), *panes, *lamps, depth=4)


MEDIA: dict[str, Callable[[Path], Dict]] = {
    "a ball of fog": lambda _: lit(ball(NOTHING, interior=fog(0.6))),
    "a ball of coloured fog": lambda _: lit(ball(NOTHING, interior=fog(0.0, RUST, (0.9, 0.3, 0.1), scale=3.0))),
    "milk in glass": lambda _: lit(
        ball({"type": "dielectric", "int_ior": 1.3}, interior=fog(-0.4, (0.8,), RUST, scale=2.0)), depth=8
    ),
    "ink in glass": lambda _: lit(
        ball({"type": "dielectric", "int_ior": 1.3}, interior=fog(0.0, (0.0,), RUST, scale=2.0)), depth=8
    ),
    "jelly": lambda _: lit(
        ball({"type": "roughdielectric", "int_ior": 1.2, "alpha": 0.3}, interior=fog(0.3, (0.7,), RUST)), depth=6
    ),
    "a ball of air": lambda _: lit(ball(NOTHING, interior=fog(sigma_t=(2.0,)) | {"phase": {"type": "rayleigh"}})),
    "air and dust everywhere": lambda _: everywhere(fog(sigma_t=(0.3,)) | {"phase": DUSTY}),
    "fog of volumes": lambda _: lit(
        ball(NOTHING, interior=fog() | {"albedo": even(rgb(*RUST)), "sigma_t": even(2.0), "phase": DUSTY_BY_VOLUME})
    ),
    "fog everywhere": lambda _: everywhere(fog(0.5, sigma_t=(0.3,))),
    "fog in fog": lambda _: in_one_another(),
    "things in fog": lambda _: lit(
        {"type": "cube", "to_world": at(0, 0, 0, [1.5, 0.99, 1.2]), "bsdf": NOTHING, "interior": fog(0.5, RUST)},
        {"type": "sphere", "radius": 0.4, "bsdf": rough("ggx", 0.3), "exterior": fog(0.5, RUST)},
    ),
    "a mask that is crossed for nothing": lambda _: lit(
        {"type": "rectangle", "to_world": at(0, 0, 1, 0.8, 30), "bsdf": half_there(0.4)},
        {"type": "disk", "to_world": at(0.5, 0, 0, 0.8, 20), "bsdf": half_there(0.6)},
        depth=3,
    ),
    "thin glass that is crossed for nothing": lambda _: volume(
        *(floor(), {"type": "constant", "radiance": rgb(0.5, 0.4, 0.3)}),
        {"type": "rectangle", "to_world": at(0, 0, 1, 0.8, 30), "bsdf": {"type": "thindielectric"}},
        {"type": "sphere", "to_world": at(0.8, 0, 0, 0.6), "bsdf": {"type": "thindielectric"}, "interior": fog()},
        depth=2,
    ),
    "lights without extent behind thin glass": lambda _: behind_glass(),
    "fog in instances": lambda _: (
        copies(
            *(at(-1.2, 0, 0, 0.7, 30), at(0.8, 0.2, 0.5, [0.9, 0.5, 0.6], 60)),
            ball={"type": "sphere", "bsdf": NOTHING, "interior": fog(0.3, scale=5.0)},
        )
        | {"integrator": {"type": "volpath", "max_depth": 5}}
    ),
    "media that the integrator does not see": lambda _: volume(
        floor(), lamp(), ball(NOTHING, interior=fog()), integrator="path"
    ),
}
