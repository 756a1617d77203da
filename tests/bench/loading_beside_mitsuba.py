"""Seconds and memory to load scenes of Mitsuba's, over those of Mitsuba 3 with the same file, and for glTF our own.

From the file to the first ray, in a process of its own each time that has loaded a small scene before, so that
libraries and plugins are there; files are in the system's cache. Memory is what the process has grown by once the scene
is built, and at its peak meanwhile. `--threads` is not used: neither can be told for loading.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from time import perf_counter
from typing import Any

from core_worker import peak_bytes, resident_bytes
from measuring import SCENES, arguments, print_conditions, ratio, text
from workers import Worker, serve

from equaltime.errors import EqualtimeError
from equaltime.statistics.intervals import median_interval

SMALL = SCENES / "mitsuba" / "cornell-box" / "scene.xml"
WHAT = {"seconds": "s", "grown": "MB", "peak": "MB"}


def main() -> None:
    parser = arguments(__doc__, repeats=5)
    parser.add_argument("folder", type=Path, nargs="?", default=SCENES / "mitsuba")
    parser.add_argument("--variant", default="llvm_ad_rgb")
    options = parser.parse_args()
    print_conditions(options)
    for path in sorted(p for ending in ("xml", "gltf", "glb") for p in options.folder.rglob(f"*.{ending}")):
        compare(path, path.relative_to(options.folder), options)


def compare(path: Path, name: Path, options: Any) -> None:
    """Load one scene with both in turn, and print medians and ratios."""
    whose = ["equaltime", *(["mitsuba"] if path.suffix == ".xml" else [])]
    answers: dict[str, list[dict[str, Any]]] = {who: [] for who in whose}
    for number in range(options.repeats):
        for who in whose if number % 2 == 0 else whose[::-1]:
            with Worker(Path(__file__).name, ["--serve", who, options.variant]) as worker:
                answers[who].append(worker.ask(scene=str(path)))
    for who in whose:
        if wrong := next((a["wrong"] for a in answers[who] if "wrong" in a), None):
            print(f"{name}: {who} cannot read it: {wrong}")
    ours = answers["equaltime"]
    if any("wrong" in a for a in ours):
        return
    print(f"{name}")
    for key, unit in WHAT.items():
        own = [a[key] / (1 if unit == "s" else 1e6) for a in ours]
        line = f"  {key:8} {text(median_interval(own))} {unit}"
        if "mitsuba" in answers and not any("wrong" in a for a in answers["mitsuba"]):
            line += f"; over Mitsuba's {text(ratio([a[key] for a in ours], [a[key] for a in answers['mitsuba']]))}"
        print(line)


def defines(path: Path) -> dict[str, str]:
    """Return what neither renderer has a default for: some files name an integrator of their repository's own."""
    return {"integrator": "path"} if path.suffix == ".xml" and "$integrator" in path.read_text() else {}


def ours() -> Callable[[Path], object]:
    import equaltime as et

    def load(path: Path) -> object:
        scene = et.load(path, substitute=True, **defines(path))
        return scene, scene.core.intersect([[0.0, 0.0, 0.0]], [[0.0, 0.0, 1.0]])

    return load


def theirs(variant: str) -> Callable[[Path], object]:
    import mitsuba as mi

    mi.set_variant(variant)

    def load(path: Path) -> object:
        scene = mi.load_file(str(path), **defines(path))
        hit = scene.ray_intersect(mi.Ray3f(mi.Point3f(0, 0, 0), mi.Vector3f(0, 0, 1)))
        return scene, str(hit.t)

    return load


def answer_with(load: Callable[[Path], object]) -> Callable[[Mapping[str, Any]], Mapping[str, Any]]:
    def answer(question: Mapping[str, Any]) -> dict[str, Any]:
        kept = [load(SMALL)]
        before, path = resident_bytes(), Path(question["scene"])
        Path("/proc/self/clear_refs").write_text("5")  # the peak from here on
        begin = perf_counter()
        try:
            kept.append(load(path))
        except (RuntimeError, ValueError, EqualtimeError) as error:
            return {"wrong": str(error).splitlines()[0]}
        seconds = perf_counter() - begin
        return {"seconds": seconds, "grown": resident_bytes() - before, "peak": peak_bytes() - before}

    return answer


if __name__ == "__main__":
    if "--serve" in sys.argv:
        who, variant = sys.argv[2:]
        serve(answer_with(ours() if who == "equaltime" else theirs(variant)))
    else:
        main()
