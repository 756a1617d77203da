"""Charts on logarithmic axes: the error against time, and the times to one error on all scenes."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from equaltime.experiments.analysis.sentences import listed
from equaltime.experiments.model.summary import SceneResult, StrategyResult, Summary
from equaltime.experiments.report.looks import GRID, INK, MUTED, Style
from equaltime.experiments.report.telling import says_slower
from equaltime.experiments.report.words import measured_cell, percent, seconds
from equaltime.extras import optional
from equaltime.statistics.intervals import UNKNOWN, Interval
from equaltime.statistics.runs import TYPICAL

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = [
    "clearest",
    "curve_titles",
    "draw_curves",
    "draw_dots",
    "has_dots",
    "has_pale_points",
    "has_typical_times",
    "is_drawn",
    "places_along",
    "tick",
    "unmarked",
    "with_one_point",
    "without_curve",
]


def draw_curves(
    scene: SceneResult,
    targets: Sequence[float],
    looks: Mapping[str, Style],
    size: tuple[float, float],
    *,
    legend: bool,
) -> Figure:
    """Draw the error of all strategies of a scene against time, and return the figure.

    Errors are drawn against samples per pixel where the scene asks for it (`SceneResult.against_samples`). ``targets``
    are errors, drawn as horizontal lines. ``looks`` gives colour, marker and line style by label of a strategy.
    ``size`` is width and height in inches, and ``legend`` tells whether to draw a legend. Points are pale, and have no
    band, if a table prints no number with an interval for them. A curve without points has no entry in the legend. In
    the SVG, the points of each curve are in the groups that `curve_titles` names.
    """
    figure: Figure = optional("matplotlib.figure").Figure(figsize=size, layout="constrained", facecolor="none")
    axes = figure.add_subplot(facecolor="none")
    for order, strategy in enumerate(scene.strategies):
        _draw_curve(axes, scene, strategy, looks[strategy.label], order)
    _scale(axes, scene)
    _frame(axes, ("left", "bottom"))
    _draw_marks(axes, scene, targets)
    tick(axes.xaxis, _count_words if scene.against_samples else seconds, min(_MOST_TICKS, _TIMES_AN_INCH * size[0]))
    tick(axes.yaxis, percent)
    axes.set_xlabel("samples per pixel" if scene.against_samples else "time, first sample to image", color=INK)
    axes.set_ylabel("error (root mean square of the runs)", color=INK)
    if legend:
        _add_legend(axes, has_pale_points(scene))
        if has_typical_times(scene):
            figure.supxlabel(_TYPICAL_TIMES, fontsize=7, color=INK)
    return figure


def curve_titles(order: int, strategy: StrategyResult) -> dict[str, list[str]]:
    """Return a tooltip for each drawn point of a strategy's curve: error, time and samples per pixel.

    ``order`` is the index of the strategy in the scene's results. The tooltips are by the id of the SVG group that
    holds their points: one group for the points with a trusted interval, one for the others.
    """
    curve = strategy.curve
    titles = [
        f"{strategy.label}: {measured_cell(curve.error[i])} after {seconds(curve.seconds[i].value)}, {curve.spp[i]} spp"
        for i in _drawn(strategy)
    ]
    return {
        _curve_gid(order, pale): [titles[place] for place in _places(strategy, pale=pale)] for pale in (False, True)
    }


def has_pale_points(scene: SceneResult) -> bool:
    """Tell whether `draw_curves` draws any pale point: one whose interval cannot be trusted."""
    return any(_places(strategy, pale=True) for strategy in scene.strategies)


def is_drawn(strategy: StrategyResult) -> bool:
    """Tell whether `draw_curves` draws any point of a strategy's curve."""
    return bool(_drawn(strategy))


def without_curve(scene: SceneResult) -> str:
    """Return a sentence on each strategy without any point in the chart, with the reason; empty without such ones."""
    told = []
    for strategy in scene.strategies:
        if not is_drawn(strategy):
            exact = all(error.trusted and error.value == 0.0 for error in strategy.curve.error)
            unknown = "it is exact from its first image on" if exact else "none of its errors is known"
            why = next((error.note for error in strategy.curve.error if error.note), unknown)
            told.append(f"{strategy.label} has no curve: {why}.")
    return " ".join(told)


def with_one_point(scene: SceneResult) -> str:
    """Return a sentence on the strategies that have a single point in the chart; empty without such ones."""
    names = [strategy.label for strategy in scene.strategies if len(_drawn(strategy)) == 1]
    if not names:
        return ""
    have = "have one point each" if len(names) > 1 else "has one point"
    return f"{listed(names)} {have}: no slope can be told, and no line drawn."


