"""Files from which an experiment is made, and the SHA-256 of their contents."""

from __future__ import annotations

import hashlib
import os
import shlex
import shutil
import tomllib
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from equaltime.experiments.model.experiment import Experiment, StrategyEntry
from equaltime.scene import Scene

__all__ = ["PROGRAM_FILES", "made_from", "program_files", "sha256_of", "strategy_files", "sums_of"]

PROGRAM_FILES = "files"
"""Key of an identity's strategy with the SHA-256 of the files of its program."""


def sha256_of(path: Path) -> str:
    """Return the SHA-256, in hexadecimal digits, of a file's content; raises OSError if it cannot be read."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def sums_of(paths: Iterable[Path]) -> dict[str, str]:
    """Return the SHA-256 of each file by its absolute path; files that cannot be read are left out."""
    return {str(path.resolve()): sha256_of(path) for path in paths if _readable(path)}


def program_files(entry: StrategyEntry, folder: Path) -> dict[str, Path]:
    """Return the files of the program that renders an entry's images, by the texts that name them.

    A command names its program, and every file that a word, or a word's part after ``=``, names relative to
    ``folder``. Modules, libraries and files that the program opens by itself are not known. Strategies of equaltime
    and Mitsuba have no such files: the build and the name stand for them.
    """
    if entry.python is not None:
        file = Path(entry.python.rpartition(":")[0])
        return {file.name: file} if _readable(file) else {}
    if entry.peer is None or entry.peer.command is None:
        return {}
    return dict(_named(entry.peer.command, folder))


def _named(command: str, folder: Path) -> Iterator[tuple[str, Path]]:
    try:
        words = [word for word in shlex.split(command) if "{" not in word]
    except ValueError:
        return  # the renderer reports the unbalanced quote
    for word in words:
        for text in (word, word.partition("=")[2]):
            if text and _readable(folder / text):
                yield text, folder / text
    first = next(iter(shlex.split(command)), "")
    if "/" not in first and (program := shutil.which(first)) and _readable(Path(program)):
        yield first, Path(program)


def _readable(path: Path) -> bool:
    return os.access(path, os.R_OK) and path.is_file()  # in this order: a word may be longer than a path can be


def strategy_files(source: Path, strategies: Sequence[str] = ()) -> Iterator[Path]:
    """Yield the file ``source`` and the TOML files of strategies that it, or ``strategies``, names.

    ``source`` is a readable experiment or a scene; ``strategies`` are texts for `Strategy.parse`.
    """
    yield source
    yield from (Path(text) for text in strategies if text.endswith(".toml"))
    listed = tomllib.loads(source.read_text("utf-8-sig")).get("strategies") if source.suffix.lower() == ".toml" else ()
    for entry in listed if isinstance(listed, list) else ():
        text = entry.get("strategy") if isinstance(entry, dict) else entry
        if isinstance(text, str) and text.endswith(".toml"):
            yield source.parent / text


def made_from(experiment: Experiment, scenes: Sequence[Scene], files: Iterable[Path] = ()) -> dict[str, str]:
    """Return the SHA-256 of every known file from which an experiment is made, by its absolute path.

    Those are ``files``, the files of the scenes, the programs of other renderers, and the file of the reference.
    """
    programs = (program_files(entry, experiment.folder).values() for entry in experiment.strategies)
    reference = experiment.reference.file
    own = {*files, *(path for scene in scenes for path in scene.files), *(path for each in programs for path in each)}
    return dict(sorted(sums_of(own | ({reference} if reference is not None else set())).items()))
