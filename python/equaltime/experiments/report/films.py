"""Films of how each strategy's image converges, side by side at equal time.

The page plays the films, and an animated file shows them in real time.
"""

from __future__ import annotations

import base64
import io
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from equaltime.errors import EqualtimeError
from equaltime.experiments.model.summary import SceneResult
from equaltime.experiments.report.looks import Style
from equaltime.experiments.report.words import percent, seconds
from equaltime.experiments.run.forming import Film, read_film
from equaltime.extras import optional
from equaltime.files import replacing
from equaltime.images.preview import srgb_bytes

__all__ = ["FilmView", "Reel", "film_view", "write_animation"]

Bytes = NDArray[np.uint8]

_COLUMNS = 8
_QUALITY = 85
_TALLEST = 320
"""Approximate height of a picture in the animated file, in pixels; small pictures are enlarged by whole factors."""
_LEAST_MS = 20
"""Shortest time of a picture, in milliseconds: browsers show shorter pictures longer."""
_REST_MS = 2000
"""Time of the last picture before the animation repeats, in milliseconds."""
_MARGIN, _TEXT = 12, 15


@dataclass(frozen=True)
class Reel:
    """Film of one strategy for a page: an image file with all pictures, row by row, and the time of each picture."""

    label: str
    look: Style
    """Colour, marker and line style of the strategy on the page."""
    uri: str
    """Image file with all pictures, as a data URI."""
    alt: str
    columns: int
    rows: int
    times: tuple[float, ...]
    """Time of each picture, in seconds since the first sample."""
    says: tuple[str, ...]
    """Caption of each picture."""


@dataclass(frozen=True)
class FilmView:
    """Data with which a page plays films of converging images, one of each strategy, side by side at equal time."""

    reels: tuple[Reel, ...]
    seconds: float
    """Time of the last picture, in seconds."""
    aspect: str
    """Width and height of the pictures as CSS text, such as ``16 / 9``."""


def film_view(scene: SceneResult, looks: Mapping[str, Style], stops: float) -> FilmView | None:
    """Return the films of a scene for a page, to show how images converge; None if the scene has no films.

    All pictures are multiplied by 2 to the power ``stops``. ``looks`` gives colour, marker and line style by label of a
    strategy.
    """
    films = _films(scene)
    if not films:
        return None
    height, width = next(iter(films.values())).frames.shape[1:3]
    reels = tuple(_reel(label, film, looks[label], scene.name, stops) for label, film in films.items())
    return FilmView(reels, _end(films), f"{width} / {height}")


def write_animation(folder: Path, slug: str, scene: SceneResult, stops: float) -> tuple[str, ...]:
    """Write the films of all strategies on a scene, side by side, into one animated WebP file in ``folder``.

    A film shows how an image converges. Returns the name of the file, ``FOLDER/SLUG-forming.webp``, in a tuple, which
    is empty without films. ``slug`` is the scene's name as a file name. All pictures are multiplied by 2 to the power
    ``stops``.
    """
    films = _films(scene)
    if not films:
        return ()
    times = _moments(films)
    pictures = [_side_by_side(films, time, stops) for time in times]
    lasts = [*np.diff(times), _REST_MS / 1000.0]
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{slug}-forming.webp"
    with replacing(path) as file:
        pictures[0].save(
            file,
            "WEBP",
            save_all=True,
            append_images=pictures[1:],
            duration=[max(_LEAST_MS, round(1000.0 * float(last))) for last in lasts],
            loop=0,
            quality=_QUALITY,
            method=2,
        )
    return (f"{folder.name}/{path.name}",)


def _films(scene: SceneResult) -> dict[str, Film]:
    """Read the films of the first one's size; unreadable films are left out."""
    films: dict[str, Film] = {}
    for strategy in scene.strategies:
        if strategy.film is None:
            continue
        try:
            film = read_film(strategy.film)
        except EqualtimeError:
            continue
        shapes = {one.frames.shape[1:] for one in films.values()} or {film.frames.shape[1:]}
        if len(film.frames) and film.frames.shape[1:] in shapes:
            films[strategy.label] = film
    return films


def _end(films: Mapping[str, Film]) -> float:
    return max(float(film.seconds[-1]) for film in films.values())


def _reel(label: str, film: Film, look: Style, scene: str, stops: float) -> Reel:
    count = len(film.frames)
    columns = min(_COLUMNS, count)
    rows = math.ceil(count / columns)
    says = tuple(_said(film, number) for number in range(count))
    alt = f"{scene} forming by {label}: {count} pictures, the first after {says[0]}, the last after {says[-1]}"
    return Reel(label, look, _sheet(film, columns, rows, stops), alt, columns, rows, tuple(film.seconds.tolist()), says)


def _said(film: Film, number: int) -> str:
    error = float(film.error[number])
    known = f"; error of this run: {percent(error)}" if math.isfinite(error) else ""
    return f"{seconds(float(film.seconds[number]))}, {int(film.spp[number])} spp{known}"


def _sheet(film: Film, columns: int, rows: int, stops: float) -> str:
    """Put all pictures of a film onto one sheet, and return the sheet as a data URI."""
    count, height, width = film.frames.shape[:3]
    sheet = np.zeros((rows * height, columns * width, 3), np.uint8)
    for number in range(count):
        y, x = number // columns * height, number % columns * width
        sheet[y : y + height, x : x + width] = srgb_bytes(film.frames[number], stops)
    buffer = io.BytesIO()
    optional("PIL.Image").fromarray(sheet).save(buffer, "WEBP", quality=_QUALITY, method=4)
    return "data:image/webp;base64," + base64.b64encode(buffer.getvalue()).decode()


def _moments(films: Mapping[str, Film]) -> list[float]:
    """Return the times at which any picture changes, from 0 on; changes within 20 ms are merged."""
    times = sorted({float(time) for film in films.values() for time in film.seconds})
    kept = [0.0]
    for time in times:
        if time - kept[-1] >= _LEAST_MS / 1000.0:
            kept.append(time)
    return kept if kept[-1] == times[-1] else [*kept[:-1], times[-1]]


def _side_by_side(films: Mapping[str, Film], time: float, stops: float) -> Any:
    """Return all films at one time, each with its label above and its caption below."""
    image, draw, font = optional("PIL.Image"), optional("PIL.ImageDraw"), optional("PIL.ImageFont")
    height, width = next(iter(films.values())).frames.shape[1:3]
    factor = max(1, round(_TALLEST / height))
    tall, wide = factor * height, factor * width
    line = _TEXT + 7
    size = (len(films) * (wide + _MARGIN) + _MARGIN, tall + 2 * line + 2 * _MARGIN)
    page = image.new("RGB", size, "white")
    pen, letters = draw.Draw(page), font.load_default(_TEXT)
    for place, (label, film) in enumerate(films.items()):
        x = _MARGIN + place * (wide + _MARGIN)
        number = int(np.searchsorted(film.seconds, time, side="right")) - 1
        pen.text((x, _MARGIN - 4), label, fill="#1b1f24", font=letters)
        said = "no sample yet" if number < 0 else _said(film, number).replace("\N{NARROW NO-BREAK SPACE}", " ")
        pen.text((x, _MARGIN + line + tall + 2), said, fill="#5c6470", font=letters)
        pixels = np.zeros((height, width, 3), np.uint8) if number < 0 else srgb_bytes(film.frames[number], stops)
        page.paste(image.fromarray(pixels).resize((wide, tall), image.Resampling.NEAREST), (x, _MARGIN + line))
    return page
