"""What the pictures of the gallery are made of: a stage with a thing on it, and small files for it to name."""

from __future__ import annotations

import base64
import json
import math
import struct
import zlib
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from equaltime.images import image_files as images
from equaltime.images.preview import srgb_bytes

Dict = dict[str, Any]
Array = NDArray[np.float64]

SIDE = 144
SKY = Path(__file__).resolve().parents[1] / "terrain" / "venice_sunset.exr"


def stage(*things: Dict, lights: tuple[Dict, ...] | None = None, **extra: Any) -> Dict:
    """Return things on a floor, in the light of a lamp and a sunset unless other lights are given."""
    present = (*things, *((sunset(), lamp()) if lights is None else lights))
    objects = {f"thing{i}": thing for i, thing in enumerate(present)}
    film = {"type": "hdrfilm", "width": SIDE, "height": SIDE}
    camera = {"type": "perspective", "fov": 28.0, "to_world": view((0.0, 2.2, 6.0), (0.0, 0.85, 0.0)), "film": film}
    whole = {"type": "scene", "integrator": {"type": "path"}, "sensor": camera, "floor": floor(), **objects}
    return whole | extra


def view(origin: tuple[float, ...], target: tuple[float, ...]) -> list[Dict]:
    """Return a camera's place."""
    return [{"look_at": {"origin": list(origin), "target": list(target), "up": [0, 1, 0]}}]


def floor() -> Dict:
    """Return a large plane of tiles."""
    to_world = [{"rotate": {"axis": [1, 0, 0], "angle": -90}}, {"scale": 20}]
    return {"type": "rectangle", "to_world": to_world, "bsdf": tiles()}


def tiles() -> Dict:
    """Return grey in two shades."""
    to_uv = [{"scale": [20, 20, 1]}]
    board = {"type": "checkerboard", "color0": 0.45, "color1": 0.3, "to_uv": to_uv}
    return {"type": "diffuse", "reflectance": board}


def sunset(scale: float = 0.5) -> Dict:
    """Return the sky of `terrain`."""
    turned = [{"rotate": {"axis": [0, 1, 0], "angle": 120}}]
    return {"type": "envmap", "filename": str(SKY), "scale": scale, "to_world": turned}


def lamp(radiance: Any = 14.0) -> Dict:
    """Return a square above, to the left and before the thing."""
    to_world = [{"scale": 0.8}, *view((-2.5, 4.0, 2.5), (0.0, 0.8, 0.0))]
    return {"type": "rectangle", "to_world": to_world, "emitter": {"type": "area", "radiance": radiance}}


def ball(bsdf: Dict | None, **extra: Any) -> Dict:
    """Return a ball of radius 1 on the floor."""
    turned = [{"rotate": {"axis": [1, 0, 0], "angle": -90}}, {"translate": [0, 1, 0]}]
    return {"type": "sphere", "to_world": turned, **({} if bsdf is None else {"bsdf": bsdf}), **extra}


def diffuse(*color: float) -> Dict:
    """Return a matt surface."""
    return {"type": "diffuse", "reflectance": list(color)}


def on_floor(size: float = 1.0, turn: float = 30.0, height: float = 1.0) -> list[Dict]:
    """Return a size, a turn about the vertical, and a height."""
    return [{"scale": size}, {"rotate": {"axis": [0, 1, 0], "angle": turn}}, {"translate": [0, height, 0]}]


def knot(rings: int = 240, sides: int = 24) -> tuple[Array, Array, Array, NDArray[np.uint32]]:
    """Return vertices, normals, texture coordinates and faces of a tube along a trefoil."""
    t = np.linspace(0, 2 * math.pi, rings + 1)
    path = np.stack([np.sin(t) + 2 * np.sin(2 * t), np.cos(t) - 2 * np.cos(2 * t), -np.sin(3 * t)], axis=1) / 3.2
    along = np.gradient(path, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    across = np.cross(along, [0.0, 0.0, 1.0])
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    up = np.cross(across, along)
    a = np.linspace(0, 2 * math.pi, sides + 1)
    normals = across[:, None] * np.cos(a)[:, None] + up[:, None] * np.sin(a)[:, None]
    vertices = path[:, None] + 0.22 * normals
    u, v = np.meshgrid(np.arange(rings + 1) / rings, np.arange(sides + 1) / sides, indexing="ij")
    first = (np.arange(rings)[:, None] * (sides + 1) + np.arange(sides)).reshape(-1)
    faces = np.stack([first, first + sides + 2, first + 1, first, first + sides + 1, first + sides + 2], axis=1)
    uvs = np.stack([u, v], axis=-1).reshape(-1, 2)
    return vertices.reshape(-1, 3), normals.reshape(-1, 3), uvs, faces.reshape(-1, 3).astype(np.uint32)


def knot_on_floor(kind: str, filename: str, bsdf: Dict) -> Dict:
    """Return the knot of a file, upright."""
    return {"type": kind, "filename": filename, "to_world": on_floor(1.0, 25, 1.1), "bsdf": bsdf}


def rainbow(count: int) -> Array:
    """Return colours (count, 3) that go round the hues."""
    turns = np.linspace(0, 2, count)[:, None] + np.array([0.0, 1 / 3, 2 / 3])
    return np.asarray(0.5 + 0.4 * np.cos(2 * math.pi * turns))


def write_ply(path: Path, colors: bool = False) -> str:
    """Write the knot, with colours of its vertices if asked to, and return its name; so do the next ones."""
    vertices, normals, uvs, faces = knot()
    names = ["x", "y", "z", "nx", "ny", "nz", "u", "v", *(("r", "g", "b") if colors else ())]
    rows = np.hstack([vertices, normals, uvs, *((rainbow(len(vertices)),) if colors else ())]).astype("<f4")
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(rows)}"]
    header += [*(f"property float {name}" for name in names), f"element face {len(faces)}"]
    header += ["property list uchar int vertex_indices", "end_header\n"]
    corners = np.empty(len(faces), dtype=[("count", "u1"), ("corners", "<i4", 3)])
    corners["count"], corners["corners"] = 3, faces
    path.write_bytes("\n".join(header).encode() + rows.tobytes() + corners.tobytes())
    return str(path)


