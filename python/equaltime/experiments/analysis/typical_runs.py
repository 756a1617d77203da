"""Gains of typical runs: how much less time the standard strategy needs than the baseline, where they end.

A gain needs no time to a given error, so it is often known where no speed-up is.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from equaltime.experiments.analysis.sentences import joined, less_time, where
from equaltime.experiments.model.summary import SceneResult, StrategyResult
from equaltime.statistics.curves import INDEPENDENT
from equaltime.statistics.in_words import about
from equaltime.statistics.intervals import product_mean, sound
from equaltime.words import duration, percent

__all__ = ["Found", "grows", "standards", "typical_ends", "typical_gain", "with_gain"]

Found = tuple[SceneResult, StrategyResult]
"""A scene, and a strategy on it."""


def typical_gain(scenes: Sequence[SceneResult]) -> str:
    """Return a sentence on the median efficiency of the standard strategy; empty if none is trusted."""
    found = with_gain(scenes)
    if not found:
        return ""
    labels, baseline = joined(s.label for _, s in found), joined(scene.baseline for scene, _ in found)
    place = where([scene.name for scene, _ in found], len(scenes))
    gain = product_mean([strategy.efficiency for _, strategy in found])
    return (
        f"{place}, for the error that {labels} has {_end(found)}, a typical run of {labels} needs "
        f"{less_time(gain, f'one of {baseline}')}, if the error of {baseline} goes on to fall as 1/sqrt(time)."
    )


def _end(found: Sequence[Found]) -> str:
    """Return the time at which runs ended, and on one scene the error measured there: the last point of the curve."""
    if len(found) == 1:
        curve = found[0][1].curve
        error = curve.error[-1].value
        measured = f" (measured {percent(error)})" if 0.0 < error < math.inf else ""
        return f"after {duration(curve.seconds[-1].value)}{measured}"
    ends = {duration(scene.other_end(strategy) or scene.budget_s) for scene, strategy in found}
    return f"after {ends.pop()}" if len(ends) == 1 else "at the end of its runs"


def grows(scenes: Sequence[SceneResult]) -> str:
    """Return a sentence if the error of the standard surely falls faster than 1/sqrt(time) on all scenes."""
    found = [strategy for _, strategy in with_gain(scenes)]
    if not all(one.curve.slope.trusted and one.curve.slope.high < INDEPENDENT for one in found):
        return ""
    return (
        f"The error of {joined(one.label for one in found)} falls faster than 1/sqrt(time), so the gain is larger for "
        "smaller errors."
    )


def typical_ends(scenes: Sequence[SceneResult]) -> str:
    """Return a sentence on the smallest and the largest efficiency of the standard strategy; empty for one scene."""
    found = sorted(with_gain(scenes), key=lambda one: one[1].efficiency.value)
    if len(found) < 2:
        return ""
    least, most = (f"{about(one[1].efficiency)} times on {one[0].name}" for one in (found[0], found[-1]))
    return f"The gain is {least} to {most}."


def with_gain(scenes: Sequence[SceneResult]) -> list[Found]:
    """Return the scenes on which the standard strategy's efficiency is known, with the strategy."""
    return [
        (scene, strategy)
        for scene, strategy in standards(scenes)
        if strategy.label != scene.baseline and sound(strategy.efficiency)
    ]


def standards(scenes: Sequence[SceneResult]) -> Iterator[Found]:
    """Return each scene with its standard strategy."""
    return ((scene, s) for scene in scenes for s in scene.strategies if s.label == scene.standard)
