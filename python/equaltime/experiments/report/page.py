"""The report of an experiment: one HTML page, made from templates, which contains all its pictures and scripts."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from importlib import resources
from pathlib import Path
from typing import Any

from equaltime.experiments.analysis.sentences import Answer
from equaltime.experiments.analysis.verdict import verdict
from equaltime.experiments.model.summary import SceneResult, Summary
from equaltime.experiments.report.charts import (
    has_dots,
    has_pale_points,
    has_typical_times,
    unmarked,
    with_one_point,
    without_curve,
)
from equaltime.experiments.report.figures import NARROW, WIDE, chart, dots, write_figures
from equaltime.experiments.report.films import FilmView, film_view, write_animation
from equaltime.experiments.report.footnotes import letter, shared_remarks
from equaltime.experiments.report.gallery import Crop, Series, kinds_of
from equaltime.experiments.report.latex import write_latex
from equaltime.experiments.report.links import next_links
from equaltime.experiments.report.looks import DARK, LIGHT, Style, looks
from equaltime.experiments.report.losing import INTRODUCTION, LossView, losing
from equaltime.experiments.report.overlap import hidden_curves
from equaltime.experiments.report.own import other_renderers
from equaltime.experiments.report.pictures import Bar, Pictures, load_pictures
from equaltime.experiments.report.rays import rays_view
from equaltime.experiments.report.tables import (
    PAGE_NOTE,
    Table,
    TableRow,
    beside_table,
    check_table,
    label_row,
    overview_tables,
    point_table,
    time_table,
)
from equaltime.experiments.report.telling import commands, is_quick
from equaltime.experiments.report.words import facts, percent, provenance_groups, slug, spread_sentence
from equaltime.extras import optional
from equaltime.files import replacing
from equaltime.images.image_files import SOFTWARE

__all__ = [
    "OverviewView",
    "SceneView",
    "longest_side",
    "overview_views",
    "with_marks",
    "without_marks",
    "write_page",
    "write_report",
]


@dataclass(frozen=True)
class SceneView:
    """Content of a page's section about one scene, for the template: charts, tables, pictures and sentences."""

    slug: str
    name: str
    facts: str
    """Sentence on the scene's size, path depth, reference, repeats and equal time."""
    verdict: Answer
    wide_chart: str
    """Chart of the error curves for a desktop: an ``<svg>`` element that needs no escaping."""
    narrow_chart: str
    """Chart of the error curves for a phone: an ``<svg>`` element that needs no escaping."""
    legend: tuple[TableRow, ...]
    against_samples: bool
    """Whether the charts show errors against samples per pixel instead of time."""
    has_pale_points: bool
    """Whether the charts have points whose interval cannot be trusted."""
    hidden: str
    """Sentences on error curves that lie beneath others in the chart or have no points; empty if all can be seen."""
    has_typical_times: bool
    """Whether times in the tables are medians of typical runs, which the charts do not show."""
    tables: tuple[tuple[str, Table], ...]
    """Pairs of heading and table, the most important for the experiment's question first."""
    points: Table
    """Table of the points of all error curves."""
    notes: tuple[tuple[str, str], ...]
    """Pairs: the label of a strategy, and a warning about its numbers."""
    kinds: tuple[Series, ...]
    size: tuple[int, int]
    """Width and height of the images, in pixels."""
    picture_notes: tuple[str, ...]
    losses: tuple[LossView, ...]
    loss_bar: Bar | None
    losses_intro: str
    film: FilmView | None
    files: tuple[str, ...]
    """Names of the figure files written beside the page."""

    @property
    def aspect(self) -> str:
        """Width and height of the images as CSS text, such as ``16 / 9``."""
        return f"{self.size[0]} / {self.size[1]}"

    @property
    def columns(self) -> int:
        """Number of pictures side by side on a wide screen: all in one row if they are few and not wide."""
        count = len(self.kinds[0].frames)
        most = 6 if self.size[0] <= 1.25 * self.size[1] else 4
        return math.ceil(count / math.ceil(count / most))

    def split(self, crops: Sequence[Crop]) -> str:
        """Return the width of the image's column in a CSS grid, such as ``2.667fr``.

        The column of crops beside the image is 1fr wide. The image is then as high as all crops, one below the other.
        """
        heights = sum(crop.window[3] / crop.window[2] for crop in crops) or 2.0
        return f"{heights * self.size[0] / self.size[1]:.3f}fr"

    def sharing(self, shared: tuple[str, ...]) -> SceneView:
        """Return a copy whose tables leave the remarks of these shapes to the notes of the page."""
        tables = tuple((heading, replace(table, shared=shared)) for heading, table in self.tables)
        return replace(self, tables=tables, points=replace(self.points, shared=shared))

    def place(self, window: tuple[int, int, int, int]) -> str:
        """Return CSS that places a window over the image, with position and size in % of the image.

        ``window`` is (x, y, width, height) in pixels of the image.
        """
        (x, y, w, h), (width, height) = window, self.size
        parts = {"left": x / width, "top": y / height, "width": w / width, "height": h / height}
        return "; ".join(f"{name}: {100.0 * part:.3f}%" for name, part in parts.items())


