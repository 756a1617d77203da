"""Figures for papers as PDF and PNG: the error curves of each scene, and crops of its images at equal time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from equaltime.experiments.model.summary import SceneResult, StrategyResult
from equaltime.experiments.report.charts import draw_curves
from equaltime.experiments.report.gallery import Window
from equaltime.experiments.report.looks import INK, Style
from equaltime.experiments.report.pictures import Pictures, exposed
from equaltime.experiments.report.words import error_cell
from equaltime.extras import optional
from equaltime.files import replacing

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["draw_comparison", "write_figure", "write_figures"]

_KINDS = {"pdf": {"CreationDate": None}, "png": {}}
"""File types and their metadata; without a date, so that equal figures give equal files."""


def write_figure(figure: Figure, folder: Path, name: str) -> tuple[str, ...]:
    """Write a figure to ``folder`` as NAME.pdf and NAME.png, each atomically.

    Returns the names of both files with the last part of the folder's path, as in ``figures/NAME.pdf``.
    """
    folder.mkdir(parents=True, exist_ok=True)
    for kind, metadata in _KINDS.items():
        with replacing(folder / f"{name}.{kind}") as file:
            figure.savefig(file, format=kind, dpi=200, facecolor="white", metadata=metadata)
    return tuple(f"{folder.name}/{name}.{kind}" for kind in _KINDS)


_FRAMES = ("#e69f00", "#56b4e9", "#009e73", "#cc79a7")


def write_figures(
    folder: Path,
    slug: str,
    scene: SceneResult,
    targets: Sequence[float],
    looks: Mapping[str, Style],
    pictures: Pictures | None,
    crops: Sequence[Window],
) -> tuple[str, ...]:
    """Write figures of a scene's error curves, and of its crops if there are pictures, to ``folder``.

    Returns the files as ``FOLDER/SLUG-curves.pdf`` and so on. ``targets`` are errors, drawn as horizontal lines.
    ``crops`` are windows (x, y, width, height) in pixels. ``looks`` gives colour, marker and line style by label.
    """
    drawn = {f"{slug}-curves": draw_curves(scene, targets, looks, (6.0, 4.0), legend=True)}
    if pictures is not None and pictures.runs and crops:
        drawn[f"{slug}-crops"] = draw_comparison(scene, pictures, crops)
    return tuple(file for name, figure in drawn.items() for file in write_figure(figure, folder, name))


def draw_comparison(scene: SceneResult, pictures: Pictures, crops: Sequence[Window]) -> Figure:
    """Return a figure of the reference with marked windows ``crops``, and beside it the crops of all images.

    The crops form a table: a row per window, a column for the reference, and a column per strategy.
    """
    shown = [strategy for strategy in scene.strategies if strategy.label in pictures.runs]
    height, width = pictures.reference.mean.shape[:2]
    left = len(crops) * width / height
    columns = 1 + len(shown)
    size = (1.3 * (left + columns), 1.3 * len(crops) + 0.45)
    figure: Figure = optional("matplotlib.figure").Figure(figsize=size, layout="constrained")
    grid = figure.add_gridspec(len(crops), 1 + columns, width_ratios=[left] + [1.0] * columns, wspace=0.02, hspace=0.02)
    whole = figure.add_subplot(grid[:, 0])
    _show(whole, exposed(pictures.reference.mean, pictures.stops))
    for (x, y, w, h), colour in zip(crops, _cycle(len(crops)), strict=True):
        rectangle = optional("matplotlib.patches").Rectangle((x, y), w, h, fill=False, edgecolor=colour, linewidth=1.5)
        whole.add_patch(rectangle)
    _title(whole, f"{scene.name}, equal time")
    for column in range(columns):
        image = pictures.reference.mean if column == 0 else pictures.runs[shown[column - 1].label][0]
        for row, ((x, y, w, h), colour) in enumerate(zip(crops, _cycle(len(crops)), strict=True)):
            axes = figure.add_subplot(grid[row, 1 + column])
            _show(axes, exposed(image[y : y + h, x : x + w], pictures.stops), colour)
            if row == 0:
                _title(axes, "reference" if column == 0 else _heading(shown[column - 1]))
    return figure


def _heading(strategy: StrategyResult) -> str:
    error = error_cell(strategy.error_at_budget)
    return f"{strategy.label}\n{error.text}" if error.state == "trusted" else strategy.label


def _cycle(count: int) -> list[str]:
    return [_FRAMES[i % len(_FRAMES)] for i in range(count)]


def _show(axes: Axes, pixels: np.ndarray[tuple[int, ...], np.dtype[np.uint8]], frame: str | None = None) -> None:
    axes.imshow(pixels, interpolation="nearest")
    axes.set_xticks([])
    axes.set_yticks([])
    for spine in axes.spines.values():
        spine.set_visible(frame is not None)
        spine.set_color(frame or INK)
        spine.set_linewidth(1.5)


def _title(axes: Axes, text: str) -> None:
    axes.set_title(text, fontsize=8, color=INK).set_parse_math(False)
