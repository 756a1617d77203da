"""Follows scenes/render/README.md in an empty folder: runs its commands, edits its scene, and makes its pictures.

Usage: ``python scenes/render/make.py``, in some minutes; ``--quick`` makes tiny, noisy pictures in some seconds. Prints
each command and its answer.
"""

from __future__ import annotations

import argparse
import re
import shlex
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import chdir
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from equaltime.cli import main as equaltime
from equaltime.images import image_files as images

HERE = Path(__file__).resolve().parent
PICTURES: Final[Mapping[str, tuple[str, ...]]] = {
    "errors": ("mill", "mill 2", "mill 3"),
    "changes": ("gold", "evening"),
    "cameras": ("sails", "lens"),
    "frames": ("still", "blur"),
}
"""The renders that a picture shows side by side; ``mill 2`` is the second one that was saved as mill.exr."""
CLOSE: Final = {"errors": (0.36, 0.34, 0.80, 1.0)}
"""Window of a picture that shows a part of each render: left, top, right and bottom, in widths and heights."""
QUICK: Final = {
    r" --size \S+": "",
    r" --error \S+": " --error 60%",
    r"^equaltime (render|quote)": r"\g<0> --size 24x16",
    r"--pixel \S+": "--pixel 7,7",
}
"""What is replaced in commands for ``--quick``."""


def main() -> None:
    """Make all pictures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true")
    quick = parser.parse_args().quick
    with tempfile.TemporaryDirectory() as name, chdir(name):
        renders = dict(rendered((HERE / "README.md").read_text(encoding="utf-8"), quick))
    for name, shown in PICTURES.items():
        strip = np.concatenate([cut(renders[one], CLOSE.get(name, (0.0, 0.0, 1.0, 1.0))) for one in shown], axis=1)
        part = images.Layer(("R", "G", "B"), np.rint(255.0 * strip).astype(np.uint8), {"Compression": "jpeg:90"})
        images.write(HERE / f"{name}.jpg", "jpeg", [part])


def rendered(page: str, quick: bool) -> Iterator[tuple[str, NDArray[np.float32]]]:
    """Follow the page in the present folder, and yield the name and the preview (H, W, 3) of each render.

    Previews are in sRGB, from 0 to 1.
    """
    seen: list[str] = []
    steps = r"^```(sh|toml)\n(.*?)^```|`(equaltime [^`\n]+)`"
    for kind, block, inline in re.findall(steps, page, re.DOTALL | re.MULTILINE):
        if kind == "toml":
            edit(block)
            continue
        for command in inline.splitlines() or block.splitlines():
            run(command, quick)
            if saved := re.search(r"-o (\w+)\.exr", command):
                seen.append(saved[1])
                count = seen.count(saved[1])
                yield saved[1] if count == 1 else f"{saved[1]} {count}", images.read(Path(f"{saved[1]}.png")).image


def edit(block: str) -> None:
    """Put a block of the page in the place of those of the same names, in the file that its first line names."""
    first, changed = block.split("\n", 1)
    path = Path(first.removeprefix("# "))
    text = path.read_text(encoding="utf-8")
    for table in re.findall(r"^\[.+?\]\n.*?(?=^\[|\Z)", changed, re.DOTALL | re.MULTILINE):
        heading = table.split("\n", 1)[0]
        text, count = re.subn(
            rf"^{re.escape(heading)}\n.*?(?=^\[|\Z)", f"{table.strip()}\n\n", text, flags=re.DOTALL | re.MULTILINE
        )
        if not count:
            raise SystemExit(f"{path} has no block {heading}")
    path.write_text(text, encoding="utf-8")


def run(command: str, quick: bool) -> None:
    """Run a command of the page; one that fails ends the program."""
    for long, short in QUICK.items() if quick else ():
        command = re.sub(long, short, command)
    print(f"$ {command}", flush=True)
    if code := equaltime(shlex.split(command)[1:]):
        raise SystemExit(f"exit code {code}: {command}")


def cut(image: NDArray[np.float32], window: tuple[float, float, float, float]) -> NDArray[np.float32]:
    """Return a window of an image: left, top, right and bottom, in widths and heights."""
    height, width = image.shape[:2]
    left, top, right, bottom = (round(at * side) for at, side in zip(window, (width, height) * 2, strict=True))
    return image[top:bottom, left:right]


if __name__ == "__main__":
    main()