def has_typical_times(scene: SceneResult) -> bool:
    """Tell whether any time to an error is a median over repeats, and so not where the drawn curve has that error."""
    return any(TYPICAL in time.note for strategy in scene.strategies for time in strategy.time_to.values())


def _curve_gid(order: int, pale: bool = False) -> str:
    """Return the id of the SVG group of one strategy's points, trusted or ``pale``."""
    return f"curve-{order}-pale" if pale else f"curve-{order}"


def _drawn(strategy: StrategyResult) -> list[int]:
    """Return the indices of checkpoints with positive time and error, which logarithmic axes can show."""
    pairs = zip(strategy.curve.seconds, strategy.curve.error, strict=True)
    return [i for i, (time, error) in enumerate(pairs) if _positive(time.value) and _positive(error.value)]


def places_along(scene: SceneResult, strategy: StrategyResult) -> tuple[float, ...]:
    """Return where the points of a curve stand along the chart's lower axis: seconds, or samples per pixel."""
    curve = strategy.curve
    return tuple(map(float, curve.spp)) if scene.against_samples else tuple(time.value for time in curve.seconds)


def _count_words(count: float) -> str:
    return f"{count:,.3g}"


def _places(strategy: StrategyResult, pale: bool) -> list[int]:
    """Return the places, in the list of drawn points, of those with a trusted interval or of the ``pale`` others."""
    errors = (strategy.curve.error[i] for i in _drawn(strategy))
    return [place for place, error in enumerate(errors) if _is_pale(error) == pale]


def _is_pale(error: Interval) -> bool:
    """Tell whether a table prints a limit of this error, or no number, instead of a number with its interval."""
    return measured_cell(error).state != "trusted"


def _positive(value: float) -> bool:
    return math.isfinite(value) and value > 0.0


def _draw_curve(axes: Axes, scene: SceneResult, strategy: StrategyResult, look: Style, order: int) -> None:
    points = _drawn(strategy)
    along = places_along(scene, strategy)
    times = [along[i] for i in points]
    errors = [strategy.curve.error[i] for i in points]
    bands = [_band(error) for error in errors]
    axes.fill_between(
        times,
        [low for low, _ in bands],
        [high for _, high in bands],
        color=look.light,
        alpha=0.18,
        linewidth=0,
        gid=f"{_curve_gid(order)}-band",
    )
    values = [error.value for error in errors]
    sure = [math.nan if _is_pale(error) else error.value for error in errors]  # the line has a gap at each NaN
    style: dict[str, Any] = {
        "color": look.light,
        "marker": look.marker,
        "linestyle": "--" if strategy.biased and look.line == "-" else look.line,
        "markerfacecolor": "none" if strategy.biased else look.light,
        "markersize": 5.5,
        "linewidth": 1.8,
    }
    label = f"{_SHOWN}{strategy.named}{', one point' * (len(points) == 1)}" if points else None
    axes.plot(times, sure, **style, label=label, gid=_curve_gid(order), zorder=3)
    if pale := _places(strategy, pale=True):
        axes.plot(times, values, **style, markevery=pale, alpha=_PALE, gid=_curve_gid(order, pale=True), zorder=2.9)


def _band(error: Interval) -> tuple[float, float]:
    """Return the ends of the band at one point; the band of a pale point has zero width."""
    return (error.value, error.value) if _is_pale(error) else (max(error.low, 0.2 * error.value), error.high)


def _scale(axes: Axes, scene: SceneResult) -> None:
    """Make both axes logarithmic, with limits that include all points, all bands and the equal time."""
    times = [scene.budget_s] if _positive(scene.budget_s) and not scene.against_samples else []
    errors: list[float] = []
    for strategy in scene.strategies:
        for i in _drawn(strategy):
            times.append(places_along(scene, strategy)[i])
            errors.extend(_band(strategy.curve.error[i]))
    axes.set(xscale="log", yscale="log", xlim=_limits(times), ylim=_limits(errors))


def _limits(values: Sequence[float]) -> tuple[float, float]:
    """Return limits with a margin on both sides, more than a factor of 2 apart."""
    low, high = min(values, default=0.1), max(values, default=1.0)
    room = max((high / low) ** 0.06, 1.5 if high < 2.0 * low else 1.0)
    return low / room, high * room


