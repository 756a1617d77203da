"""Scenes for comparing strategies: shipped ones, small and of limited depth, and some that have what those lack.

No light is so small that sampling BSDFs alone hits upon it too rarely for the means of 64 seeds to be normal, except in
Veach's scene: without its smallest light it is a scene by itself.
"""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any, Final

import numpy as np
import OpenImageIO

import equaltime as et
from equaltime.scene.model import ThinLens, VolPath

__all__ = ["NAMES", "SIDE", "stage"]

SIDE: Final = 32
SHIPPED: Final = Path(__file__).parents[2] / "scenes"
NOTHING: Final = {"type": "null"}
METAL: Final = {"eta": [0.2, 0.9, 1.1], "k": [3.9, 2.4, 2.1]}
NAMES: Final = (
    "cornell",
    "veach",
    "veach without its small light",
    "montelight",
    "glossy",
    "sky",
    "point",
    "tubes",
    "fog",
)


def stage(name: str, folder: Path) -> et.Scene:
    """Return the scene of one of NAMES; `folder` is for the images that it needs."""
    rough = {"type": "roughconductor", "alpha": 0.2, **METAL}
    satin = {"type": "roughconductor", "distribution": "beckmann", "alpha_u": 0.5, "alpha_v": 0.2, **METAL}
    mirror, glass = {"type": "conductor", **METAL}, {"type": "dielectric", "int_ior": 1.5}
    if name == "cornell":
        return shipped("cornell-box.toml", 8)
    if name == "veach":
        return shipped("veach-mis.toml", 5)
    if name == "veach without its small light":
        veach = shipped("veach-mis.toml", 5)
        shapes = tuple(s for s in veach.model.shapes if s.id != "small_light")
        assert len(shapes) == len(veach.model.shapes) - 1
        return dataclasses.replace(veach, model=veach.model.model_copy(update={"shapes": shapes}))
    if name == "montelight":
        return shipped("montelight/simple.toml", 6)
    if name == "glossy":
        windows = {"w": window(-2, 1.0, [6, 5, 4]), "v": window(2, 0.7, [4, 8, 12])}
        return around(-1, floor=floor(), a=ball(-1, rough), b=ball(1, satin), **windows)
    if name == "sky":
        return around(8, floor=floor(), a=ball(-1, rough), b=ball(1, mirror), sky=sky(folder / "sky.exr"))
    if name == "tubes":
        return tubes(rough)
    if name == "fog":
        return fog(satin)
    bulb = {"type": "point", "position": [1, 1, 2], "intensity": [3, 3, 4]}
    return around(8, floor=floor(), a=ball(-1, satin), b=ball(1, glass), bulb=bulb, w=window(1.5, 1.5, [2, 2, 3]))


def shipped(name: str, depth: int) -> et.Scene:
    return et.load(SHIPPED / name).with_(size=(SIDE, SIDE), max_depth=depth)


def around(max_depth: int, **objects: dict[str, Any]) -> et.Scene:
    """Return a scene whose camera looks at the floor's middle from one side."""
    camera = {
        "type": "perspective",
        "fov": 40,
        "to_world": [{"look_at": {"origin": (0.5, 1.5, 5), "target": (0, -0.4, 0), "up": (0, 1, 0)}}],
        "film": {"type": "hdrfilm", "width": SIDE, "height": SIDE, "rfilter": {"type": "box"}},
    }
    integrator = {"type": "path", "max_depth": max_depth}
    return et.load_dict({"type": "scene", "integrator": integrator, "sensor": camera, **objects})


