"""Small scenes of textures and of BSDFs made of others, as `feature_scenes` has them for everything else."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np

from .scene_parts import (
    Dict,
    at,
    ball,
    box,
    colored,
    floor,
    icosahedron,
    lamp,
    mesh,
    metal,
    rgb,
    rough,
    scene,
    towards,
    window,
)

__all__ = ["EVERYDAY_MATERIALS", "MATERIALS"]


def picture(path: Path, width: int = 7, height: int = 5, channels: int = 3) -> Path:
    """Write an image of unlike pixels, 8 bits for PNG and half precision for EXR."""
    pixels = np.random.default_rng(3).uniform(0.05, 0.95, (height, width, channels)).astype(np.float32)
    image = mi.Bitmap(pixels)
    if path.suffix == ".png":
        image = image.convert(component_format=mi.Struct.Type.UInt8, srgb_gamma=True)
    else:
        image = image.convert(component_format=mi.Struct.Type.Float16)
    image.write(str(path))
    return path


def bitmap(path: Path, **extra: Any) -> Dict:
    return {"type": "bitmap", "filename": str(path), **extra}


def attribute(name: str, scale: float = 1.0) -> Dict:
    return {"type": "mesh_attribute", "name": name, "scale": scale}


def uv(*rows: list[float]) -> Any:
    """Return to_uv from the 2x3 matrix of (u, v, 1)."""
    (a, b, c), (d, e, f) = rows
    return mi.ScalarTransform4f([[a, b, 0, c], [d, e, 0, f], [0, 0, 1, 0], [0, 0, 0, 1]])


def board(scale: float = 4.0, **extra: Any) -> Dict:
    colors = {"color0": rgb(0.9, 0.3, 0.2), "color1": rgb(0.1, 0.2, 0.7)}
    return {"type": "checkerboard", "to_uv": uv([scale, 0, 0.1], [0, scale, 0.2]), **colors, **extra}


def painted(texture: Dict) -> Dict:
    return {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": texture}}


def shapes(texture: Dict) -> Dict:
    """Every shape with texture coordinates of its own, so turned that a wrong orientation would be seen."""
    bsdf = painted(texture)
    return scene(
        *(floor(), lamp(), window(), {"type": "constant", "radiance": 0.3}),
        {"type": "rectangle", "to_world": at(-1.2, 0.6, 0, 0.7, 30, (0, 1, 0)), "bsdf": bsdf},
        {"type": "sphere", "to_world": at(0.2, 0.8, 0, 0.6, 50, (1, 2, 1)), "bsdf": bsdf},
        {"type": "disk", "to_world": at(1.5, 0.5, 0, 0.7, -30, (0, 1, 0)), "bsdf": bsdf},
        {"type": "cube", "to_world": at(0.3, -0.5, 0.9, 0.4, 50), "bsdf": bsdf},
        {"type": "sphere", "to_world": at(-1, -0.5, 0.6, [0.4, -0.4, 0.4], 20), "bsdf": bsdf},
    )


def masked(opacity: Any, bsdf: Dict | None = None) -> Dict:
    return {"type": "mask", "opacity": opacity, "nested": bsdf or painted(rgb(0.8, 0.6, 0.2))}


def under_a_sky(whole: Dict) -> Dict:
    """For masks: without a sky Mitsuba drops what a path gathered if nothing but masks is behind them."""
    return whole | {"sky": {"type": "constant", "radiance": rgb(0.1, 0.2, 0.3)}}


def curtain(bsdf: Dict, depth: int = 6, *more: Dict) -> Dict:
    """A tile between the lamps and most of what they light, and one in front of the camera."""
    return scene(
        *(floor(), lamp(), window(), box(), *more, {"type": "constant", "radiance": rgb(0.1, 0.2, 0.3)}),
        {"type": "rectangle", "to_world": at(0, 1.6, 0.5, 1.2, -70, (1, 0, 0)), "bsdf": bsdf},
        {"type": "rectangle", "to_world": at(0.4, 0.3, 2, 0.5, 20, (0, 1, 0)), "bsdf": bsdf},
        depth=depth,
    )


def blended(weight: Any, first: Dict, second: Dict) -> Dict:
    return {"type": "blendbsdf", "weight": weight, "first": first, "second": second}


def waves(path: Path, size: int = 16) -> Path:
    """Write a grey image of smooth waves."""
    x, y = np.meshgrid(*2 * [np.arange(size) / size])
    height = 0.5 + 0.25 * np.sin(2 * np.pi * (x + 2 * y)) + 0.2 * np.cos(2 * np.pi * (2 * x - y))
    mi.Bitmap(height[..., None].astype(np.float32)).write(str(path))
    return path


def leaning(path: Path, size: int = 8, most: float = 0.6) -> Path:
    """Write a normal map, in floats."""
    n = np.random.default_rng(9).uniform(-most, most, (size, size, 3))
    n[..., 2] = 1.0
    n /= np.linalg.norm(n, axis=2, keepdims=True)
    mi.Bitmap((0.5 * n + 0.5).astype(np.float32)).write(str(path))
    return path


def bumpy(path: Path, bsdf: Dict, scale: float = 0.1, to_uv: Any = None, **extra: Any) -> Dict:
    height = bitmap(waves(path), raw=True) | ({} if to_uv is None else {"to_uv": to_uv})
    return {"type": "bumpmap", "texture": height, "scale": scale, "bsdf": bsdf, **extra}


def mapped(path: Path, bsdf: Dict, most: float = 0.6, **extra: Any) -> Dict:
    return {"type": "normalmap", "normalmap": bitmap(leaning(path, most=most), raw=True), "bsdf": bsdf, **extra}


def both(bsdf: Dict) -> Dict:
    return {"type": "twosided", "bsdf": bsdf}


def seen_from_both_sides(bsdf: Dict) -> Dict:
    """Tiles that show their fronts and their backs, and every shape with texture coordinates of its own."""
    parts = dict(shapes(board()))
    for part in parts.values():
        if isinstance(part, dict) and part.get("bsdf", {}).get("type") == "twosided":
            part["bsdf"] = bsdf
    parts["back"] = {"type": "rectangle", "to_world": at(1.2, -0.4, 1.0, 0.4, 150, (0, 1, 0)), "bsdf": bsdf}
    return parts


def red() -> Dict:
    return {"type": "diffuse", "reflectance": rgb(0.8, 0.1, 0.1)}


def brass(alpha: float = 0.3) -> Dict:
    """A rough metal, for blends: Mitsuba's lose light in a part that scatters into discrete directions."""
    return metal("roughconductor", alpha=alpha)


