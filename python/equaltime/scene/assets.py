"""The meshes and images that a scene names, read when needed and checked.

Reading raises ValueError with a readable message. The caller adds the file and line where the scene names the file.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from equaltime.scene.core import MeshData, read_obj, read_obj_by_material, read_ply
from equaltime.scene.creases import Creased, creased
from equaltime.scene.gltf import Contents, Triangles, split
from equaltime.scene.lost_images import Lost
from equaltime.scene.model import Bitmap, EnvMap, Gltf, MeshFile, Obj, Serialized, mesh_files
from equaltime.scene.pictures import Texels, read_picture
from equaltime.scene.search import Search, exists
from equaltime.scene.serialized import read_serialized

__all__ = ["Assets", "Mesh"]

Mesh = MeshData | Triangles | Creased
"""Vertices, faces and attributes of a mesh; normals and texture coordinates if the file has any."""
CHUNK = 1 << 22


class Assets:
    """Reader of the meshes and images of one scene, which keeps their contents until `release`.

    A file that has changed since its first use is refused with ValueError, so that the scene stays the same.
    """

    def __init__(self, search: Search) -> None:
        self._search = search
        self._meshes: dict[tuple[str, int | str | None, float | None], Mesh] = {}
        self._images: dict[Path, NDArray[np.float32]] = {}
        self._told: dict[Path, tuple[str, ...]] = {}
        self._texels: dict[tuple[str, bool], Texels] = {}
        self._stamps: dict[Path, tuple[int, int]] = {}
        self._sums: dict[Path, str] = {}
        self._contents: dict[Path, Contents] = {}
        self._by_material: dict[Path, dict[bytes, Mesh]] = {}

    def mesh(self, shape: MeshFile) -> Mesh:
        """Return the mesh of `shape` in local coordinates, with finite vertices and valid indices.

        For a deforming mesh, return the first pose. A mesh without normals gets some if the shape has a crease angle
        and no flat faces. Raises ValueError if the file cannot be used.
        """
        filename = mesh_files(shape.filename)[0]
        path = self.path(filename)
        part = (
            shape.shape_index if isinstance(shape, Serialized) else shape.material if isinstance(shape, Obj) else None
        )
        angle = None if shape.face_normals else shape.crease_angle
        key = (filename, part, angle)
        if key not in self._meshes:
            mesh = self._read_mesh(shape, path, split(filename)[1] or "")
            _check_mesh(path, mesh)
            self._meshes[key] = mesh if angle is None or mesh.normals is not None else creased(mesh, angle)
        return self._meshes[key]

    def _read_mesh(self, shape: MeshFile, path: Path, inside: str) -> Mesh:
        if isinstance(shape, Gltf):
            return self._within(path).mesh(inside)
        try:
            if isinstance(shape, Serialized):
                return read_serialized(path, shape.shape_index)
            if isinstance(shape, Obj):
                return self._read_obj(path, shape.material)
            return read_ply(path)
        except (OSError, ValueError) as error:
            message = str(error)
            raise ValueError(message if str(path) in message else f"{path}: {message}") from error

    def _read_obj(self, path: Path, material: str | None) -> Mesh:
        """Read the faces of one material, or of all; a file with many materials is read only once."""
        if material is None:
            return read_obj(path)
        if path not in self._by_material:
            try:
                self._by_material[path] = {**read_obj_by_material(path)}
            except ValueError:  # the part of the file that is asked for may still be valid
                self._by_material[path] = {}
        for name in _encodings(material):
            if (mesh := self._by_material[path].pop(name, None)) is not None:
                return mesh
        return read_obj(path, material.encode(errors="surrogateescape"))

    def _within(self, path: Path) -> Contents:
        """Return the contents of the glTF file at `path`; the files it names are looked for in its folder."""
        if path not in self._contents:
            self._contents[path] = Contents(path, lambda name: self.path(str(path.parent.absolute() / name)))
        return self._contents[path]

    def extensions(self, filename: str) -> dict[str, str]:
        """Return the extensions that the glTF file `filename` uses, as a dict from the name to words.

        The words name the plugin or parameter that represents the extension, or are ``not used``.
        """
        return self._within(self.path(filename)).extensions

    def companions(self, filename: str) -> tuple[str, ...]:
        """Return the names of the files that the glTF file `filename` reads, relative to its folder."""
        return self._within(self.path(filename)).companions

    def image(self, emitter: EnvMap) -> NDArray[np.float32]:
        """Return the image (H, W, 3) of `emitter` in linear sRGB; all values are finite and at least 0."""
        path = self.path(emitter.filename)
        if path not in self._images:
            self._images[path], self._told[path] = _read_sky(path)
        return self._images[path]

    def told_of_image(self, emitter: EnvMap) -> tuple[str, ...]:
        """Return the warnings about the image file of `emitter`, such as unused channels, as text.

        The image is read if needed.
        """
        self.image(emitter)
        return self._told[self.path(emitter.filename)]

    def texture(self, bitmap: Bitmap) -> Texels:
        """Return the texels of `bitmap`, all finite; raises ValueError if the image file cannot be read."""
        path, fragment = self.path(bitmap.filename), split(bitmap.filename)[1]
        key = bitmap.filename, bitmap.raw
        if key not in self._texels:
            within = None if fragment is None else self._within(path).bitmap(fragment)
            self._texels[key] = within or read_picture(path, bitmap.raw)
        return self._texels[key]

    def sha256(self, filename: str) -> str:
        """Return the SHA-256 of the file `filename`, in hexadecimal digits, to detect changes.

        For ``file.gltf#fragment``, the hash covers only the mesh or the image that the fragment names.
        """
        path, fragment = self.path(filename), split(filename)[1]
        if fragment is not None:
            return self._within(path).sha256(fragment)
        if path not in self._sums:  # each instance of a group asks for the group's files
            content = hashlib.sha256()
            with path.open("rb") as file:
                while chunk := file.read(CHUNK):
                    content.update(chunk)
            self._sums[path] = content.hexdigest()
        return self._sums[path]

    def absolute(self, filename: str) -> str:
        """Return `filename` with an absolute path; a fragment, as in ``file.gltf#fragment``, is kept."""
        inside = split(filename)[1]
        return str(self.path(filename).absolute()) + ("" if inside is None else f"#{inside}")

    def release(self) -> None:
        """Free the memory of all files' contents. A later use reads the files again."""
        self._meshes.clear()
        self._by_material.clear()
        self._images.clear()
        self._contents.clear()
        self._texels.clear()

    @property
    def files(self) -> set[Path]:
        """Paths of all meshes, images and other files that were found while the scene was read."""
        return self._search.files

    def lost(self, filename: str) -> Lost | None:
        """Return what replaces the image `filename` if it is missing; None if it is there.

        An image that a glTF file names or contains counts as missing if it cannot be decoded. Other problems of the
        file have no substitute, so the result is None; reading the image tells them.
        """
        name, fragment = split(filename)
        if not exists(self._search.find(name)):
            return Lost(f"missing image '{filename}'")
        with suppress(ValueError):
            return None if fragment is None else self._within(self.path(name)).lost(fragment)
        return None

    def path(self, filename: str) -> Path:
        """Return the path of the file called `filename`, without a fragment.

        Raises ValueError if the file is missing, or has changed since its first use.
        """
        path = self._search.find(split(filename)[0])
        try:
            if not path.is_file():
                raise ValueError(f"{'is no file' if path.exists() else 'no such file'}: {path}")
            stat = path.stat()
        except OSError as error:  # such as a name that no file can have
            raise ValueError(f"{error.strerror or error}: {path}") from error
        stamp = (stat.st_size, stat.st_mtime_ns)
        if self._stamps.setdefault(path, stamp) != stamp:
            raise ValueError(f"the file has changed since the scene was loaded: {path}")
        return path


