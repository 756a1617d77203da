"""What the feature scenes are made of: dictionaries that both Mitsuba and equaltime take as they are.

Colours are numbers or what `rgb` returns; transforms are Mitsuba's own. A variant of Mitsuba must have been chosen.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np

Dict = dict[str, Any]


def rgb(*value: float) -> Dict:
    return {"type": "rgb", "value": list(value)}


def at(x: float, y: float, z: float, scale: Any = 1.0, turn: float = 0.0, axis: Any = (1, 2, 0)) -> Any:
    """A place, with a size and a turn by so many degrees about an axis before."""
    t, unit = mi.ScalarTransform4f, np.divide(axis, math.hypot(*axis))  # Mitsuba does not make it one
    return t().translate([x, y, z]) @ t().rotate(unit.tolist(), turn) @ t().scale(scale)


def towards(origin: Any, target: Any = (0, 0, 0), scale: Any = 1.0) -> Any:
    t = mi.ScalarTransform4f
    return t().look_at(origin=list(origin), target=list(target), up=[0, 1, 0]) @ t().scale(scale)


def scene(*objects: Dict, depth: int = 4, film: Dict | None = None, **sensor: Any) -> Dict:
    """Objects near the origin, seen from the front and a little above, in 40x32 pixels."""
    film = {"type": "hdrfilm", "width": 40, "height": 32, "pixel_format": "rgb", "rfilter": {"type": "box"}} | (
        film or {}
    )
    view = {"type": "perspective", "fov": 40.0, "to_world": towards((0.5, 1.5, 5)), "film": film} | sensor
    parts = {f"object{i}": part for i, part in enumerate(objects)}
    return {"type": "scene", "integrator": {"type": "path", "max_depth": depth}, "sensor": view, **parts}


def floor() -> Dict:
    return {
        "type": "rectangle",
        "to_world": at(0, -1, 0, 4, -90, (1, 0, 0)),
        "bsdf": {"type": "diffuse", "reflectance": rgb(0.6, 0.5, 0.4)},
    }


def light(shape: str, to_world: Any, *radiance: float, **extra: Any) -> Dict:
    return {
        "type": shape,
        "to_world": to_world,
        "emitter": {"type": "area", "radiance": rgb(*(radiance or (9.0, 10.0, 11.0)))},
        **extra,
    }


def lamp() -> Dict:
    return light("sphere", at(1, 3, 2, 0.5))


def window() -> Dict:
    return light("rectangle", towards((-3, 2, 3), scale=[0.5, 2, 1]), 3, 2, 1)


def ball(bsdf: Dict, **extra: Any) -> Dict:
    return {"type": "sphere", "radius": 0.9, "bsdf": bsdf, **extra}


def box(bsdf: Dict | None = None, **extra: Any) -> Dict:
    return {"type": "cube", "to_world": at(0, 0, 0, 0.7, 50), "bsdf": bsdf or {"type": "diffuse"}, **extra}


def metal(kind: str = "conductor", **extra: Any) -> Dict:
    return {"type": kind, "eta": rgb(0.2, 0.9, 1.1), "k": rgb(3.9, 2.4, 2.1), **extra}


def rough(distribution: str, alpha: float, across: float | None = None) -> Dict:
    alphas = {"alpha": alpha} if across is None else {"alpha_u": alpha, "alpha_v": across}
    return metal("roughconductor", distribution=distribution, **alphas)


def metals(distribution: str, *alphas: float) -> Dict:
    """A ball, a box and a tile of a rough metal under a lamp, a window and a dim sky."""
    bsdf = rough(distribution, *alphas)
    return scene(
        *(floor(), lamp(), window(), {"type": "constant", "radiance": rgb(0.2, 0.3, 0.4)}),
        {"type": "sphere", "to_world": at(-1.1, 0, 0, 0.7, 40), "bsdf": bsdf},
        {"type": "cube", "to_world": at(0.4, -0.3, 0.4, 0.4, 50), "bsdf": bsdf},
        {"type": "rectangle", "to_world": at(1.3, 0.4, -0.5, 0.6, 20), "bsdf": bsdf},
        {"type": "disk", "to_world": at(0.2, 1.0, -1, 0.6, -20), "bsdf": {"type": "twosided", "bsdf": bsdf}},
    )


def red_and_green() -> Dict:
    return {
        "type": "twosided",
        "front": {"type": "diffuse", "reflectance": rgb(0.9, 0.1, 0.1)},
        "behind": {"type": "diffuse", "reflectance": rgb(0.1, 0.9, 0.1)},
    }


def turned_tile(angle: float, **extra: Any) -> Dict:
    return {"type": "rectangle", "to_world": at(0, 0, 0, 0.9, angle, (0, 1, 0)), "bsdf": red_and_green(), **extra}


def lights(shape: str, **extra: Any) -> Dict:
    """Two lights of one shape near enough to fill much of the sky, one stretched (but for spheres) and turned."""
    stretched = 0.6 if shape == "sphere" else [0.9, 0.4, 0.6]
    return scene(
        *(floor(), box()),
        light(shape, towards((-1.5, 1.5, 1), (0, -1, 0), stretched), **extra),
        light(shape, at(1.6, 0.5, -1, 0.3, 100), 2, 8, 3, **extra),
    )


def glass(**dielectric: Any) -> Dict:
    """A ball in front of a lamp that it hides, so that all of its light passes through or reflects."""
    lit = light("disk", towards((0, 0.2, -3), scale=0.7), 5, 6, 7)
    return scene(
        *(floor(), lit, {"type": "constant", "radiance": 0.3}), ball({"type": "dielectric", **dielectric}), depth=9
    )


def hidden() -> Dict:
    """Flat lights and a sky that are not seen, behind panes of three kinds and beside them.

    With ``volpath``: Mitsuba's ``path`` has another image of such a scene in each of its variants, and so have both of
    spheres that shine.
    """
    kinds = ({"type": "thindielectric"}, {"type": "null"}, {"type": "mask", "opacity": 0.4, "bsdf": red_and_green()})
    panes = [{"type": "rectangle", "to_world": at(0.9 * i - 0.8, 0.9, 2, 0.3), "bsdf": b} for i, b in enumerate(kinds)]
    whole = scene(
        *(floor(), ball({"type": "dielectric"}), {"type": "constant", "radiance": rgb(0.2, 0.3, 0.4)}, *panes),
        light("disk", at(0, 0.8, 1.5, 0.4)),
        light("rectangle", towards((1.2, 1, -1), (0.5, 1.5, 5), [0.4, 0.4, 1])),
    )
    return whole | {"integrator": {"type": "volpath", "max_depth": 5, "hide_emitters": True}}


def icosahedron(path: Path, normals: bool = False, uvs: bool = False) -> Path:
    """Write a mesh, ascii PLY or OBJ by the name of the file, with the ball's normals and some parametrisation."""
    g = (1 + math.sqrt(5)) / 2
    corners = np.array([v for a in (-1, 1) for b in (-g, g) for v in ((0, a, b), (a, b, 0), (b, 0, a))], dtype=float)
    faces = [
        (i, j, k) if np.linalg.det(corners[[i, j, k]]) > 0 else (i, k, j)
        for i in range(12)
        for j in range(i)
        for k in range(j)
        if all(np.linalg.norm(corners[a] - corners[b]) < 2.1 for a, b in ((i, j), (j, k), (k, i)))
    ]
    columns = {"v": corners, "vt": corners[:, :2] * (0.3, 0.5), "vn": corners / np.linalg.norm(corners[0])}
    columns = {name: c for name, c in columns.items() if name == "v" or {"vt": uvs, "vn": normals}[name]}
    if path.suffix == ".obj":
        lines = [" ".join([name, *map(str, row)]) for name, rows in columns.items() for row in rows]
        form = {"v": "{0}", "vvt": "{0}/{0}", "vvn": "{0}//{0}", "vvtvn": "{0}/{0}/{0}"}["".join(columns)]
        lines += ["f " + " ".join(form.format(i + 1) for i in face) for face in faces]
    else:
        names = {"v": "x y z", "vt": "u v", "vn": "nx ny nz"}
        lines = ["ply", "format ascii 1.0", f"element vertex {len(corners)}"]
        lines += [f"property float {n}" for name in columns for n in names[name].split()]
        lines += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header"]
        lines += [" ".join(map(str, row)) for row in np.hstack(list(columns.values()))]
        lines += [" ".join(map(str, (3, *face))) for face in faces]
    path.write_text("\n".join(lines) + "\n")
    return path


