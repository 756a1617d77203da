"""All scenes of an experiment at a glance: for each error to reach a chart and a table."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from equaltime.cost.report.charts import NARROW, WIDE, dots
from equaltime.cost.report.dots import has_dots
from equaltime.cost.report.looks import Look
from equaltime.cost.report.tables import overview_tables
from equaltime.cost.report.views import Table
from equaltime.cost.report.words import percent
from equaltime.cost.summary import Summary

__all__ = ["OverviewView", "overview_views"]


@dataclass(frozen=True)
class OverviewView:
    """What a page shows of all scenes for one error to reach."""

    name: str
    table: Table
    wide_chart: Any
    narrow_chart: Any
    """``<svg>`` elements, safe as they are; empty if no time can be trusted."""


def overview_views(summary: Summary, looks: Mapping[str, Look]) -> tuple[OverviewView, ...]:
    """Return the views of all targets, in their order."""
    tables = overview_tables(summary, looks)
    return tuple(_view(summary, target, table, looks) for target, table in zip(summary.targets, tables, strict=True))


def _view(summary: Summary, target: float, table: Table, looks: Mapping[str, Look]) -> OverviewView:
    wide = narrow = ""
    if has_dots(summary, target):
        wide = dots(summary, f"{table.slug}-wide", target, looks, WIDE[0])
        narrow = dots(summary, f"{table.slug}-narrow", target, looks, NARROW[0])
    return OverviewView(percent(target), table, wide, narrow)
