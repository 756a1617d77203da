"""Work of a machine of a cluster: whole runs of one scene, of which it builds the scene once."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from dataclasses import dataclass, field

from equaltime.experiments.run.record import Row
from equaltime.experiments.run.single_run import RunOrder, SingleRun
from equaltime.images.metrics import Reference
from equaltime.rendering.core_subject import CoreSubject, Point
from equaltime.scene import Scene
from equaltime.strategy import Strategy

__all__ = ["FinishedRun", "Stage", "perform"]

_ONE_RUN = threading.Lock()
"""Held during a run: a run that a killed process left behind ends before the next one begins."""


@dataclass
class Stage:
    """Scene and reference, and the subjects that have rendered the scene, by label."""

    scene: Scene
    known: Reference
    subjects: dict[str, CoreSubject] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class FinishedRun:
    """All rows of a run, and its state at the last one."""

    rows: tuple[Row, ...]
    last: Point

    def checkpoints(self) -> Iterator[tuple[Row, Point]]:
        """Yield the rows for `equaltime.experiments.run.single_run.record`, which uses the state at the last one."""
        return ((row, self.last) for row in self.rows)


def perform(stage: Stage, order: RunOrder, strategy: Strategy) -> FinishedRun:
    """Render and measure a run in this process.

    Raises what `SingleRun.checkpoints` raises.
    """
    label = order.key[1]
    subject = stage.subjects.setdefault(label, CoreSubject(label, strategy))
    rows = []
    with _ONE_RUN:
        for row, point in SingleRun(order, stage.scene, subject, stage.known).checkpoints():
            rows.append(row)
            last = point
    return FinishedRun(tuple(rows), last)
