"""The folder of an experiment: its files, and the check whether an experiment may be continued in it.

::

    records.csv      one row for each checkpoint of each run (`record`)
    experiment.json  the experiment of the last call, its identity, which a continuation must match, and the SHA-256 of
                     the files from which the call made it
    experiment.lock  empty; locked by the process that runs the experiment
    provenance.json  machines and builds by their keys in the records; references; agreements; sessions;
                     own_depths; strategies in full; workers of a cluster, with the runs that each took
    references/      SCENE.npz (`reference`); SCENE--PEER.npz for a peer with another expected image
    images/          SCENE/STRATEGY-r0.npy: the last image of each run, float32 (H, W, 3); STRATEGY-r0-samples.npy:
                     sample counts (H, W) if they differ between pixels; STRATEGY-r0-variance.npy: variance of one
                     sample of each pixel (H, W), float32, if the renderer reports it; on request
                     SCENE/STRATEGY-film.npz (`forming`) and directions.npz (`directions`)
    failure.txt      traceback of an unexpected error, if one ended this experiment in a run of many experiments
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import shlex
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from equaltime import files as disk
from equaltime.errors import ExperimentError, ImageError, Problem
from equaltime.experiments.model.experiment import Experiment
from equaltime.experiments.model.problems import file_name
from equaltime.experiments.model.recorded import to_record
from equaltime.experiments.model.sources import PROGRAM_FILES
from equaltime.experiments.run.record import Key, load
from equaltime.files import try_lock
from equaltime.machine import machine_facts
from equaltime.rendering.core import build_facts
from equaltime.strict_json import json_text

__all__ = [
    "IN_FULL",
    "OWN_DEPTHS",
    "WORKERS",
    "ExperimentFolder",
    "build_facts",
    "fingerprint",
    "machine_facts",
    "read_array",
    "read_arrays",
    "replacing",
]

_OURS = ("records.csv", "experiment.json", "provenance.json", "references", "images", "figures", "report.html")
_GROWING = ("scenes", "strategies")
"""Sections of an identity to which named entries may be added later."""
_DAMAGED = "is damaged; put a copy of the file there, or use another folder"
_TYPES: Mapping[str, type[int] | type[float] | type[str] | type[list[Any]]] = {
    "max_depth": int,
    "caveat": str,
    "note": str,
    "call": str,
    "words": str,
    "host": str,
    "ran": list,
    "agrees": bool,
    "p": float,
}
"""Types of optional facts that readers of the provenance rely on."""
_RESTORE = "put a copy of the file there, or remove it to go on without it"
OWN_DEPTHS = "own_depths"
"""Section of the provenance (origin of the records) with the ``max_depth`` of each scene's file, before the
experiment's changes.
"""
IN_FULL = "strategies"
"""Section of the provenance with all words of each strategy of equaltime's own, by label: presets may change later."""
WORKERS = "workers"
"""Section of the provenance with the workers of a cluster by address: ``host``, and in ``ran`` the runs of each."""