def colored(path: Path) -> Path:
    """Write the mesh with colours of its vertices and other ones, and a number, of its faces."""
    lines = icosahedron(path).read_text().splitlines()
    first, face, end = (lines.index(line) for line in ("property float x", "element face 20", "end_header"))
    numbers = np.random.default_rng(5).uniform(0.05, 0.95, (len(lines), 4)).round(3)
    extra = [" ".join(map(str, row)) for row in numbers]
    records = [f"{line} {more}" for line, more in zip(lines[end + 1 :], extra, strict=False)]
    header = [*lines[: first + 3], *(f"property float {c}" for c in ("r", "g", "b", "w_0")), *lines[face:end]]
    header += [f"property float {c}" for c in ("p_r", "p_g", "p_b", "q_0")]
    path.write_text("\n".join([*header, "end_header", *records]) + "\n")
    return path


def mesh(path: Path, bsdf: Dict | None = None, **extra: Any) -> Dict:
    shape = {"type": path.suffix[1:], "filename": str(path), "to_world": at(0, 0, 0, 0.5, 50)}
    return scene(floor(), lamp(), window(), shape | {"bsdf": bsdf or {"type": "diffuse"}} | extra)


def flat(path: Path) -> Dict:
    """For lights: Mitsuba's light from a mesh with vertex normals depends on the technique."""
    return {"filename": str(path), "face_normals": True}


