"""Instructions a path, by kernel, in a room that calls for no effect: counted by valgrind, the same each time.

What differs between kernels is what the code of effects costs a scene that does not call for them.
"""

from __future__ import annotations

import argparse
import importlib.util
import re
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from itertools import combinations
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np

SIZE, SAMPLES = 32, 8
PATHS = SIZE**2 * SAMPLES


class Profile(NamedTuple):
    """The instructions that renders took."""

    total: int
    functions: Mapping[str, int]
    """Of those without lines of source: of this project and of Embree."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--core", metavar="FILE", help="another build of equaltime._core [the installed one]")
    parser.add_argument("--render", metavar="EFFECTS", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.render is not None:
        renderer(load(options.core), options.render.split()).advance(SAMPLES)
        return
    file = options.core or find()
    core = load(file)
    names = [*core.SceneBuilder().build().effects(), "splitting"]
    kernels: dict[str, str] = {}  # each once, by what it takes to get it
    for number in (0, 1, 2, len(names)):
        for also in combinations(names, number):
            kernels.setdefault(str(renderer(core, also).kernel), " ".join(also))
    counts = {kernel: count(file, also).total for kernel, also in kernels.items()}
    plain = next(iter(counts.values()))
    for kernel, instructions in sorted(counts.items(), key=lambda item: item[1]):
        print(f"{instructions / PATHS:8.1f} a path, {instructions / plain:.4f} x: {kernel}")


def find() -> str:
    """Return the file of the installed core."""
    from equaltime import _core  # here: what counts imports nothing else

    return _core.__file__


def load(file: str) -> Any:
    """Load the core alone: all else would run under valgrind too."""
    sys.modules.setdefault("equaltime", ModuleType("equaltime"))
    spec = importlib.util.spec_from_file_location("equaltime._core", file)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def count(core: str, also: str) -> Profile:
    """Return the instructions of the kernel that covers these effects too, those of Embree included."""
    worker = [sys.executable, __file__, "--core", core, "--render", also]
    (found,) = profiles(worker)
    return found


def profiles(command: list[str]) -> list[Profile]:
    """Run a command under callgrind, and return what its renders took, each time that it asked for a profile."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "out"
        tool = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={out}", "--toggle-collect=*render_block<*&)"]
        subprocess.run([*tool, *command], capture_output=True, check=True)
        numbered = sorted(Path(folder).iterdir(), key=lambda file: (len(file.name), file.name))
        return [found for found in map(_read, numbered) if found.total]


def _read(file: Path) -> Profile:
    command = ["callgrind_annotate", "--threshold=100", "--show-percs=no", "--auto=no", str(file)]
    table = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    total = re.search(r"^ *([\d,]+)  PROGRAM TOTALS$", table, re.MULTILINE)
    functions: dict[str, int] = {}
    for line in re.finditer(r"^ *([\d,]+)  \?\?\?:(.+?)(?: \[.*\])?$", table, re.MULTILINE):
        functions[line[2]] = functions.get(line[2], 0) + _number(line[1])
    return Profile(_number(total[1]) if total else 0, functions)


def _number(digits: str) -> int:
    return int(digits.replace(",", ""))


def renderer(core: Any, also: Sequence[str]) -> Any:
    """Return a renderer of a floor and a wall under a lamp, whose kernel covers these effects too."""
    builder = core.SceneBuilder()
    grey = builder.add_bsdf("diffuse", (0.7, 0.6, 0.5))
    lamp = np.diag([0.3, -0.3, -1.0, 1.0])
    lamp[2, 3] = 2.0
    wall = np.array([[1, 0, 0, 0], [0, 0, -1, 1], [0, 1, 0, 1], [0, 0, 0, 1.0]])
    camera = np.array([[-1, 0, 0, 0], [0, 0, 1, -3], [0, 1, 0, 1], [0, 0, 0, 1.0]])
    for place, radiance in ((np.eye(4), None), (wall, None), (lamp, (17.0, 12.0, 4.0))):
        builder.add_rectangle(place, flip_normals=False, front=grey, back=grey, radiance=radiance)
    builder.set_perspective(camera, 45.0)
    builder.set_film(SIZE, SIZE, (0, 0, SIZE, SIZE), "box", 0.5)
    return core.Renderer(builder.build(), core.Settings(max_depth=8), seed=1, threads=1, also=list(also))


if __name__ == "__main__":
    main()
