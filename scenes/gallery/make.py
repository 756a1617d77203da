"""Renders the pictures of the gallery and writes the list of them in scenes/README.md.

Usage: ``python scenes/gallery/make.py [NAME ...]``: the pictures that are named are made anew, or all.
"""

from __future__ import annotations

import argparse
import re
import sys
import tempfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from pictures import PICTURES
from stage import SIDE, Dict

import equaltime as et
from equaltime.images import image_files as images
from equaltime.images.preview import srgb_bytes

HERE = Path(__file__).resolve().parent
README = HERE.parent / "README.md"
IN_A_ROW = 6
BEGIN, END = "<!-- gallery -->", "<!-- end of the gallery -->"


def main() -> None:
    """Make what is asked for."""
    scenes = {name: scene for group in PICTURES.values() for name, scene in group.items()}
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME")
    parser.add_argument("--spp", type=int, default=128)
    options = parser.parse_args()
    if unknown := set(options.names) - set(scenes):
        parser.error(f"no picture of {', '.join(sorted(unknown))}")
    for name in options.names or scenes:
        with tempfile.TemporaryDirectory() as folder:
            pixels = rendered(scenes[name](Path(folder)), options.spp)
        write(HERE / f"{name}.jpg", pixels)
        print(name, file=sys.stderr)
    text = README.read_text(encoding="utf-8")
    listed = f"{BEGIN}\n{table()}\n{END}"
    README.write_text(re.sub(f"{BEGIN}.*{END}", lambda _: listed, text, flags=re.DOTALL), encoding="utf-8")


def rendered(scene: Dict, spp: int) -> NDArray[np.float64]:
    """Return the picture (SIDE, SIDE, 3), linear: of a depth or normals if there are some, else the image."""
    result = et.render(scene, spp=spp, seed=1)
    image = np.asarray(result.image, np.float64)
    if "depth.T" in result.aovs:
        depth = result.aovs["depth.T"][..., None]
        image = np.repeat(np.where(depth > 0, np.exp(-0.25 * np.maximum(depth - 4, 0)), 0), 3, axis=2)
    elif result.aovs:
        normals = np.stack(list(result.aovs.values()), axis=-1)
        image = np.where(normals.any(axis=-1, keepdims=True), 0.5 + 0.5 * normals, 0.0)
    times = SIDE // len(image)
    return image.repeat(times, axis=0).repeat(times, axis=1)


def write(path: Path, image: NDArray[np.float64]) -> None:
    """Write a small JPEG file."""
    part = images.Layer(("R", "G", "B"), srgb_bytes(image), {"Compression": "jpeg:90"})
    images.write(path, "jpeg", [part])


def table() -> str:
    """Return the rows of pictures, each with its plugin's name below."""
    lines = []
    for title, group in PICTURES.items():
        names = list(group)
        for row in (names[i : i + IN_A_ROW] for i in range(0, len(names), IN_A_ROW)):
            cells = [f'<img src="gallery/{name}.jpg" alt="{name}" width="{SIDE}"><br>`{name}`' for name in row]
            lines += ["", f"**{title}**", "", f"| {' | '.join(cells)} |", "|" + "---|" * len(cells)]
            title += ", more"
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    main()