def _frame(axes: Axes, sides: Sequence[str]) -> None:
    """Draw lines along these ``sides`` only, and a grid behind the data."""
    for name, spine in axes.spines.items():
        spine.set_visible(name in sides)
        spine.set_color(MUTED)
    axes.tick_params(which="both", colors=MUTED, labelcolor=INK)
    axes.grid(visible=True, which="major", color=GRID, linewidth=0.8)
    axes.set_axisbelow(True)


def _draw_marks(axes: Axes, scene: SceneResult, targets: Sequence[float]) -> None:
    """Mark the targets within the axes' limits, and the equal time on an axis of times."""
    low, high = axes.get_ylim()
    for target in targets:
        if low < target < high:
            axes.axhline(target, color=MUTED, linewidth=0.9, linestyle=(0, (1, 2)), zorder=1)
    if _positive(scene.budget_s) and not scene.against_samples:
        axes.axvline(scene.budget_s, color=MUTED, linewidth=0.9, linestyle=(0, (5, 3)), zorder=1)
        left, right = axes.get_xlim()
        room = math.log(scene.budget_s / left) > 0.3 * math.log(right / left)
        axes.annotate(
            f"equal time, {seconds(scene.budget_s)}",
            (scene.budget_s, 1.0),
            (0.0, 2.0),  # above the axes, where neither curves nor the legend are
            xycoords=("data", "axes fraction"),
            textcoords="offset points",
            ha="right" if room else "left",
            va="bottom",
            color=MUTED,
            fontsize=9,
        )


_MOST_TICKS = 8.0
"""Number of ticks from which an axis of curves has powers of ten alone."""
_TIMES_AN_INCH = 1.3
"""Labels of times per inch of a figure's width that do not touch."""


def tick(axis: Any, words: Callable[[float], str], most: float = _MOST_TICKS) -> None:
    """Put ticks on a logarithmic axis at 1, 2 and 5 times powers of ten.

    If these are more than ``most`` ticks, only powers of ten get a tick. If fewer than `_FEWEST_TICKS` are within the
    axis, more multiples of powers of ten get one, and in the end round numbers at equal distances. The function
    ``words`` formats the number at a tick.
    """
    ticker = optional("matplotlib.ticker")
    low, high = axis.get_view_interval()
    many = 3.0 * math.log10(high / low) < most
    found = (_multiples(low, high, steps) for steps in (_STEPS[2:] if many else _STEPS))
    places = next((ticks for ticks in found if len(ticks) >= _FEWEST_TICKS), None)
    if places is None:
        places = [place for place in ticker.MaxNLocator(4).tick_values(low, high) if low <= place <= high]
    axis.set_major_locator(ticker.FixedLocator(places[:: math.ceil(len(places) / max(2.0, most))]))
    axis.set_major_formatter(ticker.FuncFormatter(lambda value, _: words(value)))
    axis.set_minor_formatter(ticker.NullFormatter())


_FEWEST_TICKS = 3
"""Least number of labelled ticks of an axis: two do not show that it is logarithmic."""
_STEPS = ((1.0,), (1.0, 3.0), (1.0, 2.0, 5.0), (1.0, 1.5, 2.0, 3.0, 5.0, 7.0), tuple(map(float, range(1, 10))))
"""Multiples of powers of ten that get a tick: the first ones that give enough ticks."""


def _multiples(low: float, high: float, steps: Sequence[float]) -> list[float]:
    """Return the numbers from ``low`` to ``high`` that are one of the ``steps`` times a power of ten, ascending."""
    powers = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    return [place for power in powers for step in steps if low <= (place := float(f"{step}e{power}")) <= high]


_TYPICAL_TIMES = (
    "Curves are root mean squares of all runs. Times with \N{DAGGER} in tables are medians of typical runs:\n"
    "they are not where a curve crosses the error."
)
_SHOWN = "curve "
"""Prefix of labels in Matplotlib, which omits labels with a leading underscore from legends."""
_PALE = 0.6
"""Opacity of points whose interval cannot be trusted. Short runs may have no others, so that less is hard to read."""


