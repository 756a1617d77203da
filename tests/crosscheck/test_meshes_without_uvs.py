"""What a mesh without texture coordinates has in their place, against Mitsuba 3: barycentric ones of each triangle.

Textures are looked up by these, and the triangle's edges are how its points move with them. Nothing is statistical: one
ray in a place, and light from a point.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import equaltime as et

mi = pytest.importorskip("mitsuba")
mi.set_variant("scalar_rgb")

from .material_scenes import both, bumpy, mapped, red  # noqa: E402
from .scene_parts import Dict, at, icosahedron, point, rough, towards  # noqa: E402

Array = NDArray[np.float64]
EYES = np.random.default_rng(4).normal(size=(24, 3))
EYES *= 4.0 / np.linalg.norm(EYES, axis=1, keepdims=True)
OFF = np.random.default_rng(5).uniform(-0.3, 0.3, (24, 3))
"""How far from the middle each eye looks."""


def principled(_: Path) -> Dict:
    return both({"type": "principled", "metallic": 1.0, "roughness": 0.4, "anisotropic": 0.8})


BSDFS: dict[str, Callable[[Path], Dict]] = {
    "a bump map": lambda folder: bumpy(folder / "b.exr", both(red()), 0.3),
    "a normal map": lambda folder: mapped(folder / "n.exr", both(red())),
    "brushed metal": lambda _: both(rough("ggx", 0.15, 0.6)),
    "principled, brushed metal": principled,
}
GROUP_AT = at(0.1, -0.2, 0.0, 0.5, 50)
PLACES: dict[str, Any] = {
    "in the world": None,
    "in a group": at(-0.2, 0.1, 0.3, [1.6, 0.7, 1.1], 35, (2, 1, 3)),
    "in a group, mirrored": at(-0.2, 0.1, 0.3, [-1.6, 0.7, 1.1], 35, (2, 1, 3)),
}


def placed(shape: Dict, place: Any) -> Dict:
    if place is None:
        return {"shape": shape}
    instance = {"type": "instance", "group": {"type": "ref", "id": "group"}, "to_world": place}
    return {"group": {"type": "shapegroup", "shape": shape}, "instance": instance}


def ball(folder: Path, suffix: str, **extra: Any) -> Dict:
    return {"type": suffix, "filename": str(icosahedron(folder / f"mesh.{suffix}")), "to_world": GROUP_AT, **extra}


def seen(objects: Dict, eye: Array, target: Array, fov: float = 1e-3) -> Dict:
    film = {"type": "hdrfilm", "width": 1, "height": 1, "pixel_format": "rgb", "rfilter": {"type": "box"}}
    camera = {"type": "perspective", "fov": fov, "to_world": towards(eye, target), "film": film}
    light = point(*(1.5 * eye + [0.5, 1.0, -0.7]))
    path = {"type": "path", "max_depth": 2}
    return {"type": "scene", "integrator": path, "sensor": camera, "light": light, **objects}


def images(objects: Dict) -> tuple[Array, Array]:
    """What each eye sees (N, 3), here and in Mitsuba."""
    scenes = [seen(objects, eye, off) for eye, off in zip(EYES, OFF, strict=True)]
    ours = [et.render(et.load_dict(scene), spp=1).image[0, 0] for scene in scenes]
    theirs = [np.array(mi.render(mi.load_dict(scene), spp=1))[0, 0] for scene in scenes]
    return np.array(ours, dtype=np.float64), np.array(theirs, dtype=np.float64)


@pytest.mark.parametrize("flat", [True, False], ids=["flat", "smooth"])
@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("bsdf", BSDFS)
def test_textures_and_tangents_follow_the_edges(bsdf: str, place: str, flat: bool, tmp_path: Path) -> None:
    shape = ball(tmp_path, "ply", face_normals=flat, bsdf=BSDFS[bsdf](tmp_path))
    ours, theirs = images(placed(shape, PLACES[place]))
    assert (theirs > 0.0).any(axis=1).mean() > 0.7, "most are lit"
    np.testing.assert_allclose(ours, theirs, rtol=2e-3, atol=1e-4 * theirs.max())


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("suffix", ["ply", "obj"])
def test_points_move_along_the_edges(suffix: str, place: str, tmp_path: Path) -> None:
    objects = placed(ball(tmp_path, suffix, bsdf={"type": "diffuse"}), PLACES[place])
    aov = {"type": "aov", "aovs": "u:dp_du, v:dp_dv, at:uv", "path": {"type": "path"}}
    ours = et.load_dict(seen(objects, EYES[0], OFF[0]) | {"integrator": aov}).core.intersect(EYES, OFF - EYES)
    whole = mi.load_dict({"type": "scene", **objects})
    rays = [mi.Ray3f(mi.Point3f(eye), mi.Vector3f(way)) for eye, way in zip(EYES, OFF - EYES, strict=True)]
    theirs = [whole.ray_intersect(ray) for ray in rays]
    assert (ours["shape"] >= 0).all()
    for name in ("dp_du", "dp_dv", "uv"):
        expected = np.array([np.array(getattr(it, name)).ravel() for it in theirs])
        np.testing.assert_allclose(ours[name], expected, atol=2e-5, err_msg=name)


@pytest.mark.parametrize("place", PLACES)
def test_they_change_as_fast_from_pixel_to_pixel(place: str, tmp_path: Path) -> None:
    objects = placed(ball(tmp_path, "ply", face_normals=True, bsdf={"type": "diffuse"}), PLACES[place])
    aov = {"type": "aov", "aovs": "x:duv_dx, y:duv_dy", "path": {"type": "path"}}
    for eye, off in zip(EYES, OFF, strict=True):
        scene = seen(objects, eye, off, fov=0.1) | {"integrator": aov}
        whole = mi.load_dict(scene)
        ray, _ = whole.sensors()[0].sample_ray_differential(0.0, 0.5, [0.5, 0.5], [0.5, 0.5])
        it = whole.ray_intersect(ray)
        it.compute_uv_partials(ray)
        expected = np.array([*it.duv_dx, *it.duv_dy])
        found = np.array([plane[0, 0] for plane in et.render(et.load_dict(scene), spp=1).aovs.values()])
        np.testing.assert_allclose(found, expected, atol=5e-3 * np.abs(expected).max())
