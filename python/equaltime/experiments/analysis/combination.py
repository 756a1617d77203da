"""Verdict of experiments that compare a combination of techniques, such as MIS, with its parts."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress

from equaltime.errors import StrategyError
from equaltime.experiments.analysis.sentences import Answer, equal_samples, joined, listed
from equaltime.experiments.model.summary import SceneResult, StrategyResult
from equaltime.statistics.curves import BELOW
from equaltime.statistics.in_words import about, figure
from equaltime.statistics.intervals import Interval, sound
from equaltime.statistics.runs import TYPICAL
from equaltime.strategy import Strategy

__all__ = ["combination_verdict"]

_SINGLE = ("uniform", "bsdf", "light")
"""Techniques that combine no others: a strategy with one of them can be a part of the combination."""

_MOST_UNKNOWN = 3
"""Largest number of scenes that the verdict names because their ratio is not known; tables show more of them better."""

_Ratio = Callable[[StrategyResult], Interval]
_Found = tuple[Interval, str, str]
"""Squared error of the combination over a part's, or an upper limit of it; label of the part; name of the scene."""


def combination_verdict(scenes: Sequence[SceneResult]) -> Answer:
    """Return how much worse the baseline, a combination of techniques, is at worst than the better of its parts.

    The parts are the strategies of a single technique. Two sentences tell the worst scene at equal samples and at equal
    time. Notes tell the equal count of samples, the scenes that tell nothing, and the scene on which each part alone is
    worst.
    """
    baseline = joined(scene.baseline for scene in scenes)
    parts = list(dict.fromkeys(part.label for scene in scenes for part in _parts(scene)))
    if not parts:
        why = "no other strategy has the technique bsdf, light or uniform"
        return Answer(f"{baseline} has no parts to compare with: {why}.")
    better = f"the better of {listed(parts)}" if len(parts) > 1 else parts[0]
    said = [
        f"Compared with {better}, {_worst(scenes, baseline, _in_samples, 'at equal samples')}.",
        f"At equal time, {_worst(scenes, baseline, _in_time)}.",
    ]
    known = (scene for scene in scenes if _behind(scene, _in_samples) is not None)
    counts = (scene.equal_samples(part) for scene in known for part in _parts(scene))
    notes = [equal_samples(counts), *_unknown(scenes)]
    if alone := [told for label in parts if (told := _alone(scenes, label))]:
        notes.append(f"At equal time, {listed(alone)} the squared error of {baseline}.")
    return Answer.of(said, (*notes, _typical(scenes)))


def _in_samples(part: StrategyResult) -> Interval:
    return part.fewer_samples


def _in_time(part: StrategyResult) -> Interval:
    return part.efficiency


def _typical(scenes: Sequence[SceneResult]) -> str:
    """Return a sentence if a ratio that is told is a median of repeats instead of a ratio of means; else empty."""
    ratios = (ratio for scene in scenes for part in _parts(scene) for ratio in (part.fewer_samples, part.efficiency))
    if not any(_is_told(ratio) and TYPICAL in ratio.note for ratio in ratios):
        return ""
    return "Where a few rare events make most of an error, the ratios are those of typical runs."


def _parts(scene: SceneResult) -> list[StrategyResult]:
    return [one for one in scene.strategies if one.label != scene.baseline and _technique(one) in _SINGLE]


def _technique(strategy: StrategyResult) -> str:
    """Return the technique of a strategy of equaltime; empty for another renderer or subject."""
    if strategy.renderer == "core":
        with suppress(StrategyError):  # a user's own subject may have any name
            return Strategy.parse(strategy.name).technique
    return ""


def _behind(scene: SceneResult, ratio: _Ratio) -> _Found | None:
    """Compare the baseline with the better part of a scene; None if it is open which part is better, or how much.

    ``ratio`` returns the baseline's squared error over a part's.
    """
    found = [(ratio(part), part.label, scene.name) for part in _parts(scene)]
    return max(found, key=_most) if found and all(_is_told(one) for one, *_ in found) else None