def write_obj(path: Path) -> str:
    """Write the knot as text."""
    vertices, normals, uvs, faces = knot()
    columns = {"v": vertices, "vt": uvs, "vn": normals}
    lines = [f"{word} " + " ".join(f"{x:.6g}" for x in row) for word, rows in columns.items() for row in rows]
    lines += ["f " + " ".join(f"{i}/{i}/{i}" for i in face + 1) for face in faces.astype(int)]
    path.write_text("\n".join(lines) + "\n")
    return str(path)


def write_serialized(path: Path) -> str:
    """Write the knot in Mitsuba's format."""
    vertices, normals, uvs, faces = knot()
    content = struct.pack("<I", 0x1 | 0x2 | 0x1000) + b"a knot\0" + struct.pack("<QQ", len(vertices), len(faces))
    content += b"".join(part.astype("<f4").tobytes() for part in (vertices, normals, uvs))
    content += faces.astype("<u4").tobytes()
    path.write_bytes(struct.pack("<HH", 0x041C, 4) + zlib.compress(content))
    return str(path)


def write_gltf(path: Path) -> str:
    """Write the knot as a file whose first primitive it is, and name that."""
    vertices, normals, _, faces = knot()
    parts = [vertices.astype("<f4"), normals.astype("<f4"), faces.astype("<u4")]
    ends = np.cumsum([0, *(part.nbytes for part in parts)]).tolist()
    views = [{"buffer": 0, "byteOffset": a, "byteLength": b - a} for a, b in pairwise(ends)]
    box = {"min": parts[0].min(axis=0).tolist(), "max": parts[0].max(axis=0).tolist()}
    accessors = [
        {"bufferView": 0, "componentType": 5126, "count": len(vertices), "type": "VEC3", **box},
        {"bufferView": 1, "componentType": 5126, "count": len(normals), "type": "VEC3"},
        {"bufferView": 2, "componentType": 5125, "count": faces.size, "type": "SCALAR"},
    ]
    data = base64.b64encode(b"".join(part.tobytes() for part in parts)).decode()
    document = {
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": ends[-1], "uri": f"data:application/octet-stream;base64,{data}"}],
        "bufferViews": views,
        "accessors": accessors,
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1}, "indices": 2}]}],
    }
    path.write_text(json.dumps(document))
    return f"{path}#/meshes/0/primitives/0"


def write_picture(path: Path, pixels: Array, encoded: bool = True) -> str:
    """Write linear colours as sRGB, or the numbers as they are."""
    as_bytes = srgb_bytes(pixels) if encoded else np.round(255 * pixels).astype(np.uint8)
    images.write(path, path.suffix[1:], [images.Layer(("R", "G", "B"), as_bytes, {})])
    return str(path)


def weave(side: int = 64) -> Array:
    """Return a picture (side, side, 3) of coloured threads."""
    x, y = np.meshgrid(*2 * [np.arange(side) / side])
    over = ((8 * x).astype(int) + (8 * y).astype(int)) % 2 == 0
    thread = np.where(over, np.abs(np.sin(8 * math.pi * x)), np.abs(np.sin(8 * math.pi * y)))[..., None]
    return np.asarray(thread**0.5 * np.where(over[..., None], (0.75, 0.2, 0.08), (0.1, 0.3, 0.6)))


def hills(side: int = 128) -> Array:
    """Return heights (side, side) in [0, 1], round bumps in rows."""
    x, y = np.meshgrid(*2 * [8 * np.arange(side) / side % 1 - 0.5])
    return np.asarray(np.sqrt(np.maximum(0.0, 1 - 5 * (x**2 + y**2))))


def leaning(heights: Array, strength: float = 0.06) -> Array:
    """Return the normal map (n + 1) / 2 of heights, as linear numbers."""
    rows, columns = np.gradient(heights * strength * len(heights))
    n = np.stack([-columns, -rows, np.ones_like(rows)], axis=-1)
    return np.asarray(0.5 + 0.5 * n / np.linalg.norm(n, axis=-1, keepdims=True))