def _encodings(name: str) -> Iterator[bytes]:
    """Yield the possible encodings of a name in a file: UTF-8, then Latin-1."""
    yield name.encode(errors="surrogateescape")
    with suppress(UnicodeEncodeError):
        yield name.encode("latin-1")


def _check_mesh(path: Path, mesh: Mesh) -> None:
    if len(mesh.faces) == 0:
        raise ValueError(f"{path}: the mesh has no faces")
    for what, data in (("vertex", mesh.vertices), ("normal", mesh.normals), ("texture coordinate", mesh.uvs)):
        if data is not None and not np.isfinite(data).all():
            wrong = np.flatnonzero(~np.isfinite(data).all(axis=1))
            more = f" (and {len(wrong) - 1} more)" if len(wrong) > 1 else ""
            raise ValueError(f"{path}: {what} {wrong[0]} is not finite: {data[wrong[0]].tolist()}{more}")
    if mesh.faces.max() >= len(mesh.vertices):
        face = int(np.flatnonzero((mesh.faces >= len(mesh.vertices)).any(axis=1))[0])
        raise ValueError(f"{path}: face {face} names a vertex that does not exist (there are {len(mesh.vertices)})")


def _read_sky(path: Path) -> tuple[NDArray[np.float32], tuple[str, ...]]:
    """Return the image of a sky (H, W, 3), and the reader's remarks on its file."""
    picture = read_picture(path)
    height, width, _ = picture.texels.shape
    if width < 2 or height < 3:
        raise ValueError(f"{path}: an environment needs at least 2x3 pixels, found {width}x{height}")
    image = picture.linear
    count = np.count_nonzero((image < 0.0).any(axis=2))
    if not count:
        return image, picture.told
    # negative values come from resampling or from another gamut
    least = f"the least is {image.min():.3g}, the largest {image.max():.3g}"
    dark = f"{count} pixels have negative values, which count as 0: {least}"
    return np.maximum(image, 0.0), (*picture.told, dark)
