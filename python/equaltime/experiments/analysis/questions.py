"""Verdicts of experiments that ask for bias, samples or efficiency, and not for the time to an error."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Final

from equaltime.experiments.analysis.pictures import differing_renderers, size_of
from equaltime.experiments.analysis.sentences import Answer, equal_samples, joined, less_time, listed, times
from equaltime.experiments.model.summary import SceneResult, StrategyResult
from equaltime.statistics.in_words import figure
from equaltime.statistics.intervals import Interval, product_mean, sound
from equaltime.statistics.runs import TYPICAL
from equaltime.words import percent

__all__ = ["NO_RARE_PATHS", "bias_verdict", "efficiency_verdict", "samples_verdict"]

NO_RARE_PATHS: Final = 'an experiment with question = "bias" declares that its scenes have no rare bright paths'
"""Reason why such an experiment tests strategies with heavy tails too."""


def bias_verdict(scenes: Sequence[SceneResult], level: float) -> Answer:
    """Return the strategies found biased; the notes name those not found biased, and those not tested.

    A strategy is biased if its expected image differs from the expected image of the scene's standard strategy, which
    is usually ``best``. ``level`` is the false-alarm rate of all these tests together. Biases of which only an upper
    limit is known have a sentence of their own, and so has a renderer that failed the test of agreement with equaltime.
    If no strategy was found biased, the first note is the answer. A note names strategies with heavy tails.
    """
    found, limited, right, untested = [], [], [], []
    for scene, strategy in _others(scenes):
        on = f" on {scene.name}" if len(scenes) > 1 else ""
        if strategy.disagrees:
            continue  # told by its own sentence: that test is another one
        if strategy.equality_p is None:
            untested.append(f"{strategy.label}{on}{f' ({strategy.notes[0]})' if strategy.notes else ''}")
        elif strategy.unequal and strategy.bias is not None and strategy.bias.bound == "high":
            limited.append(f"{strategy.label}{on}{_at_most(strategy.bias)}")
        elif strategy.unequal:
            found.append(f"{strategy.label}{on} {size_of(strategy.bias)}")
        else:
            right.append(f"{strategy.label}{on}{_at_most(strategy.bias)}")
    standard = joined(scene.standard or "no strategy" for scene in scenes)
    said = [
        (beginning, items, together)
        for beginning, items, together in (
            (f"{_cause(scenes)}, however long it renders: ", found, ", ".join),
            (f"Biased{' too' if found else ''}, by an amount of which only a limit is known: ", limited, ", ".join),
            ("No bias was found in ", right, listed),
            ("Not tested: ", untested, ", ".join),
        )
        if items
    ]
    notes = [f"{beginning}{together(items)}." for beginning, items, together in said[1:]]
    if found or limited or right:
        notes.append(f"Compared with {standard}; the risk of a false alarm is {figure(100.0 * level)} %.")
    notes += filter(None, [_heavy(scenes), *map(_hidden, scenes), differing_renderers(scenes)])
    if said:
        return Answer.listing(*said[0]).noted(notes)
    return Answer.of(notes[:1] or ["No other strategy was compared."], notes[1:])


def _at_most(bias: Interval | None) -> str:
    """Return the upper limit of a bias, in brackets; empty if it is not known."""
    if bias is None or not (bias.trusted or bias.bound == "high") or not 0.0 < bias.high < math.inf:
        return ""
    return f" (at most {percent(bias.high)})"


def _heavy(scenes: Sequence[SceneResult]) -> str:
    """Return a sentence on the strategies that take part in a test although their errors have heavy tails; or empty."""
    labels = dict.fromkeys(one.label for scene in scenes for one in scene.strategies if one.tail_share > 0.0)
    if not labels:
        return ""
    return f"Compared despite a heavy tail: {listed([*labels])}; {NO_RARE_PATHS}."


def _hidden(scene: SceneResult) -> str:
    """Return a sentence if the reference's noise hides the size of a bias that was found; else empty."""
    limited = any(one.unequal and one.bias is not None and one.bias.bound == "high" for one in scene.strategies)
    if not (limited and scene.reference_error > 0.0):
        return ""
    return (
        f"Where only a limit of a bias is told, noise hides its size: the reference of {scene.name} has an error of "
        f"{percent(scene.reference_error)}."
    )


