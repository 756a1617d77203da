"""Where the files that a scene names are looked for."""

from __future__ import annotations

from pathlib import Path

__all__ = ["Search"]


class Search:
    """An ordered list of folders: that of the scene file, those that it adds, those of the files that it includes."""

    def __init__(self, folder: Path) -> None:
        self._home = folder
        self._folders = [folder]
        self.files: set[Path] = set()
        """Every file that was found, or `note` was told of."""

    def add(self, folder: Path, *, first: bool = False) -> None:
        """Look in `folder` too, after all others or before them."""
        if folder not in self._folders:
            self._folders.insert(0 if first else len(self._folders), folder)

    def find(self, name: str) -> Path:
        r"""Return the first file or folder of that name; where there is none, what it would be beside the scene file.

        Names that were written on Windows, such as ``textures\wood.png``, are understood where no file has them.
        """
        for spelling in dict.fromkeys((name, name.replace("\\", "/"))):
            for folder in self._folders:
                if _exists(path := folder / spelling):
                    return self.note(path)
        return self._home / name

    def note(self, path: Path) -> Path:
        """Remember a file that is read without being looked for, and return it."""
        self.files.add(path)
        return path


def _exists(path: Path) -> bool:
    try:
        return path.exists()
    except (OSError, ValueError):  # such as a name that no file can have
        return False