@dataclass(frozen=True)
class ExperimentFolder:
    """The folder of an experiment: paths of its files, and methods that lock, read and write them."""

    path: Path

    @property
    def records(self) -> Path:
        """Path of the CSV file with the records."""
        return self.path / "records.csv"

    @property
    def experiment(self) -> Path:
        """Path of the JSON file with the experiment and its identity (all settings that affect records)."""
        return self.path / "experiment.json"

    @property
    def provenance(self) -> Path:
        """Path of the file with the origin of the records: machines, builds, references, sessions."""
        return self.path / "provenance.json"

    def reference(self, scene: str, strategy: str | None = None) -> Path:
        """Return the path of a scene's reference (precise image), or of the separate reference of ``strategy``."""
        name = file_name(scene) if strategy is None else f"{file_name(scene)}--{file_name(strategy)}"
        return self.path / "references" / f"{name}.npz"

    def image(self, scene: str, strategy: str, repeat: int) -> Path:
        """Return the path of the last image of the run number ``repeat``: an ``.npy`` file, float32 (H, W, 3)."""
        return self.path / "images" / file_name(scene) / f"{file_name(strategy)}-r{repeat}.npy"

    def samples(self, scene: str, strategy: str, repeat: int) -> Path:
        """Return the path of the sample counts of a run's last image: an ``.npy`` file, (H, W).

        The file exists only if counts differ between pixels.
        """
        image = self.image(scene, strategy, repeat)
        return image.with_name(f"{image.stem}-samples.npy")

    def variance(self, scene: str, strategy: str, repeat: int) -> Path:
        """Return the path of the variance of one sample of each pixel in a run: an ``.npy`` file, float32 (H, W).

        The file exists only if the renderer reports variances.
        """
        image = self.image(scene, strategy, repeat)
        return image.with_name(f"{image.stem}-variance.npy")

    def film(self, scene: str, strategy: str) -> Path:
        """Return the path of the film, an ``.npz`` file, that shows how a strategy's image of a scene converges."""
        return self.path / "images" / file_name(scene) / f"{file_name(strategy)}-film.npz"

    @property
    def directions(self) -> Path:
        """Path of the file with ray directions drawn by uniform and by BSDF sampling."""
        return self.path / "images" / "directions.npz"

    @property
    def failure(self) -> Path:
        """Path of the file with the traceback of an unexpected error that ended the experiment."""
        return self.path / "failure.txt"

    @contextmanager
    def locked(self) -> Iterator[None]:
        """Make the folder, and lock it during the context: only one process at a time may run an experiment in it.

        Raises
        ------
        ExperimentError
            If another process holds the lock, or the folder has files that could be mistaken for an experiment's.
        """
        try:
            disk.make_folder(self.path)
            self._refuse_foreign()
            lock = os.open(self.path / "experiment.lock", os.O_RDWR | os.O_CREAT, 0o666)
        except OSError as error:
            raise _refused(self.path, error.strerror or str(error)) from error
        try:
            self._lock(lock)
            yield
        finally:
            os.close(lock)

    def _lock(self, descriptor: int) -> None:
        try:
            try_lock(descriptor)
        except BlockingIOError as error:
            why = "another process runs its experiment; wait until that ends, or use another folder"
            raise _refused(self.path, why) from error
        except OSError as error:  # for example a network folder without locks
            raise _refused(self.path, f"cannot be locked: {error.strerror or error}; use another folder") from error

    def claim(
        self, identity: Mapping[str, Any], experiment: Experiment, files: Mapping[str, str] = MappingProxyType({})
    ) -> None:
        """Write the ``identity`` of an experiment to the folder, or check that it matches the identity written before.

        The identity is every setting that affects records. The folder must be locked. Scenes and strategies may be
        added or dropped; their records stay in the folder. The experiment is written anew at each call, with
        its present title, description and targets, but without the content of scenes that no file holds: their digests
        are a part of the identity. A scene or strategy with a recorded name must be
        unchanged, and so must all other settings. A folder without a finished run takes any experiment.

        Parameters
        ----------
        files
            SHA-256 of the files from which the experiment is made, by absolute path (`sources.made_from`).

        Raises
        ------
        ExperimentError
            If the folder holds another experiment; lists the differences.
        """
        try:
            before = self.read_experiment() if self.experiment.exists() else None
            now = json.loads(json_text(identity))
            if before is not None and any(row.last for row in load(self.records)):
                known = before["identity"]
                joined = _joined(known, now)
                self._compare(known, joined)
                now = joined
            elif before is not None and before["identity"] != now:
                self._forget(before["identity"])
            after = {"identity": now, "experiment": to_record(experiment), "files": dict(files)}
            if after != before:
                self._write(self.experiment, after)
        except OSError as error:
            raise _refused(self.path, error.strerror or str(error)) from error

    def _forget(self, known: Mapping[str, Any]) -> None:
        """Remove what an experiment left behind that has another identity and no finished run.

        References would stand for other scenes, and tests of agreement for other renderers. References that equaltime
        rendered stay in the cache.
        """
        for scene in known["scenes"]:
            for strategy in (None, *known["strategies"]):
                self.reference(scene, strategy).unlink(missing_ok=True)
        for path in (self.provenance, self.records, self.directions):
            path.unlink(missing_ok=True)

    def read_experiment(self) -> dict[str, Any]:
        """Return the contents of the experiment's JSON file: the tables ``identity`` and ``experiment``.

        The identity is every setting that affects records, in tables of scenes and of strategies. Raises
        ExperimentError if the file is missing or damaged.
        """
        content = _read_json(self.experiment)
        known = content.get("identity")
        if not isinstance(known, dict) or not all(isinstance(known.get(key), dict) for key in _GROWING):
            raise ExperimentError((Problem(f"{self.experiment}: identity", _DAMAGED),))
        return content

    def _refuse_foreign(self) -> None:
        found = [name for name in _OURS if (self.path / name).exists()]
        if found and not self.experiment.exists():
            why = f"has {', '.join(found)}, but not of an experiment that could be continued; use another folder"
            raise _refused(self.path, why)

    def note(self, section: str, key: str, facts: Mapping[str, Any]) -> None:
        """Write facts to the provenance file (origin of the records) under a section and a key.

        Earlier facts under that key are replaced. The folder must be locked.
        """
        provenance = self.read_provenance()
        provenance.setdefault(section, {})[key] = dict(facts)
        self._write(self.provenance, provenance)

    def note_worker(self, address: str, host: str, key: Key) -> None:
        """Write to the provenance file that the worker at an address took a run; the folder must be locked."""
        facts = self.read_provenance().get(WORKERS, {}).get(address, {})
        self.note(WORKERS, address, {"host": host, "ran": [*facts.get("ran", ()), key]})

    def read_provenance(self) -> dict[str, Any]:
        """Return the origin of the records, from the provenance file: facts by section and key; empty without a file.

        Raises ExperimentError if the file is damaged.
        """
        if not self.provenance.exists():
            return {}
        found = _read_json(self.provenance)
        if (wrong := next(_misshapen(found), None)) is not None:
            raise ExperimentError((Problem(f"{self.provenance}: {wrong}", _DAMAGED),))
        return found

    def tidy(self) -> None:
        """Remove temporary files that a killed process left behind."""
        for folder in (self.path, self.path / "references", self.path / "figures", *self.path.glob("images/*")):
            disk.tidy(folder)

    def _compare(self, there: object, joined: Mapping[str, Any]) -> None:
        before, now = dict(_flat(there)), dict(_flat(joined))
        added = tuple(
            f"{section}.{name}."
            for section in _GROWING
            for name in joined.get(section, {})
            if not isinstance(there, dict) or name not in there.get(section, {})
        )
        added += tuple(f"strategies.{name}.{PROGRAM_FILES}." for name in _without_files(there))
        differing = [key for key in {**before, **now} if before.get(key) != now.get(key) and not key.startswith(added)]
        if differing:
            texts = (_difference(key, before.get(key), now.get(key)) for key in differing)
            place = f"{self.path}: has records of another experiment"
            problems = tuple(Problem(place, text) for text in texts)
            raise ExperimentError((*problems, Problem(str(self.path), self._way_back())))

    def _way_back(self) -> str:
        """Return a sentence with the commands that show what the folder measured and go on with it."""
        folder, file = (shlex.quote(str(path)) for path in (self.path, self.experiment))
        return (
            f"the changed experiment needs another folder; `equaltime info {folder}` shows what was measured here, and "
            f"`equaltime cost {file} -o {folder}` goes on with the experiment as it was, with scenes and programs as "
            "they are now"
        )

    def _write(self, path: Path, content: Mapping[str, Any]) -> None:
        with replacing(path) as file:
            file.write(json_text(content, indent=2, ensure_ascii=False, default=str).encode())


