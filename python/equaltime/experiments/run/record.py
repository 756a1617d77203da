"""Records: a CSV file with one row for each checkpoint of each run, which survives kill -9 at any moment.

A checkpoint is a moment of a run at which its error is measured.

A row is appended with a single write, and is on the disk before the next checkpoint begins. A kill leaves at worst an
incomplete last line and the rows of an unfinished run. `load` skips the incomplete line. `Recorder` removes the line
and the rows before it appends. A run is therefore in the file once and complete, or can be repeated.
"""

from __future__ import annotations

import csv
import errno
import io
import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields
from itertools import chain
from pathlib import Path
from types import TracebackType
from typing import Annotated, Self

from pydantic import BeforeValidator, Field, PlainSerializer, TypeAdapter, ValidationError
from pydantic_core import ErrorDetails

from equaltime.errors import ExperimentError, Problem
from equaltime.files import to_disk, try_lock
from equaltime.validation import NOUNS, explain

__all__ = ["COLUMNS", "Key", "Recorder", "Row", "check_seeds", "complete", "counts_of", "load"]


def _four(cell: str) -> list[str]:
    if len(numbers := cell.split()) != 4:
        raise ValueError(f"expected 4 whole numbers, found {cell!r}")
    return numbers


def _flag(cell: object) -> bool:
    if cell not in ("0", "1"):
        raise ValueError(f"expected 0 or 1, found {cell!r}")
    return cell == "1"


_EMPTY = BeforeValidator(lambda cell: None if cell == "" else cell)
_MOST = 2**62
"""Largest sizes, counts and seconds: they must fit into 64 bits."""

Natural = Annotated[int, Field(ge=0, le=_MOST)]
Positive = Annotated[int, Field(ge=1, le=_MOST)]
Seconds = Annotated[float, Field(ge=0.0, le=_MOST, allow_inf_nan=False)]
Flag = Annotated[bool, BeforeValidator(_flag), PlainSerializer(int)]
Window = Annotated[tuple[int, int, int, int], BeforeValidator(_four), PlainSerializer(lambda w: " ".join(map(str, w)))]
Count = Annotated[int | None, _EMPTY]
Number = Annotated[float | None, _EMPTY]
Text = Annotated[str | None, _EMPTY]

Key = tuple[str, str, int]
"""Key of a run: name of the scene, label of the strategy, number of the repeat from 0."""


@dataclass(frozen=True, kw_only=True)
class Row:
    """One row of the records: one checkpoint of one run, a moment at which its error is measured.

    Errors are relative (0.02 is 2 %), times are in seconds, and None is an empty cell.
    """

    scene: str
    """The scene's name in the experiment."""
    digest: str
    """SHA-256 of the scene's content, files included."""
    width: Positive
    """Width of the whole film, in pixels."""
    height: Positive
    """Height of the whole film, in pixels."""
    crop: Window
    """Rendered window, in pixels: x, y, width, height."""
    max_depth: int
    strategy: str
    """Label of the strategy in the experiment."""
    name: str
    """Full text of the strategy, as its renderer reads it."""
    renderer: str
    """Renderer of the strategy: ``core``, ``mitsuba`` or ``command``."""
    biased: Flag
    """Whether the strategy declares itself biased."""
    repeat: Natural
    """Number of the repeat, from 0."""
    seed: int
    checkpoint: Natural
    """Number, from 0, of the checkpoint (moment at which the error is measured) in its run."""
    spp: Positive
    """Samples per pixel so far."""
    wall_s: Seconds
    """Wall-clock seconds since the run's first sample, without the time spent on measuring errors."""
    cpu_s: Seconds
    """CPU seconds since the run's first sample, summed over threads, without the time spent on measuring errors."""
    setup_s: Seconds
    """Seconds of loading and building, before the first sample."""
    threads: int
    paths: Count
    """Number of camera paths so far; None from renderers that do not count them."""
    rays: Count
    """Number of rays so far, without shadow rays; None from renderers that do not count them."""
    shadow_rays: Count
    """Number of shadow rays so far; None from renderers that do not count them."""
    relmse: Number
    """Squared relative error with the reference's noise subtracted; a small value may be negative by chance."""
    mse: Number
    """Mean squared difference, with the reference's noise subtracted."""
    mare: Number
    """Mean absolute relative difference; the reference's noise is included."""
    flip: Number
    """FLIP of the run's last image; None in other rows, and for runs under 1 s (first repeat) or 5 s (others).

    FLIP takes a second or more.
    """
    reference_relmse: Number
    """Squared relative error of the reference, which was subtracted from ``relmse``."""
    estimate: Number
    """Relative error that the render itself estimates, as a fraction; None if it estimates none."""
    estimate_low: Number
    """Lower end of the 95 % interval of ``estimate``."""
    estimate_high: Number
    """Upper end of the 95 % interval of ``estimate``."""
    doubt: Text = None
    """Reason, stated by the render, why the upper limit of its error cannot be trusted."""
    decided: Text = None
    """Words of the strategy that the run put in place of what the strategy leaves open, such as
    ``roulette=efficiency,adaptive=none``; None if it leaves nothing open."""
    splitting: Number = None
    """Variance times rays with split paths over the same without, by the run's pilot; None if no pilot measured it."""
    last: Flag
    """Whether this row is the last of its run, which is then complete."""
    image: Text
    """Path of the run's last image, relative to the experiment's folder; None before the last row."""
    machine: str
    """Key of the machine in ``provenance.json``."""
    build: str
    """Key of the build of equaltime in ``provenance.json``."""
    started: str
    """Start of the run: UTC, ISO 8601."""

    @property
    def key(self) -> Key:
        """Scene, strategy label and number of the repeat: the key of the row's run."""
        return self.scene, self.strategy, self.repeat


