"""Sentence on curves that other curves hide in the chart of errors."""

from __future__ import annotations

from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from equaltime.experiments.model.summary import SceneResult, StrategyResult
from equaltime.experiments.report.charts import places_along

__all__ = ["hidden_curves"]

Floats = NDArray[np.float64]

_CLOSE = 0.012
"""Largest distance of two curves that look like one, as a share of the chart's height; a line is about that wide."""


def hidden_curves(scene: SceneResult) -> str:
    """Return a sentence on hidden curves, which lie beneath others; empty if all curves are visible."""
    points = {strategy.label: _points(scene, strategy) for strategy in scene.strategies}
    heights = np.concatenate([errors for _, errors in points.values()] or [np.zeros(0)])
    most = _CLOSE * float(np.ptp(heights)) if heights.size else 0.0
    hidden = {one: other for one, other in combinations(points, 2) if _is_hidden(points[one], points[other], most)}
    parts = [f"{one} lies exactly beneath {other}" for one, other in hidden.items()]
    return f"{'; '.join(parts)}." if parts else ""


def _points(scene: SceneResult, strategy: StrategyResult) -> tuple[Floats, Floats]:
    """Return the logarithms of times (or samples) and errors that the chart can show, in order of time."""
    along = places_along(scene, strategy)
    pairs = [(place, error.value) for place, error in zip(along, strategy.curve.error, strict=True)]
    shown = [pair for pair in pairs if all(np.isfinite(pair)) and min(pair) > 0.0]
    logs = np.log(np.asarray(sorted(shown), np.float64).reshape(-1, 2))
    return logs[:, 0], logs[:, 1]


def _is_hidden(lower: tuple[Floats, Floats], upper: tuple[Floats, Floats], most: float) -> bool:
    """Tell whether all points of one curve, but one at an end, lie within ``most`` of another curve."""
    (times, errors), (others, their_errors) = lower, upper
    if min(times.size, others.size) < 2:
        return False
    inside = (times >= others[0]) & (times <= others[-1])
    apart = np.abs(np.interp(times[inside], others, their_errors) - errors[inside])
    return bool(inside.sum() >= max(2, times.size - 1) and apart.max() <= most)
