"""Figures of a report: as SVG in the page, and as PDF and PNG beside it.

An SVG in the page has the page's colours (light or dark), unique ids, and selectable text.
"""

from __future__ import annotations

import io
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree

import numpy as np

from equaltime.experiments.model.summary import SceneResult, StrategyResult, Summary
from equaltime.experiments.report.captions import short_caption
from equaltime.experiments.report.charts import curve_titles, draw_curves, draw_dots, is_drawn
from equaltime.experiments.report.gallery import Window
from equaltime.experiments.report.looks import GRID, INK, LIGHT, MUTED, Style
from equaltime.experiments.report.pictures import Pictures
from equaltime.experiments.report.words import meanings, percent, seconds
from equaltime.extras import optional
from equaltime.files import replacing
from equaltime.images.preview import srgb_bytes

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = [
    "NARROW",
    "SMALL",
    "WIDE",
    "chart",
    "dots",
    "draw_comparison",
    "inline_svg",
    "themed",
    "write_figure",
    "write_figures",
]

WIDE, NARROW, SMALL = (8.6, 4.6), (4.4, 4.0), (4.2, 2.9)
"""Width and height of a chart in inches: for a desktop, for a phone, and for one of many on a page."""
_PAPER = (7.6, 4.0)
"""Width and height in inches of a chart for papers, whose legend stands beside it."""
_COLUMN = 1.5
"""Inches of a crop's side, which the lines above it need."""
_KINDS = {"pdf": {"CreationDate": None}, "png": {}}
"""File types and their metadata; without a date, so that equal figures give equal files."""
_TRUETYPE = {"pdf.fonttype": 42, "ps.fonttype": 42}
"""Settings of matplotlib for fonts that journals accept; its default are fonts of Type 3, which many refuse."""
_FRAMES = ("#e69f00", "#56b4e9", "#009e73", "#cc79a7")
_FONT = re.compile(r"font(-family|-size)?:[^;]*;?")
_CURVE = re.compile(r"curve-(\d+)(?:-band|-pale)?")
_FONT_SIZE = re.compile(r"(\d+(?:\.\d+)?)px")


def inline_svg(
    figure: Figure,
    prefix: str,
    colours: Mapping[str, str],
    titles: Mapping[str, Sequence[str]],
    description: str,
) -> str:
    """Return a figure as an ``<svg>`` element for HTML.

    Parameters
    ----------
    figure
        Figure to draw.
    prefix
        Beginning of every id, so that ids of several figures on a page differ.
    colours
        ``#rrggbb`` → its replacement, such as ``var(--ink)``.
    titles
        Id of a group of markers → tooltip of each marker.
    description
        Description of the figure for screen readers.

    """
    buffer = io.StringIO()
    # keep text as text, to be read and copied; matplotlib offers this only as a global setting
    with optional("matplotlib").rc_context({"svg.fonttype": "none", "svg.hashsalt": prefix}):
        figure.savefig(buffer, format="svg", metadata={"Date": None})
    root = ElementTree.fromstring(buffer.getvalue())
    _forget_namespaces(root)
    root.attrib = {"viewBox": root.attrib["viewBox"], "role": "img", "aria-label": description}
    for element in root.findall("metadata"):
        root.remove(element)
    for element in root.findall("defs"):
        for style in element.findall("style"):
            element.remove(style)  # would apply to the whole page
    for group, texts in titles.items():
        _title_markers(root, group, texts)
    for element in root.iter():
        _restyle(element, prefix, colours)
    return ElementTree.tostring(root, encoding="unicode")


def _forget_namespaces(root: ElementTree.Element) -> None:
    """Remove XML namespaces, which an ``<svg>`` inside HTML does not have."""
    for element in root.iter():
        element.tag = element.tag.rpartition("}")[2]
        element.attrib = {name.rpartition("}")[2]: value for name, value in element.attrib.items()}


def _title_markers(root: ElementTree.Element, group: str, texts: Sequence[str]) -> None:
    found = root.find(f".//g[@id='{group}']")
    if found is None:
        return
    for marker, text in zip(found.iter("use"), texts, strict=False):
        ElementTree.SubElement(marker, "title").text = text


