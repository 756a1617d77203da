"""Sentences of verdicts that name the best strategy of each scene, where a reader may take another one for it."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from equaltime.experiments.analysis.sentences import listed
from equaltime.experiments.model.summary import SceneResult, StrategyResult
from equaltime.statistics.in_words import in_time
from equaltime.statistics.intervals import Interval, product_mean, sound, sound_below
from equaltime.statistics.runs import TYPICAL
from equaltime.strategy import PRESETS
from equaltime.words import percent

__all__ = ["best_per_scene", "fastest", "is_own", "quotient"]

_MOST_EQUAL = 3
"""Largest number of equally good strategies that a sentence names as the best of a scene."""

_KNOWN, _RUNS = " of those whose time is known", " in typical runs"

_Measure = Callable[[StrategyResult], Interval]


@dataclass(frozen=True)
class _Winners:
    scene: str
    strategies: tuple[StrategyResult, ...]
    """The best strategy, and those whose intervals overlap with its interval."""
    value: Interval
    """The best of their numbers."""
    among: str
    """Words on what was compared: `_KNOWN` if another strategy may be better, `_RUNS` if numbers are medians of runs
    and rare events are left out, both or none."""

    @property
    def labels(self) -> tuple[str, ...]:
        """Labels of the strategies."""
        return tuple(strategy.label for strategy in self.strategies)


def fastest(scenes: Sequence[SceneResult], target: float) -> str:
    """Return a sentence that names the strategy that first reaches the error ``target`` on each scene.

    Strategies whose intervals overlap with the first one's are named with it. The text is empty if the verdict says as
    much already: the standard is the fastest on every scene, alone or together with the baseline. If the user compares
    a method of their own, the sentence is always given. On a single scene other renderers do not count, because another
    sentence names them.
    """
    pairs = [(scene, one) for scene in scenes if (one := _winners(scene, lambda s: s.time_to[target])) is not None]
    found, alone = [one for _, one in pairs], len(scenes) == 1
    beaten = any(scene.standard not in one.labels for scene, one in pairs)
    equal = any(_is_rival(scene, strategy, alone) for scene, one in pairs for strategy in one.strategies)
    if not found or not (beaten or equal or any(_has_own(scene, alone) for scene in scenes)):
        return ""
    among = "".join(words for words in (_KNOWN, _RUNS) if any(words in one.among for one in found))
    time = f", {in_time(found[0].value)}" if alone and beaten else ""
    return f"Fastest to {percent(target)}{among}: {_told(found, len(scenes))}{time}."


def best_per_scene(scenes: Sequence[SceneResult]) -> str:
    """Return a sentence that names the strategy of the best efficiency on each of several scenes.

    The text is empty for one scene, and if one strategy is the best on all.
    """
    found = [
        one
        for scene in scenes
        if (one := _winners(scene, lambda s: s.efficiency.map(lambda gain: 1.0 / gain if gain else math.inf)))
    ]
    if len(scenes) == 1 or len(found) < 2 or set.intersection(*(set(one.labels) for one in found)):
        return ""
    return f"Best on each scene: {_told(found, len(scenes))}."


def _winners(scene: SceneResult, measure: _Measure) -> _Winners | None:
    """Return the strategies with the smallest numbers; None if there is nothing to rank.

    A ranking needs two known numbers, or a single one that all others are surely above.

    A strategy is as good as the one with the smallest number if their intervals overlap. A test of pairs would be
    narrower, but does not hold for the smallest of several numbers, which is chosen after the runs.
    Medians of typical runs are compared with means of other strategies. Means are given where rare events make little
    of the error, and are the numbers of typical runs too.
    """
    rivals = [(s, measure(s)) for s in scene.strategies if not s.disagrees or sound(measure(s))]
    known = [(s, number) for s, number in rivals if sound(number)]
    if not known:
        return None
    _, least = min(known, key=lambda one: one[1].value)
    unknown = any(not sound(number) and not _is_above(number, least) for _, number in rivals)
    if len(rivals) < 2 or (unknown and len(known) < 2):
        return None
    best = [(s, number) for s, number in known if number.low <= least.high]
    typical = any(TYPICAL in number.note for _, number in best)
    return _Winners(scene.name, tuple(s for s, _ in best), least, _KNOWN * unknown + _RUNS * typical)


def _is_above(number: Interval, least: Interval) -> bool:
    """Tell whether a number is surely above ``least``: by its lower end, or because it is never reached."""
    valid = sound(number) or sound_below(number) or (number.trusted and math.isinf(number.value))
    return valid and number.low > least.high


def quotient(number: Interval, other: Interval) -> Interval | None:
    """Return the ratio of two independently measured numbers; None if a number or the ratio is not trusted."""
    if not (sound(number) and sound(other)):
        return None
    square = product_mean([number, other.map(lambda value: 1.0 / value)])
    return found if sound(found := square.map(lambda root: root**2).telling()) else None


def _has_own(scene: SceneResult, alone: bool) -> bool:
    """Tell whether a method of one's own takes part beside standard and baseline: a renderer, or no plain preset.

    ``alone`` tells that the scene is the only one, on which other renderers have a sentence of their own.
    """
    return any(is_own(scene, one) and _is_rival(scene, one, alone) for one in scene.strategies)


def _is_rival(scene: SceneResult, strategy: StrategyResult, alone: bool) -> bool:
    """Tell whether a strategy is neither standard nor baseline, nor another renderer with a sentence of its own.

    ``alone`` tells that the scene is the only one, on which other renderers have such a sentence.
    """
    return strategy.label not in (scene.standard, scene.baseline) and not (alone and strategy.renderer != "core")


def is_own(scene: SceneResult, strategy: StrategyResult) -> bool:
    """Tell whether a strategy is a method of one's own: a renderer or no plain preset, nor standard or baseline."""
    known = strategy.renderer == "core" and strategy.label in PRESETS
    return not known and strategy.label not in (scene.standard, scene.baseline)


def _told(found: Sequence[_Winners], scenes: int) -> str:
    """Return the best strategies with their scenes: ``best on box and room, mine on hall``."""
    places: dict[str, list[str]] = {}
    for one in found:
        count = len(one.strategies)
        text = listed([s.named for s in one.strategies]) if count <= _MOST_EQUAL else f"{count} strategies"
        places.setdefault(f"{text} (their intervals overlap)" if count > 1 else text, []).append(one.scene)
    return ", ".join(text if scenes == 1 else f"{text} on {listed(names)}" for text, names in places.items())
