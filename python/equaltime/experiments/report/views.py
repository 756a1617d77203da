"""What a page shows, as values ready for its template: pictures with captions, tables, sentences."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from equaltime.experiments.report.films import FilmView
from equaltime.experiments.report.looks import Look
from equaltime.experiments.report.words import Cell

__all__ = ["Bar", "Crop", "Frame", "Kind", "LossView", "Row", "SceneView", "Table"]


@dataclass(frozen=True)
class Crop:
    """A window of an image, shown enlarged."""

    uri: str
    window: tuple[int, int, int, int]
    """x, y, width, height in pixels of the image."""


@dataclass(frozen=True)
class Frame:
    """One picture of a series that can be flipped through."""

    label: str
    look: Look | None
    """None for the reference."""
    uri: str
    alt: str
    caption: str
    crops: tuple[Crop, ...] = ()

    @property
    def key(self) -> str:
        """What no other frame of the series has: a strategy may be labelled "reference"."""
        return f"strategy {self.label}" if self.look else "reference"


@dataclass(frozen=True)
class Bar:
    """The colour bar of maps: evenly spaced colours and what the ends and the middle stand for."""

    colours: tuple[str, ...]
    ticks: tuple[str, ...]


@dataclass(frozen=True)
class Kind:
    """A series of pictures of one kind: the images, their errors, their standard errors, their sample counts."""

    name: str
    slug: str
    explanation: str
    bar: Bar | None
    frames: tuple[Frame, ...]


@dataclass(frozen=True)
class LossView:
    """Where one strategy loses: a map or two, and sentences."""

    label: str
    look: Look
    half_uri: str
    half_alt: str
    ratio_uri: str
    ratio_alt: str
    sentences: tuple[str, ...]


@dataclass(frozen=True)
class Row:
    """A row of a table."""

    label: str
    look: Look | None
    tags: tuple[str, ...]
    """Words beside the label: baseline, biased."""
    cells: tuple[tuple[Cell, ...], ...]
    """Of each column: one number, or a number and another below it."""
    title: str = ""
    """The label in full."""


@dataclass(frozen=True)
class Table:
    """A table of numbers; what must be said of them is numbered and stands below."""

    slug: str
    caption: str
    corner: str
    """Head of the first column."""
    columns: tuple[str, ...]
    rows: tuple[Row, ...]

    @property
    def footnotes(self) -> tuple[str, ...]:
        """Everything that is said of cells, once each, in the order of reading.

        What differs in a number alone is one footnote, with the least and the greatest number.
        """
        return tuple(_merged(same) for same in self._groups.values())

    def marks(self, cell: Cell) -> tuple[int, ...]:
        """Return the numbers, from 1, of a cell's footnotes."""
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
    """Take the note of a cell apart; a remark on "this" strategy, beside one on the baseline, is what it is alone."""
    return [remark.removeprefix("this: ") for remark in cell.note.split("; ") if remark]


def _shape(remark: str) -> str:
    """Return what is the same in remarks that differ in their first number alone; in a scene's name it is no number."""
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
    """One scene's part of the page."""

    slug: str
    name: str
    facts: str
    """Size, depth, reference, equal time in a line."""
    verdict: str
    wide_chart: str
    """``<svg>`` elements, safe as they are."""
    narrow_chart: str
    legend: tuple[Row, ...]
    tables: tuple[tuple[str, Table], ...]
    """Headings and tables, in the order of their weight for what is asked."""
    points: Table
    """The numbers behind the curves."""
    notes: tuple[tuple[str, str], ...]
    """Label and what is to be known of it."""
    kinds: tuple[Kind, ...]
    size: tuple[int, int]
    """Width, height of the images in pixels."""
    picture_notes: tuple[str, ...]
    losses: tuple[LossView, ...]
    loss_bar: Bar | None
    losses_intro: str
    film: FilmView | None
    files: tuple[str, ...]
    """Figure files written beside the page."""

    @property
    def aspect(self) -> str:
        """Width over height of the images, as CSS writes it."""
        return f"{self.size[0]} / {self.size[1]}"

    def split(self, crops: Sequence[Crop]) -> str:
        """Return the CSS width of the image beside a column of its crops, one wide, of the same height."""
        heights = sum(crop.window[3] / crop.window[2] for crop in crops) or 2.0
        return f"{heights * self.size[0] / self.size[1]:.3f}fr"

    def place(self, window: tuple[int, int, int, int]) -> str:
        """Return the CSS that puts a window where it belongs on the image."""
        (x, y, w, h), (width, height) = window, self.size
        parts = {"left": x / width, "top": y / height, "width": w / width, "height": h / height}
        return "; ".join(f"{name}: {100.0 * part:.3f}%" for name, part in parts.items())
