"""Looks for the files that a scene names."""

from __future__ import annotations

from pathlib import Path

__all__ = ["Search"]


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
        """Add `folder` at the end of the list of folders, or with `first` at the beginning, unless it is listed."""
        if folder not in self._folders:
            self._folders.insert(0 if first else len(self._folders), folder)

    def find(self, name: str) -> Path:
        r"""Return the path of the first file or folder called `name` in the listed folders.

        If there is none, return the path that `name` would have in the scene file's folder. Names written on Windows,
        such as ``textures\wood.png``, are understood if no file has exactly that name.
        """
        for spelling in dict.fromkeys((name, name.replace("\\", "/"))):
            for folder in self._folders:
                if _exists(path := folder / spelling):
                    return self.note(path)
        return self._home / name

    def note(self, path: Path) -> Path:
        """Add the file at `path`, which was not looked for by `find`, to `files`, and return `path`."""
        self.files.add(path)
        return path


def _exists(path: Path) -> bool:
    try:
        return path.exists()
    except (OSError, ValueError):  # such as an invalid file name
        return False
