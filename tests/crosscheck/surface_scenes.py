"""Small scenes of plastics, glass and the principled model, as `feature_scenes` has them for everything else."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from .material_scenes import attribute, bitmap, board, both, picture
from .scene_parts import Dict, at, ball, box, colored, floor, lamp, light, mesh, rgb, scene, towards, window

__all__ = ["SURFACES"]

PALE, DARK = rgb(0.9, 0.8, 0.7), rgb(0.6, 0.2, 0.1)


def shown(bsdf: Dict, depth: int = 4) -> Dict:
    """A ball, a box and a tile, and a disk that shows its back, under two lamps and a dim sky."""
    return scene(
        *(floor(), lamp(), window(), {"type": "constant", "radiance": rgb(0.2, 0.3, 0.4)}),
        {"type": "sphere", "to_world": at(-1.1, 0, 0, 0.7, 40), "bsdf": bsdf},
        {"type": "cube", "to_world": at(0.4, -0.3, 0.4, 0.4, 50), "bsdf": bsdf},
        {"type": "rectangle", "to_world": at(1.3, 0.4, -0.5, 0.6, 20), "bsdf": bsdf},
        {"type": "disk", "to_world": at(0.2, 1.0, -1, 0.6, 160, (0, 1, 0)), "bsdf": bsdf},
        depth=depth,
    )


def through(bsdf: Dict, depth: int = 9) -> Dict:
    """A ball and a pane before a lamp that they hide, so that its light passes through or reflects."""
    lit = light("disk", towards((0, 0.2, -3), scale=0.9), 5, 6, 7)
    return scene(
        *(floor(), lit, {"type": "constant", "radiance": 0.3}),
        ball(bsdf),
        {"type": "rectangle", "to_world": at(1.3, 0.2, 0.8, 0.6, 20, (0, 1, 0)), "bsdf": bsdf},
        depth=depth,
    )


def principled(**parameters: Any) -> Dict:
    return {"type": "principled", "base_color": rgb(0.8, 0.5, 0.2), "roughness": 0.4, **parameters}


def frosted(**parameters: Any) -> Dict:
    return {"type": "roughdielectric", "alpha": 0.3, **parameters}


SURFACES: dict[str, Callable[[Path], Dict]] = {
    "plastic": lambda _: shown({"type": "plastic", "diffuse_reflectance": DARK}),
    "plastic of two sides, nonlinear": lambda _: shown(
        both({"type": "plastic", "diffuse_reflectance": PALE, "specular_reflectance": PALE, "nonlinear": True})
    ),
    "plastic of a bitmap": lambda folder: shown(
        {"type": "plastic", "diffuse_reflectance": bitmap(picture(folder / "picture.png")), "int_ior": 1.8}
    ),
    "rough plastic, GGX": lambda _: shown({"type": "roughplastic", "diffuse_reflectance": DARK, "distribution": "ggx"}),
    "rough plastic, Beckmann": lambda _: shown(
        both({"type": "roughplastic", "diffuse_reflectance": PALE, "alpha": 0.3, "nonlinear": True})
    ),
    "rough plastic of a checkerboard": lambda _: shown({"type": "roughplastic", "diffuse_reflectance": board()}),
    "frosted glass, GGX": lambda _: through(frosted(distribution="ggx")),
    "frosted glass, Beckmann": lambda _: through(frosted(distribution="beckmann", int_ior=1.8)),
    "frosted glass from within": lambda _: through(frosted(distribution="ggx", int_ior=1.0, ext_ior=1.3)),
    "frosted glass of textured roughness": lambda folder: through(
        frosted(distribution="ggx", alpha=bitmap(picture(folder / "grey.exr", channels=1), raw=True))
    ),
    "a thin pane": lambda _: through({"type": "thindielectric", "specular_transmittance": PALE}),
    "principled": lambda _: shown(both(principled())),
    "principled, a textured colour and roughness": lambda folder: shown(
        principled(
            base_color=bitmap(picture(folder / "picture.png")),
            roughness=bitmap(picture(folder / "grey.exr", channels=1), raw=True),
        )
    ),
    "principled, colours of vertices": lambda folder: mesh(  # which Mitsuba's plastics do not take
        colored(folder / "mesh.ply"), principled(base_color=attribute("vertex_color")), face_normals=True
    ),
    "principled, brushed metal": lambda _: shown(both(principled(metallic=1.0, anisotropic=0.7))),
    "principled, a coat": lambda _: shown(principled(clearcoat=1.0, clearcoat_gloss=0.3)),
    "principled, sheen and flatness": lambda _: shown(principled(sheen=1.0, sheen_tint=0.5, flatness=0.7)),
    "principled, glass": lambda _: through(principled(spec_trans=1.0, eta=1.4)),
    "principled, half glass": lambda _: through(principled(spec_trans=0.5, spec_tint=0.5, metallic=0.2)),
    "a box of everything": lambda _: scene(
        *(floor(), lamp(), window(), box(principled(clearcoat=0.5))),
        {"type": "sphere", "to_world": at(-1.4, -0.4, 0.5, 0.5), "bsdf": {"type": "plastic"}},
        {"type": "sphere", "to_world": at(1.4, -0.4, 0.5, 0.5), "bsdf": {"type": "roughplastic"}},
    ),
}
