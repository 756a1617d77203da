"""All runs of one strategy on one scene: records and images, joined into the data from which intervals follow."""

from __future__ import annotations

import math
import re
from collections import defaultdict
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from equaltime.errors import StrategyError
from equaltime.experiments.run.record import Row, read_array
from equaltime.images.bias_variance import BiasVariance, relmse_of_parts
from equaltime.images.metrics import Reference, squared_errors, tail_of
from equaltime.statistics.curves import Runs
from equaltime.statistics.intervals import FEWEST_REPEATS
from equaltime.strategy import Strategy

__all__ = ["StrategyRuns", "runs_of"]

Floats = NDArray[np.float64]

_MOST_BYTES = 5e8
"""Most bytes of final images (float64) in memory at once; further repeats' images are left out."""
_MOST_BIAS = 0.1
"""If bias² exceeds this share of an unbiased strategy's squared error, its runs have missed light.

Its later error is then not predictable."""


@dataclass(frozen=True, eq=False)
class StrategyRuns:
    """The records (rows) of one strategy on one scene, and the times and errors of its runs, taken from the records."""

    label: str
    rows: tuple[Row, ...]
    folder: Path
    spp: tuple[int, ...]
    """Sample counts of the checkpoints that all repeats have."""
    runs: Runs
    parts: BiasVariance | None = None
    """Bias and variance of the final images; None without images or without a reference of their size."""
    heavy: bool = False
    """Whether few pixels of few repeats make most of the squared error: a heavy tail (see `tails`)."""

    @classmethod
    def of(cls, label: str, rows: Sequence[Row], folder: Path, reference: Reference | None) -> StrategyRuns:
        """Join the records of a strategy, and check its final images for heavy tails and for missed light.

        The tail is heavy if few pixels of few repeats make most of the error. Images are read from ``folder``. Without
        images or without a reference of their size, the checks are left out.
        """
        spp, runs = runs_of(rows)
        plain = cls(label, tuple(rows), folder, spp, runs)
        images = plain.images() if spp else None
        if images is None or reference is None or reference.mean.shape != images.shape[1:]:
            return plain
        parts, tail = relmse_of_parts(images, reference), tail_of(squared_errors(images, reference))
        missing = "" if runs.biased else _missing(parts, float(runs.relmse[:, -1].mean()))
        judged = replace(runs, doubt=tail.doubt, missing=missing, unseen=tail.unseen, shared=parts.shared)
        return replace(plain, runs=judged, parts=parts, heavy=bool(tail.doubt))

    @property
    def last(self) -> tuple[Row, ...]:
        """The last row of each repeat's records, in the order of repeats."""
        return tuple(sorted((row for row in self.rows if row.last), key=lambda row: row.repeat))

    def apart_from(self, other: StrategyRuns) -> bool:
        """Tell whether all runs of one of the two strategies began before all runs of the other.

        True means that one of the strategies was added to the experiment later.
        """
        own, others = ([row.started for row in runs.last] for runs in (self, other))
        return bool(own and others) and (max(own) < min(others) or max(others) < min(own))

    def images(self) -> Floats | None:
        """Return the final images of the first K repeats as one array (K, H, W, 3); memory limits K.

        Returns None if one of these images is missing or not finite.

        Raises
        ------
        ImageError
            If an image file is damaged.
        """
        width, height = self.rows[0].crop[2:]
        most = max(int(_MOST_BYTES / (24 * width * height)), FEWEST_REPEATS)
        last = self.last[:most]
        if not all(row.image and math.isfinite(row.mse or 0.0) for row in last):
            return None
        try:
            images = [read_array(self.folder / (row.image or ""), (height, width, 3)) for row in last]
        except FileNotFoundError:
            return None
        return np.stack(images).astype(np.float64)


def runs_of(rows: Sequence[Row]) -> tuple[tuple[int, ...], Runs]:
    """Return the sample counts that every repeat of a strategy has, and the times and errors at these counts."""
    table: dict[int, dict[int, Row]] = defaultdict(dict)
    for row in rows:
        table[row.repeat][row.spp] = row
    common = sorted(set.intersection(*(set(run) for run in table.values())))
    chosen = [[table[repeat][spp] for spp in common] for repeat in sorted(table)]
    seconds = np.array([[row.wall_s for row in run] for run in chosen])
    relmse = np.array([[math.nan if row.relmse is None else row.relmse for row in run] for run in chosen])
    return tuple(common), Runs(seconds, relmse, _independent(rows[0]), rows[0].biased)


def _independent(row: Row) -> bool:
    """Tell whether samples are known to be independent; for a command this is unknown."""
    if row.renderer == "core":
        with suppress(StrategyError):  # a user's own subject may have any name
            return Strategy.parse(row.name).sampler == "independent"
    return row.renderer == "mitsuba" and re.search(r"\bindependent\b", row.name) is not None


def _missing(parts: BiasVariance, relmse: float) -> str:
    """Return a warning if an unbiased strategy's images share an offset from the reference, else an empty text.

    The spread over repeats does not show a common offset.
    """
    if not parts.bias2.low > _MOST_BIAS * abs(relmse):
        return ""
    return "its images are off the reference together: they or it have not found all light, or the strategy is biased"
