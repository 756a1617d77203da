"""Renders the picture of README.md: the Cornell box at errors of 30, 10, 3 and 1 %, side by side.

Usage: ``python scenes/gallery/errors.py``. One render is shown when its error first falls to each of the four.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import equaltime as et
from equaltime.images import image_files as images
from equaltime.images.preview import srgb_bytes

SCENES = Path(__file__).resolve().parents[1]
ERRORS = (0.30, 0.10, 0.03, 0.01)
BRIGHTER = 2.0
"""Factor of all pixels: one stop, since most of the room is dark beside its lamp."""


def main() -> None:
    """Render the picture."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--size", type=int, default=240, help="pixels along each side [%(default)s]")
    parser.add_argument("--to", type=Path, default=SCENES / "errors.png", help="[scenes/errors.png]")
    parser.add_argument("--errors", type=float, nargs="+", default=ERRORS, help=argparse.SUPPRESS)
    options = parser.parse_args()
    scene = et.load(SCENES / "cornell-box.toml").with_(size=(options.size, options.size))
    strip = np.concatenate(forming(scene, options.errors), axis=1)
    images.write(options.to, "png", [images.Layer(("R", "G", "B"), srgb_bytes(BRIGHTER * strip), {})])


def forming(scene: et.Scene, errors: list[float]) -> list[NDArray[np.float32]]:
    """Return the image (H, W, 3) of one render at the first pass at which its error is at most each of ``errors``."""
    found: list[NDArray[np.float32]] = []
    for state in et.progressive(scene, error=min(errors), strategy="best,adaptive=none"):
        while len(found) < len(errors) and state.error.value <= sorted(errors, reverse=True)[len(found)]:
            found.append(np.array(state.image))
            print(f"{state.error:%} at {state.spp:g} spp")
    return found


if __name__ == "__main__":
    main()