def sky(path: Path, width: int, height: int) -> Dict:
    """An environment image with bright spots off the axes and at a pole, so that half a texel would be seen."""
    pixels = np.full((height, width, 3), (0.2, 0.3, 0.4), np.float32)
    pixels[height // 4, width // 5] = (40.0, 30.0, 20.0)
    pixels[2 * height // 3, 2 * width // 3] = (0.0, 5.0, 9.0)
    pixels[0] += 1.0
    mi.Bitmap(pixels).write(str(path))
    environment = {"type": "envmap", "filename": str(path), "scale": 0.5, "to_world": at(0, 0, 0, 1, 70)}
    mirror = {"type": "sphere", "to_world": at(-1, 0, 0, 0.8), "bsdf": metal()}
    return scene(
        floor(), environment, mirror, {"type": "sphere", "to_world": at(1, 0, 0, 0.7), "bsdf": rough("ggx", 0.2)}
    )


def spot(origin: Any, target: Any, **extra: Any) -> Dict:
    return {"type": "spot", "to_world": towards(origin, target), "intensity": rgb(50, 40, 30), **extra}


def slide(path: Path) -> str:
    """Write a small picture of unlike texels, and return its name."""
    mi.Bitmap(np.random.default_rng(2).uniform(0.1, 1.0, (5, 7, 3)).astype(np.float32)).write(str(path))
    return str(path)


def seen(film: Dict | None = None, **sensor: Any) -> Dict:
    """A scene that is about the camera."""
    return scene(floor(), lamp(), {"type": "constant", "radiance": 0.1}, box(), film=film, **sensor)


def from_afar(to_world: Any, **clips: float) -> Dict:
    whole = seen()
    return whole | {"sensor": {"type": "orthographic", "to_world": to_world, "film": whole["sensor"]["film"]} | clips}


def copies(*placed: Any, **shapes: Dict) -> Dict:
    """A group of shapes, and an instance of it at each place."""
    instances = [{"type": "instance", "group": {"type": "ref", "id": "object0"}, "to_world": to} for to in placed]
    return scene({"type": "shapegroup", **shapes}, floor(), lamp(), window(), *instances)


def point(x: float, y: float, z: float) -> Dict:
    return {"type": "point", "position": [x, y, z], "intensity": rgb(9, 10, 11)}
