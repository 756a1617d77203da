"""The progress of commands, on stderr: a bar in a terminal, else a line a minute."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
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

_SECONDS_A_LINE = 60.0
"""Seconds between two lines where there is no terminal, such as in a log file."""

_FIRST_LINE = 20.0
"""Seconds until the first of these lines."""


@contextmanager
def progress_bar(quiet: bool = False) -> Iterator[Callable[[Progress | RunProgress | float], None] | None]:
    """Show progress on stderr during the context, and yield the function that updates it; None if ``quiet``.

    On a terminal it is a bar. In a file or a pipe it is a line after 20 seconds, then a line a minute. The function
    takes the progress of a render or of an experiment, or the fraction of the work that is done, in [0, 1].
    """
    console = Console(stderr=True)
    if quiet:
        yield None
    elif console.is_terminal:
        with _bar(console) as show:
            yield show
    else:
        yield _Lines()


@contextmanager
def _bar(console: Console) -> Iterator[Callable[[Progress | RunProgress | float], None]]:
    begin, countdown = time.monotonic(), _Countdown()
    words = bars.TextColumn("{task.description}", table_column=Column(no_wrap=True), markup=False)
    columns = (bars.BarColumn(bar_width=24), words, countdown)
    with bars.Progress(*columns, console=console, transient=True, refresh_per_second=_REFRESHES_PER_SECOND) as bar:
        task = bar.add_task("", total=1.0)

        def show(progress: Progress | RunProgress | float) -> None:
            fraction, left = _fraction_and_left(progress, time.monotonic() - begin)
            countdown.set(left)
            bar.update(task, completed=fraction, description=describe(progress))

        yield show


class _Lines:
    """Printer of a line of progress after 20 seconds, and then every minute."""

    def __init__(self) -> None:
        self._begin = time.monotonic()
        self._next = self._begin + _FIRST_LINE

    def __call__(self, progress: Progress | RunProgress | float) -> None:
        now = time.monotonic()
        if now < self._next:
            return
        self._next = now + _SECONDS_A_LINE
        fraction, left = _fraction_and_left(progress, now - self._begin)
        words = filter(None, (describe(progress), "" if left is None else time_left(left)))
        since = now - self._begin
        ago = f"{since:.0f} s" if since < 60.0 else f"{since / 60.0:.0f} min"
        done = [f"{100.0 * fraction:.0f} %"] if fraction > 0.0 else []  # else it is unknown
        said = ", ".join([ago, *done, *words])
        with suppress(OSError):  # nobody reads it any more
            print(said, file=sys.stderr, flush=True)


def _fraction_and_left(progress: Progress | RunProgress | float, seconds: float) -> tuple[float, float | None]:
    """Return the fraction done and the seconds left, after ``seconds`` of work."""
    if isinstance(progress, Progress | RunProgress):
        return progress.fraction, progress.time_left
    return progress, seconds * (1.0 / progress - 1.0) if progress > 0.0 else None


@singledispatch
def describe(progress: object) -> str:
    """Return the work that a command does at present as text, for its progress bar; empty if it is not known."""
    return ""


@describe.register
def _(progress: Progress) -> str:
    target = "" if progress.target is None else f"/{progress.target}"
    noise = "" if progress.error is None or not progress.error.known else f"  noise {100 * progress.error.value:.3g} %"
    return f"{progress.samples}{target} spp{noise}{'  ' * bool(progress.cluster)}{progress.cluster}"


@describe.register
def _(progress: RunProgress) -> str:
    words = {
        "setup": f"setting up {progress.strategy} on {progress.scene}",
        "agreement": f"agreement of {progress.strategy} with equaltime on {progress.scene}",
        "own reference": f"reference of {progress.scene} by {progress.strategy}",
        "reference": f"reference of {progress.scene}",
        "film": f"filming {progress.strategy} on {progress.scene}",
        "report": " of ".join(filter(None, ("writing the report", progress.scene))),
    }
    if progress.phase in words:
        return words[progress.phase]
    if progress.done == progress.total:
        return f"{progress.total} runs done"
    if progress.machines:
        on = f"{progress.machines} machine{'s' * (progress.machines != 1)}"
        return f"{progress.done} of {progress.total} runs done on {on}; begins {progress.strategy} on {progress.scene}"
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
