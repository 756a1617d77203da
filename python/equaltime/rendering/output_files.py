"""Paths of a result's files, and checks before they are written: no scene file is replaced, and no work is lost."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, Final, Literal, NamedTuple, get_args

from equaltime.errors import ImageError
from equaltime.files import replacing
from equaltime.images import image_files as images
from equaltime.images.preview import EXTENSIONS, REPEAT, SOURCE, is_edited
from equaltime.images.reading import utf8
from equaltime.rendering.render_file import read_record
from equaltime.statistics.in_words import count

__all__ = [
    "AovPicture",
    "OutputPaths",
    "check_output",
    "check_replaceable",
    "check_spares",
    "copies",
    "keep_others",
    "keep_work",
    "replaced",
]

_WORTH_KEEPING: Final = 60.0
"""Seconds of rendering from which a replaced render of equal content is kept."""
_EARLY: Final = {"interrupt", "unfinished", "nonfinite", "faulty"}
"""Ends of a render (``stopped_by``) before its limits."""


AovPicture = Literal["variance"]
"""Pictures that `Result.save` can write beside the preview: ``variance`` of one sample of each pixel."""


class OutputPaths(NamedTuple):
    """Paths of the files that `Result.save` writes, to check them before a render begins."""

    exr: Path | None
    """EXR file with all data; None if only pictures are written."""
    preview: Path
    """Picture of the image, PNG or JPEG."""
    variance: Path | None = None
    """Picture of the variance; None if it is not asked for."""

    @property
    def pictures(self) -> tuple[Path, ...]:
        """Paths of the pictures: the preview, and the variance if asked for."""
        return tuple(path for path in self[1:] if path is not None)

    @property
    def all(self) -> tuple[Path, ...]:
        """Paths of all files, the EXR first."""
        return self.pictures if self.exr is None else (self.exr, *self.pictures)


def check_output(
    path: Path, extensions: tuple[str, ...] = (".exr", *EXTENSIONS), aov: Collection[AovPicture] = ()
) -> OutputPaths:
    """Return the paths of the files that a result saved as ``path`` writes.

    Raises `ImageError` if one of the files cannot be written, or if ``path`` has none of the ``extensions``. Raises
    ValueError if ``aov`` names an unknown picture.
    """
    known = get_args(AovPicture)
    if wrong := next((name for name in aov if name not in known), None):
        raise ValueError(f"aov lists pictures to write, of {', '.join(known)}; found {wrong!r}")
    images.check_writable(path, extensions)
    exr = path if path.suffix.lower() == ".exr" else None
    preview = path if exr is None else path.with_suffix(".png")
    paths = OutputPaths(exr, preview, path.with_suffix(".variance.png") if "variance" in aov else None)
    for picture in paths.pictures:
        images.check_writable(picture, EXTENSIONS)
    return paths


def check_spares(places: Iterable[Path], files: Iterable[Path], why: str) -> None:
    """Check that no output path in ``places`` is one of the input ``files``, not even by another name or a link.

    Input files are the files of the scene, or the renders to merge. Raises `ImageError` if an output would replace one
    of them. The message has the output's path, followed by the text ``why``: the reason not to write there.
    """
    there = [file for file in files if os.path.exists(file)]
    for place in filter(Path.exists, places):
        if any(place.samefile(file) for file in there):
            raise ImageError(f"{place}: {why}; write to another")


def check_replaceable(
    places: Iterable[Path], scene: str | None, digest: str | None = None, how: str = "--overwrite"
) -> None:
    """Raise `ImageError` if an output file would replace a file of another program, or a render of another scene.

    Renders of the same scene file may be replaced, even if the file has changed since; `keep_work` then keeps what
    would be lost. A picture that was edited since equaltime wrote it counts as another program's. A scene that was made
    in memory is known to be the same only by its digest.

    Parameters
    ----------
    places
        Paths of the files to be written, which may exist or not; an EXR before the pictures beside it.
    scene
        Absolute path of the scene's file; None for a scene made in memory.
    digest
        SHA-256 of the scene's content: a render of that content is of the same scene, wherever its file was.
    how
        Option or argument that replaces such files, for the message.
    """
    for place, what in _of_others(places, scene, digest):
        raise ImageError(f"{place}: is there already, {what}; {how} replaces it")


def keep_others(places: Iterable[Path], scene: str | None, digest: str | None) -> tuple[Path, ...]:
    """Copy each file that `check_replaceable` would refuse to ``NAME~``, and return the copies.

    An earlier ``NAME~`` is replaced. Raises `ImageError` if a file cannot be copied. ``places``, ``scene`` and
    ``digest`` are as in `check_replaceable`.
    """
    return tuple(_copied(place, "the file would be lost") for place, _ in _of_others(places, scene, digest))


def _of_others(places: Iterable[Path], scene: str | None, digest: str | None) -> Iterator[tuple[Path, str]]:
    """Yield existing files that are no renders of this scene, and what each is."""
    beside = False  # a render of this scene: a picture beside it that names no scene is taken for its own
    for place in filter(Path.exists, places):
        record, text = read_record(place), _attributes(place)
        if not record and not text.get("Software", "").startswith("equaltime "):
            yield place, "and does not say that equaltime made it"
            continue
        if is_edited(place, text):
            yield place, "and was edited since equaltime wrote it"
            continue
        theirs = record.get("scene", text.get(SOURCE))
        content = record.get("digest", _digest(text))
        if (digest is not None and content == digest) or (theirs is not None and _is_same(theirs, scene)):
            beside = True
        elif not (beside and theirs is None and content is None):
            other = f"another scene ({theirs})" if theirs is not None else "a scene made in memory, maybe another one"
            yield place, f"a render of {other}"


def _digest(text: Mapping[str, str]) -> str | None:
    """Return the digest of the scene that a picture shows, from the picture's attributes; None if it is not told."""
    digest = _repeat(text).get("digest")
    return digest if isinstance(digest, str) else None


