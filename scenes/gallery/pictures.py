"""The scenes of the gallery: every plugin once, by its name."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from stage import (
    SIDE,
    Dict,
    ball,
    diffuse,
    hills,
    knot_on_floor,
    lamp,
    leaning,
    on_floor,
    stage,
    sunset,
    view,
    weave,
    write_gltf,
    write_obj,
    write_picture,
    write_ply,
    write_serialized,
)

__all__ = ["PICTURES"]

Scene = Callable[[Path], Dict]
RED, CREAM, BLUE = (0.65, 0.1, 0.08), (0.75, 0.68, 0.55), (0.1, 0.2, 0.55)
GOLD = {"type": "roughconductor", "material": "Au", "alpha": 0.15}
DIM = (sunset(0.12),)
MIXED = {"type": "blendphase", "weight": 0.5, "a": {"type": "rayleigh"}, "b": {"type": "hg", "g": 0.8}}


def picture(folder: Path, name: str = "weave.png") -> str:
    """Write a picture to be mapped onto something."""
    pixels = hills()[..., None].repeat(3, axis=2) if name == "hills.png" else weave()
    return write_picture(folder / name, pixels)


def matte(bsdf: Dict) -> Scene:
    """Return a ball of a surface that needs no files."""
    return lambda _: stage(ball(bsdf))


def shiny(bsdf: Dict) -> Scene:
    """Return a ball of a surface that shows what is around it, without the lamp, whose reflections are noise."""
    return lambda _: stage(ball(bsdf), lights=(sunset(0.8),))


def meshed(kind: str, write: Callable[[Path], str]) -> Scene:
    """Return the knot, read from a file of a kind."""
    return lambda folder: stage(knot_on_floor(kind, write(folder / f"knot.{kind}"), diffuse(*CREAM)))


def lit(*lights: Dict) -> Scene:
    """Return a ball and a box in a light."""
    box = {"type": "cube", "to_world": [*on_floor(0.4, 20, 0.4), {"translate": [1.3, 0, 0.6]}]}
    return lambda _: stage(ball(diffuse(*CREAM)), box, lights=lights)


def seen(**sensor: object) -> Scene:
    """Return balls in a row, through a camera."""
    row = [{"scale": 0.5}, {"translate": [0, 0.5, 0]}]
    places = ((-1.2, -2.5, RED), (-0.3, -0.5, CREAM), (0.7, 1.5, BLUE))
    balls = [
        {"type": "sphere", "to_world": [*row, {"translate": [x, 0, z]}], "bsdf": diffuse(*color)}
        for x, z, color in places
    ]
    whole = stage(*balls)
    return lambda _: whole | {"sensor": whole["sensor"] | sensor}


def sharp(kind: str, **parameters: float) -> Scene:
    """Return fine stripes through a filter, a few pixels of them."""
    board = {"type": "checkerboard", "color0": 0.02, "color1": 0.9, "to_uv": [{"scale": [4, 4, 1]}]}
    tile = {"type": "rectangle", "bsdf": {"type": "diffuse", "reflectance": board}}
    film = {"type": "hdrfilm", "width": 24, "height": 24, "rfilter": {"type": kind, **parameters}}
    camera = {"type": "perspective", "fov": 40.0, "to_world": view((0.6, 0.5, 2.2), (0, 0, 0)), "film": film}
    return lambda _: {"type": "scene", "sensor": camera, "tile": tile, "sky": {"type": "constant"}}


def integrated(integrator: Dict) -> Scene:
    """Return a ball before a wall in the corner of two colours, whose light the integrator takes or leaves."""
    wall = {"type": "rectangle", "to_world": [{"scale": 3}, {"translate": [0, 1, -2]}], "bsdf": diffuse(*BLUE)}
    side = [{"scale": 3}, {"rotate": {"axis": [0, 1, 0], "angle": -90}}, {"translate": [1.8, 1, 0]}]
    red = {"type": "rectangle", "to_world": side, "bsdf": diffuse(*RED)}
    return lambda _: stage(ball(diffuse(*CREAM)), wall, red, lights=(lamp(20),), integrator=integrator)


def copies(_: Path) -> Dict:
    """Return a group of two shapes, nine times."""
    leg = {"type": "cylinder", "p0": [0, 0, 0], "p1": [0, 0.6, 0], "radius": 0.08, "bsdf": both(diffuse(*CREAM))}
    cap = {"type": "sphere", "center": [0, 0.7, 0], "radius": 0.22, "bsdf": diffuse(*RED)}
    group = {"type": "shapegroup", "leg": leg, "cap": cap}
    places = [(0.9 * (i % 3 - 1), 0.0, 0.9 * (i // 3 - 1)) for i in range(9)]
    to = [[{"scale": 0.4 + 0.08 * i}, {"translate": list(place)}] for i, place in enumerate(places[::-1])]
    whole = [{"type": "instance", "shapegroup": {"type": "ref", "id": "thing0"}, "to_world": t} for t in to]
    return stage(group, *whole)


def both(bsdf: Dict) -> Dict:
    """Return the same on both sides."""
    return {"type": "twosided", "bsdf": bsdf}


def tube(bsdf: Dict) -> Dict:
    """Return a cylinder that shows its inside."""
    turned = [{"rotate": {"axis": [1, 0, 0], "angle": 55}}, {"rotate": {"axis": [0, 1, 0], "angle": 25}}]
    place = [*turned, {"translate": [0, 0.95, 0]}]
    return {"type": "cylinder", "p0": [0, -0.8, 0], "p1": [0, 0.8, 0], "radius": 0.7, "to_world": place, "bsdf": bsdf}


def tall(bsdf: Dict) -> Scene:
    """Return an upright tile, with a ball behind it."""
    tile = {"type": "rectangle", "to_world": on_floor(0.95, 25, 1.0), "bsdf": bsdf}
    behind = {"type": "sphere", "center": [0.5, 0.6, -1.2], "radius": 0.6, "bsdf": diffuse(*RED)}
    return lambda _: stage(tile, behind)


def textured(texture: Callable[[Path], Dict]) -> Scene:
    """Return a ball with a texture."""
    return lambda folder: stage(ball({"type": "diffuse", "reflectance": texture(folder)}))


def bumped(folder: Path) -> Dict:
    """Return a ball with bumps."""
    to_uv = [{"scale": [2, 1, 1]}]
    height = {"type": "bitmap", "filename": picture(folder, "hills.png"), "raw": True, "to_uv": to_uv}
    return stage(ball({"type": "bumpmap", "texture": height, "scale": 0.12, "bsdf": diffuse(*CREAM)}))


def mapped(folder: Path) -> Dict:
    """Return a ball with normals from a map, whose bytes are numbers and not colours."""
    path = write_picture(folder / "normals.png", leaning(hills(), 0.04), encoded=False)
    texture = {"type": "bitmap", "filename": path, "raw": True, "to_uv": [{"scale": [2, 1, 1]}]}
    shiny = {"type": "plastic", "diffuse_reflectance": list(BLUE)}
    return stage(ball({"type": "normalmap", "normalmap": texture, "bsdf": shiny}))


def holes(folder: Path) -> Dict:
    """Return round spots."""
    return {"type": "bitmap", "filename": picture(folder, "hills.png"), "raw": True}


def colored(folder: Path) -> Dict:
    """Return the knot with colours of its vertices."""
    paint = {"type": "diffuse", "reflectance": {"type": "mesh_attribute", "name": "vertex_color"}}
    return stage(knot_on_floor("ply", write_ply(folder / "knot.ply", colors=True), paint))


def cloudy(phase: Dict, sigma_t: object = 1.5, albedo: object = 0.98) -> Scene:
    """Return a ball of nothing but a medium, in the light of a lamp behind it."""
    medium = {"type": "homogeneous", "sigma_t": sigma_t, "albedo": albedo, "phase": phase}
    behind = {"type": "point", "position": [1.5, 2.5, -4.0], "intensity": 20.0}
    whole = stage(ball({"type": "null"}, interior=medium), lights=(sunset(0.3), behind))
    return lambda _: whole | {"integrator": {"type": "volpath", "max_depth": 16}}


def spotlight(*color: float) -> Dict:
    """Return a cone of light from above."""
    place = view((-1.5, 4.0, 2.5), (0.0, 0.7, 0.0))
    return {"type": "spot", "to_world": place, "intensity": list(color), "cutoff_angle": 16.0, "beam_width": 10.0}


SHAPES: dict[str, Scene] = {
    "sphere": matte(diffuse(*CREAM)),
    "cube": lambda _: stage({"type": "cube", "to_world": on_floor(0.8, 30, 0.8), "bsdf": diffuse(*CREAM)}),
    "rectangle": tall(both(diffuse(*CREAM))),
    "disk": lambda _: stage({"type": "disk", "to_world": on_floor(1, 25), "bsdf": both(diffuse(*CREAM))}),
    "cylinder": lambda _: stage(
        {"type": "cylinder", "p0": [0, 0, 0], "p1": [0, 1.7, 0], "radius": 0.8, "bsdf": both(diffuse(*CREAM))}
    ),
    "obj": meshed("obj", write_obj),
    "ply": meshed("ply", write_ply),
    "serialized": meshed("serialized", write_serialized),
    "gltf": meshed("gltf", write_gltf),
    "instance": copies,
}
SURFACES: dict[str, Scene] = {
    "diffuse": matte(diffuse(*RED)),
    "roughdiffuse": matte({"type": "roughdiffuse", "reflectance": list(RED), "alpha": 0.6}),
    "plastic": matte({"type": "plastic", "diffuse_reflectance": list(RED)}),
    "pplastic": matte({"type": "pplastic", "diffuse_reflectance": list(RED), "alpha": 0.1}),
    "roughplastic": matte({"type": "roughplastic", "diffuse_reflectance": list(RED), "alpha": 0.2}),
    "conductor": shiny({"type": "conductor", "material": "Cu"}),
    "roughconductor": shiny(GOLD),
    "dielectric": shiny({"type": "dielectric"}),
    "thindielectric": shiny({"type": "thindielectric"}),
    "roughdielectric": shiny({"type": "roughdielectric", "alpha": 0.2}),
    "principled": matte({"type": "principled", "base_color": list(BLUE), "roughness": 0.3, "clearcoat": 1.0}),
    "twosided": lambda _: stage(tube({"type": "twosided", "a": diffuse(*RED), "b": diffuse(*BLUE)})),
    "mask": lambda folder: tall({"type": "mask", "opacity": holes(folder), "b": both(GOLD)})(folder),
    "blendbsdf": shiny({"type": "blendbsdf", "weight": 0.5, "a": diffuse(*BLUE), "b": GOLD}),
    "bumpmap": bumped,
    "normalmap": mapped,
    "null": tall({"type": "null"}),
}
TEXTURES: dict[str, Scene] = {
    "bitmap": textured(lambda folder: {"type": "bitmap", "filename": picture(folder), "to_uv": [{"scale": [2, 1, 1]}]}),
    "checkerboard": textured(
        lambda _: {"type": "checkerboard", "color0": list(RED), "color1": list(CREAM), "to_uv": [{"scale": [8, 4, 1]}]}
    ),
    "mesh_attribute": colored,
}
LIGHTS: dict[str, Scene] = {
    "area": lit(lamp(25)),
    "point": lit({"type": "point", "position": [-1.5, 3, 2], "intensity": 25.0}, *DIM),
    "spot": lit(spotlight(60, 55, 45), *DIM),
    "directional": lit({"type": "directional", "direction": [1, -1.5, -0.7], "irradiance": 3.0}, *DIM),
    "constant": lit({"type": "constant", "radiance": 0.9}),
    "envmap": lit(sunset(1.0)),
}
MEDIA: dict[str, Scene] = {
    "homogeneous": cloudy({"type": "isotropic"}, sigma_t=2.5, albedo=[0.97, 0.85, 0.6]),
    "constvolume": cloudy({"type": "isotropic"}, sigma_t={"type": "constvolume", "value": [3.0, 1.0, 0.3]}, albedo=0.0),
    "isotropic": cloudy({"type": "isotropic"}),
    "hg": cloudy({"type": "hg", "g": 0.8}),
    "rayleigh": cloudy({"type": "rayleigh"}),
    "tabphase": cloudy({"type": "tabphase", "values": [0.3, 0.1, 0.1, 0.1, 0.3, 0.3, 2.0, 6.0]}),
    "blendphase": cloudy(MIXED),
}
CAMERAS: dict[str, Scene] = {
    "perspective": seen(),
    "thinlens": seen(type="thinlens", aperture_radius=0.25, focus_distance=6.2),
    "orthographic": lambda folder: seen()(folder) | {"sensor": parallel()},
    "spherical": lambda folder: seen()(folder) | {"sensor": everywhere()},
}
FILTERS: dict[str, Scene] = {
    name: sharp(name) for name in ("box", "tent", "gaussian", "mitchell", "catmullrom", "lanczos")
}
INTEGRATORS: dict[str, Scene] = {
    "path": integrated({"type": "path"}),
    "direct": integrated({"type": "direct"}),
    "depth": integrated({"type": "depth"}),
    "aov": integrated({"type": "aov", "aovs": "n:sh_normal", "inside": {"type": "path"}}),
}


def parallel() -> Dict:
    """Return a camera without perspective."""
    film = {"type": "hdrfilm", "width": SIDE, "height": SIDE}
    to_world = [{"scale": [2.2, 2.2, 1]}, *view((0.0, 2.2, 6.0), (0.0, 0.7, 0.0))]
    return {"type": "orthographic", "to_world": to_world, "film": film}


def everywhere() -> Dict:
    """Return a camera before the thing that sees all that is round it."""
    film = {"type": "hdrfilm", "width": SIDE, "height": SIDE}
    return {"type": "spherical", "to_world": view((0.0, 1.1, 1.9), (0.0, 0.9, 0.0)), "film": film}


PICTURES: dict[str, dict[str, Scene]] = {
    "Shapes": SHAPES,
    "Surfaces": SURFACES,
    "Textures": TEXTURES,
    "Lights": LIGHTS,
    "Media": MEDIA,
    "Cameras": CAMERAS,
    "Filters, enlarged": FILTERS,
    "Integrators": INTEGRATORS,
}