def _restyle(element: ElementTree.Element, prefix: str, colours: Mapping[str, str]) -> None:
    for name, value in list(element.attrib.items()):
        if name == "id":
            element.set(name, f"{prefix}-{value}")
            if curve := _CURVE.fullmatch(value):
                element.set("data-curve", curve.group(1))
        elif name == "href":
            element.set(name, value.replace("#", f"#{prefix}-"))
        elif name in ("style", "clip-path", "fill", "stroke"):
            value = value.replace("url(#", f"url(#{prefix}-")
            for colour, replacement in colours.items():
                value = value.replace(colour, replacement)
            element.set(name, _inherit_font(value) if element.tag == "text" and name == "style" else value)


def _inherit_font(style: str) -> str:
    """Return a text's style with its own font size and the page's typeface."""
    size = _FONT_SIZE.search(style)
    return f"font-size: {size.group(1) if size else 10}px; {_FONT.sub('', style).strip()}"


def chart(
    scene: SceneResult, prefix: str, targets: Sequence[float], looks: Mapping[str, Style], size: tuple[float, float]
) -> Any:
    """Return a scene's curves of error against time as an ``<svg>`` element whose ids begin with ``prefix``.

    ``targets`` are errors, drawn as horizontal lines. ``looks`` gives colour, marker and line style by label of a
    strategy. ``size`` is width and height in inches.
    """
    titles: dict[str, list[str]] = {}
    for order, strategy in enumerate(scene.strategies):
        titles |= curve_titles(order, strategy)
    labels = ", ".join(strategy.label for strategy in scene.strategies if is_drawn(strategy))
    description = (
        f"Error against {'samples' if scene.against_samples else 'time'} on {scene.name}, both logarithmic, one curve "
        f"each for {labels}; equal time is {seconds(scene.budget_s)}. The numbers stand in a table of the report."
    )
    return themed(draw_curves(scene, targets, looks, size, legend=False), prefix, description, titles)


def dots(summary: Summary, prefix: str, target: float, looks: Mapping[str, Style], width: float) -> Any:
    """Return the chart of times to the error ``target`` on all scenes as an ``<svg>`` element, ``width`` inches wide.

    Ids in the element begin with ``prefix``. ``looks`` gives colour, marker and line style by label of a strategy.
    """
    names = ", ".join(scene.name for scene in summary.scenes)
    description = (
        f"Time to an error of {percent(target)}, logarithmic, one row each for {names}, one dot each for "
        f"{', '.join(looks)}. The numbers stand in a table of the report."
    )
    return themed(draw_dots(summary, target, looks, width), prefix, description)


def themed(figure: Figure, prefix: str, description: str, titles: Mapping[str, Sequence[str]] | None = None) -> Any:
    """Return a figure as an ``<svg>`` element that takes the colours of the page, light or dark.

    Ids in the element begin with ``prefix``. ``description`` describes the figure for screen readers. ``titles`` maps
    the id of a group of markers to a tooltip for each marker.
    """
    colours = {colour: f"var(--s{index})" for index, colour in enumerate(LIGHT)}
    colours |= {"#ffffff": "var(--page)", INK: "var(--ink)", MUTED: "var(--muted)", GRID: "var(--grid)"}
    return optional("markupsafe").Markup(inline_svg(figure, prefix, colours, titles or {}, description))


def write_figure(figure: Figure, folder: Path, name: str) -> tuple[str, ...]:
    """Write a figure to ``folder`` as NAME.pdf and NAME.png, each atomically, and return the names of both files.

    The names contain the last part of the folder's path, as in ``figures/NAME.pdf``. A PDF embeds TrueType fonts.
    """
    folder.mkdir(parents=True, exist_ok=True)
    for kind, metadata in _KINDS.items():
        with optional("matplotlib").rc_context(_TRUETYPE), replacing(folder / f"{name}.{kind}") as file:
            figure.savefig(file, format=kind, dpi=200, facecolor="white", metadata=metadata)
    return tuple(f"{folder.name}/{name}.{kind}" for kind in _KINDS)