@dataclass(frozen=True)
class OverviewView:
    """Content of a page's section on all scenes, for one target error: chart and table of the times to that error."""

    name: str
    table: Table
    wide_chart: Any
    """Chart for a desktop: an ``<svg>`` element that needs no escaping; empty if no time is trusted."""
    narrow_chart: Any
    """Chart for a phone: an ``<svg>`` element that needs no escaping; empty if no time is trusted."""
    looks: Mapping[str, Style] = field(hash=False)
    """Colour, marker and line style of the strategies that have a mark in the chart, by label."""
    unmarked: str = ""
    """Sentence on the strategies that have no mark in the chart on some scenes; empty if there are none."""


def overview_views(summary: Summary, looks: Mapping[str, Style]) -> tuple[OverviewView, ...]:
    """Return one chart and table of all scenes for each target error, in the order of ``summary.targets``.

    ``looks`` gives colour, marker and line style by label of a strategy.
    """
    tables = [table.telling(is_quick(summary)) for table in overview_tables(summary, looks)]
    return tuple(_view(summary, target, table, looks) for target, table in zip(summary.targets, tables, strict=True))


def _view(summary: Summary, target: float, table: Table, looks: Mapping[str, Style]) -> OverviewView:
    wide = narrow = ""
    if has_dots(summary, target):
        wide = dots(summary, f"{table.slug}-wide", target, looks, WIDE[0])
        narrow = dots(summary, f"{table.slug}-narrow", target, looks, NARROW[0])
    marked = with_marks(summary, target, looks)
    return OverviewView(percent(target), table, wide, narrow, marked, without_marks(summary, target))


def with_marks(summary: Summary, target: float, looks: Mapping[str, Style]) -> dict[str, Style]:
    """Return the styles of the strategies that have a mark in the chart of times to ``target``, for its legend.

    ``target`` is an error. ``looks`` gives the styles of all strategies: colour, marker and line style by label.
    """
    absent = unmarked(summary, target)
    return {label: look for label, look in looks.items() if len(absent.get(label, ())) < _present(summary, label)}


def without_marks(summary: Summary, target: float) -> str:
    """Return a sentence on the strategies that have no mark on some scenes in the chart of times to ``target``.

    ``target`` is an error. The sentence names the scenes. The result is empty if every strategy has a mark on every
    scene.
    """
    parts = []
    for label, names in unmarked(summary, target).items():
        everywhere = len(names) == _present(summary, label)
        parts.append(f"{label} on {'every scene' if everywhere else ', '.join(names)}")
    return f"No mark, since the time is not reached or not known: {'; '.join(parts)}." if parts else ""


def _present(summary: Summary, label: str) -> int:
    """Return the number of scenes that a strategy rendered."""
    return sum(label in [strategy.label for strategy in scene.strategies] for scene in summary.scenes)


_PALETTES = (("all", LIGHT), ("screen and (prefers-color-scheme: dark)", DARK))


def write_page(template: str, path: Path, **values: object) -> Path:
    """Fill in the template file named ``template`` with ``values``, and write the page to ``path`` atomically.

    Returns ``path``. ``values`` are by the names that the template uses.
    """
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
    text = environment.get_template(template).render(
        software=SOFTWARE,
        style=markup((files / "style.css").read_text("utf-8")),
        script=markup((files / "page.js").read_text("utf-8")),
        palettes=_PALETTES,
        **values,
    )
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")
    return path


_SHORTEST, _LONGEST = 128, 640

_PIXELS = 12_000_000
"""Limit on the pixels of all pictures of a page; a pixel takes about two bytes."""

_MAPS = 7
"""Pictures per strategy and scene on a page."""