COLUMNS = tuple(field.name for field in fields(Row))

_ADDED = (("doubt",), ("decided", "splitting"))
"""Columns that files of earlier versions lack, in the order in which they were added. A file keeps its own columns."""

_VERSIONS = tuple(
    tuple(name for name in COLUMNS if name not in chain(*_ADDED[count:])) for count in range(len(_ADDED) + 1)
)

_ROWS = TypeAdapter(Row)
_NOUNS = {**NOUNS, "int_parsing": "a whole number", "float_parsing": "a number"}


def load(path: Path) -> tuple[Row, ...]:
    """Read all rows of a file of records, except an incomplete last line; empty if there is no file.

    A row is one moment of one run at which the error was measured.

    Raises
    ------
    ExperimentError
        With every invalid line, and every moment that occurs twice.
    """
    return _parse(_whole_lines(path), path)


def complete(rows: Iterable[Row]) -> tuple[Row, ...]:
    """Return the rows of finished runs: runs whose last row is among ``rows``."""
    rows = tuple(rows)
    ended = {row.key for row in rows if row.last}
    return tuple(row for row in rows if row.key in ended)


def counts_of(path: Path) -> dict[str, dict[str, tuple[int, ...]]]:
    """Return the samples per pixel at the checkpoints of each strategy on each scene, by scene and label.

    A file of records is read from ``path``. All repeats have the counts of the first one.

    Raises
    ------
    ExperimentError
        If there is no finished run, or the file has invalid lines.
    """
    found: dict[str, dict[str, tuple[int, ...]]] = {}
    for row in complete(load(path)):
        if row.repeat == 0:
            counts = found.setdefault(row.scene, {})
            counts[row.strategy] = (*counts.get(row.strategy, ()), row.spp)
    if not found:
        raise ExperimentError((Problem(str(path), "has no finished run whose counts could be taken"),))
    return found


def check_seeds(rows: Iterable[Row], path: Path) -> None:
    """Raise `ExperimentError` if two repeats of a strategy on a scene have the same seed, and thus the same image.

    ``path`` names the file of the rows in the error.
    """
    seen: dict[tuple[str, str, int], int] = {}
    for row in rows:
        first = seen.setdefault((row.scene, row.strategy, row.seed), row.repeat)
        if first != row.repeat:
            text = f"repeats {first} and {row.repeat} of {row.strategy} on {row.scene} have one seed, and so one image"
            raise ExperimentError((Problem(str(path), f"{text}; use another folder"),))


