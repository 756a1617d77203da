"""Renders that were saved: taken up where they stopped, for the bits of a render that was never stopped."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from equaltime import images
from equaltime.budget import Look
from equaltime.errors import ImageError
from equaltime.parts_of_merge import MergedFilm
from equaltime.provenance import checked, differences
from equaltime.stopping import Stop

__all__ = ["Checkpoint"]


@dataclass(frozen=True, eq=False)
class Checkpoint:
    """A saved render with its moments."""

    path: Path
    record: Mapping[str, Any]
    """The provenance, as `Result.record` has it, checked."""
    moments: NDArray[Any]
    """(R, H, W), as `equaltime.moments` describes them."""
    missed: Mapping[str, NDArray[np.float32]] = field(default_factory=dict)
    """What samples may have missed, as `Result.missed` has it."""
    parts: NDArray[Any] | None = None
    """(H, W): sums over what was merged (`equaltime.parts_of_merge`); None if nothing was, or by equaltime 0.1.0."""

    @classmethod
    def read(cls, path: str | os.PathLike[str]) -> Checkpoint:
        """Read a file that `Result.save` wrote; raises `ImageError` if it is none, damaged, or without moments."""
        record = images.read(path).record
        if not record:
            raise ImageError(f"{path}: was not rendered by equaltime")
        moments = images.read_moments(path)
        if moments is None:
            raise ImageError(f"{path}: holds no moments, only an image")
        record = checked(record, path)
        _, _, width, height = record["crop"]
        missed, parts = images.read_missed(path), images.read_parts(path)
        planes = (*missed.values(), *(() if parts is None else (parts,)))
        sizes = {(height, width), *(plane.shape[:2] for plane in planes)}
        if sizes != {moments.shape[1:]} or record["replicates"] != len(moments):
            raise ImageError(f"{path}: its parts are not of one size")
        if parts is not None and not MergedFilm(moments, parts).consistent:
            raise ImageError(f"{path}: the sums over what was merged do not belong to its samples")
        return cls(Path(path), record, moments, missed, parts)

    @property
    def film(self) -> MergedFilm:
        """Its samples for merging. Without sums over parts it is one part."""
        return MergedFilm.of(self.moments) if self.parts is None else MergedFilm(self.moments, self.parts)

    @property
    def seconds(self) -> float:
        """Rendering time that went into it."""
        return float(self.record["seconds"])

    @property
    def looks(self) -> tuple[Look, ...]:
        """What it saw when it looked at its error."""
        return tuple(
            Look(samples, math.nan if value is None else value, math.inf if high is None else high, brightest or 0.0)
            for samples, value, high, brightest in self.record["looks"]
        )

    @property
    def stop(self) -> Stop | None:
        """The rule by which it was to stop at an error, if it was asked for one."""
        return None if self.record["stop"] is None else Stop.from_dict(self.record["stop"])

    @property
    def position(self) -> tuple[int, int, int]:
        """Where its passes stood, as `Result.position` says; raises `ImageError` if it does not tell."""
        if self.record["position"] is None:
            raise ImageError(f"{self.path}: cannot be taken up: it does not tell where its passes stood")
        done, target, next_block = self.record["position"]
        return done, target, next_block

    def check(self, wanted: Mapping[str, Any]) -> None:
        """Raise `ImageError` if this is a part of another render, with what differs.

        ``wanted`` holds what its record should have.
        """
        if self.record["sources"]:
            raise ImageError(
                f"{self.path}: cannot be taken up: it was merged; render with another seed, and merge again"
            )
        if different := differences(self.record, wanted, ("seed", "substitutions", "build")):
            raise ImageError(f"{self.path}: cannot be taken up: it has {'; '.join(different)}")