def _add_legend(axes: Axes, pale: bool) -> None:
    if pale:
        axes.plot(
            [], [], color=MUTED, marker="o", markersize=5.5, linestyle="none", alpha=_PALE, label="pale: not trusted"
        )
    if not axes.get_legend_handles_labels()[0]:
        return  # no strategy has a curve
    # beside the axes: inside, it may lie on curves and lines
    legend = axes.legend(frameon=False, labelcolor=INK, fontsize=9, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    for text in legend.get_texts():
        text.set_text(text.get_text().removeprefix(_SHOWN))
        text.set_parse_math(False)  # dollar signs in a name are no formula


_ROW, _REST = 0.34, 0.75
"""Height of a scene's row, and of everything else, in inches."""
_LABELS = 2.2
"""Labels per inch of the time axis, which takes about half of the width."""
_LETTERS = 6.8
"""Letters of a scene's name per inch of the figure's width; names take about half of the width."""


def has_dots(summary: Summary, target: float) -> bool:
    """Tell whether the chart of times to the error ``target`` on all scenes (`draw_dots`) would have any dot.

    A dot stands for a time whose interval can be trusted.
    """
    return _count(summary, target) > 0


def unmarked(summary: Summary, target: float) -> dict[str, list[str]]:
    """Return, by strategy label, the names of the scenes on which the chart of times lacks a mark of that strategy.

    The chart (`draw_dots`) has times to the error ``target``. Strategies with a mark (dot or arrow) on every scene are
    left out.
    """
    found: dict[str, list[str]] = {}
    for scene in summary.scenes:
        for strategy in scene.strategies:
            time = strategy.time_to.get(target, UNKNOWN)
            if _trusted(time) is None and not _is_an_end(scene, target, time):
                found.setdefault(strategy.label, []).append(scene.name)
    return found


def clearest(summary: Summary) -> float | None:
    """Return the target error for which the chart of times (`draw_dots`) has the most dots; None if no target has one.

    If several targets have equally many dots, the smallest is returned.
    """
    counts = {target: _count(summary, target) for target in summary.targets}
    most = max(counts.values(), default=0)
    return min(target for target, count in counts.items() if count == most) if most else None


def draw_dots(summary: Summary, target: float, looks: Mapping[str, Style], width: float) -> Figure:
    """Draw the times of all strategies to the error ``target`` on all scenes, and return the figure.

    ``width`` is in inches. Hollow dots are estimated times, beyond the runs. Arrows are lower limits of times.
    ``looks`` gives colour, marker and line style by label of a strategy.
    """
    height = _REST + _ROW * len(summary.scenes)
    figure: Figure = optional("matplotlib.figure").Figure(
        figsize=(width, height), layout="constrained", facecolor="none"
    )
    axes = figure.add_subplot(facecolor="none")
    for label, look in looks.items():
        _draw_dots(axes, summary, target, label, look)
    _frame_rows(axes, [_short(scene.name, int(_LETTERS * width)) for scene in summary.scenes], target, width)
    return figure


def _count(summary: Summary, target: float) -> int:
    times = (strategy.time_to.get(target, UNKNOWN) for scene in summary.scenes for strategy in scene.strategies)
    return sum(_trusted(time) is not None for time in times)


def _draw_dots(axes: Axes, summary: Summary, target: float, label: str, look: Style) -> None:
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
    """Draw an arrow at each lower limit that shows that another strategy is faster."""
    times = [_time(scene, label, target) for scene in summary.scenes]
    rows = [row for row, scene in enumerate(summary.scenes) if _is_an_end(scene, target, times[row])]
    lows = [times[row].low for row in rows]
    axes.plot(lows, rows, color=look.light, marker=">", markerfacecolor="white", linestyle="none", zorder=4)


def _time(scene: SceneResult, label: str, target: float) -> Interval:
    times = (one.time_to.get(target, UNKNOWN) for one in scene.strategies if one.label == label)
    return next(times, UNKNOWN)


def _is_an_end(scene: SceneResult, target: float, time: Interval) -> bool:
    """Tell whether only the lower limit of the time is known, and shows that another strategy is faster."""
    return time.bound == "low" and 0.0 < time.low < math.inf and says_slower(scene, target, time)


def _trusted(time: Interval) -> Interval | None:
    """Return the time if it is trusted and finite, else None."""
    if not time.trusted or not (0.0 < time.value < math.inf and time.high < math.inf):
        return None
    return time


def _short(name: str, most: int) -> str:
    return name if len(name) <= most else name[: most - 1] + "\N{HORIZONTAL ELLIPSIS}"


def _frame_rows(axes: Axes, names: Sequence[str], target: float, width: float) -> None:
    axes.set(xscale="log", ylim=(len(names) - 0.5, -0.5))
    low, high = axes.get_xlim()
    if high < 3.0 * low:  # so that there is more than one tick
        axes.set_xlim(low / 1.5, high * 1.5)
    axes.set_yticks(range(len(names)), names)
    for text in axes.get_yticklabels():
        text.set_parse_math(False)
    _frame(axes, ("bottom",))
    axes.tick_params(axis="y", length=0)
    tick(axes.xaxis, seconds, 0.5 * _LABELS * width)
    axes.set_xlabel(f"time to an error of {percent(target)}", color=INK)
