"""Output of ``equaltime cost`` other than tables: JSON data, and the message after an interruption."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from equaltime.errors import ExperimentError
from equaltime.experiments.run.folder import ExperimentFolder
from equaltime.experiments.run.record import load
from equaltime.statistics.intervals import Interval

__all__ = ["as_data", "recorded"]


def recorded(folder: Path) -> str:
    """Return a sentence on how many finished runs the records of a folder and its subfolders hold."""
    runs = _runs(folder)
    if runs == 0:
        return "no run was finished"
    return f"{runs} {'run is' if runs == 1 else 'runs are'} recorded in {folder}; the same command goes on from there"


def _runs(folder: Path) -> int:
    """Count the recorded runs of a folder and of its subfolders."""
    try:
        records = [ExperimentFolder(folder).records, *folder.glob("*/records.csv")]
        return sum(row.last for path in records for row in load(path))
    except ExperimentError:
        return 0


def as_data(value: object) -> Any:
    """Return a value, such as a `Summary`, as JSON data; numbers that are not finite become None."""
    if isinstance(value, Interval):
        return value.as_dict()
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {field.name: as_data(getattr(value, field.name)) for field in dataclasses.fields(value)}
    if isinstance(value, BaseModel):
        return value.model_dump(mode="json")
    if isinstance(value, Mapping):
        return {f"{key:g}" if isinstance(key, float) else str(key): as_data(entry) for key, entry in value.items()}
    if isinstance(value, tuple | list):
        return [as_data(entry) for entry in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value if isinstance(value, str | int | bool | None) else str(value)
