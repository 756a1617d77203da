"""Pictures of rays that leave a surface, drawn by uniform and by BSDF sampling, one column per scene."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from equaltime.errors import EqualtimeError
from equaltime.experiments.model.summary import Summary
from equaltime.experiments.report.figures import themed, write_figure
from equaltime.experiments.report.looks import GRID, INK, LIGHT, MUTED
from equaltime.experiments.report.words import percent
from equaltime.experiments.run.directions import WO, Rays, read_directions
from equaltime.extras import optional

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["RaysView", "draw_rays", "rays_view", "write_rays"]

Directions = Mapping[str, Mapping[str, Rays]]
Floats = NDArray[np.float64]

_WAYS = {"uniform": "uniform", "bsdf": "from the BSDF"}
_CARRIES = 0.05
"""Rays with less than this share of the mean weight are drawn faint, as carrying no light."""
_TILT = math.radians(14.0)
"""Angle in radians by which the hemisphere is viewed from above."""
_LIGHT = LIGHT[1]


@dataclass(frozen=True)
class RaysView:
    """Pictures of directions that were sampled uniformly and from the BSDF, and a table of each technique's efficiency.

    All are for an experiment's page. The pictures show the sampled directions as rays that leave a surface. The table
    gives the effective share of the samples: the effective sample size over the number of samples. It is 100 % if all
    samples have equal weights.
    """

    wide: Any
    """Picture for wide screens, with all scenes side by side: an ``<svg>`` element that needs no escaping."""
    narrow: Any
    """Picture for narrow screens (phones), with two scenes side by side: an ``<svg>`` element that needs no escaping.
    """
    rows: tuple[tuple[str, str, str], ...]
    """Rows of the table: scene, and the effective share of uniform and of BSDF samples as text."""
    files: tuple[str, ...]
    """Names of the files (PDF and PNG) that hold the wide picture."""


def rays_view(summary: Summary, folder: Path) -> RaysView | None:
    """Return the pictures of the rays that an experiment has drawn by uniform and by BSDF sampling, for its page.

    They are also written as PDF and PNG to ``folder/figures``. Returns None if the experiment has no file of rays, or
    the file cannot be read.
    """
    if summary.directions is None:
        return None
    try:
        directions = read_directions(summary.directions)
    except EqualtimeError:
        return None
    if not directions:
        return None
    rows = tuple((name, _effective(rays["uniform"]), _effective(rays["bsdf"])) for name, rays in directions.items())
    words = "; ".join(f"{name}: {uniform} uniform, {bsdf} from the BSDF" for name, uniform, bsdf in rows)
    alt = f"Rays that leave a surface, drawn uniformly and from its BSDF. Effective samples of {words}."
    wide = themed(draw_rays(directions, len(directions)), "rays-wide", alt)
    narrow = themed(draw_rays(directions, 2), "rays-narrow", alt)
    return RaysView(wide, narrow, rows, write_rays(folder / "figures", directions))


def write_rays(folder: Path, directions: Directions) -> tuple[str, ...]:
    """Write one picture of all scenes' rays as PDF and PNG to ``folder``; return the names of the files.

    ``directions`` holds the rays by name of the scene and then by technique.
    """
    return write_figure(draw_rays(directions, len(directions)), folder, "directions")


def draw_rays(directions: Directions, columns: int) -> Figure:
    """Return a figure of every scene's rays, with ``columns`` scenes side by side.

    ``directions`` holds the rays by name of the scene and then by technique. For each scene, uniform sampling is drawn
    above BSDF sampling.
    """
    bands = math.ceil(len(directions) / columns)
    size = (1.4 * columns, bands * 2.55)
    figure: Figure = optional("matplotlib.figure").Figure(figsize=size, facecolor="none")
    figure.set_layout_engine("constrained", w_pad=0.02, h_pad=0.02, wspace=0.02, hspace=0.02)
    grid = figure.add_gridspec(2 * bands, columns)
    for place, (name, rays) in enumerate(directions.items()):
        band, column = divmod(place, columns)
        mean = float(rays["bsdf"].weight.mean())  # equal in expectation for both, with less noise here
        for row, way in enumerate(_WAYS):
            axes = figure.add_subplot(grid[2 * band + row, column])
            _draw(axes, rays[way], max(mean, 1e-30))
            if row == 0:
                axes.set_title(name, fontsize=11, color=INK, pad=5).set_parse_math(False)
            words = f"{_WAYS[way]}\n{_effective(rays[way])}"
            axes.text(0.0, -0.3, words, fontsize=9, color=INK, ha="center", va="top")
    return figure


def _draw(axes: Axes, rays: Rays, mean: float) -> None:
    """Draw a hemisphere on its disk, the incoming ray and the outgoing rays; rays that carry no light are faint."""
    angle = np.linspace(0.0, 2.0 * np.pi, 73)
    rim = _flat(np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], axis=1))
    axes.plot(rim[:, 0], rim[:, 1], color=GRID, linewidth=0.8, zorder=1)
    axes.plot(np.cos(angle[:37]), np.sin(angle[:37]), color=GRID, linewidth=0.8, zorder=1)
    carries = rays.weight > _CARRIES * mean
    _lines(axes, rays.wi[~carries], MUTED, np.full((~carries).sum(), 0.22), 0.5, 2)
    strength = np.minimum(rays.weight[carries] / (2.0 * mean), 1.0)
    _lines(axes, rays.wi[carries], _LIGHT, 0.15 + 0.75 * np.sqrt(strength), 0.9, 3)
    tail = _flat(1.02 * WO[None, :])[0]
    axes.annotate(
        "", (0.06 * tail[0], 0.06 * tail[1]), tail, zorder=4, arrowprops={"arrowstyle": "-|>", "color": INK, "lw": 1.4}
    )
    axes.set(xlim=(-1.08, 1.08), ylim=(-0.78, 1.06), aspect="equal")
    axes.axis("off")


def _lines(axes: Axes, ends: Floats, colour: str, alphas: Floats, width: float, order: int) -> None:
    segments = [((0.0, 0.0), tuple(end)) for end in _flat(ends)]
    red, green, blue = optional("matplotlib.colors").to_rgb(colour)
    colours = [(red, green, blue, round(float(alpha), 2)) for alpha in alphas]
    collection = optional("matplotlib.collections").LineCollection
    axes.add_collection(collection(segments, colors=colours, linewidths=width, zorder=order), autolim=False)


def _flat(points: Floats) -> Floats:
    """Project points (N, 3) onto the picture: x to the left (the viewer's side), z up, seen from slightly above."""
    height = points[:, 2] * math.cos(_TILT) + points[:, 1] * math.sin(_TILT)
    return np.stack([-points[:, 0], height], axis=1)


def _effective(rays: Rays) -> str:
    """Format the effective share of the samples in %; a mirror has "one direction"."""
    if math.isnan(rays.effective):
        return "one direction"
    part = float(f"{rays.effective:.2g}")
    return f"{percent(part)} effective"
