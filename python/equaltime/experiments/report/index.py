"""Index page of a folder of experiments: published and measured numbers, and a link to each report."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from equaltime.experiments.model.summary import Summary
from equaltime.experiments.report.charts import clearest, has_pale_points
from equaltime.experiments.report.figures import SMALL, chart, dots
from equaltime.experiments.report.looks import Style, looks
from equaltime.experiments.report.own import other_renderers
from equaltime.experiments.report.page import with_marks, without_marks, write_page
from equaltime.experiments.report.tables import Table, beside_table
from equaltime.experiments.report.words import percent, seconds

__all__ = ["Card", "write_index"]

_MANY = 4
"""Most scenes for which the curves of a single scene are shown; with more, all scenes are shown as dots."""

State = Literal["waiting", "earlier", "done", "left out", "failed"]
"""State of an experiment on the index page: ``waiting`` for its run, ``done``, ``left out`` or ``failed``. ``earlier``
is an experiment that waits for its run, and has a report of an earlier run."""


@dataclass(frozen=True)
class Card:
    """Entry of one experiment on the index page: its title, its state, and its results or its problem."""

    name: str
    """Name of the experiment's folder beside the page."""
    title: str
    state: State = "waiting"
    summary: Summary | None = None
    problem: str = ""
    """Reason why the experiment has no results; empty if it has some."""


@dataclass(frozen=True)
class _View:
    """Contents of the page for one experiment."""

    card: Card
    chart: Any = ""
    """An ``<svg>`` element that needs no escaping."""
    shown: str = ""
    """Caption of the chart."""
    looks: Mapping[str, Style] = field(default_factory=dict, hash=False)
    beside: Table | None = None
    others: tuple[str, ...] = ()
    """Sentences on renderers that are not equaltime's own."""
    facts: str = ""


def write_index(cards: Sequence[Card], folder: Path, quick: bool = False, command: str = "") -> Path:
    """Write ``index.html`` into a folder, beside the folders of the experiments that ``cards`` describe.

    Parameters
    ----------
    quick
        Whether the experiments were shrunk for a first look; the page then says so.
    command
        Command line that started the experiments.

    Returns
    -------
    Path
        Path of the page: one file that needs no network, with links to the reports.
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
    labels = [strategy.label for scene in summary.scenes for strategy in scene.strategies]
    look = looks(labels, summary.scenes[0].baseline)
    drawn, shown, marked = _chart(summary, card.name, look)
    table = beside_table(card.name, summary)
    return _View(card, drawn, shown, marked, table, other_renderers(summary), _facts(summary))


def _chart(summary: Summary, prefix: str, look: Mapping[str, Style]) -> tuple[Any, str, Mapping[str, Style]]:
    """Return chart, caption, and the looks of the strategies in the chart.

    The chart has dots for more than four scenes, else the curves of the scene with published numbers.
    """
    target = clearest(summary)
    if len(summary.scenes) > _MANY and target is not None:
        shown = f"Time to an error of {percent(target)}. {without_marks(summary, target)}".rstrip(". ")
        return dots(summary, prefix, target, look, SMALL[0]), shown, with_marks(summary, target, look)
    wanted = summary.beside[0].scene if summary.beside else ""
    scene = next((scene for scene in summary.scenes if scene.name == wanted), summary.scenes[0])
    where = f", {scene.name}" if len(summary.scenes) > 1 else ""
    pale = "; pale points cannot be trusted" if has_pale_points(scene) else ""
    return (
        chart(scene, prefix, summary.targets, look, SMALL),
        f"Error against {'samples' if scene.against_samples else 'time'}{where}{pale}",
        look,
    )


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
    """Return the names of the processors on which the experiments ran."""
    found: dict[str, None] = {}
    for card in cards:
        machines = card.summary.provenance.get("machines", {}) if card.summary else {}
        for facts in machines.values() if isinstance(machines, Mapping) else ():
            found[f"{facts.get('cpu', 'a processor')}, {facts.get('processors', '?')} processors"] = None
    return "; ".join(found)
