"""Overview of all scenes of an experiment: one chart and one table per target error."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from equaltime.experiments.model.summary import Summary
from equaltime.experiments.report.charts import NARROW, WIDE, dots
from equaltime.experiments.report.dots import has_dots, unmarked
from equaltime.experiments.report.looks import Look
from equaltime.experiments.report.tables import overview_tables
from equaltime.experiments.report.views import Table
from equaltime.experiments.report.words import percent

__all__ = ["OverviewView", "overview_views", "without_marks"]


@dataclass(frozen=True)
class OverviewView:
    """Chart and table of all scenes for one target error."""

    name: str
    table: Table
    wide_chart: Any
    narrow_chart: Any
    """``<svg>`` elements that need no escaping; empty if no time is trusted."""
    unmarked: str = ""
    """Sentence on the strategies without a mark in the chart on some scenes."""


def overview_views(summary: Summary, looks: Mapping[str, Look]) -> tuple[OverviewView, ...]:
    """Return the views of all targets, in order."""
    tables = overview_tables(summary, looks)
    return tuple(_view(summary, target, table, looks) for target, table in zip(summary.targets, tables, strict=True))


def _view(summary: Summary, target: float, table: Table, looks: Mapping[str, Look]) -> OverviewView:
    wide = narrow = ""
    if has_dots(summary, target):
        wide = dots(summary, f"{table.slug}-wide", target, looks, WIDE[0])
        narrow = dots(summary, f"{table.slug}-narrow", target, looks, NARROW[0])
    return OverviewView(percent(target), table, wide, narrow, without_marks(summary, target))


def without_marks(summary: Summary, target: float) -> str:
    """Return a sentence on the strategies without a mark, and their scenes; empty if all have marks."""
    parts = []
    for label, names in unmarked(summary, target).items():
        present = sum(label in [strategy.label for strategy in scene.strategies] for scene in summary.scenes)
        everywhere = len(names) == present
        parts.append(f"{label} on {'every scene' if everywhere else ', '.join(names)}")
    return f"No mark, since the time is not reached or not known: {'; '.join(parts)}." if parts else ""
