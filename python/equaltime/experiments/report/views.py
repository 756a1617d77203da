"""Data classes for the page templates: pictures with captions, tables, sentences."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from equaltime.experiments.report.films import FilmView
from equaltime.experiments.report.looks import Style
from equaltime.experiments.report.words import Cell

__all__ = ["Bar", "Crop", "Frame", "LossView", "SceneView", "Series", "Table", "TableRow"]


@dataclass(frozen=True)
class Crop:
    """An enlarged window of an image, as a PNG in a data URI."""

    uri: str
    window: tuple[int, int, int, int]
    """x, y, width, height in pixels of the image."""


@dataclass(frozen=True)
class Frame:
    """One picture of a series; the page shows one picture of a series at a time."""

    label: str
    look: Style | None
    """Colour, marker and line style of the strategy; None for the reference."""
    uri: str
    alt: str
    caption: str
    crops: tuple[Crop, ...] = ()

    @property
    def key(self) -> str:
        """Text that identifies the frame in its series, even if a strategy is labelled "reference"."""
        return f"strategy {self.label}" if self.look else "reference"


@dataclass(frozen=True)
class Bar:
    """Colour bar of maps: evenly spaced colours, and labels of low end, middle and high end."""

    colours: tuple[str, ...]
    ticks: tuple[str, ...]


@dataclass(frozen=True)
class Series:
    """A series of pictures, one per strategy: all are images, error maps, standard-error maps, or sample counts."""

    name: str
    slug: str
    explanation: str
    bar: Bar | None
    frames: tuple[Frame, ...]


@dataclass(frozen=True)
class LossView:
    """Two loss maps of one strategy, each with a sentence.

    The first map (``half``) marks the blocks of pixels that make half of the strategy's squared error. The second map
    (``ratio``) shows the strategy's error divided by the baseline's. ``ratio_uri`` and ``ratio_alt`` are empty without
    a second map.
    """

    label: str
    look: Style
    half_uri: str
    half_alt: str
    ratio_uri: str
    ratio_alt: str
    sentences: tuple[str, ...]


@dataclass(frozen=True)
class TableRow:
    """A row of a table: a label with tags, and the cells of each column."""

    label: str
    look: Style | None
    tags: tuple[str, ...]
    """Words beside the label: baseline, biased, or the name of another renderer."""
    cells: tuple[tuple[Cell, ...], ...]
    """Cells of each column: one number, or two numbers one below the other."""
    title: str = ""
    """Full text of the label."""


@dataclass(frozen=True)
class Table:
    """A table of numbers, with numbered footnotes below the table."""

    slug: str
    caption: str
    corner: str
    """Head of the first column."""
    columns: tuple[str, ...]
    rows: tuple[TableRow, ...]

    @property
    def footnotes(self) -> tuple[str, ...]:
        """Footnotes of all cells, each once, in reading order.

        Remarks that differ only in their first number become one footnote with the smallest and the largest number.
        """
        return tuple(_merged(same) for same in self._groups.values())

    def marks(self, cell: Cell) -> tuple[int, ...]:
        """Return the numbers of the footnotes that a cell refers to, counted from 1, in rising order."""
        order = list(self._groups)
        return tuple(sorted({order.index(_shape(remark)) + 1 for remark in _remarks(cell)}))

    @property
    def _groups(self) -> dict[str, list[str]]:
        groups: dict[str, list[str]] = {}
        for row in self.rows:
            for cells in row.cells:
                for cell in cells:
                    for remark in _remarks(cell):
                        groups.setdefault(_shape(remark), []).append(remark)
        return groups


_NUMBER = re.compile(r"\d+(?:\.\d+)?(?:e[+-]?\d+)?")
_POWER = re.compile(r"\d+(?:\.\d+)?e\+\d+")


def _remarks(cell: Cell) -> list[str]:
    """Split the note of a cell into remarks, without the prefix "this: "."""
    return [remark.removeprefix("this: ") for remark in cell.note.split("; ") if remark]


def _shape(remark: str) -> str:
    """Return the remark with its first number replaced by #; remarks that begin with a scene's name are unchanged.

    Remarks that differ only in their first number thus have one shape.
    """
    return remark if remark.startswith("on ") else _NUMBER.sub("#", remark, count=1)


def _merged(remarks: Sequence[str]) -> str:
    numbers = [found.group() for remark in remarks if (found := _NUMBER.search(remark))]
    if len(set(numbers)) < 2:
        return _spelt(remarks[0])
    least, most = min(numbers, key=float), max(numbers, key=float)
    return _spelt(_NUMBER.sub(f"{least} to {most}", remarks[0], count=1))


def _spelt(remark: str) -> str:
    """Write numbers with powers of ten in full."""
    return _POWER.sub(lambda found: f"{float(found.group()):,.0f}".replace(",", "\N{NARROW NO-BREAK SPACE}"), remark)


@dataclass(frozen=True)
class SceneView:
    """The section of a page about one scene: charts, tables, pictures and sentences."""

    slug: str
    name: str
    facts: str
    """Sentence on size, depth, reference, repeats and equal time."""
    verdict: str
    wide_chart: str
    """An ``<svg>`` element that needs no escaping; ``narrow_chart`` is another."""
    narrow_chart: str
    legend: tuple[TableRow, ...]
    tables: tuple[tuple[str, Table], ...]
    """Headings and tables, the most important for the experiment's question first."""
    points: Table
    """The numbers behind the curves."""
    notes: tuple[tuple[str, str], ...]
    """Label of a strategy and warnings about it."""
    kinds: tuple[Series, ...]
    size: tuple[int, int]
    """Width and height of the images, in pixels."""
    picture_notes: tuple[str, ...]
    losses: tuple[LossView, ...]
    loss_bar: Bar | None
    losses_intro: str
    film: FilmView | None
    files: tuple[str, ...]
    """Figure files written beside the page."""

    @property
    def aspect(self) -> str:
        """Width and height of the images as CSS text, such as ``16 / 9``."""
        return f"{self.size[0]} / {self.size[1]}"

    def split(self, crops: Sequence[Crop]) -> str:
        """Return the width of the image's column in a CSS grid, such as ``2.667fr``.

        The column of crops beside the image is 1fr wide. The image is then as high as all crops, one below the other.
        """
        heights = sum(crop.window[3] / crop.window[2] for crop in crops) or 2.0
        return f"{heights * self.size[0] / self.size[1]:.3f}fr"

    def place(self, window: tuple[int, int, int, int]) -> str:
        """Return CSS that places a window over the image, with position and size in % of the image.

        ``window`` is (x, y, width, height) in pixels of the image.
        """
        (x, y, w, h), (width, height) = window, self.size
        parts = {"left": x / width, "top": y / height, "width": w / width, "height": h / height}
        return "; ".join(f"{name}: {100.0 * part:.3f}%" for name, part in parts.items())
