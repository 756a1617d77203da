"""What is fuzzed: readers, each given the content of one file, which they read or refuse with an error of ours."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Final

import equaltime as et
from equaltime.render_file import read_film, read_picture

__all__ = ["MEMORY", "SECONDS", "SUBJECTS", "check", "limit_of", "suffix_of"]

SECONDS: Final = 5
"""An input that takes longer hangs."""
MEMORY: Final = 64 << 20
"""What any input may take at most, in bytes, beside 20 times its size."""
LENS: Final = {"type": "perspective", "film": {"type": "hdrfilm", "width": 4, "height": 4}}
Subject = Callable[[Path], object]
"""Reads a file; raises nothing but errors of equaltime."""


def limit_of(size: int) -> int:
    """Return the memory that the reader of so many bytes may take."""
    return MEMORY + 20 * size


def _scene(path: Path) -> object:
    return et.load(path).model


def _mitsuba(path: Path) -> object:
    return et.load(path, integrator="path").model


def _painted(path: Path) -> object:
    """Read a library of materials, for a mesh that uses them."""
    mesh = path.with_name("painted.obj")
    mesh.write_text(f"mtllib {path.name}\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\nusemtl b\nf 1 2 3\n")
    return et.load(mesh).model


def _serialized(path: Path) -> object:
    shapes = {f"shape{i}": {"type": "serialized", "filename": str(path), "shape_index": i} for i in (0, 1)}
    return et.load_dict({"type": "scene", "sensor": LENS, **shapes}).model


def _texture(path: Path) -> object:
    bitmap = {"type": "bitmap", "filename": str(path)}
    ball = {"type": "sphere", "bsdf": {"type": "diffuse", "reflectance": bitmap}}
    sky = {"type": "envmap", "filename": str(path)}
    return et.load_dict({"type": "scene", "sensor": LENS, "ball": ball, "sky": sky}).model


def _picture(path: Path) -> object:
    read_film(path)
    return read_picture(path).channels


def _dict(path: Path) -> object:
    """Read JSON as a scene's dict."""
    try:
        scene: Any = json.loads(path.read_bytes())
    except (ValueError, RecursionError):
        return None
    return et.load_dict(scene).model if isinstance(scene, dict) else None


SUBJECTS: Final[Mapping[str, Subject]] = {
    "toml": _scene,
    "xml": _mitsuba,
    "gltf": _scene,
    "glb": _scene,
    "mtl": _painted,
    "serialized": _serialized,
    "ply": _scene,
    "obj": _scene,
    "png": _texture,
    "jpg": _texture,
    "hdr": _texture,
    "exr": _texture,
    "result": _picture,
    "dict": _dict,
}
"""By the name of their corpus; of most, that is how their files end too."""


def suffix_of(name: str) -> str:
    """Return how files of a corpus end."""
    return {"result": ".exr", "dict": ".json"}.get(name, f".{name}")


def check(name: str, path: Path) -> bool:
    """Return whether the file was read, not refused; whatever else happens is a finding."""
    try:
        SUBJECTS[name](path)
    except (et.SceneError, et.ImageError):
        return False
    return True
