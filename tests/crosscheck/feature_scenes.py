"""Small scenes, one for each feature: dictionaries that both Mitsuba and equaltime take as they are."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from .scene_parts import (
    Dict,
    at,
    ball,
    box,
    copies,
    flat,
    floor,
    from_afar,
    glass,
    hidden,
    icosahedron,
    lamp,
    light,
    lights,
    mesh,
    metal,
    metals,
    point,
    red_and_green,
    rgb,
    rough,
    scene,
    seen,
    sky,
    slide,
    spot,
    towards,
    turned_tile,
    window,
)

__all__ = ["EVERYDAY", "OTHER_RULE", "SCENES", "lights"]

EVERYDAY = (
    "cube lights",
    "many lights of unlike power",
    "rough metals, GGX 0.4",
    "a glass ball",
    "a crop",
    "hidden emitters",
)
"""The scenes of the everyday suite; the others are for ``-m slow``."""
OTHER_RULE = ("a mesh turned over", "a smooth mesh of two sides", "a smooth mesh of glass")
"""Where interpolated and geometric normal see a direction on different sides, both sides of which scatter light: the
geometric normal decides in equaltime, the interpolated one in Mitsuba."""

SCENES: dict[str, Callable[[Path], Dict]] = {
    "sphere lights": lambda _: lights("sphere"),
    "disk lights": lambda _: lights("disk"),
    "rectangle lights": lambda _: lights("rectangle"),
    "cube lights": lambda _: lights("cube"),
    "sphere lights inside out": lambda _: scene(
        *(floor(), box(), lamp()), light("sphere", at(0, 0, 0, 8), 0.3, 0.2, 0.1, flip_normals=True)
    ),
    "disk lights turned over": lambda _: lights("disk", flip_normals=True),
    "rectangle lights turned over": lambda _: lights("rectangle", flip_normals=True),
    "cube lights inside out": lambda _: scene(
        *(floor(), box(), lamp()), light("cube", at(0, 0, 0, 8), 0.3, 0.2, 0.1, flip_normals=True)
    ),
    "mesh lights": lambda folder: scene(
        *(floor(), box(), lamp()),
        light("ply", at(-1.5, 0.5, 1, 0.3), **flat(icosahedron(folder / "mesh.ply"))),
        light("obj", at(1.5, 0.5, 0, 0.3), 5, 3, 4, **flat(icosahedron(folder / "mesh.obj", normals=True))),
    ),
    "a lamp that reflects": lambda _: scene(
        floor(), box(), light("sphere", at(1, 1, 1, 0.5), 1, 2, 3, bsdf={"type": "diffuse", "reflectance": 0.8})
    ),
    "a point light": lambda _: scene(floor(), point(1, 2, 3), box()),
    "a spot light": lambda _: scene(
        *(floor(), box(), light("sphere", at(1, 3, -2, 0.5)), spot((1, 3, 2), (0, -0.5, 0))),
        spot((-2, 2, 1), (-1, -1, 0), cutoff_angle=30.0, beam_width=5.0),
    ),
    "a projector": lambda folder: scene(
        *(floor(), box(), lamp(), spot((-2, 2, 1), (-1, -1, 0), cutoff_angle=30.0, beam_width=5.0)),
        spot(
            (1, 3, 2),
            (0, -0.5, 0),
            cutoff_angle=25.0,
            texture={"type": "bitmap", "filename": slide(folder / "slide.exr")},
        ),
    ),
    "directional lights": lambda _: scene(
        *(floor(), box(), {"type": "constant", "radiance": 0.1}),
        {"type": "directional", "direction": [1, -2, -0.5], "irradiance": rgb(3, 2, 1)},
        {"type": "directional", "to_world": towards((0, 0, 0), (-1, -1, -1)), "irradiance": rgb(0.2, 0.2, 1)},
    ),
    "cylinder lights": lambda _: scene(
        *(floor(), box()),
        light("cylinder", at(-1.5, 0.5, 0.5, 0.4, 60), 5, 4, 3, p0=[0, 0, -1], p1=[0, 0.5, 1], radius=0.4),
        light("cylinder", at(1.5, 0.5, 0, 0.8, 30), 2, 8, 3, flip_normals=True, radius=0.5),
    ),
    "cylinders": lambda _: scene(
        *(floor(), lamp(), window()),
        {"type": "cylinder", "p0": [-1, -1, 0], "p1": [-0.6, 0.8, 0.3], "radius": 0.4, "bsdf": red_and_green()},
        {"type": "cylinder", "to_world": at(0.9, -0.5, 0, 0.6, 70), "bsdf": rough("ggx", 0.1, 0.4)},
        {"type": "cylinder", "to_world": at(0, 0.6, 1, 0.3, 90), "bsdf": {"type": "twosided", "b": metal()}},
    ),
    "many lights of unlike power": lambda _: scene(
        *(floor(), point(-1, 2, -3), lamp(), window(), box(), light("disk", at(-1.5, 1, 0, 0.3), 40, 1, 1)),
        {"type": "constant", "radiance": rgb(0.5, 0.4, 0.3)},
    ),
    "a constant sky": lambda _: scene(floor(), {"type": "constant", "radiance": rgb(0.5, 0.7, 0.9)}, box()),
    "an environment image": lambda folder: sky(folder / "sky.exr", 16, 9),
    "an environment image of even height": lambda folder: sky(folder / "sky.exr", 11, 6),
    "only emitted light": lambda _: scene(floor(), lamp(), window(), box(), depth=1),
    "direct light": lambda _: scene(floor(), lamp(), window(), box(), depth=2),
    "paths of any length": lambda _: scene(
        *(floor(), box(), light("sphere", at(0, 0, 0, 8), 0.3, 0.2, 0.1, flip_normals=True)), depth=-1
    ),
    "a mirror": lambda _: scene(floor(), lamp(), window(), box(metal(specular_reflectance=rgb(0.9, 0.5, 0.7)))),
    "a perfect mirror": lambda _: scene(floor(), lamp(), window(), ball({"type": "conductor", "material": "none"})),
    "rough metals, GGX 0.4": lambda _: metals("ggx", 0.4),
    "rough metals, GGX 0.05": lambda _: metals("ggx", 0.05),
    "rough metals, GGX 1": lambda _: metals("ggx", 1.0),
    "rough metals, Beckmann 0.4": lambda _: metals("beckmann", 0.4),
    "rough metals, Beckmann 0.05": lambda _: metals("beckmann", 0.05),
    "rough metals, Beckmann 1": lambda _: metals("beckmann", 1.0),
    "brushed metals, GGX": lambda _: metals("ggx", 0.08, 0.4),
    "brushed metals, Beckmann": lambda _: metals("beckmann", 0.5, 0.1),
    "a glass ball": lambda _: glass(int_ior=1.5, ext_ior=1.0),
    "a coloured glass ball": lambda _: glass(
        int_ior="bk7", specular_reflectance=rgb(0.9, 0.5, 0.7), specular_transmittance=rgb(0.5, 0.9, 0.7)
    ),
    "a bubble in water": lambda _: glass(int_ior="air", ext_ior="water"),
    "a pane of glass": lambda _: scene(
        *(floor(), lamp(), window()),
        {"type": "rectangle", "to_world": at(0, 0, 1, 0.8, 30), "bsdf": {"type": "dielectric"}},
        {"type": "disk", "to_world": at(1, 0, 0, 0.8, 150), "bsdf": {"type": "dielectric"}, "flip_normals": True},
        depth=6,
    ),
    "a ball of light in a ball of glass": lambda _: scene(
        floor(), light("sphere", at(0, 0, 0, 0.4), 3, 2, 1), ball({"type": "dielectric", "int_ior": 1.3}), depth=8
    ),
    "a tile's front": lambda _: scene(floor(), lamp(), window(), turned_tile(30)),
    "a tile's back": lambda _: scene(floor(), lamp(), window(), turned_tile(200)),
    "a tile turned over": lambda _: scene(floor(), lamp(), window(), turned_tile(30, flip_normals=True)),
    "a ball inside out": lambda _: scene(floor(), lamp(), ball(red_and_green(), flip_normals=True)),
    "mirrored shapes": lambda _: scene(
        *(floor(), lamp(), window()),
        {"type": "sphere", "to_world": at(-1.2, 0, 0, [-0.6, 0.6, 0.6], 40), "bsdf": red_and_green()},
        {"type": "cube", "to_world": at(0.2, 0, 0, [0.4, -0.4, 0.4], 40), "bsdf": red_and_green()},
        {"type": "rectangle", "to_world": at(1.3, 0, 0, [0.5, 0.5, -0.5], 20), "bsdf": red_and_green()},
        {"type": "disk", "to_world": at(0.5, 1.1, 0, [-0.5, 0.5, 0.5], 20), "bsdf": red_and_green()},
    ),
    "stretched shapes": lambda _: scene(
        *(floor(), lamp(), window()),
        {"type": "sphere", "to_world": at(-1.2, 0, 0, [0.6, 0.9, 0.2], 40), "bsdf": red_and_green()},
        light("sphere", at(0.3, 1.2, -1, [-0.3, 0.9, 0.2], 70), 3, 4, 2, flip_normals=True),
        {"type": "cylinder", "to_world": at(1.0, -0.5, 0, [0.3, 0.3, 1.5], 70), "bsdf": rough("ggx", 0.1, 0.4)},
        light("cylinder", at(0, -0.8, 1.2, [0.1, 0.1, 0.6], 90), 4, 2, 1),
    ),
    "a mesh without normals, PLY": lambda folder: mesh(icosahedron(folder / "mesh.ply")),
    "a mesh without normals, OBJ": lambda folder: mesh(icosahedron(folder / "mesh.obj")),
    "a mesh with normals, PLY": lambda folder: mesh(icosahedron(folder / "mesh.ply", normals=True)),
    "a mesh with normals, OBJ": lambda folder: mesh(icosahedron(folder / "mesh.obj", normals=True)),
    "a mesh with normals shaded flat": lambda folder: mesh(
        icosahedron(folder / "mesh.ply", normals=True), face_normals=True
    ),
    "a mesh turned over": lambda folder: mesh(
        icosahedron(folder / "mesh.obj", normals=True), red_and_green(), flip_normals=True
    ),
    "a smooth mesh of two sides": lambda folder: mesh(icosahedron(folder / "mesh.obj", normals=True), red_and_green()),
    "a smooth mesh of rough metal": lambda folder: mesh(icosahedron(folder / "mesh.ply"), rough("ggx", 0.3)),
    "a smooth mesh of glass": lambda folder: mesh(icosahedron(folder / "mesh.ply"), {"type": "dielectric"}),
    "a brushed mesh, PLY": lambda folder: mesh(icosahedron(folder / "mesh.ply", uvs=True), rough("ggx", 0.1, 0.5)),
    "a brushed mesh, OBJ": lambda folder: mesh(
        icosahedron(folder / "mesh.obj", uvs=True), rough("ggx", 0.1, 0.5), face_normals=True
    ),
    "instances of a mesh": lambda folder: copies(
        *(at(-1.2, 0, 0, 0.4, 30), at(0.3, 0.2, 0.5, [0.5, 0.2, 0.3], 60), at(1.4, 0, 0, [-0.4, 0.4, 0.4], 10)),
        mesh={"type": "ply", "filename": str(icosahedron(folder / "mesh.ply", normals=True)), "to_world": at(0, 0, 1)},
    ),
    "instances of solids": lambda _: copies(
        *(at(-1.0, 0, 0, 0.5, 30), at(0.8, 0.2, 0.5, [0.5, 0.2, 0.3], 60), at(0.5, 1, -1, [0.3, -0.6, 0.3], 20)),
        cube={"type": "cube", "to_world": at(0, -1, 0, 0.6, 20), "bsdf": rough("ggx", 0.3)},
        ball={"type": "sphere", "center": [0, 0.5, 0], "radius": 0.6, "bsdf": {"type": "diffuse"}},
        plate={"type": "disk", "to_world": at(0, 0.5, 1, 0.5, 30), "bsdf": red_and_green()},
        tube={"type": "cylinder", "p0": [1, -1, 0], "p1": [1, 1, 0], "radius": 0.3, "bsdf": red_and_green()},
        tile={"type": "rectangle", "to_world": at(-1, 0, 0.5, 0.5, 60), "bsdf": red_and_green()},
    ),
    "field of view along y": lambda _: seen(fov_axis="y"),
    "field of view along the diagonal": lambda _: seen(fov_axis="diagonal"),
    "field of view along the smaller side": lambda _: seen(fov_axis="smaller"),
    "field of view along the larger side": lambda _: seen(fov_axis="larger"),
    "clip planes": lambda _: seen(near_clip=4.9, far_clip=6.5),
    "the principal point off the middle": lambda _: seen(principal_point_offset_x=0.2, principal_point_offset_y=-0.1),
    "a crop": lambda _: seen(
        {"width": 90, "height": 70, "crop_offset_x": 30, "crop_offset_y": 20, "crop_width": 40, "crop_height": 32}
    ),
    "a lens": lambda _: seen(type="thinlens", aperture_radius=0.3, focus_distance=4.0),
    "a lens that is clipped": lambda _: seen(
        type="thinlens", aperture_radius=0.1, focus_distance=6.0, near_clip=4.9, far_clip=6.5
    ),
    "parallel rays": lambda _: from_afar(towards((0.5, 1.5, 5), scale=[1.5, 1.5, 1])),
    "parallel rays, clipped": lambda _: from_afar(towards((0.5, 1.5, 5)), near_clip=4.9, far_clip=6.5),
    "a high film": lambda _: seen({"width": 32, "height": 40}),
    "hidden emitters": lambda _: hidden(),
    "a hidden sky, direct light": lambda _: (
        scene(*(floor(), ball({"type": "dielectric"}), box(), point(1, 2, 3)), {"type": "constant", "radiance": 0.3})
        | {"integrator": {"type": "direct", "hide_emitters": True}}
    ),
}
