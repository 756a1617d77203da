"""The command ``equaltime merge``: joins renders of one scene."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated

import typer

from equaltime.cli.messages import Written, doubts, headline, print_json, print_lines
from equaltime.cli.options import AsJson, ExposureStops, Overwrite, Small
from equaltime.cli.recorded import next_error
from equaltime.errors import ImageError
from equaltime.images import preview
from equaltime.rendering.merge import merge as merge_files
from equaltime.rendering.output_files import check_output, check_replaceable, check_spares
from equaltime.rendering.result import Result
from equaltime.statistics.in_words import about, span
from equaltime.statistics.intervals import Interval
from equaltime.words import percent

__all__ = ["merge"]


def merge(
    files: Annotated[
        list[Path], typer.Argument(metavar="A.exr B.exr...", help="Renders of one scene.", show_default=False)
    ],
    output: Annotated[
        Path,
        typer.Option(
            "-o",
            "--output",
            metavar="FILE",
            show_default=False,
            help="The joined render: FILE.exr, which can be merged again, with a preview FILE.png beside it.",
        ),
    ],
    exposure: ExposureStops = "auto",
    small: Small = False,
    overwrite: Overwrite = False,
    as_json: AsJson = False,
) -> int:
    """Join renders of one scene that were made with different seeds, on any machines.

    The image equals one render with all samples. The error bar comes from how far the renders differ: more renders make
    the error bar more reliable. Renders with adaptive=neighbours, history or cutoff cannot be merged.


    For instance: `equaltime merge monday.exr tuesday.exr -o both.exr`
    """
    if output.suffix.lower() in preview.EXTENSIONS:  # it could not be merged again
        exr = output.with_suffix(".exr")
        raise ImageError(f"{output}: the joined render is an EXR file with a PNG beside it; give -o {exr} instead")
    paths = check_output(output, (".exr",))
    check_spares(paths.all, files, "is one of the files to be merged")
    result = merge_files(files)
    if not overwrite:
        check_replaceable(paths.all, result.origin.scene, result.origin.digest)
    stops = result.exposure(exposure)
    written = Written(result.save(output, small, exposure=exposure, overwrite=True), stops)
    if as_json:
        print_json({**result.record, "files": written.files, "exposure": stops})
        return 0
    wrote = "; ".join(filter(None, [f"wrote {written}", written.kept]))
    print_lines([f"Joined {len(files)} renders: {headline(result)}", wrote, *doubts(result), *_needed(result)])
    return 0


def _needed(result: Result) -> Iterator[str]:
    """Yield how many renders like the joined ones reach the next smaller error: error² is inverse to their number."""
    target = next_error(result.error.value)
    if target is None or not result.error.trusted or not math.isfinite(result.error.high) or result.bias is not None:
        return
    renders = len(result.origin.sources)
    value, low, high = (
        renders * (error / target) ** 2 for error in (result.error.value, result.error.low, result.error.high)
    )
    needed = Interval(value, low, high)
    yield f"{percent(target)} takes about {about(needed)} {span(needed)} such renders in all, each with its own seed"
