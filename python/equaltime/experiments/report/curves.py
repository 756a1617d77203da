"""Figure of error against time on logarithmic axes, with bands for the intervals, for web pages and papers."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from equaltime.experiments.model.summary import SceneResult, StrategyResult
from equaltime.experiments.report.looks import Style
from equaltime.experiments.report.words import error_cell, percent, seconds
from equaltime.extras import optional
from equaltime.statistics.intervals import Interval

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["GRID", "INK", "MUTED", "curve_gid", "draw_curves", "point_titles", "tick"]

INK, MUTED, GRID = "#1b1f24", "#5c6470", "#d8dce2"


def draw_curves(
    scene: SceneResult,
    targets: Sequence[float],
    looks: Mapping[str, Style],
    size: tuple[float, float],
    *,
    legend: bool,
) -> Figure:
    """Draw the error of all strategies of a scene against time, and return the figure.

    ``targets`` are errors, drawn as horizontal lines. ``looks`` gives colour, marker and line style by label. ``size``
    is width and height in inches. In the SVG, each curve is a group with the id `curve_gid`.
    """
    figure: Figure = optional("matplotlib.figure").Figure(figsize=size, layout="constrained", facecolor="none")
    axes = figure.add_subplot(facecolor="none")
    for order, strategy in enumerate(scene.strategies):
        _draw_strategy(axes, strategy, looks[strategy.label], order)
    _scale(axes, scene)
    _frame(axes)
    _draw_marks(axes, scene, targets)
    tick(axes.xaxis, seconds)
    tick(axes.yaxis, percent)
    axes.set_xlabel("time, first sample to image", color=INK)
    axes.set_ylabel("error", color=INK)
    if legend:
        _add_legend(axes)
    return figure


def curve_gid(order: int) -> str:
    """Return the id of the SVG group with the curve of the scene's strategy at index ``order``."""
    return f"curve-{order}"


def point_titles(strategy: StrategyResult) -> list[str]:
    """Return a tooltip for each drawn point of a strategy's curve: error, time and samples per pixel."""
    curve = strategy.curve
    return [
        f"{strategy.label}: {error_cell(curve.error[i])} after {seconds(curve.seconds[i].value)}, {curve.spp[i]} spp"
        for i in _drawn(strategy)
    ]


def _drawn(strategy: StrategyResult) -> list[int]:
    """Return the indices of checkpoints with positive time and error, which logarithmic axes can show."""
    pairs = zip(strategy.curve.seconds, strategy.curve.error, strict=True)
    return [i for i, (time, error) in enumerate(pairs) if _positive(time.value) and _positive(error.value)]


def _positive(value: float) -> bool:
    return math.isfinite(value) and value > 0.0


def _draw_strategy(axes: Axes, strategy: StrategyResult, look: Style, order: int) -> None:
    points = _drawn(strategy)
    times = [strategy.curve.seconds[i].value for i in points]
    errors = [strategy.curve.error[i] for i in points]
    bands = [_band(error) for error in errors]
    axes.fill_between(
        times,
        [low for low, _ in bands],
        [high for _, high in bands],
        color=look.light,
        alpha=0.18,
        linewidth=0,
        gid=f"{curve_gid(order)}-band",
    )
    axes.plot(
        times,
        [error.value for error in errors],
        color=look.light,
        marker=look.marker,
        linestyle="--" if strategy.biased and look.line == "-" else look.line,
        markerfacecolor="none" if strategy.biased else look.light,
        markersize=5.5,
        linewidth=1.8,
        label=f"{_SHOWN}{strategy.label} (biased)" if strategy.biased else f"{_SHOWN}{strategy.label}",
        gid=curve_gid(order),
        zorder=3,
    )


def _band(error: Interval) -> tuple[float, float]:
    """Return the ends of the band at one point; the band of an untrusted interval has zero width."""
    if not (error.trusted and math.isfinite(error.high)):
        return error.value, error.value
    return max(error.low, 0.2 * error.value), error.high


def _scale(axes: Axes, scene: SceneResult) -> None:
    """Make both axes logarithmic, with limits that include all points, all bands and the equal time."""
    times = [scene.budget_s] if _positive(scene.budget_s) else []
    errors: list[float] = []
    for strategy in scene.strategies:
        for i in _drawn(strategy):
            times.append(strategy.curve.seconds[i].value)
            errors.extend(_band(strategy.curve.error[i]))
    axes.set(xscale="log", yscale="log", xlim=_limits(times), ylim=_limits(errors))


def _limits(values: Sequence[float]) -> tuple[float, float]:
    """Return limits with a margin on both sides, more than a factor of 2 apart."""
    low, high = min(values, default=0.1), max(values, default=1.0)
    room = max((high / low) ** 0.06, 1.5 if high < 2.0 * low else 1.0)
    return low / room, high * room


def _frame(axes: Axes) -> None:
    for name, spine in axes.spines.items():
        spine.set_visible(name in ("left", "bottom"))
        spine.set_color(MUTED)
    axes.tick_params(which="both", colors=MUTED, labelcolor=INK)
    axes.grid(visible=True, which="major", color=GRID, linewidth=0.8)
    axes.set_axisbelow(True)


def _draw_marks(axes: Axes, scene: SceneResult, targets: Sequence[float]) -> None:
    """Mark the targets within the axes' limits, and the equal time."""
    low, high = axes.get_ylim()
    for target in targets:
        if low < target < high:
            axes.axhline(target, color=MUTED, linewidth=0.9, linestyle=(0, (1, 2)), zorder=1)
    if _positive(scene.budget_s):
        axes.axvline(scene.budget_s, color=MUTED, linewidth=0.9, linestyle=(0, (5, 3)), zorder=1)
        left, right = axes.get_xlim()
        room = math.log(scene.budget_s / left) > 0.3 * math.log(right / left)
        axes.annotate(
            "equal time",
            (scene.budget_s, 1.0),
            (-5.0 if room else 5.0, -2.0),
            xycoords=("data", "axes fraction"),
            textcoords="offset points",
            ha="right" if room else "left",
            va="top",
            color=MUTED,
            fontsize=9,
        )


def tick(axis: Any, words: Callable[[float], str], most: float = 8.0) -> None:
    """Put ticks on a logarithmic axis at 1, 2 and 5 times powers of ten.

    If these are more than ``most`` ticks, only powers of ten get a tick. The function ``words`` formats the number at a
    tick.
    """
    ticker = optional("matplotlib.ticker")
    low, high = axis.get_view_interval()
    decades = math.log10(high / low)
    steps, count = ((1.0, 2.0, 5.0), 20) if 3.0 * decades < most else ((1.0,), max(2, round(most)))
    axis.set_major_locator(ticker.LogLocator(subs=steps, numticks=count))
    axis.set_major_formatter(ticker.FuncFormatter(lambda value, _: words(value)))
    axis.set_minor_formatter(ticker.NullFormatter())


_SHOWN = "curve "
"""Prefix of labels in Matplotlib, which omits labels with a leading underscore from legends."""


def _add_legend(axes: Axes) -> None:
    legend = axes.legend(frameon=False, labelcolor=INK, fontsize=9)
    for text in legend.get_texts():
        text.set_text(text.get_text().removeprefix(_SHOWN))
        text.set_parse_math(False)  # dollar signs in a name are no formula
