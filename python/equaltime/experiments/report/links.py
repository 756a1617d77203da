"""Links from a report to the files beside it, for the reader to open next."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from equaltime.images.image_files import SOFTWARE

__all__ = ["Link", "next_links"]

_HEAD = 1000
"""Letters at the beginning of a page in which it names the software that made it."""


@dataclass(frozen=True)
class Link:
    """A file beside a report, and a description of its contents."""

    path: str
    """Path relative to the report."""
    words: str


_FILES = (
    ("records.csv", "every measured number, one row for each checkpoint of each run"),
    ("figures/", "the charts and pictures as PDF and PNG, for papers"),
    ("experiment.json", "the experiment as it ran: scenes, strategies, sizes, times"),
)


def next_links(folder: Path) -> tuple[Link, ...]:
    """Return links to the files beside the report in ``folder``, and to the page of all experiments if there is one."""
    index = folder.parent / "index.html"
    found = [Link("../index.html", "all experiments of this folder, beside the claims that they test")]
    return (
        *(found if _is_ours(index) else ()),
        *(Link(path, words) for path, words in _FILES if (folder / path).exists()),
    )


def _is_ours(page: Path) -> bool:
    """Tell whether a page was made by this software."""
    try:
        with page.open(encoding="utf-8", errors="replace") as file:
            return f'content="{SOFTWARE.split()[0]} ' in file.read(_HEAD)
    except OSError:
        return False
