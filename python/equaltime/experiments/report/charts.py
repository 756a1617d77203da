"""Charts for a page, as SVG in the colours of the page's theme; the page has its own legend."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from equaltime.experiments.model.summary import SceneResult, Summary
from equaltime.experiments.report.curves import GRID, INK, MUTED, curve_gid, draw_curves, point_titles
from equaltime.experiments.report.dots import draw_dots
from equaltime.experiments.report.looks import LIGHT, Look
from equaltime.experiments.report.svg import inline_svg
from equaltime.experiments.report.words import percent, seconds
from equaltime.extras import optional

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["NARROW", "SMALL", "WIDE", "chart", "dots", "themed"]

WIDE, NARROW, SMALL = (8.6, 4.6), (4.4, 4.0), (4.2, 2.9)
"""Width and height of a chart in inches: for a desktop, for a phone, and for one of many on a page."""


def chart(
    scene: SceneResult, prefix: str, targets: Sequence[float], looks: Mapping[str, Look], size: tuple[float, float]
) -> Any:
    """Return a scene's curves as an ``<svg>`` element whose ids begin with ``prefix``."""
    titles = {curve_gid(order): point_titles(strategy) for order, strategy in enumerate(scene.strategies)}
    labels = ", ".join(strategy.label for strategy in scene.strategies)
    description = (
        f"Error against time on {scene.name}, both logarithmic, one curve each for {labels}; "
        f"equal time is {seconds(scene.budget_s)}. The numbers stand in a table of the report."
    )
    return themed(draw_curves(scene, targets, looks, size, legend=False), prefix, description, titles)


def dots(summary: Summary, prefix: str, target: float, looks: Mapping[str, Look], width: float) -> Any:
    """Return the times to an error on all scenes as an ``<svg>`` element whose ids begin with ``prefix``."""
    names = ", ".join(scene.name for scene in summary.scenes)
    description = (
        f"Time to an error of {percent(target)}, logarithmic, one row each for {names}, one dot each for "
        f"{', '.join(looks)}. The numbers stand in a table of the report."
    )
    return themed(draw_dots(summary, target, looks, width), prefix, description)


def themed(figure: Figure, prefix: str, description: str, titles: Mapping[str, Sequence[str]] | None = None) -> Any:
    """Return a figure as an ``<svg>`` element in the colours of the page, light or dark."""
    colours = {colour: f"var(--s{index})" for index, colour in enumerate(LIGHT)}
    colours |= {"#ffffff": "var(--page)", INK: "var(--ink)", MUTED: "var(--muted)", GRID: "var(--grid)"}
    return optional("markupsafe").Markup(inline_svg(figure, prefix, colours, titles or {}, description))