@contextmanager
def replacing(path: Path) -> Iterator[IO[bytes]]:
    """Yield a temporary file to write; after the context, the temporary file replaces ``path`` atomically.

    After the context, the new contents are on the disk, even if the machine fails. After an error in the context,
    ``path`` is unchanged.
    """
    disk.make_folder(path.parent)
    with disk.replacing(path) as temporary, temporary.open("wb") as file:
        yield file


def read_array(path: Path, shape: tuple[int, ...], *, infinite: bool = False) -> NDArray[Any]:
    """Return the array of an ``.npy`` file, which must have this ``shape``.

    With ``infinite``, numbers may be positive infinity.

    Raises
    ------
    FileNotFoundError
        If the file is missing.
    ImageError
        If the file is damaged, or its array has another shape or a number that it may not have.
    """
    try:
        # memory-mapped, so that a damaged header cannot allocate more memory than the file's size
        found = np.load(path, mmap_mode="r", allow_pickle=False)
    except FileNotFoundError:
        raise
    except Exception as error:  # the type of NumPy's error depends on the damage
        raise ImageError(f"{path}: is damaged: {error}; {_RESTORE}") from error
    if not isinstance(found, np.ndarray) or found.dtype.kind not in "fiu":
        raise ImageError(f"{path}: is damaged: it holds no array of numbers; {_RESTORE}")
    if found.shape != shape:
        raise ImageError(f"{path}: is damaged: it has shape {found.shape}, not {shape}; {_RESTORE}")
    if not (np.isfinite(found) | (infinite & np.isposinf(found))).all():
        raise ImageError(f"{path}: is damaged: it has numbers that are not finite; {_RESTORE}")
    return np.array(found)


