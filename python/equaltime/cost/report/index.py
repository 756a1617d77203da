"""The page of many experiments: what others say of each, what we measure, and the way to its report."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from equaltime.cost.report.charts import SMALL, chart
from equaltime.cost.report.looks import looks
from equaltime.cost.report.tables import label_row
from equaltime.cost.report.templates import write_page
from equaltime.cost.report.theirs import beside_table
from equaltime.cost.report.views import Row, Table
from equaltime.cost.report.words import seconds
from equaltime.cost.summary import SceneResult, Summary

__all__ = ["Card", "write_index"]

State = Literal["waiting", "done", "left out", "failed"]


@dataclass(frozen=True)
class Card:
    """One experiment on the page of all."""

    name: str
    """Of its folder beside the page."""
    title: str
    state: State = "waiting"
    summary: Summary | None = None
    problem: str = ""
    """Why there is no summary."""


@dataclass(frozen=True)
class _View:
    """What the page shows of an experiment that was run."""

    card: Card
    chart: Any = ""
    scene: str = ""
    """The scene of the chart."""
    legend: tuple[Row, ...] = ()
    beside: Table | None = None
    facts: str = ""


def write_index(cards: Sequence[Card], folder: Path, quick: bool = False, command: str = "") -> Path:
    """Write ``index.html`` into a folder, beside the folders of the experiments.

    Parameters
    ----------
    quick
        Whether the numbers are no more than a first look, which the page then says.
    command
        The command line that asked for it.

    Returns
    -------
    Path
        Of the page: one file that needs no network, with links to the reports.
    """
    views = [_view(card) for card in cards]
    return write_page(
        "index.html",
        folder / "index.html",
        title="Claims, and what we measure",
        suffix=": equaltime's experiments",
        views=views,
        quick=quick,
        command=command,
        machine=_machine(cards),
    )


def _view(card: Card) -> _View:
    summary = card.summary
    if summary is None or not summary.scenes:
        return _View(card)
    scene = _chosen(summary)
    look = looks([strategy.label for one in summary.scenes for strategy in one.strategies], scene.baseline)
    drawn = chart(scene, card.name, summary.targets, look, SMALL)
    legend = tuple(label_row(scene, strategy, look[strategy.label]) for strategy in scene.strategies)
    return _View(card, drawn, scene.name, legend, beside_table(card.name, summary), _facts(summary))


def _chosen(summary: Summary) -> SceneResult:
    """Return the scene that the numbers beside theirs are of, first of all."""
    wanted = summary.beside[0].scene if summary.beside else ""
    return next((scene for scene in summary.scenes if scene.name == wanted), summary.scenes[0])


def _facts(summary: Summary) -> str:
    scenes, runs = len(summary.scenes), summary.provenance.get("runs", 0)
    rendering = sum(
        strategy.curve.seconds[-1].value * strategy.repeats
        for scene in summary.scenes
        for strategy in scene.strategies
        if strategy.curve.seconds
    )
    return f"{scenes} {'scene' if scenes == 1 else 'scenes'}, {runs} runs, {seconds(rendering)} of rendering"


def _machine(cards: Sequence[Card]) -> str:
    """Name the processors on which it was measured."""
    found: dict[str, None] = {}
    for card in cards:
        machines = card.summary.provenance.get("machines", {}) if card.summary else {}
        for facts in machines.values() if isinstance(machines, Mapping) else ():
            found[f"{facts.get('cpu', 'a processor')}, {facts.get('processors', '?')} processors"] = None
    return "; ".join(found)