def tubes(bsdf: dict[str, Any]) -> et.Scene:
    """Under two tubes of light, a spot and a sun: instances of a group, seen through a lens."""
    tube = {"type": "cylinder", "p0": [-2, 2, 0.5], "p1": [-1, 1.5, 2], "radius": 0.5}
    inner = {"type": "cylinder", "p0": [1.5, 0, 1], "p1": [1.5, 1.5, 1], "radius": 0.8, "flip_normals": True}
    group = {"type": "shapegroup", "ball": {"type": "sphere", "radius": 0.6, "bsdf": bsdf}, "cube": {"type": "cube"}}
    copies = {
        f"copy{x}": {
            "type": "instance",
            "g": {"type": "ref", "id": "group"},
            "to_world": [{"scale": [0.5, 0.7, 0.4]}, {"translate": [x, -0.4, 0]}],
        }
        for x in (-1, 1)
    }
    spot = {
        "type": "spot",
        "intensity": [9, 6, 3],
        "to_world": [{"look_at": {"origin": (0, 3, 2), "target": (0, -1, 0)}}],
    }
    scene = around(
        5,
        floor=floor(),
        group=group,
        **copies,
        tube=tube | {"emitter": {"type": "area", "radiance": [2, 3, 4]}},
        inner=inner | {"emitter": {"type": "area", "radiance": [1, 2, 1]}},
        spot=spot,
        sun={"type": "directional", "direction": [1, -2, -1], "irradiance": [0.5, 0.5, 0.3]},
    )
    view = scene.model.sensor
    lens = ThinLens(to_world=view.to_world, fov=40.0, aperture_radius=0.1, focus_distance=5.0, film=view.film)
    return dataclasses.replace(scene, model=scene.model.model_copy(update={"sensor": lens}))


def fog(bsdf: dict[str, Any]) -> et.Scene:
    """Under a window and a dim sky: smoke in a cube, in which half a ball of milk is, of a higher priority."""
    smoke = {"type": "homogeneous", "sigma_t": [0.5, 1.0, 1.5], "albedo": 0.8, "phase": {"type": "hg", "g": 0.3}}
    milk = {"type": "homogeneous", "sigma_t": 3.0, "albedo": [0.9, 0.8, 0.5]}
    cube = {"type": "cube", "to_world": [{"scale": [1.2, 0.6, 0.8]}, {"translate": [0, -0.3, 0]}], "bsdf": NOTHING}
    scene = around(
        5,
        floor=floor(),
        smoke=cube | {"interior": smoke, "priority": 1},
        milk=ball(-1, NOTHING) | {"interior": milk, "priority": 2},
        a=ball(1, bsdf),
        window=window(0.5, 1.2, [6, 5, 4]),
        sky={"type": "constant", "radiance": 0.2},
    )
    return dataclasses.replace(scene, model=scene.model.replace(integrator=VolPath(max_depth=5)))


def floor() -> dict[str, Any]:
    to_world = [{"rotate": {"axis": (1, 0, 0), "angle": -90}}, {"scale": 4}, {"translate": (0, -1, 0)}]
    bsdf = {"type": "diffuse", "reflectance": [0.6, 0.5, 0.4]}
    return {"type": "rectangle", "to_world": to_world, "bsdf": bsdf}


def ball(x: float, bsdf: dict[str, Any]) -> dict[str, Any]:
    return {"type": "sphere", "center": [x, -0.3, 0], "radius": 0.7, "bsdf": bsdf}


def window(x: float, size: float, radiance: list[float]) -> dict[str, Any]:
    turned = {"look_at": {"origin": (x, 2.5, 1), "target": (0, -0.5, 0), "up": (0, 0, 1)}}
    return {
        "type": "rectangle",
        "to_world": [{"scale": size}, turned],
        "emitter": {"type": "area", "radiance": radiance},
        "bsdf": {"type": "diffuse", "reflectance": 0.5},
    }


def sky(path: Path) -> dict[str, Any]:
    """Return a map of the sky with a sun in it."""
    pixels = np.full((16, 32, 3), 0.3, np.float32)
    pixels[8:] = 0.05
    pixels[4, 9] = (20.0, 16.0, 10.0)
    out = OpenImageIO.ImageOutput.create(str(path))
    assert out is not None
    assert out.open(str(path), OpenImageIO.ImageSpec(32, 16, 3, "float"))
    assert out.write_image(pixels)
    out.close()
    return {"type": "envmap", "filename": str(path)}
