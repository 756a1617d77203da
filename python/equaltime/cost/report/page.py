"""One self-contained page for one experiment: everything that it shows is inside the file, and nothing is fetched."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from importlib import resources
from pathlib import Path
from typing import Any

from equaltime.cost.extras import optional
from equaltime.cost.report.curves import GRID, INK, MUTED, curve_gid, draw_curves, point_titles
from equaltime.cost.report.figures import write_figures
from equaltime.cost.report.gallery import kinds_of
from equaltime.cost.report.looks import DARK, LIGHT, Look, looks
from equaltime.cost.report.losing import INTRODUCTION, losing
from equaltime.cost.report.pictures import Pictures, load_pictures
from equaltime.cost.report.sentences import facts, provenance_groups
from equaltime.cost.report.svg import inline_svg
from equaltime.cost.report.tables import check_table, label_row, overview_tables, point_table, time_table
from equaltime.cost.report.views import SceneView
from equaltime.cost.report.words import percent, seconds, slug
from equaltime.cost.summary import SceneResult, Summary
from equaltime.cost.verdict import verdict
from equaltime.images import SOFTWARE

__all__ = ["longest_side", "write_report"]

_WIDE, _NARROW = (8.6, 4.6), (4.4, 4.0)
_SHORTEST, _LONGEST = 128, 640
_PIXELS = 12_000_000
"""In all pictures of a page; a pixel takes about two bytes."""
_MAPS = 6
"""Pictures that a page has of a strategy on a scene."""


def write_report(summary: Summary, folder: Path) -> Path:
    """Write ``report.html`` and ``figures/`` (PDF and PNG) into a folder.

    Parameters
    ----------
    summary
        What was found. Images that its paths do not lead to are said to be missing.
    folder
        Is made if it is not there.

    Returns
    -------
    Path
        Of the page: one file with all its pictures, style and script, that needs no network.

    Raises
    ------
    EqualtimeError
        If a package of the extra ``report`` is missing.
    """
    folder.mkdir(parents=True, exist_ok=True)
    labels = [strategy.label for scene in summary.scenes for strategy in scene.strategies]
    longest = longest_side(summary)
    look = looks(labels, summary.scenes[0].baseline if summary.scenes else "")
    slugs: list[str] = list(_OWN_IDS)
    for scene in summary.scenes:
        slugs.append(slug(scene.name, slugs))
    views = [
        _scene_view(scene, name, summary, look, folder, longest)
        for scene, name in zip(summary.scenes, slugs[len(_OWN_IDS) :], strict=True)
    ]
    text = _render(summary, views, look)
    path = folder / "report.html"
    temporary = path.with_name(f".report-{os.getpid()}.part")  # a reader never sees half a page
    try:
        temporary.write_text(text, encoding="utf-8")
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)
    return path


_OWN_IDS = ("content", "overview", "reading", "provenance")


def _render(summary: Summary, views: list[SceneView], look: Mapping[str, Look]) -> str:
    jinja: Any = optional("jinja2")
    markup: Any = optional("markupsafe").Markup
    files = resources.files(__package__) / "template"
    environment = jinja.Environment(
        loader=jinja.FunctionLoader(lambda name: (files / name).read_text("utf-8")),
        autoescape=True,
        undefined=jinja.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    several = len(summary.scenes) > 1
    tables = overview_tables(summary, look) if several else []
    return str(
        environment.get_template("report.html").render(
            title=summary.title,
            verdict=summary.verdict,
            description=summary.description,
            software=SOFTWARE,
            style=markup((files / "style.css").read_text("utf-8")),
            script=markup((files / "page.js").read_text("utf-8")),
            palettes=(("all", LIGHT), ("screen and (prefers-color-scheme: dark)", DARK)),
            overview=[(percent(target), table) for target, table in zip(summary.targets, tables, strict=False)],
            scenes=views,
            provenance=provenance_groups(summary),
        )
    )


def longest_side(summary: Summary) -> int:
    """Return how long a side of a picture may be, so that a page of many scenes stays one that can be opened."""
    pictures = sum(1 + _MAPS * len(scene.strategies) for scene in summary.scenes)
    return max(_SHORTEST, min(_LONGEST, math.isqrt(_PIXELS // max(1, pictures))))


def _scene_view(
    scene: SceneResult, name: str, summary: Summary, look: Mapping[str, Look], folder: Path, longest: int
) -> SceneView:
    loaded = load_pictures(scene)
    pictures = loaded if isinstance(loaded, Pictures) else None
    kinds = kinds_of(scene, pictures, look, longest) if pictures else ()
    crops = [crop.window for crop in kinds[0].frames[0].crops] if kinds else []
    views, bar = losing(scene, pictures, look, longest) if pictures else ((), None)
    return SceneView(
        slug=name,
        name=scene.name,
        facts=facts(scene),
        verdict=verdict((scene,), summary.targets),
        wide_chart=_chart(scene, name, "wide", summary, look, _WIDE),
        narrow_chart=_chart(scene, name, "narrow", summary, look, _NARROW),
        legend=tuple(label_row(scene, strategy, look[strategy.label]) for strategy in scene.strategies),
        tables=(time_table(name, scene, summary.targets, look), check_table(name, scene, look)),
        points=point_table(name, scene, look),
        notes=tuple((strategy.label, note) for strategy in scene.strategies for note in strategy.notes),
        kinds=kinds,
        size=(pictures.reference.mean.shape[1], pictures.reference.mean.shape[0]) if pictures else scene.size,
        picture_notes=loaded.missing if isinstance(loaded, Pictures) else (loaded,),
        losses=views,
        loss_bar=bar,
        losses_intro=INTRODUCTION,
        files=write_figures(folder / "figures", name, scene, summary.targets, look, pictures, crops),
    )


def _chart(
    scene: SceneResult, name: str, kind: str, summary: Summary, look: Mapping[str, Look], size: tuple[float, float]
) -> Any:
    """Draw the curves for the page: colours are the theme's, and the legend is the page's."""
    colours = {colour: f"var(--s{index})" for index, colour in enumerate(LIGHT)}
    colours |= {INK: "var(--ink)", MUTED: "var(--muted)", GRID: "var(--grid)"}
    titles = {curve_gid(order): point_titles(strategy) for order, strategy in enumerate(scene.strategies)}
    labels = ", ".join(strategy.label for strategy in scene.strategies)
    description = (
        f"Error against time on {scene.name}, both logarithmic, one curve each for {labels}; "
        f"equal time is {seconds(scene.budget_s)}. The numbers stand in a table below."
    )
    figure = draw_curves(scene, summary.targets, look, size, legend=False)
    return optional("markupsafe").Markup(inline_svg(figure, f"{name}-{kind}", colours, titles, description))
