"""What is fuzzed: readers, each given the content of one file, which they read or refuse with an error of ours."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final

import equaltime as et
from equaltime.experiments.model.reader import read_experiment
from equaltime.rendering.render_file import read_film, read_picture
from equaltime.scene import load_file
from equaltime.scene.lint import lint

from .doubling import MARK
from .experiments import read_image_of, read_provenance_of, read_records_of, read_reference_of

__all__ = ["MEMORY", "SCENES", "SECONDS", "SUBJECTS", "check", "check_use", "limit_of", "suffix_of"]

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
    with TemporaryDirectory() as folder:  # not beside the library, which may be a file of the corpus
        mesh = Path(folder) / "painted.obj"
        shutil.copy(path, mesh.with_name("some.mtl"))
        mesh.write_text("mtllib some.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\nusemtl b\nf 1 2 3\n")
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
    """Read JSON as a scene's dict, whose parts may be joined with themselves."""
    try:
        scene: Any = json.loads(path.read_bytes(), object_hook=_joined)
    except (ValueError, RecursionError):
        return None
    return et.load_dict(scene).model if isinstance(scene, dict) else None


def _joined(table: dict[str, Any]) -> Any:
    """Return what a table stands for that a mutator has marked: a part that is used twice, level by level."""
    levels, part = table.get(MARK), table.get("of")
    for _ in range(levels if isinstance(levels, int) and levels <= 100 else 0):
        part = {"type": "blendbsdf", "weight": 0.5, "a": part, "b": part} if isinstance(part, dict) else [part, part]
    return table if MARK not in table else part


def _experiment(path: Path) -> object:
    return read_experiment(path)


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
    "experiment": _experiment,
    "csv": read_records_of,
    "npy": read_image_of,
    "npz": read_reference_of,
    "json": read_provenance_of,
}
"""By the name of their corpus; of most, that is how their files end too."""
SCENES: Final = frozenset({"toml", "xml", "gltf", "glb", "ply", "obj"})
"""The subjects that are whole scenes."""


def suffix_of(name: str) -> str:
    """Return how files of a corpus end."""
    return {"result": ".exr", "dict": ".json", "experiment": ".toml"}.get(name, f".{name}")


def check(name: str, path: Path) -> bool:
    """Return whether the file was read, not refused; whatever else happens is a finding."""
    try:
        SUBJECTS[name](path)
    except (et.SceneError, et.ImageError, et.ExperimentError):
        return False
    return True


def check_use(name: str, path: Path) -> bool:
    """Return whether a scene that can be read can be rendered too; whatever else happens is a finding."""
    try:
        scene = load_file(path, {"integrator": "path"} if name == "xml" else {}).with_(size=(4, 4), max_depth=6)
        lint(scene)
        et.render(scene, spp=2, threads=1)
    except (et.SceneError, et.ImageError, et.RenderError):
        return False
    return True
