"""Verdicts on three questions of experiments: which strategies are biased, samples to an error, squared error x time.

The module `verdict` answers the fourth question: the time to an error.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence

from equaltime.experiments.model.summary import SceneResult, StrategyResult
from equaltime.statistics.intervals import Interval, product_mean, sound

__all__ = ["bias_verdict", "efficiency_verdict", "samples_verdict"]

_TIMES = "\N{MULTIPLICATION SIGN}"


def bias_verdict(scenes: Sequence[SceneResult], level: float) -> str:
    """Return a sentence that lists the strategies found biased, those not found biased, and those not tested.

    A strategy is biased if its expected image differs from the expected image of the scene's standard strategy.
    ``level`` is the false-alarm rate of all these tests together.
    """
    found, right, open_ = [], [], []
    for scene, strategy in _others(scenes):
        on = f" on {scene.name}" if len(scenes) > 1 else ""
        if strategy.equality_p is None:
            open_.append(f"{strategy.label}{on}{_why(strategy)}")
        elif strategy.unequal:
            found.append(f"{strategy.label}{_size(strategy.bias)}{on}")
        else:
            right.append(f"{strategy.label}{on}")
    standard = " / ".join(dict.fromkeys(scene.standard or "nothing" for scene in scenes))
    parts = [
        f"found biased at a level of {100.0 * level:.2g} %, held against {standard}: {_listed(found)}",
        f"not: {_listed(right)}",
        *([f"not to be told: {_listed(open_)}"] if open_ else []),
    ]
    return "; ".join(parts)


def samples_verdict(scenes: Sequence[SceneResult]) -> str:
    """Return a sentence on the factor by which each strategy needs fewer samples than the baseline at equal error."""
    baseline = " / ".join(dict.fromkeys(scene.baseline for scene in scenes))
    said = []
    for scene, strategy in _others(scenes, baseline=True):
        on = f" on {scene.name}" if len(scenes) > 1 else ""
        said.append(f"{strategy.label}{on} {_fewer(strategy.fewer_samples)}")
    return f"samples to the same error, against {baseline}: {_listed(said)}"


def efficiency_verdict(scenes: Sequence[SceneResult]) -> str:
    """Return a sentence with each strategy's gain: the baseline's squared error x time, divided by the strategy's.

    With several scenes, each gain is a geometric mean over scenes, with its smallest and largest value. The standard
    strategy comes first.
    """
    baseline = " / ".join(dict.fromkeys(scene.baseline for scene in scenes))
    found: dict[str, list[tuple[str, Interval]]] = {}
    for scene, strategy in _others(scenes, baseline=True):
        found.setdefault(strategy.label, []).append((scene.name, strategy.efficiency))
    standards = {scene.standard for scene in scenes}
    said = [_gain(label, found[label], len(scenes)) for label in sorted(found, key=lambda one: one not in standards)]
    what = f"squared error {_TIMES} time, of typical runs, against {baseline}"
    return f"{what}{' (geometric means)' if len(scenes) > 1 else ''}: {_listed(said)}"


def _gain(label: str, found: Sequence[tuple[str, Interval]], scenes: int) -> str:
    """Format the mean gain of one strategy; with several scenes also its smallest and largest gain."""
    known = [(name, interval) for name, interval in found if sound(interval)]
    if not known:
        return f"{label} not to be told ({found[0][1].note})"
    text = f"{label} {_less(product_mean([interval for _, interval in known]))}"
    if len(known) > 1:
        least, most = (pick(known, key=lambda one: one[1].value) for pick in (min, max))
        text += f" ({least[0]}: {_less(least[1])}; {most[0]}: {_less(most[1])})"
    return text + (f" on {len(known)} of {scenes} scenes" if len(known) < scenes else "")


def _less(ratio: Interval) -> str:
    """Format a ratio of costs as "N times less" or "N times more"."""
    low, value, high = (ratio.low, ratio.value, ratio.high) if ratio.value >= 1.0 else _inverse(ratio)
    return f"{value:.3g}{_TIMES} [{low:.3g}, {high:.3g}] {'less' if ratio.value >= 1.0 else 'more'}"


def _inverse(ratio: Interval) -> tuple[float, float, float]:
    return 1.0 / ratio.high, 1.0 / ratio.value, 1.0 / ratio.low


def _others(scenes: Sequence[SceneResult], baseline: bool = False) -> Iterator[tuple[SceneResult, StrategyResult]]:
    for scene in scenes:
        for strategy in scene.strategies:
            if strategy.label != (scene.baseline if baseline else scene.standard):
                yield scene, strategy


def _fewer(ratio: Interval) -> str:
    if math.isinf(ratio.value):
        return "needs one, being exact"
    if not ratio.trusted:
        if ratio.bound == "low":
            return f"at least {ratio.low:.3g}{_TIMES} fewer"
        if ratio.bound == "high" and ratio.high < 1.0:
            return f"at least {1.0 / ratio.high:.3g}{_TIMES} more"
        return f"not to be told ({ratio.note})"
    if ratio.value >= 1.0:
        return f"{ratio.value:.3g}{_TIMES} [{ratio.low:.3g}, {ratio.high:.3g}] fewer"
    low, value, high = _inverse(ratio)
    return f"{value:.3g}{_TIMES} [{low:.3g}, {high:.3g}] more"


def _size(bias: Interval | None) -> str:
    """Format a bias as a relative error in %; empty if its interval is not trusted or includes 0."""
    if bias is None or not bias.trusted or bias.low <= 0.0:
        return ""
    return f" by {100.0 * bias.value:.3g} % [{100.0 * bias.low:.3g}, {100.0 * bias.high:.3g}]"


def _why(strategy: StrategyResult) -> str:
    return f" ({strategy.notes[0]})" if strategy.notes else ""


def _listed(texts: Iterable[str]) -> str:
    return ", ".join(texts) or "none"