def _is_told(ratio: Interval) -> bool:
    """Tell whether a ratio is trusted, or known to be below 1: the part is then the worse one."""
    return sound(ratio) or (ratio.bound == "high" and 0.0 < ratio.high < 1.0)


def _most(found: _Found) -> float:
    """Return the ratio, or its upper limit if only that is known."""
    return found[0].value if sound(found[0]) else found[0].high


def _worst(scenes: Sequence[SceneResult], baseline: str, ratio: _Ratio, when: str = "") -> str:
    """Return the largest ratio in words, with its interval, part and scene; it tells if no scene shows a loss."""
    told = [one for scene in scenes if (one := _behind(scene, ratio)) is not None]
    when = f" {when}" if when else ""
    if not told:
        return f"the squared error of {baseline} cannot be compared{when}"
    worst, part, scene = max(told, key=_most)
    several = len(scenes) > 1
    against = f"against {part}{f' on {scene}' if several else ''}"
    has = f"{baseline} has{' at worst' if several else ''}"
    if not sound(worst):
        return f"{baseline} has at most {figure(worst.high)} times the squared error{when}, {against}"
    text = (
        f"{has} {about(worst)} times the squared error{when} ({figure(worst.low)} to {figure(worst.high)}), {against}"
    )
    if worst.low > 1.0 or worst.high < 1.0:
        return text
    if any(sound(one) and one.low > 1.0 for one, *_ in told):
        return f"{text}; this interval includes 1"
    return f"{text}; {baseline} is not shown to be worse{' on any scene' if several else ''}"


def _unknown(scenes: Sequence[SceneResult]) -> Iterator[str]:
    """Yield sentences that name the scenes whose ratio is not known, each with a reason."""
    in_samples, in_time = (
        [f"{scene.name}{_why(scene, ratio)}" for scene in scenes if _parts(scene) and _behind(scene, ratio) is None]
        for ratio in (_in_samples, _in_time)
    )
    if in_samples == in_time:
        yield from (f"Not known on {_few(in_time)}." for _ in in_time[:1])
        return
    for named, when in ((in_samples, "samples"), (in_time, "time")):
        if named:
            yield f"Not known at equal {when} on {_few(named)}."


def _why(scene: SceneResult, ratio: _Ratio) -> str:
    """Return a reason why a scene's ratio is not known, in brackets; empty without one."""
    for part in _parts(scene):
        found = ratio(part)
        if not _is_told(found) and (reason := _reason(found.note)):
            whose = {"baseline": scene.baseline, "this": part.label}
            side, colon, rest = reason.partition(": ")
            return f" ({whose[side]}: {rest})" if colon and side in whose else f" ({reason})"
    return ""


def _reason(note: str) -> str:
    """Return the reason in a note that has several: the reference's noise if it is among them, else the first."""
    reasons = [reason for reason in note.split("; ") if reason != TYPICAL]
    below = BELOW.partition("; ")[0]
    return next((reason for reason in reasons if reason.endswith(below)), reasons[0] if reasons else "")


def _few(named: Sequence[str]) -> str:
    shown = [*named[:_MOST_UNKNOWN]]
    if len(named) > _MOST_UNKNOWN:
        shown.append(f"{len(named) - _MOST_UNKNOWN} more")
    return listed(shown)


def _alone(scenes: Sequence[SceneResult], label: str) -> str:
    """Return how much worse a part is than the baseline on its worst scene, at equal time; empty if it is not known."""
    every = [(part.efficiency, label, scene.name) for scene in scenes for part in _parts(scene) if part.label == label]
    told = [one for one in every if _is_told(one[0])]
    if not told:
        return ""
    worst = min(told, key=_most)
    several = len(scenes) > 1
    sign = "at least " if not sound(worst[0]) else ""
    place = f" (its worst scene: {worst[2]})" if several else ""
    return f"{label} alone has {sign}{figure(1.0 / _most(worst))} times{place}"
