"""Sentences of verdicts on strategies and renderers whose pictures differ, and by how much."""

from __future__ import annotations

import math
from collections.abc import Sequence

from equaltime.experiments.analysis.disagreement import NEGLIGIBLE, least_error, off_by
from equaltime.experiments.analysis.sentences import joined
from equaltime.experiments.model.summary import SceneResult, StrategyResult
from equaltime.statistics.in_words import probability, read_off
from equaltime.statistics.intervals import UNKNOWN, Interval, sound
from equaltime.words import percent

__all__ = ["biased_leaders", "differing_renderers", "other_pictures", "size_of"]

_Found = tuple[SceneResult, StrategyResult]


def other_pictures(scenes: Sequence[SceneResult]) -> tuple[str, ...]:
    """Return notes on strategies whose pictures differ from the standard's, but for those that are biased.

    A strategy of equaltime's own is unbiased by its words. So the likely reason is light that its samples have not met.
    Renderers that failed the test of agreement are named apart (`differing_renderers`).
    """
    found = [
        (scene, strategy)
        for scene, strategy in _all(scenes)
        if strategy.unequal and not strategy.disagrees and not strategy.biased
    ]
    standard = joined(scene.standard or "" for scene in scenes)
    theirs = _not_the_picture_of(standard, [one for one in found if one[1].renderer != "core"], len(scenes))
    said = [differing_renderers(scenes), theirs]
    if ours := [f"{_named(one, len(scenes))} {_probability(one[1])}" for one in found if one[1].renderer == "core"]:
        said.append(f"Unlike {standard}, by a bias or because few samples met some light: {', '.join(ours)}.")
    return tuple(filter(None, said))


def biased_leaders(scenes: Sequence[SceneResult]) -> str:
    """Return sentences on biased strategies with the lowest error at equal time; empty without any.

    They tell the bias, to which the error of such a strategy falls.
    """
    told = []
    for scene in scenes:
        measured = [one for one in scene.strategies if one.error_at_budget.value > 0.0]
        first = min(measured, key=lambda one: one.error_at_budget.value, default=None)
        if first is not None and first.biased:
            on = f" on {scene.name}" if len(scenes) > 1 else ""
            how = read_off(*(one.error_at_budget for one in measured))
            told.append(
                f"{first.label}{on} has the lowest {how} error at equal time, and {_kept(first.bias)}: more time "
                "takes its error to that bias, not to 0."
            )
    return " ".join(told)


def _kept(bias: Interval | None) -> str:
    """Return in words that a bias is kept, with its size or its upper limit."""
    if bias is not None and bias.bound == "high":
        return f"keeps a bias of at most {percent(bias.high)}"
    return f"keeps a bias of {off_by(bias) if bias is not None and sound(bias) else 'unknown size'}"


def differing_renderers(scenes: Sequence[SceneResult]) -> str:
    """Return sentences on the renderers that failed the test of agreement with equaltime; empty if there are none.

    Each sentence tells which errors and times are not given for that reason.
    """
    found = [one for one in _all(scenes) if one[1].disagrees]
    if not found:
        return ""
    different = _not_the_picture_of("equaltime", found, len(scenes)) + _filter_hint(found)
    if len(found) > 1:
        return f"{different} Errors below {NEGLIGIBLE:g} times the difference are not given, nor times to them."
    least = least_error(found[0][1].difference or UNKNOWN)
    if math.isinf(least):
        return f"{different} No error and no time is given for it."
    return f"{different} No error below {percent(least)} and no time to one is given for it."


def size_of(bias: Interval | None) -> str:
    """Return a bias in per cent with its interval, or its upper limit, or that it is not known."""
    if bias is None or (bias.bound != "high" and (not bias.trusted or bias.low <= 0.0)):
        return "(how much is not known)"
    off = off_by(bias)
    return f"is {off.replace(' (', ' off (', 1)}" if "(" in off else f"is off by {off}"


def _filter_hint(found: Sequence[_Found]) -> str:
    """Return a sentence on the box filter for commands that may not know it; empty if there are none.

    The scene of ``{json}`` has a box filter already.
    """
    commands = [strategy.name for _, strategy in found if strategy.renderer == "command"]
    if all("{filter}" in command or "{json}" in command for command in commands):
        return ""
    return " Such runs need a box filter, not the scene's own; {filter} in a command stands for it."


def _not_the_picture_of(standard: str, found: Sequence[_Found], scenes: int) -> str:
    """Return a sentence on renderers whose pictures differ, with the difference or its p-value; empty without any."""
    told = ", ".join(f"{_named(one, scenes)} {_off(one[1])}" for one in found)
    return f"Not the picture of {standard}: {told}." if told else ""


def _off(strategy: StrategyResult) -> str:
    size = strategy.difference if strategy.disagrees else strategy.bias
    known = size is not None and (size.bound == "high" or (size.trusted and size.low > 0.0))
    return size_of(size) if known else _probability(strategy)


def _probability(strategy: StrategyResult) -> str:
    return "" if strategy.picture_p is None else f"({probability(strategy.picture_p)})"


def _named(one: _Found, scenes: int) -> str:
    scene, strategy = one
    return f"{strategy.label} on {scene.name}" if scenes > 1 else strategy.label


def _all(scenes: Sequence[SceneResult]) -> list[_Found]:
    return [(scene, strategy) for scene in scenes for strategy in scene.strategies]
