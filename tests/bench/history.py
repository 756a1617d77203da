"""The core's history: instructions a path, relMSE at 64 samples a pixel and coverage, appended to history.csv.

Four scenes of `trial_scenes` are rendered with the default strategy and the same seeds each time, at x86-64-v2, to
which Embree is held too. So equal code gives equal figures on machines whose C library takes the same functions.
Instructions are those of the path loop and of Embree, counted by valgrind. Coverage is the share of renders whose
stated interval holds the realised error.

The script fails if a figure is more than 1 % worse than in the last row of its scene. A commit that is meant to change
a figure says so: a line ``History: instructions, relmse`` in the message of any commit since that row. So does one
that changes bits, because other bits scatter. Rare bright paths make most of relMSE in `mis` and `caustic`: the
standard error of its mean over these seeds is 50 and 90 % there, 2 % in `door` and 1 % in `cornell`.
"""

from __future__ import annotations

import argparse
import csv
import os
import re
import subprocess
import sys
from collections.abc import Iterator, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Final, NamedTuple

FILE: Final = Path(__file__).with_suffix(".csv")
SCENES: Final = ("cornell", "door", "mis", "caustic")
SIDE, SAMPLES = 32, 64
COUNTED: Final = 8
"""Samples a pixel while instructions are counted."""
SEEDS: Final = range(35_000_000, 35_000_060)
REFERENCE: Final = 2**14
WORSE: Final = 1.01
FIGURES: Final = ("instructions", "relmse", "coverage")


class Row(NamedTuple):
    """The figures of one scene at one commit."""

    commit: str
    date: str
    scene: str
    instructions: float
    """Of a path."""
    relmse: float
    """Mean of error² over the renders, against a reference."""
    coverage: float
    """Share of the renders whose interval holds the realised error."""

    @classmethod
    def read(cls, line: Sequence[str]) -> Row:
        """Return a row of the file."""
        return cls(*line[:3], *map(float, line[3:]))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", nargs="+", default=[*SCENES], choices=SCENES)
    parser.add_argument("--dry", action="store_true", help="append nothing")
    parser.add_argument("--render", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if os.environ.get("EQUALTIME_ISA") != "v2":  # before the core is loaded
        return subprocess.run([sys.executable, *sys.argv], env={**os.environ, "EQUALTIME_ISA": "v2"}).returncode
    if options.render:
        render(options.scenes)
        return 0
    rows = list(measured(options.scenes))
    before = [Row.read(line) for line in list(csv.reader(FILE.open()))[1:]] if FILE.exists() else []
    faults = [fault for row in rows for fault in worse(row, before)]
    for row in rows:
        print(
            f"{row.scene:8s} {row.instructions:8.1f} instructions a path, relMSE {row.relmse:.6g}, {row.coverage:.3f}"
        )
    print(*faults, sep="\n")
    if not options.dry:
        append(rows)
    return 1 if faults else 0


def measured(scenes: Sequence[str]) -> Iterator[Row]:
    """Yield the row of each scene at the commit that is checked out."""
    import numpy as np  # here: what counts instructions imports less
    from instructions import profiles
    from stated_errors import rendered
    from trial_scenes import realised_square, reference, trial_scene

    import equaltime as et

    commit = _git("describe", "--always", "--dirty", "--abbrev=10")
    date = datetime.now(UTC).strftime("%Y-%m-%d")
    counts = profiles([sys.executable, __file__, "--render", "--scenes", *scenes])
    for name, found in zip(scenes, counts, strict=True):
        truth = reference(name, SIDE, REFERENCE)
        images, stated = rendered(trial_scene(name, SIDE), et.Strategy(), SEEDS, [SAMPLES], threads=0)
        squares = [realised_square(image[0], truth) for image in images]
        errors = np.sqrt(np.maximum(squares, 0.0))
        held = [said[0].low <= error <= said[0].high for said, error in zip(stated, errors, strict=True)]
        instructions = round(found.total / (SIDE**2 * COUNTED), 1)
        yield Row(commit, date, name, instructions, float(f"{np.mean(squares):.6g}"), round(float(np.mean(held)), 4))


def render(scenes: Sequence[str]) -> None:
    """Render each scene on one thread, and have valgrind write a profile of each."""
    from trial_scenes import trial_scene

    import equaltime as et
    from equaltime.rendering.core import make_renderer

    strategy = et.Strategy.parse("best,roulette=throughput,adaptive=none")  # nothing but the estimator is counted
    for name in scenes:
        make_renderer(trial_scene(name, SIDE), strategy, SEEDS[0], 1).advance(COUNTED)
        subprocess.run(["callgrind_control", "--dump", str(os.getpid())], capture_output=True, check=True)


def worse(row: Row, before: Sequence[Row]) -> Iterator[str]:
    """Yield what is more than 1 % worse than in the last row of the scene, and not meant to be."""
    last = next((old for old in reversed(before) if old.scene == row.scene), None)
    if last is None:
        return
    meant = meant_since(last.commit)
    for figure in FIGURES:
        was, now = getattr(last, figure), getattr(row, figure)
        higher, lower = (was, now) if figure == "coverage" else (now, was)
        if figure not in meant and higher > WORSE * lower:
            yield f"WORSE: {figure} of {row.scene} from {was:g} ({last.commit}) to {now:g}"


def meant_since(commit: str) -> set[str]:
    """Return the figures that messages of commits since then name as meant to change."""
    messages = _git("log", "--format=%B", f"{commit.removesuffix('-dirty')}..HEAD")
    lines = re.findall(r"^History: *(.+)$", messages, re.MULTILINE)
    return {word for line in lines for word in re.split(r"[ ,]+", line)}


def append(rows: Sequence[Row]) -> None:
    """Append the rows to the file."""
    new = not FILE.exists()
    with FILE.open("a", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        if new:
            writer.writerow(Row._fields)
        writer.writerows(rows)


def _git(*words: str) -> str:
    done = subprocess.run(["git", *words], capture_output=True, text=True, check=True, cwd=FILE.parent)
    return done.stdout.strip()


if __name__ == "__main__":
    sys.exit(main())
