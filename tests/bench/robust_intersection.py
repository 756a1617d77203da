"""What watertight intersection costs: paths per second with Embree's fast mode over those with its robust mode."""

from __future__ import annotations

import tempfile
from pathlib import Path

from large_scenes import write_terrain
from measuring import SHIPPED, arguments, print_conditions, ratio, render_seconds, rounds, samples_for, text

import equaltime as et
from equaltime import _core
from equaltime.scene.compile import compile_scene
from equaltime.statistics.intervals import Interval


class FastBuilder(_core.SceneBuilder):
    """Builds as the default builder does, but for fast intersection."""

    def build(self, intersection: object = None) -> _core.Scene:
        return super().build("fast")


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--triangles", type=int, default=1_000_000, help="of the generated terrain [%(default)s]")
    options = parser.parse_args()
    print_conditions(options)
    with tempfile.TemporaryDirectory() as folder:
        for path in (*SHIPPED, write_terrain(Path(folder), options.triangles)):
            faster = compare(path, options.repeats, options.threads)
            print(f"{path.name:20} fast over robust: {text(faster)} x the paths/s")


def compare(path: Path, repeats: int, threads: int) -> Interval:
    """Build the scene in both modes and render them in turn."""
    scene, again = et.load(path), et.load(path)
    settings = _core.Settings(max_depth=scene.max_depth)
    cores = {"robust": scene.core, "fast": compile_scene(again.model, again.assets, FastBuilder())}
    spp = samples_for(scene.core, settings, threads)

    def seconds(name: str, seed: int) -> float:
        return render_seconds(cores[name], settings, spp, threads, seed)[0]

    times = rounds(cores, seconds, repeats)
    return ratio(times["robust"], times["fast"])


if __name__ == "__main__":
    main()
