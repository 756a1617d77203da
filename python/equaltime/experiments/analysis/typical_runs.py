"""Gains of typical runs: how much less time the standard strategy needs than the baseline, where they end.

A gain needs no time to a given error, so it is often known where no speed-up is.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from equaltime.experiments.analysis.sentences import compared, joined, listed, where
from equaltime.experiments.model.summary import SceneResult, StrategyResult
from equaltime.statistics.curves import BELOW, INDEPENDENT, TOO_NOISY
from equaltime.statistics.in_words import about
from equaltime.statistics.intervals import UNKNOWN, product_mean, sound
from equaltime.statistics.runs import MISSING
from equaltime.words import duration, percent

__all__ = [
    "Found",
    "beside_nearest_rival",
    "elsewhere",
    "grows",
    "standards",
    "typical_ends",
    "typical_gain",
    "with_gain",
]

Found = tuple[SceneResult, StrategyResult]
"""A scene, and a strategy on it."""


def typical_gain(scenes: Sequence[SceneResult]) -> str:
    """Return a sentence on the median efficiency of the standard strategy; empty if none is trusted."""
    found = with_gain(scenes)
    if not found:
        return ""
    labels, baseline = _named(found), joined(scene.baseline for scene, _ in found)
    place = where([scene.name for scene, _ in found], len(scenes))
    gain = product_mean([strategy.efficiency for _, strategy in found])
    return (
        f"{place}, {compared(f'a typical run of {labels}', gain, baseline)}, to the error that it has {_end(found)}; "
        f"the error of {baseline} is taken to fall as 1/sqrt(time)."
    )


def _named(found: Sequence[Found]) -> str:
    """Return the labels of strategies; of different ones with their scenes: ``tree (on lamps) or power (on room)``."""
    scenes = {strategy.label: [scene.name for scene, s in found if s.label == strategy.label] for _, strategy in found}
    if len(scenes) == 1:
        return next(iter(scenes))
    return joined(f"{label} (on {listed(names)})" for label, names in scenes.items())


def _end(found: Sequence[Found]) -> str:
    """Return the time at which runs ended, and on one scene the error measured there: the last point of the curve."""
    if len(found) == 1:
        curve = found[0][1].curve
        error = curve.error[-1].value
        measured = f" (measured {percent(error)})" if 0.0 < error < math.inf else ""
        return f"after {duration(curve.seconds[-1].value)}{measured}"
    ends = {duration(scene.other_end(strategy) or scene.budget_s) for scene, strategy in found}
    return f"after {ends.pop()}" if len(ends) == 1 else "at the end of its runs"


def elsewhere(scenes: Sequence[SceneResult], target: float) -> str:
    """Return sentences on the ``scenes`` that an answer leaves out; empty without any.

    They give the gain of typical runs, or the reason why no speed-up to the error ``target`` is known.
    """
    found = with_gain(scenes)
    lacking = [scene for scene in scenes if scene not in [one for one, _ in found]]
    told = []
    if found:
        place = found[0][0].name if len(found) == 1 else f"{len(found)} other scenes (geometric mean)"
        gain = product_mean([strategy.efficiency for _, strategy in found])
        faster = compared(f"a typical run of {_named(found)}", gain, joined(scene.baseline for scene, _ in found))
        told.append(f"On {place}, {faster}, to the error at its end.")
    if lacking:
        place = lacking[0].name if len(lacking) == 1 else f"{len(lacking)} other scenes"
        reasons = {_why_unknown(scene, target) for scene in lacking}
        told.append(f"On {place}, no speed-up is known: {reasons.pop() if len(reasons) == 1 else _CANNOT_TELL}.")
    return " ".join(told)


def beside_nearest_rival(scene: SceneResult) -> str:
    """Return a sentence that compares typical runs of the baseline with the unbiased strategy that comes nearest to it.

    It is for a baseline that is the standard too. The text is empty if no efficiency is trusted.
    """
    rivals = [s for s in scene.strategies if s.label != scene.baseline and not s.biased and sound(s.efficiency)]
    if not rivals:
        return ""
    nearest = max(rivals, key=lambda one: one.efficiency.value)
    gain = nearest.efficiency.map(lambda efficiency: 1.0 / efficiency)
    return f"In typical runs, {compared(scene.baseline, gain, nearest.label)}, to the error at the end of the runs."


_CANNOT_TELL = "these runs cannot tell"


def _why_unknown(scene: SceneResult, target: float) -> str:
    """Return in a few words why no speed-up of a scene's standard to the error ``target`` is known."""
    if scene.standard is None:
        return "all strategies are biased"
    if scene.standard == scene.baseline:
        return f"{scene.baseline} is the baseline"
    pair = [one for one in scene.strategies if one.label in (scene.standard, scene.baseline)]
    if any(one.ratio.get(target, UNKNOWN).bound == "low" for one in pair):
        return "there is only a limit"
    notes = "; ".join(one.time_to.get(target, UNKNOWN).note for one in pair)
    if TOO_NOISY in notes or BELOW in notes:
        return "the reference is too noisy"
    if MISSING in notes:
        return "images may lack light"
    late = [one.label for one in pair if math.isinf(one.time_to.get(target, UNKNOWN).value)]
    return f"{joined(late)} does not reach {percent(target)}" if late else _CANNOT_TELL


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
    several = len({strategy.label for _, strategy in found}) > 1
    least, most = (
        f"{about(strategy.efficiency)} times on {scene.name}{f' ({strategy.label})' if several else ''}"
        for scene, strategy in (found[0], found[-1])
    )
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
