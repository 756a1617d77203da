"""The command ``equaltime compare``: measures how far images are from each other or from a reference."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

from equaltime.cli.messages import plain_console, print_json
from equaltime.cli.options import AsJson
from equaltime.rendering.compare import Compared, Comparison
from equaltime.rendering.compare import compare as compare_files
from equaltime.statistics.intervals import Interval

__all__ = ["compare"]

_PERCENT = {"error", "mare"}


def compare(
    a: Annotated[Path, typer.Argument(metavar="A", help="Image file.", show_default=False)],
    b: Annotated[Path, typer.Argument(metavar="B", help="Image file of the same size.", show_default=False)],
    reference: Annotated[
        Path | None,
        typer.Argument(metavar="[REF]", help="What both are measured against; else A against B.", show_default=False),
    ] = None,
    as_json: AsJson = False,
) -> int:
    """Measure how far images are from each other, or from a reference.

    Works on any renderer's files. If the files have standard errors (channels stderr.R, stderr.G, stderr.B), the
    reference's noise is subtracted, errors have 95 % intervals, and the images are tested for bias. The errors and
    their ratio describe these two images, not the strategies in general.


    For instance: `equaltime compare naive.exr best.exr reference.exr`
    """
    found = compare_files(a, b, reference)
    if as_json:
        print_json(found)
    else:
        _print(found)
    return 0


def _print(found: Comparison) -> None:
    console = plain_console()
    table = Table(box=None, pad_edge=False)
    table.add_column(f"against {found.against.name}", overflow="fold")
    for image in found.images:
        table.add_column(str(image.path), justify="right", overflow="fold")
    for metric in found.images[0].metrics:
        table.add_row(metric, *(_measured(metric, image.metrics[metric]) for image in found.images))
    for label, cells in (
        ("in doubt", ["yes, see the note" if image.doubt else "" for image in found.images]),
        ("p of equal means", [_p(image) for image in found.images]),
        ("its own estimate", [f"{image.own:%}" if image.own else "" for image in found.images]),
        ("render time", [f"{image.seconds:.3g} s" if image.seconds else "" for image in found.images]),
    ):
        if any(cells):
            table.add_row(label, *cells)
    console.print(table)
    for label, ratio in (("error", found.ratio), ("efficiency", found.efficiency)):
        if ratio is not None:
            first, second = (image.path for image in found.images)
            pair = f"{label} of {first} over that of {second}, these very images"
            console.print(f"{pair}: {_interval(ratio)}", soft_wrap=True)
    for note in found.notes:
        console.print(f"note: {note}", style="dim", soft_wrap=True)


def _measured(metric: str, measured: Interval) -> str:
    scale, unit = (100.0, " %") if metric in _PERCENT else (1.0, "")
    limited = math.isfinite(measured.high)
    if math.isnan(measured.value):
        return f"unknown, at most {scale * measured.high:.4g}{unit}" if limited else "unknown"
    text = f"{scale * measured.value:.4g}{unit}"
    if not limited:
        return text
    return f"{text} [{scale * measured.low:.4g}, {scale * measured.high:.4g}]"


def _p(image: Compared) -> str:
    return "" if image.bias_p is None else f"{image.bias_p:.2g}"


def _interval(interval: Interval) -> str:
    text = f"{interval.value:.3g}"
    if not math.isnan(interval.low):
        text += f" [{interval.low:.3g}, {interval.high:.3g}]"
    return text if interval.trusted else f"{text} (not to be trusted: {interval.note})"
