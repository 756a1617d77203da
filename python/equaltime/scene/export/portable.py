"""Gives files of their own to meshes and bitmaps that are inside glTF files, so that any renderer can read them."""

from __future__ import annotations

from pathlib import Path
from typing import Any, TypeVar

import OpenImageIO

from equaltime.scene.assets import Assets
from equaltime.scene.export.files import Folder, write_ply
from equaltime.scene.gltf import split
from equaltime.scene.model import Bitmap, Gltf, Plugin, Ply, SceneModel

__all__ = ["portable"]

P = TypeVar("P", bound=Plugin)
FORMATS = {"uint8": "uint8", "uint16": "uint16", "float16": "half", "float32": "float"}


def portable(model: SceneModel, assets: Assets, folder: Folder) -> SceneModel:
    """Return `model` with what is inside a glTF file in files of its own, written into `folder`."""
    return _Unpacker(assets, folder).node(model)


class _Unpacker:
    def __init__(self, assets: Assets, folder: Folder) -> None:
        self._assets = assets
        self._folder = folder
        self._known: dict[str, str] = {}

    def node(self, plugin: P) -> P:
        """Return `plugin` with everything in it taken out of glTF files; itself if there is nothing to do."""
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
        if isinstance(value, Gltf):
            return self._shape(value)
        if isinstance(value, Plugin):
            return self.node(value)
        if isinstance(value, tuple) and any(isinstance(item, Plugin) for item in value):
            new = tuple(self._value(item) for item in value)
            return value if all(a is b for a, b in zip(new, value, strict=True)) else new
        return value

    def _shape(self, shape: Gltf) -> Ply:
        given = {name: getattr(shape, name) for name in shape.model_fields_set if name != "type"}
        filename = self._once(shape.filename, lambda _: self._mesh(shape))
        return self.node(Ply(**given | {"filename": filename}))

    def _once(self, name: str, write: Any) -> str:
        if name not in self._known:
            self._known[name] = str(write(name).absolute())
        return self._known[name]

    def _mesh(self, shape: Gltf) -> Path:
        mesh = self._assets.mesh(shape)
        colors = getattr(mesh, "colors", None)
        return self._folder.put(
            f"{_stem(shape.filename)}.ply",
            lambda path: write_ply(path, mesh.vertices, mesh.faces, mesh.normals, mesh.uvs, colors),
        )

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


def _stem(filename: str) -> str:
    """Return ``model.glb#/meshes/0/primitives/1`` as ``model-meshes-0-primitives-1``."""
    file, fragment = split(filename)
    return Path(file).stem + (fragment or "").replace("/", "-")
