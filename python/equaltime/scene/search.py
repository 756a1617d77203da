"""Looks for the files that a scene names."""

from __future__ import annotations

from pathlib import Path

__all__ = ["Search"]


class Search:
    """The folders in which files are looked for, in order, and the files found.

    The list begins with the scene file's folder. Scenes add folders, and so do included files.
    """

    def __init__(self, folder: Path) -> None:
        self._home = folder
        self._folders = [folder]
        self.files: set[Path] = set()
        """Every file that was found, or that `note` was given."""

    def add(self, folder: Path, *, first: bool = False) -> None:
        """Add `folder` at the end of the list, or with `first` at its beginning."""
        if folder not in self._folders:
            self._folders.insert(0 if first else len(self._folders), folder)

    def find(self, name: str) -> Path:
        r"""Return the first file or folder called `name`; if there is none, a path in the scene file's folder.

        Names written on Windows, such as ``textures\wood.png``, are understood if no file has exactly that name.
        """
        for spelling in dict.fromkeys((name, name.replace("\\", "/"))):
            for folder in self._folders:
                if _exists(path := folder / spelling):
                    return self.note(path)
        return self._home / name

    def note(self, path: Path) -> Path:
        """Add a file that is read without `find` to `files`, and return its path."""
        self.files.add(path)
        return path


def _exists(path: Path) -> bool:
    try:
        return path.exists()
    except (OSError, ValueError):  # such as an invalid file name
        return False
