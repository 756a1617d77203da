"""The example scenes and experiments that come with the package: where they are, and how they are found by name."""

from __future__ import annotations

import shutil
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Final

__all__ = ["copy_to", "example_of", "experiment_names", "experiments_of", "scene_names", "scenes_folder"]

_LEFT_OUT: Final = shutil.ignore_patterns("gallery", "learn", "renderers", "__pycache__", "*.png", "*.jpg")
"""Pages with pictures, which a copy of the scenes does without."""
_KINDS: Final = (".toml", ".xml", ".glb")


def scenes_folder() -> Path:
    """Return the folder of the scenes: in the installed package if it exists there, else in the source tree."""
    installed = Path(__file__).parent / "scenes"
    return installed if installed.is_dir() else Path(__file__).parents[2] / "scenes"


def scene_names() -> Mapping[str, Path]:
    """Return the files of the example scenes by name, such as ``cornell-box`` or ``montelight/simple``."""
    return {name: path for name, path in _files().items() if not _is_experiment(path)}


def experiment_names() -> Mapping[str, Path]:
    """Return the files of the example experiments by name, such as ``experiments/x3-light``."""
    return {name: path for name, path in _files().items() if _is_experiment(path)}


def example_of(path: Path) -> Path | None:
    """Return the file of the example that ``path`` names; None if it names no example, has a suffix, or exists.

    `scene_names` and `experiment_names` list the names. The last part of a name is enough if only one example has it:
    ``simple`` for ``montelight/simple``.
    """
    if path.suffix in _KINDS or path.exists():
        return None
    wanted, files = path.as_posix(), _files()
    if wanted in files:
        return files[wanted]
    ends = [file for name, file in files.items() if name.endswith(f"/{wanted}")]
    return ends[0] if len(ends) == 1 else None


def experiments_of(path: Path) -> Path | None:
    """Return the folder of the example experiments if ``path`` is ``experiments`` and does not exist, else None.

    With the folder, a command can be given all example experiments by one word.
    """
    folder = scenes_folder() / "experiments"
    return folder if path == Path(folder.name) and not path.exists() else None


def copy_to(folder: Path) -> None:
    """Copy all examples, with what they need, into a new folder.

    Raises
    ------
    FileExistsError
        If ``folder`` exists.
    OSError
        If a file cannot be written.
    """
    shutil.copytree(scenes_folder(), folder, ignore=_LEFT_OUT)


def _files() -> dict[str, Path]:
    """Return all scenes and experiments by name; a file ``scene.xml`` has the name of its folder."""
    folder = scenes_folder()
    named = {path.relative_to(folder).with_suffix("").as_posix(): path for path in folder.rglob("*") if _counts(path)}
    return {name.removesuffix("/scene"): path for name, path in sorted(named.items())}


def _counts(path: Path) -> bool:
    return path.suffix in _KINDS and "gallery" not in path.parts


def _is_experiment(path: Path) -> bool:
    return path.suffix == ".toml" and "strategies" in tomllib.loads(path.read_text(encoding="utf-8"))