def _repeat(text: Mapping[str, str]) -> Mapping[str, Any]:
    """Return what repeats a render, from the attributes of its picture; empty if they do not tell."""
    with suppress(ValueError):
        repeat = json.loads(text.get(REPEAT, "null"))
        if isinstance(repeat, dict):
            return repeat
    return {}


def _is_same(theirs: str, ours: str | None) -> bool:
    """Tell whether a scene file is ours; older records have only its name, which may have been in any folder."""
    if ours is None:
        return False
    return (
        theirs in (ours, images.escaped(ours))
        if os.path.isabs(theirs)
        else os.path.basename(theirs) == os.path.basename(ours)
    )


def _attributes(path: Path) -> Mapping[str, str]:
    utf8(path)  # raises for a name that image files cannot have
    with suppress(ImageError):
        return images.read_attributes(path)
    return {}


def keep_work(paths: OutputPaths, record: Mapping[str, Any], scene: str | None, digest: str | None) -> tuple[Path, ...]:
    """Copy renders of this scene that a new render would replace to ``NAME~``, and return the copies.

    An EXR is copied if more than a minute of rendering would be lost, or if the scene's file has other content now:
    nothing makes the picture again. A finished render is copied too if the new one ended early, in less time. A preview
    is copied, and the variance picture with it, unless it belongs to the EXR beside it: a picture does not tell how
    long its render took. Nothing is lost if the new render contains the samples of the existing render. An earlier
    ``NAME~`` is replaced, but one of more than a minute never by a shorter render.

    Parameters
    ----------
    paths
        Paths of the files that the new render writes.
    record
        JSON data on how the new render was made.
    scene, digest
        Scene of the new render, as in `check_replaceable`.

    Raises
    ------
    ImageError
        If an existing render cannot be copied.
    """
    kept = []
    if paths.exr is not None and paths.exr.exists():
        old = read_record(paths.exr)
        if _is_worth_keeping(paths.exr, record, old):
            kept.append(_copied(paths.exr, f"{old['seconds']:.0f} s of rendering would be lost"))
    others = {place for place, _ in _of_others(paths.all, scene, digest)}
    if paths.preview.exists() and paths.preview not in others and not _is_known(paths, record):
        kept += [_copied(picture, "the picture would be lost") for picture in paths.pictures if picture.exists()]
    return tuple(kept)


