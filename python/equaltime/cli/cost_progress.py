"""The progress line of an experiment, on stderr: number of the run, strategy, scene, time left."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from contextlib import contextmanager

from rich import progress as bars
from rich.console import Console
from rich.table import Column
from rich.text import Text

from equaltime.experiments.run.runner import ProgressCallback, RunProgress

__all__ = ["cost_progress", "describe", "time_left"]

# A refresh takes a millisecond, also while a run is timed.
_REFRESHES_PER_SECOND = 1


@contextmanager
def cost_progress(quiet: bool = False) -> Iterator[ProgressCallback | None]:
    """Show a progress line on stderr during the context, and yield the function that updates the line.

    The function takes a `RunProgress`. Yields None if ``quiet`` or if stderr is no terminal.
    """
    console = Console(stderr=True)
    if quiet or not console.is_terminal:
        yield None
        return
    clock = _TimeLeft()
    words = bars.TextColumn("{task.description}", table_column=Column(no_wrap=True), markup=False)
    columns = (bars.BarColumn(bar_width=24), words, clock)
    with bars.Progress(*columns, console=console, transient=True, refresh_per_second=_REFRESHES_PER_SECOND) as bar:
        task = bar.add_task("", total=1.0)

        def show(progress: RunProgress) -> None:
            clock.set(progress.time_left)
            bar.update(task, completed=progress.fraction, description=describe(progress))

        yield show


def describe(progress: RunProgress) -> str:
    """Return the current step of an experiment as text, such as ``run 5 of 25: best on cornell-box``."""
    if progress.phase == "setup":
        return f"setting up {progress.strategy} on {progress.scene}"
    if progress.phase == "agreement":
        return f"does {progress.strategy} mean the same image of {progress.scene}?"
    if progress.phase == "reference":
        return f"reference of {progress.scene}"
    if progress.phase == "film":
        return f"filming {progress.strategy} on {progress.scene}"
    if progress.done == progress.total:
        return f"{progress.total} runs done"
    return f"run {progress.done + 1} of {progress.total}: {progress.strategy} on {progress.scene}"


def time_left(seconds: float) -> str:
    """Format seconds for a countdown: ``0:07 left``, ``1:02:30 left``."""
    minutes, rest = divmod(max(0, math.ceil(seconds)), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{rest:02} left" if hours else f"{minutes}:{rest:02} left"


class _TimeLeft(bars.ProgressColumn):
    """Counts down from the last estimate."""

    max_refresh = None

    def __init__(self) -> None:
        super().__init__(table_column=Column(no_wrap=True))
        self._end: float | None = None

    def set(self, seconds: float | None) -> None:
        self._end = None if seconds is None else time.monotonic() + seconds

    def render(self, task: bars.Task) -> Text:
        return Text("" if self._end is None else time_left(self._end - time.monotonic()))
