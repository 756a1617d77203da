"""Made-up scenes for verdicts, whose times and speed-ups are given, and what the verdict says of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from equaltime.experiments.analysis.sentences import LONGEST
from equaltime.experiments.analysis.verdict import verdict as answer_of
from equaltime.experiments.model.experiment import Question
from equaltime.experiments.model.summary import SceneResult, StrategyResult
from equaltime.statistics.intervals import UNKNOWN, Interval

from .fake_summary import curve

TARGETS = (0.1, 0.05)


TIME = Interval(0.5, 0.4, 0.6)


FAR = Interval(2.0, 1.5, 2.5, reach=3.0).noted("extrapolated 3 times beyond the longest run")


RATIO = Interval(30.0, 25.0, 36.0)


FAR_RATIO = replace(RATIO, reach=90.0).noted("baseline: extrapolated 90 times beyond the longest run by slope -1/2")


AT_LEAST = FAR_RATIO.bounded("low", "baseline: heavy tail")


def strategy(label: str, times: tuple[Interval, ...], ratios: tuple[Interval, ...], gain: Interval) -> StrategyResult:
    return StrategyResult(
        label=label,
        name=label,
        renderer="core",
        biased=False,
        repeats=6,
        curve=curve(0.1),
        time_to=dict(zip(TARGETS, times, strict=True)),
        ratio=dict(zip(TARGETS, ratios, strict=True)),
        efficiency=gain,
        error_at_budget=UNKNOWN,
        fewer_samples=UNKNOWN,
        equality_p=None,
        bias=None,
        notes=(),
        image=None,
    )


def scene(times: tuple[Interval, ...], ratios: tuple[Interval, ...], efficiency: Interval = UNKNOWN) -> SceneResult:
    nothing = (UNKNOWN, UNKNOWN)
    strategies = (strategy("naive", nothing, nothing, UNKNOWN), strategy("best", times, ratios, efficiency))
    return SceneResult("box", "abc", (8, 8), 8, 0.01, "naive", "best", 1.0, strategies)


def verdict(scenes: Sequence[SceneResult], targets: Sequence[float], question: Question = "time") -> str:
    """Return the verdict with all of its notes."""
    found = answer_of(scenes, targets, question)
    assert len(found.text) <= LONGEST
    return " ".join((found.text, *found.notes))


def said(*arguments: tuple[Interval, ...], efficiency: Interval = UNKNOWN) -> str:
    return verdict([scene(*arguments, efficiency=efficiency)], TARGETS)
