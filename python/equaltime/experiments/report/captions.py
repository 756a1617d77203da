"""Captions of pictures: the error of the one run that is shown, and the error of all runs together."""

from __future__ import annotations

import math

from equaltime.experiments.model.summary import StrategyResult
from equaltime.experiments.report.words import error_cell, marked, percent, seconds
from equaltime.statistics.intervals import Interval

__all__ = ["mean_of_runs", "short_caption", "this_run"]

_UNKNOWN = "error unknown"
_BELOW = "below what the reference can show"


def this_run(strategy: StrategyResult) -> str:
    """Return error, time and samples of the run that a picture shows: ``this run: 4.1 % after 0.6 s, 38 spp``.

    The text is empty if that run is not known.
    """
    if strategy.image_seconds is None or not strategy.curve.spp:
        return ""
    return f"this run: {_run_error(strategy)} after {seconds(strategy.image_seconds)}, {strategy.curve.spp[-1]} spp"


def mean_of_runs(strategy: StrategyResult) -> str:
    """Return the last point of a strategy's curve in words: ``the mean of 6 runs: 4.3 % after 0.7 s``.

    The mean is the root mean square of the runs' errors. The text is empty for a single run.
    """
    said = _mean_error(strategy, strategy.curve.error[-1]) if strategy.curve.error else ""
    if not said:
        return ""
    return f"the mean of {strategy.repeats} runs: {said} after {seconds(strategy.curve.seconds[-1].value)}"


def short_caption(strategy: StrategyResult, budget: float) -> str:
    """Return the error of the run that a picture shows, and the table's error, in two short lines for a narrow figure.

    Each error has its time: the end of the run, and the equal time ``budget`` in seconds of the table. Errors below
    what the reference can show are left out. The text is empty if no error is left.
    """
    lines = []
    if (error := _run_error(strategy)) not in (_UNKNOWN, _BELOW):
        time = "" if strategy.image_seconds is None else f" in {seconds(strategy.image_seconds)}"
        lines.append(f"this run: {error}{time}")
    equal = strategy.error_at_budget
    if (error := _mean_error(strategy, equal)) not in ("", _BELOW):
        lines.append(f"mean of {strategy.repeats}: {marked(error, equal)} in {seconds(budget)}")
    return "\n".join(lines)


def _run_error(strategy: StrategyResult) -> str:
    error = strategy.image_error
    if error is None:
        return _UNKNOWN
    return "exact" if error == 0.0 else percent(error) if error > 0.0 else _BELOW


def _mean_error(strategy: StrategyResult, error: Interval) -> str:
    """Return an error of several runs, with the table's digits and without interval; empty if it is not known."""
    if strategy.repeats < 2 or not math.isfinite(error.value):
        return ""
    cell = error_cell(error)
    if cell.state == "trusted":
        return cell.text
    return percent(error.value) if error.value > 0.0 else _BELOW
