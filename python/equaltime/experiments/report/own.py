"""Sentences beside the verdict on renderers that are not equaltime's own: a command, or Mitsuba."""

from __future__ import annotations

import re
from collections.abc import Sequence

from equaltime.experiments.analysis.disagreement import reason
from equaltime.experiments.analysis.pictures import other_pictures
from equaltime.experiments.analysis.sentences import across
from equaltime.experiments.model.summary import SceneResult, StrategyResult, Summary
from equaltime.experiments.report.words import Cell, error_cell, factor_cell, percent, seconds, seconds_cell
from equaltime.statistics.intervals import UNKNOWN, product_mean, sound
from equaltime.statistics.runs import of_one_kind

__all__ = ["other_renderers"]

_Found = Sequence[tuple[SceneResult, StrategyResult]]


def other_renderers(summary: Summary) -> tuple[str, ...]:
    """Return one sentence for each renderer that is not equaltime's own and whose times the verdict does not give.

    The sentence gives the renderer's time to the smallest error at which this time can be trusted on all scenes of the
    renderer. It compares the time with the times of the baseline and of the best strategy. Errors that the runs reached
    are preferred to extrapolated ones.
    """
    found: dict[str, list[tuple[SceneResult, StrategyResult]]] = {}
    pictures = other_pictures(summary.scenes)
    answer = " ".join((summary.verdict, *(note for note in summary.verdict_notes if note not in pictures)))
    for scene in summary.scenes:
        for strategy in scene.strategies:
            if strategy.renderer != "core" and not _names(answer, strategy.label):
                found.setdefault(strategy.label, []).append((scene, strategy))
    return tuple(_sentence(label, ones, summary.targets) for label, ones in found.items())


def _names(text: str, label: str) -> bool:
    return re.search(rf"(?<!\w){re.escape(label)}(?!\w)", text) is not None


def _sentence(label: str, found: _Found, targets: Sequence[float]) -> str:
    times = {target: [one.time_to.get(target, UNKNOWN) for _, one in found] for target in sorted(targets)}
    known = [target for target, each in times.items() if all(map(sound, each))]
    if not known and (reasons := {reason(one.difference) for _, one in found if one.disagrees}):
        return f"{label}: {'; '.join(sorted(reasons))}."
    if not known:
        return f"{label}: these runs cannot tell its time to an error{_last_error(found)}."
    target = next((target for target in known if all(time.reach == 1.0 for time in times[target])), known[0])
    extrapolated = "" if all(time.reach == 1.0 for time in times[target]) else ", extrapolated outside its runs"
    said = f"{label}: {percent(target)} in {_times(found, target)}{extrapolated}"
    return f"{said}{_beside_baseline(found, target)}{_beside_best(found, target)}."


def _times(found: _Found, target: float) -> str:
    return across([(scene.name, strategy.time_to[target]) for scene, strategy in found], seconds_cell)


def _beside_baseline(found: _Found, target: float) -> str:
    ratios = [strategy.ratio.get(target, UNKNOWN) for _, strategy in found]
    baselines = " / ".join(dict.fromkeys(scene.baseline for scene, _ in found))
    known = all(map(sound, ratios)) and of_one_kind(ratios)
    if not known or any(strategy.label == scene.baseline for scene, strategy in found):
        return ""
    mean = f" (geometric mean of {len(found)} scenes)" if len(found) > 1 else ""
    return f", {factor_cell(product_mean(ratios))} as fast as {baselines}{mean}"


def _beside_best(found: _Found, target: float) -> str:
    best = [(scene, one) for scene, mine in found if (one := _standard(scene)) is not None and one.label != mine.label]
    if len(best) < len(found) or not all(sound(strategy.time_to.get(target, UNKNOWN)) for _, strategy in best):
        return ""
    labels = " / ".join(dict.fromkeys(strategy.label for _, strategy in best))
    return f"; {labels} takes {_times(best, target)}"


def _standard(scene: SceneResult) -> StrategyResult | None:
    return next((strategy for strategy in scene.strategies if strategy.label == scene.standard), None)


def _last_error(found: _Found) -> str:
    """Describe the error at equal time on the first scene; empty if that cannot be told either."""
    scene, strategy = found[0]
    cell: Cell = error_cell(strategy.error_at_budget)
    if cell.state != "trusted":
        return ""
    where = f" on {scene.name}" if len(found) > 1 else ""
    return f"; after {seconds(scene.budget_s)}{where} its error is {cell}"
