"""Files of an exported scene: relative names of existing meshes and images, and new files in a folder of the scene.

For Mitsuba, meshes and bitmaps inside glTF and OBJ files become separate files. No file is overwritten.
"""

from __future__ import annotations

import filecmp
import os
import re
import shutil
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from itertools import count
from pathlib import Path
from typing import Any, Final, TypeVar

import numpy as np
import OpenImageIO
from numpy.typing import NDArray

from equaltime.errors import Problem, SceneError
from equaltime.files import beside, give_new_name
from equaltime.scene.assets import Assets, Mesh
from equaltime.scene.core import read_ply
from equaltime.scene.gltf import split
from equaltime.scene.model import (
    Bitmap,
    Deformation,
    Gltf,
    MeshFile,
    Obj,
    Plugin,
    Ply,
    SceneModel,
    Serialized,
    mesh_files,
)

__all__ = ["Folder", "portable", "relative", "write_ply"]

Array = NDArray[np.float64]

_OWN: Final = frozenset({"type", "crease_angle"})
"""Fields of a mesh that its PLY file has no use for: its normals stand in the file."""
TYPES: Final = {"<f4": "float", "<f8": "double"}
P = TypeVar("P", bound=Plugin)
FORMATS = {"uint8": "uint8", "uint16": "uint16", "float16": "half", "float32": "float"}


def portable(model: SceneModel, assets: Assets, folder: Folder) -> SceneModel:
    """Write meshes and bitmaps of glTF files, parts of OBJ files, and creased meshes as separate files into `folder`.

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
        if isinstance(value, MeshFile) and _is_part(value):
            return self._shape(value)
        if isinstance(value, Plugin):
            return self.node(value)
        if isinstance(value, tuple) and any(isinstance(item, Plugin) for item in value):
            new = tuple(self._value(item) for item in value)
            return value if all(a is b for a, b in zip(new, value, strict=True)) else new
        return value

    def _shape(self, shape: MeshFile) -> Ply:
        given = {name: getattr(shape, name) for name in shape.model_fields_set & Ply.model_fields.keys() - _OWN}
        filename: str | Deformation = self._file(shape)
        if isinstance(shape.filename, Deformation):
            poses = (shape.replace(filename=name) for name in shape.filename.filenames)
            filename = replace(shape.filename, filenames=tuple(map(self._file, poses)))
        return self.node(Ply(**given | {"filename": filename, "flip_tex_coords": shape.flip_tex_coords}))

    def _file(self, shape: MeshFile) -> str:
        return self._once(_name(shape), lambda _: self._mesh(shape))

    def _once(self, name: str, write: Any) -> str:
        if name not in self._known:
            self._known[name] = str(write(name).absolute())
        return self._known[name]

    def _mesh(self, shape: MeshFile) -> Path:
        mesh = self._assets.mesh(shape)

        def write(path: Path) -> None:
            write_ply(path, mesh.vertices, mesh.faces, mesh.normals, mesh.uvs, mesh.attributes)
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

    Faces without area and vertices that only they or no faces use are not compared: readers of PLY files drop them.
    """
    try:
        found = read_ply(path)
    except ValueError as error:
        return str(error).removeprefix(f"{path}: ")
    a, b, c = (mesh.vertices[corner] for corner in mesh.faces.T)
    with np.errstate(over="ignore", invalid="ignore"):
        used = np.unique(mesh.faces[(np.cross(b - a, c - a) != 0.0).any(axis=1)])
    for name in ("vertices", "normals", "uvs"):
        given, read = getattr(mesh, name), getattr(found, name)
        if (given is None) != (read is None) or (given is not None and not np.array_equal(given[used], read)):
            return f"its {name} are others"
    return None


def _is_part(shape: MeshFile) -> bool:
    """Tell whether a shape is another mesh than that of its whole file, as other renderers read it."""
    part = isinstance(shape, Gltf) or (isinstance(shape, Obj) and shape.material is not None)
    return part or shape.crease_angle is not None


def _name(shape: MeshFile) -> str:
    """Return the name of a shape inside its file, prefixed with the file."""
    name = mesh_files(shape.filename)[0]
    if isinstance(shape, Obj) and shape.material is not None:
        name += f"#/{shape.material}"
    if isinstance(shape, Serialized):
        name += f"#/{shape.shape_index}"
    return name if shape.crease_angle is None else f"{name}{'' if '#' in name else '#'}/crease-{shape.crease_angle:g}"


def _stem(name: str) -> str:
    """Return ``model.glb#/meshes/0/primitives/1`` as ``model-meshes-0-primitives-1``."""
    file, _, fragment = name.partition("#")
    return Path(file).stem + re.sub(r"[^\w.-]", "-", fragment)


# -- files -------------------------------------------------------------------------------------------------------------


def relative(path: Path, to: Path) -> str:
    """Return `path` relative to the folder `to`, with forward slashes.

    If the two are on different drives, the absolute path is returned.
    """
    try:
        return Path(os.path.relpath(path.resolve(), to.resolve())).as_posix()
    except ValueError:
        return path.resolve().as_posix()


