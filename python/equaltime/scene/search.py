"""Finds the files that a scene names, and reads the files that it includes, with limits on nesting and repetition."""

from __future__ import annotations

from pathlib import Path
from typing import Final

__all__ = ["Includes", "Search", "exists"]


class Search:
    """The folders in which a scene's files are looked for, in order, and the files found (`files`).

    At first, the only folder is the scene file's own. Statements of the scene and of included files add folders.
    """

    def __init__(self, folder: Path) -> None:
        self._home = folder
        self._folders = [folder]
        self.files: set[Path] = set()
        """Every file that was found, or that `note` was given."""

    def add(self, folder: Path, *, first: bool = False) -> None:
        """Add `folder` to the folders in which files are looked for, unless it is already there.

        It becomes the last folder, or with `first` the first one.
        """
        if folder not in self._folders:
            self._folders.insert(0 if first else len(self._folders), folder)

    def find(self, name: str, *, beside: Path | None = None) -> Path:
        r"""Return the path of the first file or folder called `name` in the listed folders.

        If `beside` is given, the folder of that file comes first, as in Mitsuba: a file finds its neighbour, even if
        another folder holds a file of the same name. If there is no such file, return the path that `name` would have
        in the scene file's folder. Names written on Windows, such as ``textures\wood.png``, are understood if no file
        has just that name.
        """
        folders = self._folders if beside is None else [beside.parent, *self._folders]
        for spelling in dict.fromkeys((name, name.replace("\\", "/"))):
            for folder in folders:
                if exists(path := folder / spelling):
                    return self.note(path)
        return self._home / name

    def note(self, path: Path) -> Path:
        """Record the file at `path`, which was found in another way, among the scene's `files`, and return `path`."""
        self.files.add(path)
        return path


def exists(path: Path) -> bool:
    """Tell whether there is a file or folder at `path`; False for a name that no file can have."""
    try:
        return path.exists()
    except (OSError, ValueError):  # such as an invalid file name
        return False


MOST_DEEP: Final = 15
"""Largest depth of files that include files, as in Mitsuba."""
MOST_READ_AGAIN: Final = 1 << 19
"""Largest total size, in bytes, of repeated readings of included files. Their number can double with each level."""
A_FILE: Final = 1 << 10
"""Bytes that each repeated reading of a file counts beyond the file's size, for the work of opening the file."""


class Includes:
    """Reader of the files that one scene includes. It limits the total size of repeated readings."""

    def __init__(self) -> None:
        self._opened: set[Path] = set()
        self._read_again = 0

    def read(self, path: Path, depth: int) -> bytes:
        """Return the content of a file that is included at nesting level `depth`.

        Raises ValueError if the file cannot be read, `depth` is above `MOST_DEEP`, or too much was read repeatedly.
        """
        if depth > MOST_DEEP:
            raise ValueError(f"files include each other more than {MOST_DEEP} deep")
        try:
            content = path.read_bytes()
        except (OSError, ValueError) as error:
            raise ValueError(f"cannot be read: {getattr(error, 'strerror', None) or error}: {path}") from error
        if path in self._opened:
            self._read_again += len(content) + A_FILE
        self._opened.add(path)
        if self._read_again > MOST_READ_AGAIN:
            raise ValueError(f"files are included again and again: more than {MOST_READ_AGAIN} bytes")
        return content
