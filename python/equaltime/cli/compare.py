"""The command ``equaltime compare``: measures how far images are from each other or from a reference."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

from equaltime.cli.messages import MOST_LINES, plain_console, print_json, print_line
from equaltime.cli.options import AsJson, Verbose
from equaltime.rendering.compare import Compared, Comparison
from equaltime.rendering.compare import compare as compare_files
from equaltime.statistics.agreement import LEVEL
from equaltime.statistics.in_words import figure, in_percent, probability, span
from equaltime.statistics.intervals import Interval
from equaltime.words import duration, percent

__all__ = ["compare"]

_PERCENT = {"error", "mare"}
_SHORT = {"error": "error", "flip": "visible difference (FLIP)"}
"""Metrics that are shown without ``-v``, with their titles."""
_FLIP = (
    "FLIP: 0 if no difference can be seen, 1 for the largest, at 67 pixels per degree of view. It has no interval: the "
    "noise of the image compared against counts as difference."
)

_DEFINITIONS = (
    "error: root of relmse. relmse: mean of ((A - R)\N{SUPERSCRIPT TWO} - v) / (R\N{SUPERSCRIPT TWO} + (0.1 m)"
    "\N{SUPERSCRIPT TWO}), with R the truth, v the variance of its noise and m its mean. mse: mean of (A - R)"
    "\N{SUPERSCRIPT TWO} - v. mare: mean of |A - R| / (|R| + 0.1 m), noise included."
)
_EFFICIENCY = "efficiency: 1 / (error\N{SUPERSCRIPT TWO} x render time); a larger one is better."
_INTERVALS = (
    "Intervals hold for these images alone: they tell how far noise of the truth may have moved each number. They are "
    "made from the variance of its pixels, and from the scatter of the squared differences over blocks of 4x4 pixels."
)
_TEST = (
    "p of equal means: the least p of three tests over the whole image, corrected for their number. They take means "
    "over blocks of 8x8 pixels or more, in standard errors: the largest difference of a block, the mean difference of "
    "a channel, and the sum of squares. p is near 1 if the means differ by less than the standard errors say, as with "
    "evenly spread samples."
)


def compare(
    a: Annotated[Path, typer.Argument(metavar="A", help="Image file.", show_default=False)],
    b: Annotated[
        Path,
        typer.Argument(
            metavar="B", help="Image file of the same size; without REF it is taken as the truth.", show_default=False
        ),
    ],
    reference: Annotated[
        Path | None,
        typer.Argument(
            metavar="[REF]", help="Truth for A and B; without it, B is the truth for A.", show_default=False
        ),
    ] = None,
    as_json: AsJson = False,
    verbose: Verbose = False,
) -> int:
    """Measure how far images are from each other, or from a reference.

    With two files, the second is taken as the truth: the error is that of the first. With three, the third is the truth
    for both.

    Works on any renderer's files. If the files have standard errors (channels stderr.R, stderr.G, stderr.B), the
    reference's noise is subtracted, errors have 95 % intervals, and the images are tested for bias. The errors and
    their ratio describe these two images, not the strategies in general. Intervals tell how far noise of the truth may
    have moved each number. They are made from the variance of its pixels, and from the scatter of the squared
    differences over blocks of 4x4 pixels.

    Let R be the truth, v the variance of its noise and m its mean. relmse is the mean of
    ((A - R)² - v) / (R² + (0.1 m)²), and error its root. mse is the mean of (A - R)² - v. mare is the mean of
    |A - R| / (|R| + 0.1 m), noise included. efficiency is 1 / (error² x render time).

    Bias is found if p is below 0.001. p is the least of three tests over the whole image, corrected for their number.
    They take means over blocks of 8x8 pixels or more, in standard errors: the largest difference of a block, the mean
    difference of a channel, and the sum of squares. p is near 1 if the means differ by less than the standard errors
    say, as with evenly spread samples. The output tells which bias of all pixels would be found in nine of ten
    cases.

    FLIP is 0 if no difference can be seen and 1 for the largest difference, at 67
    pixels per degree of view. It has no interval, because noise of the reference counts as difference.


    For instance: `equaltime compare naive.exr best.exr reference.exr`
    """
    found = compare_files(a, b, reference)
    if as_json:
        print_json(found)
    else:
        _print(found, verbose)
    return 0


def _print(found: Comparison, verbose: bool) -> None:
    console = plain_console()
    names = _names(found)
    for line in _answer(found, names):
        print_line(console, line)
    console.print(table := _table(found, names, verbose))
    if verbose and found.efficiency is not None:
        print_line(console, _ratio(found.efficiency, "the efficiency", found, names))
    room = MOST_LINES - 4 - table.row_count - bool(found.same) - bool(found.order) - bool(found.unlike)
    shown = found.notes if verbose or len(found.notes) <= room else found.notes[: room - 1]
    more = [f"{len(found.notes) - len(shown)} more notes"] if len(shown) < len(found.notes) else []
    for note in shown:
        print_line(console, f"note: {note}", "dim")
    if not verbose:
        hidden = "relmse, mse, mare" + ", efficiency" * (found.efficiency is not None)
        print_line(console, f"-v shows {', '.join([*more, hidden])}", "dim")
    else:
        tested = any(image.bias_p is not None for image in found.images)
        limited = any(math.isfinite(image.metrics["error"].high) for image in found.images)
        told = (
            (_DEFINITIONS, True),
            (_EFFICIENCY, found.efficiency is not None),
            (_INTERVALS, limited),
            (_TEST, tested),
        )
        for definition in (text for text, is_needed in told if is_needed):
            print_line(console, definition, "dim")
        if "flip" in found.images[0].metrics:
            print_line(console, _FLIP, "dim")


def _names(found: Comparison) -> Mapping[Path, str]:
    """Return short names of the files: without folders, if they still differ."""
    paths = {*(image.path for image in found.images), found.against}
    short = len({path.name for path in paths}) == len(paths)
    return {path: path.name if short else str(path) for path in paths}


def _answer(found: Comparison, names: Mapping[Path, str]) -> Iterator[str]:
    """Yield the answer: which image is nearer to the reference, or how far two are apart; and whether one is biased."""
    against = names[found.against]
    if found.same:
        yield found.same
    if found.unlike:
        yield f"warning: {found.unlike}"
    if found.ratio is not None:
        told = not math.isnan(found.ratio.low)
        even = told and found.ratio.low <= 1.0 <= found.ratio.high
        unsure = told and not even and not found.ratio.trusted
        begin = "No clear difference: " if even else "Perhaps: " if unsure else ""
        yield f"{begin}{_ratio(found.ratio, 'the error', found, names)}."
    elif len(found.images) > 1:
        yield f"Which image is nearer to {against} cannot be told: it is too noisy."
    else:
        error = found.images[0].metrics["error"]
        noise = "; its noise is subtracted" if math.isfinite(error.high) else ""
        yield f"{_distance(names[found.images[0].path], error, against)} {against} is taken as the truth{noise}."
    if found.order:
        yield f"warning: {found.order}"
    tested = [(names[image.path], image.bias_p) for image in found.images if image.bias_p is not None]
    unequal = [f"{name} ({probability(p)})" for name, p in tested if p < LEVEL]
    if unequal:
        yield f"Bias found: {' and '.join(unequal)} and {against} differ by more than their noise."
    elif tested:
        several = len(found.images) > 1
        found_p = ", ".join(probability(p) + f" for {name}" * several for name, p in tested)
        least = [image.least_bias for image in found.images if image.least_bias is not None]
        power = (
            f" A bias of {percent(float(f'{max(least):.2g}'))} in all pixels would mostly be found." if least else ""
        )
        yield f"No bias found: {found_p}; only p below {LEVEL:g} counts as bias.{power}"
    if tested and (untested := [names[image.path] for image in found.images if image.bias_p is None]):
        yield f"Not tested for bias, as the noise is not known: {' and '.join(untested)}."


def _distance(name: str, error: Interval, against: str) -> str:
    """Return a sentence on how far an image is from another one."""
    if not math.isnan(error.value):
        return f"{name} differs from {against} by {in_percent(error)}."
    if math.isfinite(error.high):
        return f"{name} differs from {against} by at most {percent(error.high)}; {against} is too noisy to tell more."
    return f"How much {name} differs from {against} cannot be told."


def _ratio(ratio: Interval, what: str, found: Comparison, names: Mapping[Path, str]) -> str:
    """Return a clause with the ratio of ``what``, such as an error, of the first image and of the second."""
    first, second = (names[image.path] for image in found.images)
    doubt = "" if ratio.trusted else f" (in doubt: {ratio.note})"
    return f"{first} has {figure(ratio.value)} times {span(ratio)} {what} of {second}{doubt}".replace("  ", " ")


def _table(found: Comparison, names: Mapping[Path, str], verbose: bool) -> Table:
    table = Table(box=None, pad_edge=False)
    table.add_column(f"against {names[found.against]}", overflow="fold")
    for image in found.images:
        table.add_column(names[image.path], justify="right", overflow="fold")
    for metric in found.images[0].metrics:
        if verbose or metric in _SHORT:
            measured = (_measured(metric, image.metrics[metric]) for image in found.images)
            table.add_row(_SHORT.get(metric, metric), *measured)
    for label, cells in (
        ("in doubt", ["yes, see the note" if image.doubt else "" for image in found.images]),
        ("p of equal means", [_p(image) if verbose else "" for image in found.images]),
        ("error that the file states", [in_percent(image.own) if image.own else "" for image in found.images]),
        ("render time", [duration(image.seconds) if image.seconds else "" for image in found.images]),
    ):
        if any(cells):
            table.add_row(label, *cells)
    return table


def _measured(metric: str, measured: Interval) -> str:
    scale, unit = (100.0, " %") if metric in _PERCENT else (1.0, "")
    limited = math.isfinite(measured.high)
    if math.isnan(measured.value):
        return f"unknown, at most {figure(scale * measured.high)}{unit}" if limited else "unknown"
    text = f"{figure(scale * measured.value)}{unit}"
    return f"{text} {span(measured, scale)}" if limited else text


def _p(image: Compared) -> str:
    return "" if image.bias_p is None else f"{image.bias_p:.2g}"
