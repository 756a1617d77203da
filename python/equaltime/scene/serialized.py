"""Reads Mitsuba's ``.serialized`` files, which hold several meshes, each as a header and a zlib stream.

The documentation of Mitsuba's plugin ``serialized`` describes the format. Versions 3 and 4 are read. Declared sizes are
not trusted: memory grows only with the data in the stream.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

from equaltime import _core

__all__ = ["read_serialized"]

MAGIC: Final = 0x041C
HAS_NORMALS, HAS_UVS, HAS_COLORS, FLAT, SINGLE, DOUBLE = 0x0001, 0x0002, 0x0008, 0x0010, 0x1000, 0x2000
KNOWN: Final = HAS_NORMALS | HAS_UVS | HAS_COLORS | FLAT | SINGLE | DOUBLE
MOST_INFLATED: Final = 1032
"""Largest compression factor of zlib: a stream of n bytes holds at most 1032 n bytes."""
CHUNK: Final = 1 << 20
LONGEST_NAME: Final = 1 << 16


def read_serialized(path: Path, index: int) -> _core.MeshData:
    """Return mesh number `index`, counted from 0, of the file at `path`.

    Raises MeshError (a ValueError) for an invalid file or a missing mesh, and OSError for an unreadable file.
    """
    with path.open("rb") as file:
        size = path.stat().st_size
        version = _header(file, path, 0)
        begin = _offset(file, path, index, version, size)
        if begin:
            version = _header(file, path, begin)
        return _mesh(_Inflated(file, path, size - begin), path, version)


def _fail(path: Path, message: str) -> _core.MeshError:
    return _core.MeshError(f"{path}: {message}")


def _header(file: BinaryIO, path: Path, begin: int) -> int:
    """Return the version of the mesh at `begin`; the file is then positioned after the header."""
    file.seek(begin)
    header = file.read(4)
    if len(header) < 4 or (found := struct.unpack("<HH", header))[0] != MAGIC:
        raise _fail(path, f"byte offset {begin}: no serialized mesh begins here")
    if found[1] not in (3, 4):
        raise _fail(path, f"byte offset {begin}: version {found[1]} of the format is unknown; 3 and 4 are read")
    return int(found[1])


def _offset(file: BinaryIO, path: Path, index: int, version: int, size: int) -> int:
    """Return the offset of mesh `index`, from the table at the end of the file; the first mesh needs no table."""
    if index == 0:
        return 0
    width, code = (8, "<Q") if version == 4 else (4, "<I")
    file.seek(max(0, size - 4))
    count = struct.unpack("<I", file.read(4))[0]
    if count * width + 4 > size:
        raise _fail(path, f"the table at its end declares {count} meshes, more than the file has room for")
    if index >= count:
        raise _fail(path, f"shape_index {index} does not exist: the file has {count} meshes")
    file.seek(size - 4 - width * (count - index))
    begin: int = struct.unpack(code, file.read(width))[0]
    if begin >= size:
        raise _fail(path, f"mesh {index} begins at byte {begin}, behind the end of the file")
    file.seek(begin)
    return begin


class _Inflated:
    """Reads the contents of a zlib stream in order."""

    def __init__(self, file: BinaryIO, path: Path, size: int) -> None:
        self._file = file
        self._path = path
        self._stream = zlib.decompressobj()
        self._tail = b""
        self._most = MOST_INFLATED * size

    def read(self, count: int, what: str) -> bytearray:
        """Return the next `count` bytes."""
        if count > self._most:
            raise _fail(self._path, f"{count} bytes of {what} are declared, more than the file can hold")
        out = bytearray()
        while len(out) < count:
            compressed = self._tail or self._file.read(CHUNK)
            if self._stream.eof or not compressed:
                raise _fail(self._path, f"the data end within the {what}")
            try:
                out += self._stream.decompress(compressed, min(CHUNK, count - len(out)))
            except zlib.error as error:
                raise _fail(self._path, f"the compressed data are damaged within the {what}: {error}") from None
            self._tail = self._stream.unconsumed_tail
        return out

    def number(self, code: str, what: str) -> int:
        """Return the next integer, in the format `code` of `struct`."""
        return int(struct.unpack(code, self.read(struct.calcsize(code), what))[0])

    def rows(self, count: int, width: int, kind: str, what: str) -> NDArray[np.generic]:
        """Return the next (count, width) numbers of a NumPy type."""
        values = self.read(count * width * np.dtype(kind).itemsize, what)
        return np.frombuffer(values, dtype=kind).reshape(count, width)

    def vectors(self, count: int, width: int, kind: str, what: str) -> NDArray[np.float64]:
        """Return the next (count, width) numbers as float64, including NaNs."""
        with np.errstate(invalid="ignore"):
            return self.rows(count, width, kind, what).astype(np.float64)


def _mesh(stream: _Inflated, path: Path, version: int) -> _core.MeshData:
    flags = stream.number("<I", "flags")
    if version == 4:
        for length in range(LONGEST_NAME + 1):
            if stream.read(1, "name") == b"\0":
                break
            if length == LONGEST_NAME:
                raise _fail(path, f"the name of the mesh is longer than {LONGEST_NAME} bytes")
    count, faces = stream.number("<Q", "number of vertices"), stream.number("<Q", "number of triangles")
    real = "<f8" if flags & DOUBLE else "<f4"
    vertices = stream.vectors(count, 3, real, "vertices")
    normals = stream.vectors(count, 3, real, "normals") if flags & HAS_NORMALS else None
    uvs = stream.vectors(count, 2, real, "texture coordinates") if flags & HAS_UVS else None
    colors = {"vertex_color": stream.rows(count, 3, real, "vertex colours")} if flags & HAS_COLORS else {}
    corners = stream.rows(faces, 3, "<u8" if count > 0xFFFFFFFF else "<u4", "triangles")
    if corners.size and int(corners.max()) >= count:
        raise _fail(path, f"a triangle names vertex {int(corners.max())}: the mesh has {count}, counted from 0")
    triangles = corners.astype(np.uint32, copy=False)
    return _core.finished_mesh(path, vertices, triangles, normals, uvs, colors, list(_told(flags)))


def _told(flags: int) -> Iterator[str]:
    """Iterate over remarks on the flags of a mesh that are not used."""
    if flags & FLAT:
        yield "its flag for flat faces is not used, as in Mitsuba 3; face_normals = true makes them flat"
    if unknown := flags & ~KNOWN:
        yield f"the flags {unknown:#x} are unknown and not used"