def write_figures(
    folder: Path,
    slug: str,
    scene: SceneResult,
    targets: Sequence[float],
    looks: Mapping[str, Style],
    pictures: Pictures | None,
    crops: Sequence[Window],
) -> tuple[str, ...]:
    """Write figures of a scene's error curves, and of its crops if there are pictures, to ``folder``.

    Returns the files as ``FOLDER/SLUG-curves.pdf`` and so on; ``slug`` is the scene's name as a file name. ``targets``
    are errors, drawn as horizontal lines. ``crops`` are windows (x, y, width, height) in pixels. ``looks`` gives
    colour, marker and line style by label of a strategy.
    """
    drawn = {f"{slug}-curves": draw_curves(scene, targets, looks, _PAPER, legend=True)}
    if pictures is not None and pictures.runs and crops:
        drawn[f"{slug}-crops"] = draw_comparison(scene, pictures, crops)
    return tuple(file for name, figure in drawn.items() for file in write_figure(figure, folder, name))


def draw_comparison(scene: SceneResult, pictures: Pictures, crops: Sequence[Window]) -> Figure:
    """Return a figure of the reference with marked windows ``crops``, and beside it the crops of all images.

    ``pictures`` are the images of the scene. The crops form a table: a row per window, a column for the reference, and
    a column per strategy. The headings of strategies have the error and the time of the run that is shown, and the
    table's error at equal time; a caption says so.
    """
    shown = [strategy for strategy in scene.strategies if strategy.label in pictures.runs]
    height, width = pictures.reference.mean.shape[:2]
    left = len(crops) * width / height
    columns = 1 + len(shown)
    size = (_COLUMN * (left + columns), _COLUMN * len(crops) + 0.9)
    figure: Figure = optional("matplotlib.figure").Figure(figsize=size, layout="constrained")
    grid = figure.add_gridspec(len(crops), 1 + columns, width_ratios=[left] + [1.0] * columns, wspace=0.02, hspace=0.02)
    whole = figure.add_subplot(grid[:, 0])
    _show(whole, srgb_bytes(pictures.reference.mean, pictures.stops))
    for (x, y, w, h), colour in zip(crops, _cycle(len(crops)), strict=True):
        rectangle = optional("matplotlib.patches").Rectangle((x, y), w, h, fill=False, edgecolor=colour, linewidth=1.5)
        whole.add_patch(rectangle)
    _title(whole, scene.name)
    for column in range(columns):
        image = pictures.reference.mean if column == 0 else pictures.runs[shown[column - 1].label][0]
        for row, ((x, y, w, h), colour) in enumerate(zip(crops, _cycle(len(crops)), strict=True)):
            axes = figure.add_subplot(grid[row, 1 + column])
            _show(axes, srgb_bytes(image[y : y + h, x : x + w], pictures.stops), colour)
            if row == 0:
                _title(axes, "reference" if column == 0 else _heading(shown[column - 1], scene.budget_s), 7)
    figure.supxlabel(_crops_caption(scene, shown), fontsize=7, color=INK).set_parse_math(False)
    return figure


def _heading(strategy: StrategyResult, budget: float) -> str:
    return "\n".join(filter(None, (strategy.label, short_caption(strategy, budget))))


def _crops_caption(scene: SceneResult, shown: Sequence[StrategyResult]) -> str:
    """Return the sentences on the times and errors above the crops of a scene, and on the marks of these errors."""
    lines = [
        "Each picture is one run at its end: first line, its own error and time.",
        f"Second line, as in the table: the error of all runs after the equal time, {seconds(scene.budget_s)}.",
    ]
    marks = meanings(short_caption(strategy, scene.budget_s) for strategy in shown)
    return "\n".join([*lines, *(f"{mark.strip()} {meaning}." for mark, meaning in marks.items())])


def _cycle(count: int) -> list[str]:
    return [_FRAMES[i % len(_FRAMES)] for i in range(count)]


def _show(axes: Axes, pixels: np.ndarray[tuple[int, ...], np.dtype[np.uint8]], frame: str | None = None) -> None:
    axes.imshow(pixels, interpolation="nearest")
    axes.set_xticks([])
    axes.set_yticks([])
    for spine in axes.spines.values():
        spine.set_visible(frame is not None)
        spine.set_color(frame or INK)
        spine.set_linewidth(1.5)


def _title(axes: Axes, text: str, size: float = 8) -> None:
    axes.set_title(text, fontsize=size, color=INK).set_parse_math(False)
