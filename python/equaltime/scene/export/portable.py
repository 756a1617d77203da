"""Writes meshes and bitmaps inside glTF and OBJ files as separate files, which any renderer can read."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import OpenImageIO

from equaltime.errors import Problem, SceneError
from equaltime.scene.assets import Assets, Mesh
from equaltime.scene.core import read_ply
from equaltime.scene.export.files import Folder, write_ply
from equaltime.scene.gltf import split
from equaltime.scene.model import Bitmap, Deformation, Gltf, Obj, Plugin, Ply, SceneModel, mesh_files

__all__ = ["portable"]

P = TypeVar("P", bound=Plugin)
FORMATS = {"uint8": "uint8", "uint16": "uint16", "float16": "half", "float32": "float"}


def portable(model: SceneModel, assets: Assets, folder: Folder) -> SceneModel:
    """Write meshes and bitmaps of glTF files, and parts of OBJ files, as separate files into `folder`.

    Return a copy of `model` with the names of the new files; `model` itself if nothing had to be written.
    """
    return _Unpacker(assets, folder).node(model)


class _Unpacker:
    def __init__(self, assets: Assets, folder: Folder) -> None:
        self._assets = assets
        self._folder = folder
        self._known: dict[str, str] = {}

    def node(self, plugin: P) -> P:
        """Return `plugin` with everything in it taken out of glTF and OBJ files; `plugin` itself if nothing changes."""
        changes: dict[str, Any] = {}
        for name in type(plugin).model_fields:
            value = getattr(plugin, name)
            new = self._value(value)
            if new is not value:
                changes[name] = new
        if isinstance(plugin, Bitmap) and split(plugin.filename)[1] is not None:
            changes["filename"] = self._once(plugin.filename, lambda _: self._bitmap(plugin))
        return plugin.replace(**changes) if changes else plugin

    def _value(self, value: object) -> object:
        if isinstance(value, Gltf) or (isinstance(value, Obj) and value.material is not None):
            return self._shape(value)
        if isinstance(value, Plugin):
            return self.node(value)
        if isinstance(value, tuple) and any(isinstance(item, Plugin) for item in value):
            new = tuple(self._value(item) for item in value)
            return value if all(a is b for a, b in zip(new, value, strict=True)) else new
        return value

    def _shape(self, shape: Gltf | Obj) -> Ply:
        given = {name: getattr(shape, name) for name in shape.model_fields_set if name not in ("type", "material")}
        filename: str | Deformation = self._file(shape)
        if isinstance(shape.filename, Deformation):
            poses = (shape.replace(filename=name) for name in shape.filename.filenames)
            filename = replace(shape.filename, filenames=tuple(map(self._file, poses)))
        return self.node(Ply(**given | {"filename": filename, "flip_tex_coords": shape.flip_tex_coords}))

    def _file(self, shape: Gltf | Obj) -> str:
        return self._once(_name(shape), lambda _: self._mesh(shape))

    def _once(self, name: str, write: Any) -> str:
        if name not in self._known:
            self._known[name] = str(write(name).absolute())
        return self._known[name]

    def _mesh(self, shape: Gltf | Obj) -> Path:
        mesh = self._assets.mesh(shape)
        attributes = {name: values for name, values in mesh.attributes.items() if name.startswith("vertex_")}

        def write(path: Path) -> None:
            write_ply(path, mesh.vertices, mesh.faces, mesh.normals, mesh.uvs, attributes)
            if (other := _difference(mesh, path)) is not None:
                message = f"a PLY file would be read as another mesh: {other}; write .toml, which names the glTF file"
                raise SceneError((Problem(_name(shape), message),))

        return self._folder.put(f"{_stem(_name(shape))}.ply", write)

    def _bitmap(self, bitmap: Bitmap) -> Path:
        texels = self._assets.texture(bitmap).texels
        height, width, channels = texels.shape
        small = texels.dtype.kind == "u"

        def write(path: Path) -> None:
            spec = OpenImageIO.ImageSpec(width, height, channels, FORMATS[texels.dtype.name])
            image = OpenImageIO.ImageOutput.create("x.png" if small else "x.exr")
            if image is None or not (image.open(str(path), spec) and image.write_image(texels) and image.close()):
                raise ValueError(f"{path}: cannot be written: {image.geterror() if image else 'unknown format'}")

        return self._folder.put(f"{_stem(bitmap.filename)}.{'png' if small else 'exr'}", write)


def _difference(mesh: Mesh, path: Path) -> str | None:
    """Return a difference in vertices, normals or uvs between a mesh and the PLY file written from it, or None.

    Faces are not compared, since those without area may differ.
    """
    try:
        found = read_ply(path)
    except ValueError as error:
        return str(error).removeprefix(f"{path}: ")
    for name in ("vertices", "normals", "uvs"):
        given, read = getattr(mesh, name), getattr(found, name)
        if (given is None) != (read is None) or (given is not None and not np.array_equal(given, read)):
            return f"its {name} are others"
    return None


def _name(shape: Gltf | Obj) -> str:
    """Return the name of a shape inside its file, prefixed with the file."""
    filename = mesh_files(shape.filename)[0]
    return filename if isinstance(shape, Gltf) else f"{filename}#/{shape.material}"


def _stem(name: str) -> str:
    """Return ``model.glb#/meshes/0/primitives/1`` as ``model-meshes-0-primitives-1``."""
    file, _, fragment = name.partition("#")
    return Path(file).stem + re.sub(r"[^\w.-]", "-", fragment)