def _is_known(paths: OutputPaths, record: Mapping[str, Any]) -> bool:
    """Tell whether the existing preview shows the render in the EXR to be written, or samples of the new render."""
    text = _attributes(paths.preview)
    saved = "" if paths.exr is None else _attributes(paths.exr).get("ImageDescription", "")
    if saved and text.get("ImageDescription", "").startswith(saved):
        return True
    with suppress(TypeError, AttributeError):  # a damaged tag
        repeat = _repeat(text)
        return bool(repeat) and _holds(record, repeat)
    return False


def _is_worth_keeping(path: Path, new: Mapping[str, Any], old: Mapping[str, Any]) -> bool:
    """Tell whether the EXR at ``path``, with the record ``old``, is kept as ``NAME~`` beside it."""
    seconds = old.get("seconds")
    if not isinstance(seconds, int | float) or _holds(new, old):
        return False
    if seconds > _WORTH_KEEPING:
        return True
    return (_is_edited(new, old) or _ended_early(new, old)) and not _is_long(_copy_of(path))


def _is_edited(new: Mapping[str, Any], old: Mapping[str, Any]) -> bool:
    """Tell whether two renders are of one scene file with different content or options, such as another size."""
    file = old.get("scene")
    return file is not None and _is_same(file, new.get("scene")) and new.get("digest") != old.get("digest")


def _ended_early(new: Mapping[str, Any], old: Mapping[str, Any]) -> bool:
    """Tell whether a render ended early, in less time than a finished one took."""
    early = new.get("stopped_by") in _EARLY and old.get("stopped_by") not in _EARLY
    return early and new.get("seconds", 0.0) < old["seconds"]


def _is_long(path: Path) -> bool:
    """Tell whether a file is a render of more than a minute."""
    seconds = read_record(path).get("seconds")
    return isinstance(seconds, int | float) and seconds > _WORTH_KEEPING


def _copied(path: Path, lost: str) -> Path:
    """Copy a file to ``NAME~`` beside it and return the copy; ``lost`` says what would be lost if that fails."""
    kept = _copy_of(path)
    try:
        with replacing(kept) as copy:
            shutil.copyfile(path, copy)
            shutil.copymode(path, copy)
    except OSError as error:
        raise ImageError(f"{path}: {lost}, and cannot be kept as {kept}") from error
    return kept


def _copy_of(path: Path) -> Path:
    return path.with_name(f"{path.name}~")


def copies(places: Iterable[Path]) -> dict[Path, int]:
    """Return the existing copies ``NAME~`` of files at ``places``, each with its time of change in nanoseconds."""
    found = {}
    for kept in map(_copy_of, places):
        with suppress(OSError):  # no such file, or a name that is too long
            found[kept] = kept.stat().st_mtime_ns
    return found


def replaced(path: Path, new: Mapping[str, Any], old: Mapping[str, Any]) -> str:
    """Return a sentence on a render that was replaced and not kept; empty if the new render contains its samples.

    `keep_work` keeps renders of more than a minute, renders of the scene before it was edited, and finished renders
    that one which ended early would replace. ``new`` and ``old`` are records of the EXR at ``path``: JSON data on how
    the renders were made. ``old`` is empty if there was no render.
    """
    if not isinstance(old.get("seconds"), int | float) or _holds(new, old) or _is_worth_keeping(path, new, old):
        return ""
    size = "x".join(map(str, old.get("size", ())))
    how = f"{count(old.get('spp', 0.0))} samples a pixel, strategy {old.get('strategy')}, seed {old.get('seed')}"
    stays = _is_edited(new, old) or _ended_early(new, old)
    longer = f", and {_copy_of(path).name}, which stays, more" if stays else ""
    return f"the render that was there is replaced, as it took less than a minute{longer}: {size}, {how}"


def _holds(new: Mapping[str, Any], old: Mapping[str, Any]) -> bool:
    """Tell whether a render has all samples of another one."""
    same = all(new.get(key) == old.get(key) for key in ("digest", "strategy", "without", "crop"))
    return same and _seeds(old) <= _seeds(new) and old.get("spp", 0) <= new.get("spp", 0)


def _seeds(record: Mapping[str, Any]) -> set[Any]:
    return {source.get("seed") for source in record.get("sources", ())} or {record.get("seed")}
