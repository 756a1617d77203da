"""Verdicts of experiments that do not ask how long: which estimators are biased, or which need fewest samples."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence

from equaltime.cost.statistics import Interval
from equaltime.cost.summary import SceneResult, StrategyResult

__all__ = ["bias_verdict", "samples_verdict"]

_TIMES = "\N{MULTIPLICATION SIGN}"


def bias_verdict(scenes: Sequence[SceneResult], level: float) -> str:
    """Say which strategies have another expectation than the one that they are held against, and which have not.

    ``level`` is the false-alarm rate of all tests together; each scene and strategy had its share (see `agreement`).
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
    """Say how many fewer samples than the baseline each strategy needs for the same error."""
    baseline = " / ".join(dict.fromkeys(scene.baseline for scene in scenes))
    said = []
    for scene, strategy in _others(scenes, baseline=True):
        on = f" on {scene.name}" if len(scenes) > 1 else ""
        said.append(f"{strategy.label}{on} {_fewer(strategy.fewer_samples)}")
    return f"samples to the same error, against {baseline}: {_listed(said)}"


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
    return f"{1.0 / ratio.value:.3g}{_TIMES} [{1.0 / ratio.high:.3g}, {1.0 / ratio.low:.3g}] more"


def _size(bias: Interval | None) -> str:
    """Say how large a bias is, if that is known: a relative error that no time makes smaller."""
    if bias is None or not bias.trusted or bias.low <= 0.0:
        return ""
    return f" by {100.0 * bias.value:.3g} % [{100.0 * bias.low:.3g}, {100.0 * bias.high:.3g}]"


def _why(strategy: StrategyResult) -> str:
    return f" ({strategy.notes[0]})" if strategy.notes else ""


def _listed(texts: Iterable[str]) -> str:
    return ", ".join(texts) or "none"
