"""The progress bar of commands, on stderr: the fraction done, the present work, the time left."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import singledispatch

from rich import progress as bars
from rich.console import Console
from rich.table import Column
from rich.text import Text

from equaltime.experiments.run.runner import RunProgress
from equaltime.rendering.passes import Progress

__all__ = ["describe", "progress_bar", "time_left"]

# A refresh takes a millisecond, also while a run is timed.
_REFRESHES_PER_SECOND = 2


@contextmanager
def progress_bar(quiet: bool = False) -> Iterator[Callable[[Progress | RunProgress | float], None] | None]:
    """Show a progress bar on stderr during the context, and yield the function that updates the bar.

    The function takes the progress of a render or of an experiment, or the fraction of the work that is done, in
    [0, 1]. Yields None if ``quiet`` or if stderr is no terminal.
    """
    console = Console(stderr=True)
    if quiet or not console.is_terminal:
        yield None
        return
    begin, countdown = time.monotonic(), _Countdown()
    words = bars.TextColumn("{task.description}", table_column=Column(no_wrap=True), markup=False)
    columns = (bars.BarColumn(bar_width=24), words, countdown)
    with bars.Progress(*columns, console=console, transient=True, refresh_per_second=_REFRESHES_PER_SECOND) as bar:
        task = bar.add_task("", total=1.0)

        def show(progress: Progress | RunProgress | float) -> None:
            if isinstance(progress, Progress | RunProgress):
                fraction, left = progress.fraction, progress.time_left
            else:
                fraction = progress
                left = (time.monotonic() - begin) * (1.0 / fraction - 1.0) if fraction > 0.0 else None
            countdown.set(left)
            bar.update(task, completed=fraction, description=describe(progress))

        yield show


@singledispatch
def describe(progress: object) -> str:
    """Return the present work as text; empty if only the fraction done is known."""
    return ""


@describe.register
def _(progress: Progress) -> str:
    target = "" if progress.target is None else f"/{progress.target}"
    noise = "" if progress.error is None or not progress.error.known else f"  noise {100 * progress.error.value:.3g} %"
    return f"{progress.samples}{target} spp{noise}"


@describe.register
def _(progress: RunProgress) -> str:
    words = {
        "setup": f"setting up {progress.strategy} on {progress.scene}",
        "agreement": f"does {progress.strategy} mean the same image of {progress.scene}?",
        "reference": f"reference of {progress.scene}",
        "film": f"filming {progress.strategy} on {progress.scene}",
    }
    if progress.phase in words:
        return words[progress.phase]
    if progress.done == progress.total:
        return f"{progress.total} runs done"
    return f"run {progress.done + 1} of {progress.total}: {progress.strategy} on {progress.scene}"


def time_left(seconds: float) -> str:
    """Format seconds for a countdown: ``0:07 left``, ``1:02:30 left``."""
    minutes, rest = divmod(max(0, math.ceil(seconds)), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{rest:02} left" if hours else f"{minutes}:{rest:02} left"


class _Countdown(bars.ProgressColumn):
    """Counts down from the last estimate of the time left."""

    max_refresh = None

    def __init__(self) -> None:
        super().__init__(table_column=Column(no_wrap=True))
        self._end: float | None = None

    def set(self, seconds: float | None) -> None:
        self._end = None if seconds is None else time.monotonic() + seconds

    def render(self, task: bars.Task) -> Text:
        return Text("" if self._end is None else time_left(self._end - time.monotonic()))