def read_arrays(path: Path, names: Sequence[str]) -> tuple[NDArray[Any], ...]:
    """Read the arrays with these names from an ``.npz`` file, and return the arrays in the order of ``names``.

    Raises `ImageError` if the file is missing or damaged, or an array is missing.
    """
    try:
        with np.load(path, allow_pickle=False) as file:
            return tuple(file[name] for name in names)
    except Exception as error:  # zip, zlib and NumPy raise different errors for a damaged file
        raise ImageError(f"{path}: is damaged: {error}; {_RESTORE}") from error


def _refused(folder: Path, why: str) -> ExperimentError:
    return ExperimentError((Problem(str(folder), why),))


def fingerprint(facts: Mapping[str, Any]) -> str:
    """Return a hash of the facts, 12 hexadecimal digits, which is the key of a machine or build in the records."""
    return hashlib.sha256(json_text(facts, sort_keys=True, default=str).encode()).hexdigest()[:12]


def _joined(there: Mapping[str, Any], now: Mapping[str, Any]) -> dict[str, Any]:
    """Return the present identity, with earlier scenes and strategies that are no longer asked for added.

    A program's files are those that were there at first: the program may write others that its command names.
    """
    joined = {**now, **{section: {**there.get(section, {}), **now.get(section, {})} for section in _GROWING}}
    for label, facts in joined["strategies"].items():
        first = there["strategies"].get(label, {}).get(PROGRAM_FILES)
        if first is not None and (sums := facts.get(PROGRAM_FILES)):
            kept = {name: sums[name] for name in first if name in sums}
            joined["strategies"][label] = {**facts, PROGRAM_FILES: kept}
    return joined


def _without_files(identity: object) -> Iterator[str]:
    """Yield the strategies of a stored identity that an earlier version wrote, without files of programs."""
    strategies = identity.get("strategies") if isinstance(identity, dict) else None
    for label, facts in strategies.items() if isinstance(strategies, dict) else ():
        if not isinstance(facts, dict) or PROGRAM_FILES not in facts:
            yield label


def _difference(key: str, before: object, now: object) -> str:
    """Return a sentence on a value of an identity that differs."""
    what = f"{key} is {json_text(before)} there, and {json_text(now)} now"
    if program := re.fullmatch(rf"strategies\.(.+)\.{PROGRAM_FILES}\.(.+)", key):
        label, file = program.groups()
        what = f"{file}, a file of the program of {label}, {'has changed' if now else 'is gone'} since its runs"
    return what


def _read_json(path: Path) -> dict[str, Any]:
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise ExperimentError((Problem(str(path), f"cannot be read: {error}"),)) from error
    if not isinstance(content, dict):
        raise ExperimentError((Problem(str(path), _DAMAGED),))
    return content


def _misshapen(provenance: Mapping[str, Any]) -> Iterator[str]:
    """Yield the paths of invalid entries: sections must be tables of tables, and some facts have a fixed type."""
    for section, entries in provenance.items():
        for key, facts in entries.items() if isinstance(entries, dict) else [("", None)]:
            place = f"{section}.{key}".rstrip(".")
            if not isinstance(facts, dict):
                yield place
            elif section == "agreements":
                yield from (f"{place}.{label}" for label, told in facts.items() if not _has_types(told))
            elif not _has_types(facts):
                yield place


def _has_types(facts: object) -> bool:
    """Tell whether this is a table whose facts have the types in `_TYPES`."""
    return isinstance(facts, dict) and all(isinstance(facts.get(name), kind | None) for name, kind in _TYPES.items())


def _flat(value: object, path: str = "") -> Iterator[tuple[str, object]]:
    """Yield the leaves of JSON data, each with its path of keys."""
    if isinstance(value, dict) and value:
        for key, entry in value.items():
            yield from _flat(entry, f"{path}.{key}" if path else key)
    elif isinstance(value, list) and value:
        for number, entry in enumerate(value):
            yield from _flat(entry, f"{path}[{number}]")
    else:
        yield path, value
