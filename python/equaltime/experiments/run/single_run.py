"""One run of one strategy on one scene: choice of sample counts, rendering, measuring of errors, and recording.

`SingleRun.checkpoints` renders and measures, in any process. `record` writes to the folder, in the process that holds
the folder's lock.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from typing import Any

import numpy as np

from equaltime.errors import ExperimentError, Problem, RenderError
from equaltime.experiments.run.folder import ExperimentFolder, replacing
from equaltime.experiments.run.record import Key, Recorder, Row
from equaltime.images.flip import flip
from equaltime.images.metrics import Reference, measure
from equaltime.rendering.core_subject import Point, Subject
from equaltime.scene import Scene

__all__ = ["BudgetLadder", "RunOrder", "SingleRun", "counts", "now", "record"]

# The rest of a budget is spent on one more checkpoint if it has at least this many times the last one's samples: from
# 5 % on, errors at the budget count as extrapolated. Another renderer begins anew, so that it takes as long as a run.
_LEAST_STEP = {"grown": 1.05, "anew": 1.1}
# Least ratio of the last count to the one before, where the ladder has a choice: errors of nearly equal counts tell
# little more than one of them.
_APART = 1.1
# Runs aim at so many times their budget, since later repeats may be faster than the first, which fixes the counts.
_AIM = 1.02
# Largest time of a run, in budgets, at which the last count is rounded up to an even number.
_MOST = 1.05
# Least time of a further sample, as a share of a sample's mean time: times vary, and a rate of 0 would miss the budget.
_LEAST_RATE = 0.25


def counts() -> Iterator[int]:
    """Yield the samples per pixel at which errors are measured, without end: 2, 4, 6, 8, 12, 16, 24, 32, 48, and so on.

    The counts are powers of two and, from 4 on, also 1.5 times each power.
    """
    yield 2
    power = 4
    while True:
        yield power
        yield power + power // 2
        power *= 2


_MOST_SAMPLES = 2**31
"""Samples per pixel at which a run ends before its budget is spent: a renderer that takes the same time for any number
of samples would never spend it."""


class BudgetLadder:
    """Iterator over the sample counts per pixel of a run that ends near its time budget.

    Call `taken` after each count: the last count is chosen from the time of the count before. All strategies then end
    at nearly the same time, slightly above the budget if even counts allow it, which makes their last images
    comparable. Counts are even, because a render's own error estimate comes from two halves.

    If ``anew``, every count is a render of its own. Counts then double, so that all renders before the last one take
    hardly longer than the last. The time beside samples (start, reading the scene) is told apart from two counts.
    """

    def __init__(self, seconds: float, anew: bool = False) -> None:
        self._seconds = seconds
        self._growth = 2 if anew else 1
        self._rate = 0.0
        """Seconds of a sample per pixel, beyond the start of a render."""
        self._counts = counts()
        self._spp = 0
        self._wall = 0.0
        self._ended = False

    def taken(self, spp: int, wall_s: float) -> None:
        """Record that ``spp`` samples per pixel took ``wall_s`` seconds, from which the next count is chosen."""
        self._rate = wall_s / spp
        if self._growth > 1:  # part of the time may be a start; how much, the second count tells
            found = (wall_s - self._wall) / (spp - self._spp) if spp > self._spp > 0 else 0.0
            self._rate = max(found, _LEAST_RATE * self._rate)
        self._spp, self._wall = spp, wall_s

    def __iter__(self) -> Iterator[int]:
        return self

    def __next__(self) -> int:
        if self._ended or self._wall >= self._seconds:
            raise StopIteration
        spp = next(count for count in self._counts if count > self._spp and count >= self._growth * self._spp)
        if spp > _MOST_SAMPLES:
            raise StopIteration
        last = self._last()
        if self._spp == 0 or last is None or _APART * spp <= last:
            return spp
        self._ended = True
        if last < _LEAST_STEP["anew" if self._growth > 1 else "grown"] * self._spp:
            raise StopIteration
        return last

    def _last(self) -> int | None:
        """Return the even count that ends at the budget, slightly above if possible; None if samples take no time."""
        if self._rate <= 0.0:
            return None
        last = int(self._spp + (_AIM * self._seconds - self._wall) / self._rate) // 2 * 2
        more = self._wall + self._rate * (last + 2 - self._spp)
        return last + 2 if more <= _MOST * self._seconds else last


# FLIP takes a second or more for a small image.
_FLIP_AFTER_SECONDS = {"first": 1.0, "other": 5.0}


def now() -> str:
    """Return the present time in UTC as ISO 8601 text, to the microsecond."""
    return datetime.now(UTC).isoformat().replace("+00:00", "Z")


@dataclass(frozen=True)
class RunOrder:
    """Inputs of one run beside scene, reference and renderer; another process can read them from a pickle."""

    key: Key
    seed: int
    ladder: tuple[int, ...] | float
    """Sample counts per pixel, or the budget of the run in seconds."""
    expected: tuple[int, ...] | None
    """Samples per pixel at which the first repeat was measured, which this run must match; None for the first repeat.
    """
    threads: int
    machine: str
    build: str
    """Keys of machine and build, for the records."""


@dataclass(frozen=True, eq=False)
class SingleRun:
    """One run of a strategy on a scene that is still to be rendered, with everything that it needs."""

    order: RunOrder
    scene: Scene
    subject: Subject
    known: Reference

    def checkpoints(self) -> Iterator[tuple[Row, Point]]:
        """Render the run, and yield a row of the records with the state of the image, for each sample count.

        A row must tell whether it is the run's last one. So it is held back until the next sample count is reached, or
        the run ends. The caller saves the last image, and adds its name to the last row.

        Raises
        ------
        ExperimentError
            If the sample counts differ from the first repeat's: repeats are compared at equal counts.
        """
        ladder = self.order.ladder
        setup = self.subject.prepare(self.scene, self.order.threads)
        common = {**self._common(), "setup_s": setup, "started": now(), "image": None}
        seconds = ladder if isinstance(ladder, float) else None
        anew = self.subject.renderer != "core"
        counts = BudgetLadder(ladder, anew) if isinstance(ladder, float) else ladder
        pending: Point | None = None
        number, taken = 0, list[int]()
        for checkpoint in self.subject.run(self.order.seed, counts, seconds):
            if isinstance(counts, BudgetLadder):
                counts.taken(checkpoint.spp, checkpoint.wall_s)
            taken.append(checkpoint.spp)
            self._check_counts(taken, ended=False)
            if pending is not None:
                yield Row(**common, **self._measured(pending), checkpoint=number, last=False), pending
                number += 1
            pending = checkpoint
        if pending is None:
            raise RenderError(f"{self.subject.label}: gave no image")
        self._check_counts(taken, ended=True)
        measured = {**self._measured(pending), "flip": self._flip(pending)}
        yield Row(**common, **measured, checkpoint=number, last=True), pending

    def _check_counts(self, taken: Sequence[int], ended: bool) -> None:
        """Raise `ExperimentError` if the sample counts differ from the first repeat's, or if some are missing."""
        if self.order.expected is None or (*taken,) == self.order.expected[: None if ended else len(taken)]:
            return
        scene, label, repeat = self.order.key
        found, wanted = (", ".join(map(str, counts)) for counts in (taken, self.order.expected))
        raise ExperimentError(
            (
                Problem(
                    f"{scene}: {label}",
                    f"repeat {repeat} has {found} samples a pixel, and the first repeat had {wanted}; repeats are "
                    "compared at equal counts, so let the renderer take or round the counts of a run alike each time",
                ),
            )
        )

    def _common(self) -> dict[str, Any]:
        """Return the values that all rows of the run share."""
        width, height = self.scene.size
        return {
            "scene": self.order.key[0],
            "digest": self.scene.digest,
            "width": width,
            "height": height,
            "crop": self.scene.model.sensor.film.crop,
            "max_depth": self.scene.max_depth,
            "strategy": self.subject.label,
            "name": self.subject.name,
            "renderer": self.subject.renderer,
            "biased": self.subject.biased,
            "repeat": self.order.key[2],
            "seed": self.order.seed,
            "threads": self.order.threads,
            "machine": self.order.machine,
            "build": self.order.build,
            "reference_relmse": self.known.relmse,
        }

    def _measured(self, checkpoint: Point) -> dict[str, Any]:
        """Return a row's values for one checkpoint."""
        values = measure(checkpoint.image, self.known, ("relmse", "mse", "mare"))
        estimate = checkpoint.estimate
        return {
            "spp": checkpoint.spp,
            "wall_s": checkpoint.wall_s,
            "cpu_s": checkpoint.cpu_s,
            "paths": checkpoint.paths,
            "rays": checkpoint.rays,
            "shadow_rays": checkpoint.shadow_rays,
            **{metric: measured.value for metric, measured in values.items()},
            "flip": None,
            "estimate": None if estimate is None else estimate.value,
            "estimate_low": None if estimate is None else estimate.low,
            "estimate_high": None if estimate is None else estimate.high,
            "doubt": None if estimate is None else estimate.doubt or None,
            "decided": checkpoint.decision.words or None,
            "splitting": checkpoint.decision.splitting,
        }

    def _flip(self, checkpoint: Point) -> float | None:
        """Return FLIP; None for a run that is short compared with the time of FLIP."""
        if checkpoint.wall_s < _FLIP_AFTER_SECONDS["first" if self.order.key[2] == 0 else "other"]:
            return None
        return flip(checkpoint.image, self.known.mean)


def record(checkpoints: Iterable[tuple[Row, Point]], folder: ExperimentFolder, recorder: Recorder) -> float:
    """Append the rows of one run to the records as they come, and return the seconds of rendering.

    The image of the last checkpoint is written before its row.
    """
    seconds = 0.0
    for row, checkpoint in checkpoints:
        recorder.append(replace(row, image=_keep(folder, row.key, checkpoint)) if row.last else row)
        seconds = row.wall_s
    return seconds


def _keep(folder: ExperimentFolder, key: Key, checkpoint: Point) -> str:
    """Write the image of a run, and return its name relative to the folder."""
    path = folder.image(*key)
    with replacing(path) as file:
        np.save(file, checkpoint.image)
    if checkpoint.samples is not None:
        with replacing(folder.samples(*key)) as file:
            np.save(file, checkpoint.samples)
    if checkpoint.variance is not None:
        with replacing(folder.variance(*key)) as file:
            np.save(file, checkpoint.variance)
    return path.relative_to(folder.path).as_posix()
