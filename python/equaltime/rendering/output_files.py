"""What an output may take the place of: nothing that a scene was read from, and no work that nobody meant to lose."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, Final

from equaltime.errors import ImageError
from equaltime.files import replacing
from equaltime.images import image_files as images
from equaltime.images.preview import SOURCE
from equaltime.images.reading import utf8
from equaltime.rendering.render_file import read_record

__all__ = ["check_replaceable", "check_spares", "keep_work"]

_WORTH_KEEPING: Final = 60.0
"""Seconds of rendering."""


def check_spares(places: Iterable[Path], files: Iterable[Path], why: str) -> None:
    """Raise `ImageError` for an output that would take the place of one of the files, by whatever name or link."""
    there = [file for file in files if os.path.exists(file)]
    for place in filter(Path.exists, places):
        if any(place.samefile(file) for file in there):
            raise ImageError(f"{place}: {why}; write to another")


def check_replaceable(places: Iterable[Path], scene: str | None, digest: str | None = None) -> None:
    """Raise `ImageError` for an output that would replace another program's file, or a render of another scene.

    Renders of the same scene file are replaced, whatever of it has changed since.

    Parameters
    ----------
    places
        EXR and PNG files to be written, which may be there or not.
    scene
        The scene's file as records name it; None for a scene made in memory.
    digest
        SHA-256 of the scene's content: a render of that is of the same scene, wherever its file was.
    """
    for place in filter(Path.exists, places):
        record, text = read_record(place), _attributes(place)
        if not record and not text.get("Software", "").startswith("equaltime "):
            raise ImageError(f"{place}: is there already, and is no render of equaltime's; --overwrite replaces it")
        theirs = record.get("scene", text.get(SOURCE))
        if digest is not None and record.get("digest") == digest:
            continue
        if theirs is not None and not _is_same(theirs, scene):
            words = f"is there already, a render of another scene ({theirs}); --overwrite replaces it"
            raise ImageError(f"{place}: {words}")


def _is_same(theirs: str, ours: str | None) -> bool:
    """Tell whether a scene file is ours; what a record of before calls by a name alone may have been anywhere."""
    if ours is None:
        return False
    return (
        theirs in (ours, images.escaped(ours))
        if os.path.isabs(theirs)
        else os.path.basename(theirs) == os.path.basename(ours)
    )


def _attributes(path: Path) -> Mapping[str, str]:
    utf8(path)  # of another name nothing can be known
    with suppress(ImageError):
        return images.read_attributes(path)
    return {}


def keep_work(path: Path, record: Mapping[str, Any]) -> Path | None:
    """Keep the render that is there under the name ``path~`` if more than a minute of rendering would be lost with it.

    Nothing is lost where the new render, of this ``record``, holds the samples of the old one. One render is kept: an
    older ``path~`` is replaced.

    Returns
    -------
    Path | None
        Where it is kept; None if it need not be.

    Raises
    ------
    ImageError
        If it cannot be kept.
    """
    old = read_record(path)
    seconds = old.get("seconds")
    if not isinstance(seconds, int | float) or seconds <= _WORTH_KEEPING or _holds(record, old):
        return None
    kept = path.with_name(f"{path.name}~")
    try:
        with replacing(kept) as copy:
            shutil.copyfile(path, copy)
            shutil.copymode(path, copy)
    except OSError as error:
        raise ImageError(f"{path}: {seconds:.0f} s of rendering would be lost, and cannot be kept as {kept}") from error
    return kept


def _holds(new: Mapping[str, Any], old: Mapping[str, Any]) -> bool:
    """Tell whether a render has all samples of another one."""
    same = all(new.get(key) == old.get(key) for key in ("digest", "strategy", "without", "crop"))
    return same and _seeds(old) <= _seeds(new) and old.get("paths", 0) <= new.get("paths", 0)


def _seeds(record: Mapping[str, Any]) -> set[Any]:
    return {source.get("seed") for source in record.get("sources", ())} or {record.get("seed")}
