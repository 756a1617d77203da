"""Scenes in which errors are easy to misjudge, the reference of each, and how a rate of runs is judged.

``flat``, ``glass``, ``cornell`` and ``slit`` are ordinary. In ``door`` all light comes through a door that stands ajar.
``caustic`` and ``sun`` focus a small lamp, or one bright texel of the sky, through a ball of glass. ``tinylamp`` has a
lamp far smaller than a pixel in sight, over a glossy floor; ``mis`` is Veach's scene of plates and lamps.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from measuring import SCENES
from numpy.typing import NDArray

import equaltime as et
from equaltime.film.lamps import Lamps
from equaltime.film.moments import squared_deviations
from equaltime.images import image_files as images
from equaltime.images.metrics import Reference
from equaltime.rendering.core import core_settings, make_renderer
from equaltime.strategy import Strategy

__all__ = ["TRIALS", "realised_square", "reference", "trial_scene", "wilson"]

Floats = NDArray[np.float64]

BUILD = Path(__file__).resolve().parents[2] / "build" / "trials"
_FEW = 64
"""Most pixels of a window around small lamps whose reference gets more samples."""
REFERENCE_SEEDS = (2**63 + 11, 2**63 + 12)
"""Far from those of any run."""


def trial_scene(name: str, side: int) -> et.Scene:
    """Return a scene of `TRIALS` with ``side`` pixels along each side."""
    return TRIALS[name]().with_(size=(side, side))


def reference(name: str, side: int, spp: int) -> Reference:
    """Return a reference of independent samples with the variance of its pixels; rendered once, then read.

    Pixels that see lamps smaller than a pixel get 1024 times the samples, if they are few and close together.
    """
    path = BUILD / f"{name.replace(' ', '-')}_{side}_{spp}_lamps.npz"
    if not path.exists():
        scene = trial_scene(name, side)
        mean, variance = _rendered(scene, spp)
        lamps = Lamps.of(scene.core, core_settings(scene, Strategy()), 0, 0, False).pixels
        if lamps.size:
            (top, left), (bottom, right) = ([each(axis) for axis in divmod(lamps, side)] for each in (np.min, np.max))
            width, height = int(right - left + 1), int(bottom - top + 1)
            if width * height <= _FEW:
                there = np.s_[top : bottom + 1, left : right + 1]
                window = scene.with_(crop=(int(left), int(top), width, height))
                mean[there], variance[there] = _rendered(window, 1024 * spp)
        path.parent.mkdir(parents=True, exist_ok=True)
        np.savez(path, mean=mean, variance=variance)
    found = np.load(path)
    return Reference(found["mean"], found["variance"])


def _rendered(scene: et.Scene, spp: int) -> tuple[Floats, Floats]:
    """Return the mean of independent samples and its variance, of every pixel, (H, W, 3)."""
    strategy, moments = Strategy.parse("mis,lights=power,sampler=independent,roulette=none"), []
    for seed in REFERENCE_SEEDS:
        renderer = make_renderer(scene, strategy, seed, 0)
        renderer.advance(spp // 2)
        moments += [*renderer.moments.copy()]
    counts = np.array([m["count"] for m in moments], np.float64)[..., None]
    means, total = np.array([m["mean"] for m in moments]), counts.sum(axis=0)
    mean = (counts * means).sum(axis=0) / total
    squares = sum(squared_deviations(m) for m in moments) + (counts * np.square(means - mean)).sum(axis=0)
    return mean, squares / ((total - 1.0) * total)


def realised_square(image: Floats, truth: Reference) -> float:
    """Return error² of an image against a reference, whose own noise is subtracted; it may be negative."""
    denominator = np.square(truth.mean) + (0.1 * truth.mean.mean()) ** 2
    squares = np.square(image - truth.mean) - truth.variance
    parts = np.divide(squares, denominator, out=np.zeros_like(squares), where=denominator > 0.0)
    return float(parts.mean())


def wilson(hits: int, runs: int) -> tuple[float, float]:
    """Return the 95 % interval of a rate (Wilson 1927)."""
    if runs == 0:
        return 0.0, 1.0
    z, p = 1.96, hits / runs
    middle = (p + z * z / (2 * runs)) / (1 + z * z / runs)
    half = z * math.sqrt(p * (1 - p) / runs + z * z / (4 * runs * runs)) / (1 + z * z / runs)
    return middle - half, middle + half


def _camera(origin: tuple[float, ...], target: tuple[float, ...], fov: float = 40) -> dict[str, Any]:
    look = {"origin": [*origin], "target": [*target], "up": [0, 1, 0]}
    film = {"type": "hdrfilm", "width": 32, "height": 32, "rfilter": {"type": "box"}}
    return {"type": "perspective", "fov": fov, "to_world": [{"look_at": look}], "film": film}


def _table(bsdf: Mapping[str, Any] | None = None) -> dict[str, Any]:
    lying = [{"rotate": {"axis": [1, 0, 0], "angle": -90}}, {"scale": 4}]
    return {"type": "rectangle", "to_world": lying, "bsdf": bsdf or {"type": "diffuse", "reflectance": 0.6}}


def _ball(bsdf: Mapping[str, Any], radius: float = 0.7) -> dict[str, Any]:
    return {"type": "sphere", "center": [0, radius, 0], "radius": radius, "bsdf": bsdf}


def _lamp(center: tuple[float, ...], radius: float, radiance: float) -> dict[str, Any]:
    return {"type": "sphere", "center": [*center], "radius": radius, "emitter": {"type": "area", "radiance": radiance}}


def _made(**elements: Any) -> et.Scene:
    integrator = {"type": "path", "max_depth": 6}
    camera = _camera((0, 2.4, 4), (0, 0.4, 0))
    return et.load_dict({"type": "scene", "integrator": integrator, "sensor": camera, **elements})


def _flat() -> et.Scene:
    sky = {"type": "constant", "radiance": 1.0}
    return _made(table=_table(), ball=_ball({"type": "diffuse", "reflectance": 0.5}), sky=sky)


def _glass() -> et.Scene:
    return _made(table=_table(), ball=_ball({"type": "dielectric"}, 0.9), sky={"type": "constant", "radiance": 0.5})


def _caustic() -> et.Scene:
    return _made(table=_table(), ball=_ball({"type": "dielectric"}), lamp=_lamp((-1.2, 4, 0.5), 0.1, 400))


def _sun() -> et.Scene:
    path = BUILD / "sun.exr"
    if not path.exists():
        path.parent.mkdir(parents=True, exist_ok=True)
        sky = np.full((64, 128, 3), 0.2, np.float32)
        sky[12, 40] = 2000.0
        images.write_exr(path, sky)
    return _made(table=_table(), ball=_ball({"type": "dielectric"}), sky={"type": "envmap", "filename": str(path)})


def _tinylamp() -> et.Scene:
    glossy = {"type": "roughconductor", "alpha": 0.1}
    return _made(table=_table(glossy), lamp=_lamp((0.2, 0.9, -0.5), 0.004, 1e5))


def _slit() -> et.Scene:
    """Return a lamp behind two lids that leave a slit, and a wall behind."""
    wall = {
        "type": "rectangle",
        "to_world": [{"scale": 4}, {"translate": [0, 0, -2]}],
        "bsdf": {"type": "diffuse", "reflectance": 0.6},
    }
    black = {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": 0.0}}
    lying = {"rotate": {"axis": [1, 0, 0], "angle": -90}}
    lids = {
        f"lid{side}": {
            "type": "rectangle",
            "to_world": [lying, {"scale": [2, 1, 4]}, {"translate": [at, 2.6, 0]}],
            "bsdf": black,
        }
        for side, at in enumerate((-2.02, 2.02))
    }
    return _made(table=_table(), wall=wall, lamp=_lamp((0, 3, 0), 0.3, 100), **lids)


def _door() -> et.Scene:
    """Return two rooms with a door between them that stands ajar: one sees the lamp, the other holds the camera."""
    pale = {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": [0.7, 0.65, 0.6]}}

    def block(size: list[float], *steps: dict[str, Any]) -> dict[str, Any]:
        return {"type": "cube", "to_world": [{"scale": size}, *steps], "bsdf": pale}

    # each wall ends at the door's frame; the door is as high as the room, and turned by 12 degrees about its hinge
    door = ({"translate": [0.0, 0.0, -0.25]}, {"rotate": {"axis": [0, 1, 0], "angle": 12}})
    return et.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "path", "max_depth": 8},
            "sensor": _camera((0.95, 0.2, 0.9), (0.4, -0.3, -0.6), 60),
            "room": block([1, 1, 1]),
            "left_wall": block([0.02, 1, 0.5], {"translate": [0, 0, -0.5]}),
            "right_wall": block([0.02, 1, 0.25], {"translate": [0, 0, 0.75]}),
            "door": block([0.015, 1, 0.25], *door, {"translate": [0, 0, 0.5]}),
            "ball": {"type": "sphere", "center": [0.5, -0.7, -0.4], "radius": 0.3, "bsdf": pale},
            "glossy_ball": {
                "type": "sphere",
                "center": [0.75, -0.8, 0.1],
                "radius": 0.2,
                "bsdf": {"type": "roughconductor", "alpha": 0.2},
            },
            "lamp": {
                "type": "rectangle",
                "to_world": [
                    {"scale": 0.15},
                    {"rotate": {"axis": [1, 0, 0], "angle": 90}},
                    {"translate": [-0.6, 0.99, -0.4]},
                ],
                "emitter": {"type": "area", "radiance": 60},
            },
        }
    )


def _cornell() -> et.Scene:
    return et.load(SCENES / "cornell-box.toml").with_(max_depth=8)


def _mis() -> et.Scene:
    return et.load(SCENES / "mitsuba/veach-mis/scene.xml", integrator="path").with_(max_depth=9)


TRIALS: Mapping[str, Callable[[], et.Scene]] = {
    "flat": _flat,
    "glass": _glass,
    "cornell": _cornell,
    "slit": _slit,
    "door": _door,
    "mis": _mis,
    "tinylamp": _tinylamp,
    "caustic": _caustic,
    "sun": _sun,
}