class Recorder:
    """Writer of an experiment's records, which appends rows to a file and locks the file against other writers.

    Opening removes an incomplete last line and the rows of an unfinished run.

    Raises
    ------
    ExperimentError
        If another process is writing to the file, or the file is damaged.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._file = os.open(path, os.O_RDWR | os.O_CREAT | os.O_APPEND | os.O_CLOEXEC, 0o666)
        try:
            self._rows = list(self._recover())
        except BaseException:
            os.close(self._file)
            raise
        self._keys = {(row.key, row.checkpoint) for row in self._rows}

    @property
    def rows(self) -> tuple[Row, ...]:
        """All rows of the file, in order."""
        return tuple(self._rows)

    def append(self, row: Row) -> None:
        """Write one row; the row is on the disk when the call returns."""
        place = (row.key, row.checkpoint)
        if place in self._keys:
            raise ValueError(f"checkpoint {row.checkpoint} of run {row.key} is recorded already")
        cells = _ROWS.dump_python(row)
        self._write(_line(cells[name] for name in self._columns))
        self._keys.add(place)
        self._rows.append(row)

    def close(self) -> None:
        """Close the file and release its lock."""
        os.close(self._file)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _recover(self) -> tuple[Row, ...]:
        try:
            try_lock(self._file)
        except OSError as error:
            raise ExperimentError((Problem(str(self._path), "another process is writing to it"),)) from error
        content = _whole_lines(self._path)
        everything = _parse(content, self._path)
        rows = complete(everything)
        if rows != everything[: len(rows)]:
            message = "rows of a run that has not ended stand before those of one that has"
            raise ExperimentError((Problem(str(self._path), message),))
        kept = content.split(b"\n")[: 1 + len(rows)] if content else []
        os.ftruncate(self._file, sum(len(line) + 1 for line in kept))
        self._columns = _columns(kept[0].decode()) if kept else COLUMNS
        if not kept:
            self._write(_line(COLUMNS))
            to_disk(self._path.parent)
        return rows

    def _write(self, line: bytes) -> None:
        size = os.fstat(self._file).st_size
        try:
            written = os.write(self._file, line)
        except OSError as error:
            raise OSError(error.errno, error.strerror, str(self._path)) from error
        if written != len(line):  # a full disk accepts only a part of the line
            os.ftruncate(self._file, size)
            raise OSError(errno.ENOSPC, "no space left for a record", str(self._path))
        os.fsync(self._file)


def _whole_lines(path: Path) -> bytes:
    """Return the file up to its last line break; a last line without a break is torn."""
    try:
        content = path.read_bytes()
    except FileNotFoundError:
        return b""
    except OSError as error:
        raise ExperimentError((Problem(str(path), f"cannot be read: {error.strerror or error}"),)) from error
    return content[: content.rfind(b"\n") + 1]


def _parse(content: bytes, path: Path) -> tuple[Row, ...]:
    lines = content.decode("utf-8", "replace").split("\n")[:-1]
    if not lines:
        return ()
    columns = _columns(lines[0])
    if not columns:
        raise ExperimentError((Problem(f"{path}:1", "the columns are not those of equaltime's records"),))
    problems, rows = [], []
    seen: dict[tuple[Key, int], int] = {}
    for number, line in enumerate(lines[1:], start=2):
        try:
            row = _row(_split(line), columns)
        except (KeyError, ValueError, csv.Error) as error:
            problems.append(Problem(f"{path}:{number}", f"no record: {error}"))
            continue
        if before := seen.get((row.key, row.checkpoint)):
            problems.append(Problem(f"{path}:{number}", f"the same checkpoint of the same run as line {before}"))
        seen[row.key, row.checkpoint] = number
        rows.append(row)
    if problems:
        raise ExperimentError(tuple(problems))
    return tuple(rows)


def _split(line: str) -> list[str]:
    return next(csv.reader([line], strict=True), [])


def _columns(line: str) -> tuple[str, ...]:
    """Return the columns that a file's first line names; empty if the file is not a record."""
    try:
        found = tuple(_split(line))
    except csv.Error:
        return ()
    return found if found in _VERSIONS else ()


def _row(cells: Sequence[str], columns: tuple[str, ...]) -> Row:
    if len(cells) != len(columns):
        raise ValueError(f"it has {len(cells)} cells, not {len(columns)}")
    try:
        row = _ROWS.validate_python(dict(zip(columns, cells, strict=True)))
    except ValidationError as error:
        raise ValueError("; ".join(_problem(details) for details in error.errors(include_url=False))) from None
    x, y, width, height = row.crop
    if min(x, y) < 0 or min(width, height) < 1 or x + width > row.width or y + height > row.height:
        raise ValueError(f"crop must lie in the image of {row.width}x{row.height}, found {row.crop}")
    return row


def _problem(details: ErrorDetails) -> str:
    return f"{details['loc'][0]}: {explain(details, nouns=_NOUNS)}"


def _line(cells: Iterable[object]) -> bytes:
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerow(cells)
    line = text.getvalue()
    if line.count("\n") != 1 or "\r" in line:
        raise ValueError("no cell of a record may hold a line break")
    return line.encode()
