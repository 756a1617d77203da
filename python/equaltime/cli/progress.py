"""The progress bar of a render, on stderr: samples, error so far, time left."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager

from rich import progress as bars
from rich.console import Console
from rich.table import Column

from equaltime.rendering.progress import Progress, ProgressCallback

__all__ = ["progress_bar"]


@contextmanager
def progress_bar(quiet: bool) -> Iterator[ProgressCallback | None]:
    """Show a progress bar on stderr during the context, and yield the function that updates the bar.

    The function takes a `Progress`. Yields None if ``quiet`` or if stderr is no terminal.
    """
    console = Console(stderr=True)
    if quiet or not console.is_terminal:
        yield None
        return
    columns = (bars.BarColumn(bar_width=24), bars.TextColumn("{task.description}", table_column=Column(no_wrap=True)))
    with bars.Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task("", total=1.0)

        def show(progress: Progress) -> None:
            bar.update(task, completed=progress.fraction, description=describe(progress))

        yield show


def describe(progress: Progress) -> str:
    """Return the state of a render as text, such as ``24/64 spp  noise 3.12 %  0:07 left``."""
    target = "" if progress.target is None else f"/{progress.target}"
    words = [f"{progress.samples}{target} spp"]
    if progress.error is not None and progress.error.known:
        words.append(f"noise {100 * progress.error.value:.3g} %")
    if progress.time_left is not None:
        minutes, seconds = divmod(math.ceil(progress.time_left), 60)
        words.append(f"{minutes}:{seconds:02} left")
    return "  ".join(words)
