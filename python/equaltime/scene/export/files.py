"""Files of an exported scene: relative names of existing meshes and images, and new files in a folder of the scene.

No file is overwritten.
"""

from __future__ import annotations

import filecmp
import os
import shutil
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from itertools import count
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from equaltime.files import beside, give_new_name

__all__ = ["Folder", "relative", "write_ply"]

Array = NDArray[np.float64]
TYPES: Final = {"<f4": "float", "<f8": "double"}


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
        self._tidied = False

    def copy(self, file: Path) -> Path:
        """Copy `file` into this folder and return the path of the copy.

        If the folder has an identical file with this name, that file is used instead.
        """
        return self.put(file.name, lambda target: shutil.copyfile(file, target))

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


def write_ply(
    path: Path,
    vertices: Array,
    faces: NDArray[np.uint32],
    normals: Array | None,
    uvs: Array | None,
    attributes: Mapping[str, Array] | None = None,
) -> None:
    """Write a mesh as a binary PLY file, without loss of precision.

    Shapes of the arrays: `vertices` and `normals` (N, 3), `uvs` (N, 2), `faces` (M, 3). The `attributes` of vertices
    have Mitsuba's names, such as ``vertex_color``, and shapes (N, 1) or (N, 3).
    """
    columns = {
        **dict(zip("xyz", vertices.T, strict=True)),
        **({} if normals is None else dict(zip(("nx", "ny", "nz"), normals.T, strict=True))),
        **({} if uvs is None else dict(zip("uv", uvs.T, strict=True))),
        **{name: column for attribute in (attributes or {}).items() for name, column in _columns(*attribute)},
    }
    records = np.empty(len(vertices), dtype=[(name, _smallest(column)) for name, column in columns.items()])
    for name, column in columns.items():
        records[name] = column
    corners = np.empty(len(faces), dtype=[("count", "u1"), ("corners", "<i4", 3)])
    corners["count"], corners["corners"] = 3, faces
    header = [
        "ply",
        "format binary_little_endian 1.0",
        f"element vertex {len(records)}",
        *(f"property {TYPES[records.dtype[name].str]} {name}" for name in columns),
        f"element face {len(corners)}",
        "property list uchar int vertex_indices",
        "end_header\n",
    ]
    path.write_bytes("\n".join(header).encode() + records.tobytes() + corners.tobytes())


def _columns(attribute: str, values: Array) -> Iterator[tuple[str, Array]]:
    """Iterate over the vertex properties that are read back as this attribute."""
    name = attribute.removeprefix("vertex_")
    names = "rgb" if name == "color" else [f"{name}_{number}" for number in range(values.shape[1])]
    yield from zip(names, values.T, strict=True)


def _smallest(column: Array) -> str:
    """Return the smallest PLY type that holds the numbers exactly."""
    with np.errstate(over="ignore"):
        return "<f4" if np.array_equal(column.astype("<f4").astype(np.float64), column) else "<f8"
