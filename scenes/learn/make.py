"""Renders the pictures of scenes/learn/README.md, and writes the table below each.

Usage: ``python scenes/learn/make.py [NAME ...]``: the rows that are named are made anew, or all, in some minutes. No
clock takes part. Pictures of a row that are compared take the same number of rays a pixel, or the same samples a pixel.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rows import ROWS, Picture, Row

import equaltime as et
from equaltime.images import image_files as images
from equaltime.images.preview import srgb_bytes
from equaltime.statistics.in_words import in_percent

HERE = Path(__file__).resolve().parent
PILOT = 8
"""Samples a pixel of the render that tells how many rays a sample takes."""


@dataclass(frozen=True)
class Made:
    """A rendered picture, with the numbers of its row in the table."""

    picture: Picture
    image: NDArray[Any]
    spp: int
    rays: float
    error: et.Interval
    samples: NDArray[Any] = field(repr=False)
    parts: Mapping[str, et.Interval] = field(default_factory=dict)
    """Errors in the windows `Row.parts`, by name."""


def main() -> None:
    """Make the rows that are asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME")
    parser.add_argument("--size", type=int, default=128, help="pixels along each side [%(default)s]")
    parser.add_argument("--reference", type=int, default=1024, help="samples a pixel of references [%(default)s]")
    options = parser.parse_args()
    if unknown := set(options.names) - set(ROWS):
        parser.error(f"no row {', '.join(sorted(unknown))}")
    readme = HERE / "README.md"
    for name in options.names or ROWS:
        made = rendered(ROWS[name], options.size, options.reference)
        strip = np.concatenate([shown(one, ROWS[name]) for one in made], axis=1)
        images.write(HERE / f"{name}.jpg", "jpeg", [images.Layer(("R", "G", "B"), strip, {"Compression": "jpeg:90"})])
        begin, end = f"<!-- {name} -->", f"<!-- end of {name} -->"
        listed = f"{begin}\n{table(ROWS[name], made)}\n{end}"
        text = re.sub(f"{begin}.*{end}", lambda _, new=listed: new, readme.read_text(), flags=re.DOTALL)  # type: ignore[misc]
        readme.write_text(text)
        print(name, file=sys.stderr)


def rendered(row: Row, size: int, reference_spp: int) -> list[Made]:
    """Render the pictures of a row, each with the samples that the row's rays a pixel buy."""
    references: dict[str, et.Result] = {}
    found = []
    for picture in row.pictures:
        scene = scene_of(picture, size)
        key = f"{picture.scene} {sorted(picture.define.items())}"
        if key not in references:
            references[key] = et.render(scene, spp=reference_spp, strategy="best", seed=99)
        spp = picture.spp or affordable(scene, picture, row.rays)
        result = et.render(scene, spp=spp, strategy=picture.strategy, seed=1)
        error = et.compare(result, references[key]).images[0].metrics["error"]
        parts = {name: error_in(scene, window, picture, spp, reference_spp) for name, window in row.parts.items()}
        found.append(Made(picture, result.image, spp, rays_of(result), error, result.samples, parts))
    return found


def error_in(
    scene: et.Scene, window: tuple[float, float, float, float], picture: Picture, spp: int, reference_spp: int
) -> et.Interval:
    """Return the error in a window of a picture, given by fractions of width and height."""
    width, height = scene.size
    sides = (width, height, width, height)
    part = scene.with_(crop=tuple(round(side * share) for side, share in zip(sides, window, strict=True)))
    reference = et.render(part, spp=reference_spp, strategy="best", seed=99)
    result = et.render(part, spp=spp, strategy=picture.strategy, seed=1)
    return et.compare(result, reference).images[0].metrics["error"]


def scene_of(picture: Picture, size: int) -> et.Scene:
    """Return the picture's scene, ``size`` pixels wide."""
    scene = et.load(HERE.parent / picture.scene, **picture.define)
    width, height = scene.size
    return scene.with_(size=(size, max(1, round(size * height / width))))


def affordable(scene: et.Scene, picture: Picture, rays: float) -> int:
    """Return the samples a pixel, at least 1, that take about ``rays`` rays a pixel."""
    pilot = et.render(scene, spp=PILOT, strategy=picture.strategy, seed=7)
    return max(1, round(PILOT * rays / rays_of(pilot)))


def rays_of(result: et.Result) -> float:
    """Return rays a pixel, shadow rays included."""
    return (result.stats.rays + result.stats.shadow_rays) / result.samples.size


def shown(made: Made, row: Row) -> NDArray[np.uint8]:
    """Return a picture as eight-bit sRGB, or the map of its samples: bright where there are many."""
    if made.picture.show == "samples":
        share = made.samples / made.samples.max()
        return srgb_bytes(np.repeat((0.1 + 0.9 * share)[..., None], 3, axis=2) ** 2.2)
    return srgb_bytes(2.0**row.stops * made.image)


def table(row: Row, made: Sequence[Made]) -> str:
    """Return the picture and its table in Markdown."""
    name = next(key for key, value in ROWS.items() if value is row)
    lines = [f"![{'; '.join(one.picture.label for one in made)}]({name}.jpg)", ""]
    cells: Mapping[str, list[str]] = {
        "from left to right": [one.picture.label for one in made],
        "scene": [scene_cell(one.picture) for one in made],
        "`--strategy`": [f"`{one.picture.strategy}`" for one in made],
        "samples a pixel": [str(one.spp) for one in made],
        "rays a pixel": [f"{one.rays:,.0f}" for one in made],
        "error": [error_cell(one.error) for one in made],
        **{f"error where {part}": [error_cell(one.parts[part]) for one in made] for part in row.parts},
    }
    first, *others = cells.items()
    lines += [f"| {' | '.join((first[0], *first[1]))} |", "|" + "---|" * (len(made) + 1)]
    lines += [f"| {' | '.join((what, *said))} |" for what, said in others]
    return "\n".join(lines)


def error_cell(error: et.Interval) -> str:
    """Return an error with its interval, or that it is not known."""
    return in_percent(error) if error.trusted else "unknown"


def scene_cell(picture: Picture) -> str:
    """Return a link to the picture's scene, with its definitions."""
    defined = "".join(f" `-D {name}={value}`" for name, value in picture.define.items())
    return f"[{Path(picture.scene).stem}](../{picture.scene}){defined}"


if __name__ == "__main__":
    main()
