"""Figure of the times to one target error on all scenes: a row per scene, a dot with interval per strategy."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from equaltime.experiments.model.summary import SceneResult, Summary
from equaltime.experiments.report.curves import GRID, INK, MUTED, tick
from equaltime.experiments.report.looks import Style
from equaltime.experiments.report.words import percent, seconds
from equaltime.extras import optional
from equaltime.statistics.intervals import UNKNOWN, Interval

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["clearest", "draw_dots", "has_dots", "unmarked"]

_ROW, _REST = 0.34, 0.75
"""Height of a scene's row, and of everything else, in inches."""
_LABELS = 2.2
"""Labels per inch of the time axis, which takes about half of the width."""
_LETTERS = 6.8
"""Letters of a scene's name per inch of the figure's width; names take about half of the width."""


def has_dots(summary: Summary, target: float) -> bool:
    """Tell whether `draw_dots` would draw any dot: some scene has a trusted time to the error ``target``."""
    return _count(summary, target) > 0


def unmarked(summary: Summary, target: float) -> dict[str, list[str]]:
    """Return, by strategy label, the names of the scenes on which `draw_dots` draws no mark for the strategy.

    Strategies with a mark (dot or arrow) on every scene are left out.
    """
    found: dict[str, list[str]] = {}
    for scene in summary.scenes:
        for strategy in scene.strategies:
            time = strategy.time_to.get(target, UNKNOWN)
            if _trusted(time) is None and not _is_an_end(time):
                found.setdefault(strategy.label, []).append(scene.name)
    return found


def clearest(summary: Summary) -> float | None:
    """Return the target error for which `draw_dots` draws most dots; None if no target has a dot.

    If several targets have equally many dots, the smallest is returned.
    """
    counts = {target: _count(summary, target) for target in summary.targets}
    most = max(counts.values(), default=0)
    return min(target for target, count in counts.items() if count == most) if most else None


def draw_dots(summary: Summary, target: float, looks: Mapping[str, Style], width: float) -> Figure:
    """Draw the times to the error ``target`` on all scenes, and return the figure, ``width`` inches wide.

    Hollow dots are extrapolated times. Arrows are lower limits of times. ``looks`` gives colour, marker and line style
    by label.
    """
    height = _REST + _ROW * len(summary.scenes)
    figure: Figure = optional("matplotlib.figure").Figure(
        figsize=(width, height), layout="constrained", facecolor="none"
    )
    axes = figure.add_subplot(facecolor="none")
    for label, look in looks.items():
        _draw_strategy(axes, summary, target, label, look)
    _frame(axes, [_short(scene.name, int(_LETTERS * width)) for scene in summary.scenes], target, width)
    return figure


def _count(summary: Summary, target: float) -> int:
    times = (strategy.time_to.get(target, UNKNOWN) for scene in summary.scenes for strategy in scene.strategies)
    return sum(_trusted(time) is not None for time in times)


def _draw_strategy(axes: Axes, summary: Summary, target: float, label: str, look: Style) -> None:
    found = [(row, _trusted(_time(scene, label, target))) for row, scene in enumerate(summary.scenes)]
    points = [(row, time) for row, time in found if time is not None]
    _draw_ends(axes, summary, target, label, look)
    if not points:
        return
    rows, times = [row for row, _ in points], [time for _, time in points]
    values = [time.value for time in times]
    spread = [[time.value - max(time.low, 1e-3 * time.value) for time in times], [t.high - t.value for t in times]]
    axes.plot(values, rows, color=look.light, linewidth=1.0, alpha=0.45, linestyle=look.line, zorder=2)
    axes.errorbar(values, rows, xerr=spread, fmt="none", ecolor=look.light, elinewidth=1.6, capsize=2.5, zorder=3)
    for hollow in (False, True):
        chosen = [i for i, time in enumerate(times) if (time.reach > 1.0) == hollow]
        axes.plot(
            [values[i] for i in chosen],
            [rows[i] for i in chosen],
            color=look.light,
            marker=look.marker,
            markerfacecolor="white" if hollow else look.light,
            markersize=6.5,
            linestyle="none",
            zorder=4,
        )


def _draw_ends(axes: Axes, summary: Summary, target: float, label: str, look: Style) -> None:
    """Draw an arrow at each time of which only the lower limit is known."""
    times = [_time(scene, label, target) for scene in summary.scenes]
    rows = [row for row, time in enumerate(times) if _is_an_end(time)]
    lows = [times[row].low for row in rows]
    axes.plot(lows, rows, color=look.light, marker=">", markerfacecolor="white", linestyle="none", zorder=4)


def _time(scene: SceneResult, label: str, target: float) -> Interval:
    times = (one.time_to.get(target, UNKNOWN) for one in scene.strategies if one.label == label)
    return next(times, UNKNOWN)


def _is_an_end(time: Interval) -> bool:
    """Tell whether only the lower limit of the time is known."""
    return time.bound == "low" and 0.0 < time.low < math.inf


def _trusted(time: Interval) -> Interval | None:
    """Return the time if it is trusted and finite, else None."""
    if not time.trusted or not (0.0 < time.value < math.inf and time.high < math.inf):
        return None
    return time


def _short(name: str, most: int) -> str:
    return name if len(name) <= most else name[: most - 1] + "\N{HORIZONTAL ELLIPSIS}"


def _frame(axes: Axes, names: Sequence[str], target: float, width: float) -> None:
    axes.set(xscale="log", ylim=(len(names) - 0.5, -0.5))
    low, high = axes.get_xlim()
    if high < 3.0 * low:  # so that there is more than one tick
        axes.set_xlim(low / 1.5, high * 1.5)
    axes.set_yticks(range(len(names)), names)
    for text in axes.get_yticklabels():
        text.set_parse_math(False)
    for name, spine in axes.spines.items():
        spine.set_visible(name == "bottom")
        spine.set_color(MUTED)
    axes.tick_params(which="both", colors=MUTED, labelcolor=INK)
    axes.tick_params(axis="y", length=0)
    axes.grid(visible=True, which="major", color=GRID, linewidth=0.8)
    axes.set_axisbelow(True)
    tick(axes.xaxis, seconds, 0.5 * _LABELS * width)
    axes.set_xlabel(f"time to an error of {percent(target)}", color=INK)