def _cause(scenes: Sequence[SceneResult]) -> str:
    """Return the beginning of the sentence on biased strategies: their common cause, if all of them cut paths."""
    names = [strategy.name for _, strategy in _others(scenes) if strategy.unequal]
    return "Cutting paths makes the picture wrong" if all("truncate=" in name for name in names) else "Wrong picture"


def samples_verdict(scenes: Sequence[SceneResult]) -> Answer:
    """Return a sentence on the factor by which each strategy needs fewer samples than the baseline at equal error.

    The baseline is the strategy with which the experiment compares all others.
    """
    said = []
    for scene, strategy in _others(scenes, baseline=True):
        on = f" on {scene.name}" if len(scenes) > 1 else ""
        said.append(f"{strategy.label}{on} {_fewer(strategy.fewer_samples, scene.equal_samples(strategy))}")
    beginning = f"For the same error, compared with {joined(scene.baseline for scene in scenes)}: "
    counts = (scene.equal_samples(strategy) for scene, strategy in _others(scenes, baseline=True))
    return Answer.listing(beginning, said, ", ".join).noted([equal_samples(counts)])


def efficiency_verdict(scenes: Sequence[SceneResult]) -> Answer:
    """Return a sentence with each strategy's gain: the baseline's squared error x time, divided by the strategy's.

    The baseline is the strategy with which the experiment compares all others. With several scenes, each gain is a
    geometric mean over scenes. The standard strategy (``best``, if unbiased) comes first, with its smallest and largest
    gain.
    """
    baseline = joined(scene.baseline for scene in scenes)
    found: dict[str, list[tuple[str, Interval]]] = {}
    for scene, strategy in _others(scenes, baseline=True):
        found.setdefault(strategy.label, []).append((scene.name, strategy.efficiency))
    standards = {scene.standard for scene in scenes}
    ordered = sorted(found, key=lambda one: one not in standards)
    said = [_gain(label, found[label], len(scenes), label in standards) for label in ordered]
    average = f", on average over {len(scenes)} scenes (geometric mean)" if len(scenes) > 1 else ""
    beginning = f"For the same error, compared with typical runs of {baseline}{average}: "
    return Answer.listing(beginning, said, ", ".join)


def _gain(label: str, found: Sequence[tuple[str, Interval]], scenes: int, ends: bool) -> str:
    """Return the mean gain of one strategy; with ``ends``, and several scenes, also its smallest and largest gain."""
    known = [(name, interval) for name, interval in found if sound(interval)]
    if not known:
        return f"{label} cannot be told ({found[0][1].note})"
    text = f"{label} needs {less_time(product_mean([interval for _, interval in known]))}"
    if len(known) < scenes:
        text += f" on {len(known)} of {scenes} scenes"
    if ends and len(known) > 1:
        extremes = [pick(known, key=lambda one: one[1].value) for pick in (min, max)]
        text += f", from {' to '.join(f'{_plain(gain)} on {name}' for name, gain in extremes)}"
    return text


def _plain(gain: Interval) -> str:
    """Return a gain without its interval: ``4.1 times less``."""
    less = gain.value >= 1.0
    return f"{figure(gain.value if less else 1.0 / gain.value)} times {'less' if less else 'more'}"


def _others(scenes: Sequence[SceneResult], baseline: bool = False) -> Iterator[tuple[SceneResult, StrategyResult]]:
    for scene in scenes:
        for strategy in scene.strategies:
            if strategy.label != (scene.baseline if baseline else scene.standard):
                yield scene, strategy


def _fewer(ratio: Interval, samples: int | None) -> str:
    """Return how many times fewer samples a strategy needs.

    A ratio of typical runs depends on the number of ``samples`` per pixel that both strategies have there: the variance
    may be infinite.
    """
    if math.isinf(ratio.value):
        return "needs one sample (it is exact)"
    if not ratio.trusted:
        if ratio.bound == "low":
            return f"needs at least {figure(ratio.low)} times fewer samples"
        if ratio.bound == "high" and ratio.high < 1.0:
            return f"needs at least {figure(1.0 / ratio.high)} times more samples"
        return f"cannot be told ({ratio.note})"
    count = "" if samples is None else f" with {samples:,} samples"
    typical = f" by typical runs of both{count}, without rare bright ones" if TYPICAL in ratio.note else ""
    return f"needs {times(ratio, 'fewer samples', 'more samples')}{typical}"