def write_report(summary: Summary, folder: Path, told: Callable[[float], object] = lambda share: None) -> Path:
    """Write ``report.html`` and ``figures/`` (PDF, PNG, and a table in LaTeX) into a folder.

    Parameters
    ----------
    summary
        Results of the experiment. If image files are missing, the page says which.
    folder
        Folder to write to; it is made if it does not exist.
    told
        Function that is called after each scene with the completed share of the work, in [0, 1].

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
    views = []
    for scene, name in zip(summary.scenes, slugs[len(_OWN_IDS) :], strict=True):
        views.append(_scene_view(scene, name, summary, look, folder, longest))
        told(len(views) / len(summary.scenes))
    overview = overview_views(summary, look) if len(summary.scenes) > 1 else ()
    claim = beside_table("experiment", summary)
    shared = shared_remarks(table.every_cell for table in _every_table(views, overview, claim))
    write_latex(summary, folder / "figures" / "table.tex")
    return write_page(
        "report.html",
        folder / "report.html",
        title=summary.title,
        suffix=": what accuracy costs in time",
        verdict=Answer(summary.verdict, summary.verdict_notes),
        headline_rule=summary.headline_rule,
        others=other_renderers(summary),
        quick=is_quick(summary),
        commands=commands(summary),
        description=summary.description,
        theirs=summary.theirs,
        beside=claim and replace(claim, shared=tuple(shared)),
        overview=[replace(view, table=replace(view.table, shared=tuple(shared))) for view in overview],
        looks=look,
        rays=rays_view(summary, folder),
        scenes=[view.sharing(tuple(shared)) for view in views],
        notes={letter(number): note for number, note in enumerate(shared.values())},
        note_id=PAGE_NOTE,
        links=next_links(folder),
        spread=spread_sentence(summary),
        provenance=provenance_groups(summary),
    )


def _every_table(views: Iterable[SceneView], overview: Iterable[OverviewView], claim: Table | None) -> Iterator[Table]:
    """Yield all tables of a page: of the published claim, of all scenes, and of each scene."""
    if claim is not None:
        yield claim
    yield from (view.table for view in overview)
    for view in views:
        yield view.points
        yield from (table for _, table in view.tables)


_OWN_IDS = (
    "content",
    "pictures",
    "lesson",
    "claim",
    "overview",
    "directions",
    "notes",
    "reading",
    "next",
    "provenance",
)


def longest_side(summary: Summary) -> int:
    """Return the longest side that each picture of a page may have, in pixels, which limits the size of the page.

    The result is from 128 to 640, less for more pictures.
    """
    pictures = sum(1 + _MAPS * len(scene.strategies) for scene in summary.scenes)
    return max(_SHORTEST, min(_LONGEST, math.isqrt(_PIXELS // max(1, pictures))))


def _scene_view(
    scene: SceneResult, name: str, summary: Summary, look: Mapping[str, Style], folder: Path, longest: int
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
        has_pale_points=has_pale_points(scene),
        hidden=" ".join(filter(None, (hidden_curves(scene), without_curve(scene), with_one_point(scene)))),
        against_samples=scene.against_samples,
        has_typical_times=has_typical_times(scene),
        tables=_tables(name, scene, summary, look),
        points=point_table(name, scene, look).telling(is_quick(summary)),
        notes=(
            *((strategy.label, "; ".join(strategy.notes)) for strategy in scene.strategies if strategy.notes),
            *scene.left_out,
        ),
        kinds=kinds,
        size=(pictures.reference.mean.shape[1], pictures.reference.mean.shape[0]) if pictures else scene.size,
        picture_notes=_picture_notes(scene, loaded),
        losses=views,
        loss_bar=bar,
        losses_intro=INTRODUCTION,
        film=film_view(scene, look, stops),
        files=(
            *write_figures(folder / "figures", name, scene, summary.targets, look, pictures, crops),
            *write_animation(folder / "figures", name, scene, stops),
        ),
    )


def _picture_notes(scene: SceneResult, loaded: Pictures | str) -> tuple[str, ...]:
    """Return sentences on images that could not be read, and on windows that are not shown."""
    missing = loaded.missing if isinstance(loaded, Pictures) else (loaded,)
    return (*missing, scene.crops_left_out) if scene.crops_left_out else missing


def _tables(
    name: str, scene: SceneResult, summary: Summary, look: Mapping[str, Style]
) -> tuple[tuple[str, Table], ...]:
    quick = is_quick(summary)
    times = ("Time to an error", time_table(name, scene, summary.targets, look).telling(quick))
    checks = ("Checks", check_table(name, scene, look).telling(quick))
    return (checks, times) if summary.question == "bias" else (times, checks)