class Folder:
    """Folder for the meshes and images of an exported scene.

    The folder is created together with the first file in it.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.written: list[Path] = []
        self._copies: dict[Path, Path] = {}
        self._tidied = False

    def copy(self, file: Path, companions: Sequence[str] = ()) -> Path:
        """Copy `file` into this folder and return the path of the copy, once for each file.

        If the folder has an identical file with this name, that file is used instead. The `companions` are files that
        `file` names relative to its own folder. A file with companions gets a folder of its own in this folder, where
        all of them keep their names.
        """
        if file not in self._copies:
            self._copies[file] = self._together(file, companions) if companions else self._copy(file)
        return self._copies[file]

    def _copy(self, file: Path) -> Path:
        return self.put(file.name, lambda target: shutil.copyfile(file, target))

    def _together(self, file: Path, companions: Sequence[str]) -> Path:
        """Copy a file and its companions into the first folder called `file.stem` or so in which no name is taken."""
        names = (file.name, *companions)
        for own in self._names(file.stem):
            if all(_is_free(own / name, file.parent / name) for name in names):
                for name in names:
                    inner = Folder((own / name).parent)
                    inner._copy(file.parent / name)
                    self.written += inner.written
                return own / file.name
        raise AssertionError("there is always another name")

    def put(self, name: str, write: Callable[[Path], object]) -> Path:
        """Create a file in this folder and return its path.

        The function `write` writes the content to a temporary path. The file is called `name`, or `name` with a number
        if this name is taken. If a file with one of these names has the same content, that file is used instead.
        """
        self.path.mkdir(parents=True, exist_ok=True)
        try:
            with beside(self.path / name, self._tidied) as fresh:
                self._tidied = True
                write(fresh)
                return self._keep(fresh, name)
        finally:
            with suppress(OSError):  # the folder is not empty
                self.path.rmdir()

    def _keep(self, fresh: Path, name: str) -> Path:
        for target in self._names(name):
            with suppress(FileExistsError):
                give_new_name(fresh, target)
                self.written.append(target)
                return target
            if target.exists() and filecmp.cmp(fresh, target, shallow=False):
                return target
        raise AssertionError("there is always another name")

    def _names(self, name: str) -> Iterator[Path]:
        """Yield candidate names for a file: its own, then numbered ones."""
        yield self.path / name
        stem, suffix = Path(name).stem, Path(name).suffix
        for number in count(2):
            yield self.path / f"{stem}-{number}{suffix}"


def _is_free(target: Path, file: Path) -> bool:
    """Tell whether `target` does not exist or has the content of `file`."""
    return not os.path.lexists(target) or (target.is_file() and filecmp.cmp(file, target, shallow=False))


def write_ply(
    path: Path,
    vertices: Array,
    faces: NDArray[np.uint32],
    normals: Array | None,
    uvs: Array | None,
    attributes: Mapping[str, Array] | None = None,
) -> None:
    """Write a mesh as a binary PLY file, without loss of precision.

    Shapes of the arrays: `vertices` and `normals` (N, 3), `uvs` (N, 2), `faces` (M, 3). The `attributes` have
    Mitsuba's names, such as ``vertex_color`` and ``face_color``, and shapes (N, 1) or (N, 3) and (M, 1) or (M, 3).
    """
    columns = {
        **dict(zip("xyz", vertices.T, strict=True)),
        **({} if normals is None else dict(zip(("nx", "ny", "nz"), normals.T, strict=True))),
        **({} if uvs is None else dict(zip("uv", uvs.T, strict=True))),
        **dict(_columns("vertex_", attributes or {})),
    }
    records = np.empty(len(vertices), dtype=[(name, _smallest(column)) for name, column in columns.items()])
    for name, column in columns.items():
        records[name] = column
    own = dict(_columns("face_", attributes or {}))
    types = [(name, _smallest(column)) for name, column in own.items()]
    corners = np.empty(len(faces), dtype=[("count", "u1"), ("corners", "<i4", 3), *types])
    corners["count"], corners["corners"] = 3, faces
    for name, column in own.items():
        corners[name] = column
    header = [
        "ply",
        "format binary_little_endian 1.0",
        f"element vertex {len(records)}",
        *(f"property {TYPES[records.dtype[name].str]} {name}" for name in columns),
        f"element face {len(corners)}",
        "property list uchar int vertex_indices",
        *(f"property {TYPES[corners.dtype[name].str]} {name}" for name in own),
        "end_header\n",
    ]
    path.write_bytes("\n".join(header).encode() + records.tobytes() + corners.tobytes())


def _columns(prefix: str, attributes: Mapping[str, Array]) -> Iterator[tuple[str, Array]]:
    """Iterate over the properties that are read back as the attributes whose names begin with ``prefix``."""
    for attribute, values in attributes.items():
        if attribute.startswith(prefix):
            name = attribute.removeprefix(prefix)
            names = "rgb" if name == "color" else [f"{name}_{number}" for number in range(values.shape[1])]
            yield from zip(names, values.T, strict=True)


def _smallest(column: Array) -> str:
    """Return the smallest PLY type that holds the numbers exactly."""
    with np.errstate(over="ignore"):
        return "<f4" if np.array_equal(column.astype("<f4").astype(np.float64), column) else "<f8"