def screens(texture: Dict) -> Dict:
    """Lights whose radiance is a texture, near a floor and a box.

    None is a mesh: on those, Mitsuba's light samples find a quarter less than its scattered rays.
    """
    screen = {"type": "area", "radiance": texture}
    return scene(
        *(floor(), box()),
        {"type": "rectangle", "to_world": towards((-1.5, 0.5, 1), scale=[0.9, 0.6, 1]), "emitter": screen},
        {"type": "sphere", "to_world": at(1.4, 0.6, 0, 0.4, 50, (1, 2, 1)), "emitter": screen},
        {"type": "disk", "to_world": towards((1.5, 0, 1.5), scale=0.4), "emitter": screen},
    )


EVERYDAY_MATERIALS = ("a bitmap on every shape", "a mask of a bitmap", "colours of vertices")

MATERIALS: dict[str, Callable[[Path], Dict]] = {
    "a bitmap on every shape": lambda folder: shapes(bitmap(picture(folder / "picture.png"))),
    "a checkerboard on every shape": lambda _: shapes(board()),
    "a bitmap of nearest texels": lambda folder: shapes(bitmap(picture(folder / "picture.png"), filter_type="nearest")),
    "a bitmap of raw bytes": lambda folder: shapes(bitmap(picture(folder / "picture.png"), raw=True)),
    "a bitmap in half precision": lambda folder: shapes(bitmap(picture(folder / "picture.exr"))),
    "a grey bitmap": lambda folder: shapes(bitmap(picture(folder / "picture.png", channels=1))),
    "a bitmap that is repeated": lambda folder: shapes(
        bitmap(picture(folder / "picture.png"), to_uv=uv([2.5, 0.5, 0.1], [-0.3, -1.7, 0.2]))
    ),
    "a bitmap that is mirrored": lambda folder: shapes(
        bitmap(picture(folder / "picture.png"), wrap_mode="mirror", to_uv=uv([2.5, 0.5, 0.1], [-0.3, -1.7, 0.2]))
    ),
    "a bitmap that is clamped": lambda folder: shapes(
        bitmap(picture(folder / "picture.png"), wrap_mode="clamp", to_uv=uv([1.5, 0.5, -0.3], [-0.3, -1.7, 0.8]))
    ),
    "a bitmap on a mesh with coordinates, PLY": lambda folder: mesh(
        icosahedron(folder / "mesh.ply", uvs=True),
        painted(bitmap(picture(folder / "picture.png"))),
        face_normals=True,
    ),
    "a bitmap on a mesh with coordinates, OBJ": lambda folder: mesh(
        icosahedron(folder / "mesh.obj", uvs=True),
        painted(bitmap(picture(folder / "picture.png"))),
        face_normals=True,
    ),
    "a bitmap on a mesh without coordinates": lambda folder: mesh(
        icosahedron(folder / "mesh.ply"), painted(bitmap(picture(folder / "picture.png")))
    ),
    "colours of vertices": lambda folder: mesh(
        colored(folder / "mesh.ply"), painted(attribute("vertex_color")), face_normals=True
    ),
    "colours of faces": lambda folder: mesh(
        colored(folder / "mesh.ply"), painted(attribute("face_p_color", 0.8)), face_normals=True
    ),
    "a metal as rough as its vertices say": lambda folder: mesh(
        colored(folder / "mesh.ply"), metal("roughconductor", alpha=attribute("vertex_w", 0.5)), face_normals=True
    ),
    "a mask of numbers of faces": lambda folder: under_a_sky(
        mesh(colored(folder / "mesh.ply"), masked(attribute("face_q")), face_normals=True)
    ),
    "a metal of textured colour and roughness": lambda folder: scene(
        *(floor(), lamp(), window(), {"type": "constant", "radiance": 0.3}),
        ball(
            metal(
                "roughconductor",
                alpha=bitmap(picture(folder / "grey.exr", channels=1), raw=True),
                specular_reflectance=bitmap(picture(folder / "picture.png")),
            )
        ),
    ),
    "a mirror of textured colour": lambda folder: scene(
        floor(), lamp(), window(), box(metal(specular_reflectance=bitmap(picture(folder / "picture.png"))))
    ),
    "a mask": lambda _: curtain(masked(0.3)),
    "a mask of a bitmap": lambda folder: curtain(masked(bitmap(picture(folder / "grey.png", channels=1), raw=True))),
    "a mask of a coloured bitmap": lambda folder: curtain(masked(bitmap(picture(folder / "picture.png")))),
    "a mask of a checkerboard": lambda _: curtain(masked(board())),
    "a mask of one side": lambda _: curtain(masked(0.6, red())),
    "a mask of a mirror": lambda _: curtain(masked(0.5, {"type": "twosided", "bsdf": metal()})),
    "a mask of glass": lambda _: curtain(masked(0.5, {"type": "dielectric"})),
    "a mask of a rough metal": lambda _: curtain(
        masked(0.5, {"type": "twosided", "bsdf": metal("roughconductor", alpha=0.2)})
    ),
    "masks and few vertices": lambda _: curtain(masked(0.3), 3),
    "a mask round a light": lambda _: curtain(
        masked(0.4), 7, {"type": "sphere", "to_world": at(1, 3, 2, 0.8), "bsdf": masked(0.4)}
    ),
    "nothing": lambda _: curtain({"type": "null"}),
    "a blend": lambda _: shapes_of(blended(0.3, red(), brass())),
    "a blend by a bitmap": lambda folder: shapes_of(
        blended(bitmap(picture(folder / "grey.exr", channels=1), raw=True), red(), brass())
    ),
    "a blend of blends": lambda _: shapes_of(blended(0.6, blended(0.2, red(), brass()), blended(0.7, red(), brass()))),
    "a normal map": lambda folder: seen_from_both_sides(mapped(folder / "n.exr", both(red()))),
    "a normal map on a mirror image": lambda folder: seen_from_both_sides(both(mapped(folder / "n.exr", red()))),
    "a normal map without shadowing": lambda folder: seen_from_both_sides(
        mapped(folder / "n.exr", both(red()), use_shadowing_function=False)
    ),
    "a normal map that leans far": lambda folder: seen_from_both_sides(mapped(folder / "n.exr", both(red()), 3.0)),
    "a normal map on a rough metal": lambda folder: seen_from_both_sides(both(mapped(folder / "n.exr", brass(), 0.3))),
    "a normal map on brushed metal": lambda folder: seen_from_both_sides(
        mapped(folder / "n.exr", both(rough("ggx", 0.1, 0.4)), 0.3)
    ),
    "a bump map": lambda folder: seen_from_both_sides(bumpy(folder / "b.exr", both(red()))),
    "a bump map on a mirror image": lambda folder: seen_from_both_sides(both(bumpy(folder / "b.exr", red()))),
    "a bump map, scaled and turned": lambda folder: seen_from_both_sides(
        bumpy(folder / "b.exr", both(red()), 0.2, uv([1.5, 0.5, 0.1], [-0.5, 2.0, 0.2]))
    ),
    "a bump map on a mesh": lambda folder: mesh(
        icosahedron(folder / "mesh.ply", uvs=True), bumpy(folder / "b.exr", red()), face_normals=True
    ),
    "lights of a bitmap": lambda folder: screens(bitmap(picture(folder / "picture.exr", 9, 6))),
    "lights of a checkerboard": lambda _: screens(board(3.0)),
    "two sides, each a blend": lambda _: scene(
        *(floor(), lamp(), window()),
        {
            "type": "rectangle",
            "to_world": towards((0, 0, 0), (1, -0.3, 0), 0.9),
            "bsdf": {
                "type": "twosided",
                "front": blended(0.5, red(), brass()),
                "behind": {"type": "diffuse", "reflectance": board()},
            },
        },
    ),
}


def shapes_of(bsdf: Dict) -> Dict:
    """A ball, a box and a tile of one BSDF on both sides."""
    sides = both(bsdf)
    return scene(
        *(floor(), lamp(), window(), {"type": "constant", "radiance": rgb(0.2, 0.3, 0.4)}),
        {"type": "sphere", "to_world": at(-1.1, 0, 0, 0.7, 40), "bsdf": sides},
        {"type": "cube", "to_world": at(0.4, -0.3, 0.4, 0.4, 50), "bsdf": sides},
        {"type": "rectangle", "to_world": at(1.3, 0.4, -0.5, 0.6, 20), "bsdf": sides},
    )
