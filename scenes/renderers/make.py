"""Measures renderers side by side, and writes the tables of scenes/renderers/README.md.

Usage: ``python scenes/renderers/make.py [DIR]``: runs ``scenes/experiments/against-mitsuba.toml`` into DIR (by default
``build/renderers``), or goes on there, for half an hour on a machine with nothing else to do. Needs the extras
``report`` and ``peers``, and a libLLVM for Mitsuba.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from importlib.metadata import version
from pathlib import Path

import equaltime as et
from equaltime.experiments.model.summary import SceneResult, StrategyResult
from equaltime.experiments.report.words import marked, meanings, percent, same_cell, seconds_cell
from equaltime.statistics.intervals import UNKNOWN

HERE = Path(__file__).resolve().parent
EXPERIMENT = HERE.parent / "experiments" / "against-mitsuba.toml"
BEGIN, END = "<!-- tables -->\n", "<!-- end -->\n"


def main(folder: str = "build/renderers") -> None:
    """Measure into a folder, and write the tables into the page."""
    summary = et.cost(EXPERIMENT, folder)
    page = HERE / "README.md"
    before, _, rest = page.read_text(encoding="utf-8").partition(BEGIN)
    _, _, after = rest.partition(END)
    lines = [*tables(summary), *machine(summary)]
    page.write_text(before + BEGIN + "\n".join(lines) + "\n" + END + after, encoding="utf-8")


def tables(summary: et.Summary) -> Iterator[str]:
    """Yield one table: a row for each renderer on each scene, with its times to the targets; then what marks mean."""
    targets, rows = summary.targets, list[str]()
    yield ""
    yield f"| scene | renderer | {' | '.join(f'to {percent(target)}' for target in targets)} | same picture |"
    yield f"|---|---|{'---|' * len(targets)}---|"
    for scene in summary.scenes:
        for number, strategy in enumerate(scene.strategies):
            rows.append(row(scene if number == 0 else None, strategy, targets))
    yield from rows
    yield ""
    yield from (f"`{mark.strip()}`: {meaning}.\n" for mark, meaning in meanings(rows).items())
    if any("| unknown |" in one for one in rows):
        errors = sorted(scene.reference_error for scene in summary.scenes)
        ends = " to ".join(percent(error) for error in (errors[0], errors[-1]))
        yield f"`unknown`: beyond the runs, no time is given to an error below the reference's own, here {ends}.\n"


def row(scene: SceneResult | None, strategy: StrategyResult, targets: tuple[float, ...]) -> str:
    """Return the row of a renderer; the scene is named in the first row of its renderers."""
    name = "" if scene is None else f"{scene.name}, {scene.size[0]}x{scene.size[1]}"
    found = (strategy.time_to.get(target, UNKNOWN) for target in targets)
    times = (marked(str(seconds_cell(time)), time) for time in found)
    agrees = same_cell(strategy.picture_p, strategy.another_picture).text
    return f"| {name} | {strategy.label} | {' | '.join(times)} | {agrees} |"


def machine(summary: et.Summary) -> Iterator[str]:
    """Yield the machines and the builds with which the times were measured."""
    for facts in summary.provenance["machines"].values():
        yield f"Measured on {facts['cpu']}, {facts['processors']} processors, {facts['memory_bytes'] / 2**30:.0f} GiB."
    for facts in summary.provenance["builds"].values():
        built = f"{facts['compiler']}, {facts['target']}, Embree {facts['embree']} with {facts['embree_isa']}"
        yield f"Version {facts['version']} of equaltime, {built}."
    yield f"Mitsuba {version('mitsuba')}, llvm_ad_rgb."


if __name__ == "__main__":
    main(*sys.argv[1:])
