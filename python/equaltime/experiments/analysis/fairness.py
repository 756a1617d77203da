"""Baselines with which a comparison is unfair: without Russian roulette where paths hardly end."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress

from equaltime.errors import StrategyError
from equaltime.experiments.analysis.sentences import listed
from equaltime.experiments.model.reader import DEPTH_WITHOUT_ROULETTE, ends_its_paths
from equaltime.experiments.model.summary import SceneResult, StrategyResult
from equaltime.strategy import Strategy

__all__ = ["baselines_without_roulette"]


def baselines_without_roulette(scenes: Sequence[SceneResult]) -> str:
    """Return sentences on a baseline without roulette on scenes whose paths hardly end, and on a fairer one.

    The text is empty without such scenes, and if the fairer baseline is compared too, or if no strategy has roulette.
    """
    found = [(scene.name, scene.baseline, fairer) for scene in scenes if (fairer := _fairer(scene)) is not None]
    if not found:
        return ""
    _, label, fairer = found[0]
    return (
        f"{label} has no Russian roulette, and paths on {listed([name for name, _, _ in found])} may be longer than "
        f"{DEPTH_WITHOUT_ROULETTE}: they go on until nearly black. Gains over {label} there may come from roulette. "
        f"{fairer.name} is the fairer baseline."
    )


def _fairer(scene: SceneResult) -> Strategy | None:
    """Return the baseline with roulette if the scene's baseline is unfair for want of it; else None."""
    every = {one.label: strategy for one in scene.strategies if (strategy := _strategy(one)) is not None}
    baseline = every.get(scene.baseline)
    if baseline is None or ends_its_paths(baseline, scene.max_depth):
        return None
    fairer = baseline.model_copy(update={"roulette": "throughput"})
    others = [one for one in every.values() if one.roulette != "none"]
    return None if not others or any(one.name == fairer.name for one in others) else fairer


def _strategy(result: StrategyResult) -> Strategy | None:
    """Return a strategy of equaltime's own; None for other renderers, and for a subject in Python."""
    if result.renderer == "core":
        with suppress(StrategyError):
            return Strategy.parse(result.name)
    return None
