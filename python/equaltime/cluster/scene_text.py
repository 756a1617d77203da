"""Scene as text with its digest, for other processes: they read the same files, or copies of them.

The core's scene does not travel; every process builds its own, once. The files that the scene names are read at their
own paths where these exist, as on a shared file system. Elsewhere they are copied below a folder of the process.
"""

from __future__ import annotations

import atexit
import json
import shutil
import tempfile
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from equaltime.errors import Problem, RenderError, SceneError
from equaltime.scene import Scene, load_dict
from equaltime.scene.export import scene_dict
from equaltime.strict_json import json_text

__all__ = ["Files", "SceneText", "copy_into", "lacks", "scene_of", "store"]

Files = Sequence[tuple[str, int]]
"""Absolute path and size in bytes of each file that a scene needs."""

_ROOT = "equaltime-root:"
"""Stands before each file's absolute path in the text; it becomes the folder of copies, or nothing."""
_SCENES: dict[str, Scene] = {}
"""The scenes that this process has loaded, by their digests."""
_COPIES: list[Path] = []
"""The folder of copied files in this process, once there is one."""
_PARENTS: list[str] = []
"""Folder in which the folder of copied files is made. Without one, it is made among the system's temporary files."""


@dataclass(frozen=True)
class SceneText:
    """Scene as text, and a list of the files that it needs, to be sent to another process."""

    digest: str
    """SHA-256 of the scene's content, files included."""
    text: bytes
    """The scene as a dictionary in JSON, compressed by zlib."""
    files: tuple[tuple[str, int], ...]
    """Absolute path and size in bytes of each file that the scene needs."""

    @classmethod
    def of(cls, scene: Scene) -> SceneText:
        """Return ``scene`` as text for another process.

        Raises SceneError if one of the scene's files is missing or has changed.
        """
        try:
            text = json_text(scene_dict(scene.model, lambda name: _ROOT + scene.assets.absolute(name)))
        except ValueError as error:
            raise SceneError((Problem("", str(error)),)) from error
        paths = sorted(path.absolute() for path in scene.assets.files if path.is_file())
        return cls(scene.digest, zlib.compress(text.encode()), tuple((str(p), p.stat().st_size) for p in paths))

    def load(self) -> Scene:
        """Return the scene in the process that received the text; it is loaded at the first call only.

        Raises
        ------
        RenderError
            If the files here differ from the files of the scene where the text was made.
        SceneError
            If the scene or a file cannot be read.
        """
        if self.digest not in _SCENES:
            root = "" if _at(Path("/"), self.files) else str(_copies())
            text = zlib.decompress(self.text).decode().replace(_ROOT, json_text(root)[1:-1])
            scene = load_dict(json.loads(text))
            if scene.digest != self.digest:
                raise RenderError("the files of the scene have other contents here than where the render was started")
            _SCENES.clear()  # scenes may be large, and renders come one after another
            _SCENES[self.digest] = scene
        return _SCENES[self.digest]


def lacks(files: Files) -> bool:
    """Tell whether this process needs copies of ``files``, pairs of path and size in bytes.

    A file is needed if it is missing at its path on this machine, or has another size there. Files that were copied
    before are not needed again.
    """
    return not _at(Path("/"), files) and not _at(_copies(), files)


def copy_into(folder: str) -> None:
    """Let this process make its copies of files in ``folder``, which others delete if the process is killed."""
    _PARENTS[:] = [folder]


def store(path: str, offset: int, data: bytes) -> None:
    """Write ``data`` to the copy of a file in this process, from ``offset`` in bytes on; ``path`` is the original's.

    A large file arrives in several parts. ``path`` is absolute.
    """
    copy = _below(_copies(), path)
    copy.parent.mkdir(parents=True, exist_ok=True)
    with copy.open("r+b" if offset else "wb") as file:
        file.seek(offset)
        file.write(data)


def _at(root: Path, files: Files) -> bool:
    """Tell whether all files are below a folder, with their sizes."""
    found = ((_below(root, path), size) for path, size in files)
    return all(path.is_file() and path.stat().st_size == size for path, size in found)


def _below(root: Path, path: str) -> Path:
    return root / Path(path).relative_to("/")


def _copies() -> Path:
    """Return the folder of copied files, which lasts as long as this process."""
    if not _COPIES:
        _COPIES.append(Path(tempfile.mkdtemp(prefix="equaltime-", dir=_PARENTS[0] if _PARENTS else None)))
        atexit.register(shutil.rmtree, _COPIES[0], ignore_errors=True)
    return _COPIES[0]


def scene_of(digest: str) -> Scene:
    """Return the scene whose content has the SHA-256 ``digest``, and which this process has loaded before.

    Raises RenderError if this process has loaded no such scene.
    """
    if digest not in _SCENES:
        raise RenderError("this process does not have the scene")
    return _SCENES[digest]
