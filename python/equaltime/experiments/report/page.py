"""Writes one self-contained page per experiment: all its contents are in the file, which loads no other files."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

from equaltime.experiments.analysis.verdict import verdict
from equaltime.experiments.model.summary import SceneResult, Summary
from equaltime.experiments.report.charts import NARROW, WIDE, chart
from equaltime.experiments.report.figures import write_figures
from equaltime.experiments.report.films import film_view, write_animation
from equaltime.experiments.report.gallery import kinds_of
from equaltime.experiments.report.looks import Look, looks
from equaltime.experiments.report.losing import INTRODUCTION, losing
from equaltime.experiments.report.overview import overview_views
from equaltime.experiments.report.pictures import Pictures, load_pictures
from equaltime.experiments.report.rays import rays_view
from equaltime.experiments.report.sentences import facts, provenance_groups
from equaltime.experiments.report.tables import check_table, label_row, point_table, time_table
from equaltime.experiments.report.templates import write_page
from equaltime.experiments.report.theirs import beside_table
from equaltime.experiments.report.views import SceneView, Table
from equaltime.experiments.report.words import slug

__all__ = ["longest_side", "write_report"]

_SHORTEST, _LONGEST = 128, 640
_PIXELS = 12_000_000
"""Limit on the pixels of all pictures of a page; a pixel takes about two bytes."""
_MAPS = 6
"""Pictures per strategy and scene on a page."""


def write_report(summary: Summary, folder: Path) -> Path:
    """Write ``report.html`` and ``figures/`` (PDF and PNG) into a folder.

    Parameters
    ----------
    summary
        Results. The page names images whose files are missing.
    folder
        Folder to write to; made if it does not exist.

    Returns
    -------
    Path
        Path of the page: one file with all its pictures, style and script, which needs no network.

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
    overview = overview_views(summary, look) if len(summary.scenes) > 1 else ()
    return write_page(
        "report.html",
        folder / "report.html",
        title=summary.title,
        suffix=": what accuracy costs in time",
        verdict=summary.verdict,
        description=summary.description,
        theirs=summary.theirs,
        beside=beside_table("experiment", summary),
        overview=overview,
        looks=look,
        rays=rays_view(summary, folder),
        scenes=views,
        provenance=provenance_groups(summary),
    )


_OWN_IDS = ("content", "overview", "directions", "reading", "provenance")


def longest_side(summary: Summary) -> int:
    """Return the longest side of a picture in pixels, 128 to 640, which keeps a page of many scenes small enough."""
    pictures = sum(1 + _MAPS * len(scene.strategies) for scene in summary.scenes)
    return max(_SHORTEST, min(_LONGEST, math.isqrt(_PIXELS // max(1, pictures))))


def _scene_view(
    scene: SceneResult, name: str, summary: Summary, look: Mapping[str, Look], folder: Path, longest: int
) -> SceneView:
    loaded = load_pictures(scene)
    pictures = loaded if isinstance(loaded, Pictures) else None
    kinds = kinds_of(scene, pictures, look, longest) if pictures else ()
    crops = [crop.window for crop in kinds[0].frames[0].crops] if kinds else []
    stops = pictures.stops if pictures else 0
    views, bar = losing(scene, pictures, look, longest) if pictures else ((), None)
    return SceneView(
        slug=name,
        name=scene.name,
        facts=facts(scene),
        verdict=verdict((scene,), summary.targets, summary.question),
        wide_chart=chart(scene, f"{name}-wide", summary.targets, look, WIDE),
        narrow_chart=chart(scene, f"{name}-narrow", summary.targets, look, NARROW),
        legend=tuple(label_row(scene, strategy, look[strategy.label]) for strategy in scene.strategies),
        tables=_tables(name, scene, summary, look),
        points=point_table(name, scene, look),
        notes=(
            *((strategy.label, "; ".join(strategy.notes)) for strategy in scene.strategies if strategy.notes),
            *scene.left_out,
        ),
        kinds=kinds,
        size=(pictures.reference.mean.shape[1], pictures.reference.mean.shape[0]) if pictures else scene.size,
        picture_notes=loaded.missing if isinstance(loaded, Pictures) else (loaded,),
        losses=views,
        loss_bar=bar,
        losses_intro=INTRODUCTION,
        film=film_view(scene, look, stops),
        files=(
            *write_figures(folder / "figures", name, scene, summary.targets, look, pictures, crops),
            *write_animation(folder / "figures", name, scene, stops),
        ),
    )


def _tables(name: str, scene: SceneResult, summary: Summary, look: Mapping[str, Look]) -> tuple[tuple[str, Table], ...]:
    times = ("Time to an error", time_table(name, scene, summary.targets, look))
    checks = ("Law and checks", check_table(name, scene, look))
    return (checks, times) if summary.question == "bias" else (times, checks)
