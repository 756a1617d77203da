"""The command ``equaltime open``: shows a report in the browser."""

from __future__ import annotations

import webbrowser
from pathlib import Path
from typing import Annotated

import typer

from equaltime.errors import EqualtimeError

__all__ = ["open"]

_PAGES = ("report.html", "index.html")


def open(
    folder: Annotated[
        Path,
        typer.Argument(metavar="DIR", help="Folder that equaltime cost wrote, or a page in it.", show_default=False),
    ],
) -> int:
    """Open the report of an experiment in the browser.

    Opens `DIR/report.html`, or `DIR/index.html` for a folder of experiments, and prints the path of the page. Without a
    browser, it only prints the path.
    """
    page = _page(folder)
    print(page)
    webbrowser.open(page.resolve().as_uri())
    return 0


def _page(folder: Path) -> Path:
    if folder.is_file() and folder.suffix == ".html":
        return folder
    for name in _PAGES:
        if (folder / name).is_file():
            return folder / name
    if not folder.is_dir():
        raise EqualtimeError(f"{folder}: is no folder; expected the DIR of 'equaltime cost SCENE -o DIR'")
    raise EqualtimeError(
        f"{folder}: has neither {' nor '.join(_PAGES)}; make one with 'equaltime cost SCENE -o {folder}'"
    )
