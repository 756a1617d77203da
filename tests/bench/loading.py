"""How long a mesh of five million triangles takes to load (binary PLY) and to build, and the memory at its peak."""

from __future__ import annotations

import tempfile
from pathlib import Path

from large_scenes import write_terrain
from measuring import arguments, print_conditions, text
from memory import fresh

from equaltime.statistics.intervals import median_interval


def main() -> None:
    parser = arguments(__doc__, repeats=5)
    parser.add_argument("--triangles", type=int, default=5_000_000)
    options = parser.parse_args()
    print_conditions(options)
    with tempfile.TemporaryDirectory() as folder:
        scene = write_terrain(Path(folder), options.triangles)
        size = (Path(folder) / "terrain.ply").stat().st_size
        answers = [fresh(scene=str(scene)) for _ in range(options.repeats)]
    print(f"{answers[0]['triangles']:,} triangles, {size / 1e6:.0f} MB")
    for phase in ("load", "build"):
        print(f"  {phase:6} {text(median_interval([answer[phase] for answer in answers]))} s")
    print(f"  both   {text(median_interval([answer['load'] + answer['build'] for answer in answers]))} s")
    print(f"  peak   {text(median_interval([answer['peak'] / 2**30 for answer in answers]))} GB of memory")
    print(f"  scene  {answers[0]['scene_bytes'] / 2**30:.3g} GB by the core's account")


if __name__ == "__main__":
    main()
