"""Access to meshes and bitmaps of a glTF file by name, such as ``model.glb#/meshes/0/primitives/1``."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any, Final, Literal, TypeVar

import numpy as np
from numpy.typing import NDArray

from equaltime.scene.gltf.document import Document, Malformed, parse
from equaltime.scene.gltf.extent import check_extent
from equaltime.scene.gltf.poses import Pose, at_time
from equaltime.scene.gltf.primitives import Source, Triangles, mirrored_uvs, read
from equaltime.scene.gltf.textures import bake, lost
from equaltime.scene.lost_images import Lost
from equaltime.scene.pictures import Texels

__all__ = ["Contents", "split"]

Value = TypeVar("Value")
_NAME: Final = re.compile(r"(.*\.(?:gltf|glb))#(.*)", re.IGNORECASE | re.DOTALL)
_PRIMITIVE: Final = re.compile(
    r"(?:/animations/(?P<animation>\d{1,9})/(?P<time>-?\d{1,20}(?:\.\d{1,40})?(?:e[-+]?\d{1,3})?))?"
    r"/(?P<owner>meshes|nodes)/(?P<index>\d{1,9})/primitives/(?P<primitive>\d{1,9})(?:/(?P<part>mirrored|unmirrored))?"
)
_BITMAP: Final = re.compile(r"/materials/(\d{1,9})/([a-z_]+)")


def split(filename: str) -> tuple[str, str | None]:
    """Split `filename`, the name of a mesh or bitmap, at ``#``, and return the pair (file name, fragment).

    For example, ``model.glb#/meshes/0/primitives/1`` has the fragment ``/meshes/0/primitives/1``. A name that does not
    point into a glTF file is returned unchanged, with None as fragment.
    """
    match = _NAME.fullmatch(filename)
    return (match[1], match[2]) if match else (filename, None)


class Contents:
    """Meshes and bitmaps of one glTF file, by fragment.

    A fragment is the part of a name after ``#``, such as ``/meshes/0/primitives/1``.
    """

    def __init__(self, path: Path, locate: Callable[[str], Path]) -> None:
        """Read the glTF file `path`; raise ValueError if it is malformed.

        `locate` is a function that returns the path of a file, given the name by which the glTF file refers to it.
        """
        self._path = path
        with self._told():
            self._document: Document = parse(path.name, path.read_bytes(), locate)
            check_extent(self._document)
        self._poses: dict[tuple[str, str], Pose] = {}

    @property
    def extensions(self) -> dict[str, str]:
        """Mitsuba plugins or parameters that the glTF extensions of the file become, in words, by the extension's name.

        The words come from `MAPPING`; an unsupported extension has the entry ``not used``.
        """
        return self._document.extensions

    @property
    def companions(self) -> tuple[str, ...]:
        """Names of the buffers and images outside the file, relative to its folder; missing files are left out."""
        return tuple(self._document.relative(uri, "") for uri in self._document.outside)

    def sha256(self, fragment: str) -> str:
        """Return the SHA-256, in hexadecimal digits, of the mesh or bitmap that `fragment` names.

        Raises ValueError if the mesh or bitmap does not exist or is malformed.
        """
        arrays: tuple[NDArray[Any] | None, ...]
        if _PRIMITIVE.fullmatch(fragment):
            mesh = self.mesh(fragment)
            arrays = (mesh.vertices, mesh.faces, mesh.normals, mesh.uvs, mesh.colors, mesh.light)
        else:
            bitmap = self.bitmap(fragment)
            arrays = (bitmap.texels, np.array(bitmap.srgb))
        content = hashlib.sha256()
        for array in arrays:
            content.update(b"none" if array is None else f"{array.dtype.str} {array.shape} ".encode())
            content.update(b"" if array is None else np.ascontiguousarray(array).data)
        return content.hexdigest()

    def mesh(self, fragment: str) -> Triangles:
        """Return the mesh that `fragment` names.

        ``/meshes/M/primitives/P`` is primitive P of mesh M. ``/nodes/N/primitives/P`` is primitive P of the mesh of
        node N, deformed by that node. The prefix ``/animations/A/T`` selects the pose at time T (seconds) of animation
        A. The suffix ``/mirrored`` selects the triangles on which textures appear mirrored, and ``/unmirrored`` all
        others. Raises ValueError if the primitive does not exist or is malformed.
        """
        with self._told():
            return self._mesh(fragment)

    def bitmap(self, fragment: str) -> Texels:
        """Return the bitmap of a material's parameter; `fragment` is its name, such as ``/materials/2/roughness``.

        Raises ValueError if the bitmap does not exist or is malformed.
        """
        with self._told():
            return self._parameter(fragment, bake)

    def lost(self, fragment: str) -> Lost | None:
        """Return what replaces the bitmap named `fragment` if its image cannot be read; None if it can.

        Raises ValueError if the bitmap does not exist or is malformed.
        """
        with self._told():
            return self._parameter(fragment, lost)

    @contextmanager
    def _told(self) -> Iterator[None]:
        """Add the file's name to errors in the file."""
        try:
            yield
        except Malformed as error:
            raise ValueError(f"{self._path}: {error}") from error

    def _mesh(self, fragment: str) -> Triangles:
        found, part = self._primitive(fragment)
        if part in ("mirrored", "unmirrored"):
            return replace(found, faces=found.faces[mirrored_uvs(found) == (part == "mirrored")])
        return found

    def _primitive(self, fragment: str) -> tuple[Triangles, str | None]:
        """Return the whole primitive that a name is about, and the last part of the name."""
        match, found = _PRIMITIVE.fullmatch(fragment), None
        if match is not None:
            owner: Literal["nodes", "meshes"] = "nodes" if match["owner"] == "nodes" else "meshes"
            source = Source(owner, int(match["index"]), int(match["primitive"]))
            found = read(self._pose(match["animation"], match["time"]), source)
        if match is None or found is None:
            raise Malformed(("", f"has no primitive '#{fragment}'; expected #/meshes/0/primitives/0 or the like"))
        return found, match["part"]

    def _pose(self, animation: str | None, time: str | None) -> Pose:
        """Return the pose at a time of an animation, or the pose in the file."""
        key = (animation or "", time or "")
        if key not in self._poses:
            still = animation is None or time is None
            self._poses[key] = Pose(self._document) if still else at_time(self._document, int(key[0]), float(key[1]))
        return self._poses[key]

    def _parameter(self, fragment: str, read: Callable[[Document, int, str], Value]) -> Value:
        match = _BITMAP.fullmatch(fragment)
        try:
            if match is None:
                raise KeyError(fragment)
            return read(self._document, int(match[1]), match[2])
        except (IndexError, KeyError):
            expected = "expected #/materials/0/base_color or the like"
            raise Malformed(("", f"has no bitmap '#{fragment}'; {expected}")) from None
