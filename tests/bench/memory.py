"""Peak memory: bytes a pixel of the film, bytes a triangle of the scene, whether samples matter, and what is quoted.

Each figure comes from fresh processes, and is a difference between two of them, so that what Python and the libraries
take cancels out.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

from large_scenes import write_terrain
from measuring import SCENES, arguments, print_conditions, text
from workers import fresh

from equaltime.statistics.intervals import median_interval

SMALL, LARGE = 512, 2048
FEW, MANY = 4, 256
# Below and above the number at which the core changes how it builds.
MESHES = ((200_000, 900_000), (1_500_000, 3_000_000))


def main() -> None:
    parser = arguments(__doc__, repeats=3)
    options = parser.parse_args()
    print_conditions(options)
    scene = str(SCENES / "cornell-box.toml")
    repeats = range(options.repeats)

    def film(side: int, spp: int) -> int:
        return int(fresh(scene=scene, size=[side, side], spp=spp, threads=options.threads, max_depth=2)["peak"])

    pixels = LARGE**2 - SMALL**2
    each = median_interval([(film(LARGE, 2) - film(SMALL, 2)) / pixels for _ in repeats])
    print(f"a pixel of the film   {text(each, 4)} bytes")
    growth = [(film(SMALL, MANY) - film(SMALL, FEW)) / film(SMALL, FEW) for _ in repeats]
    print(f"{MANY} spp over {FEW} spp     {text(median_interval([1 + g for g in growth]), 4)} x the peak")
    with tempfile.TemporaryDirectory() as folder:
        for strategy in ("best,adaptive=none", "best,adaptive=error"):
            for side in (SMALL, 2 * SMALL):
                question = {"scene": scene, "size": [side, side], "error": 0.5, "strategy": strategy}
                answer = fresh(**question, threads=options.threads, save=str(Path(folder) / "a.exr"))
                low, high = (answer["peak"] / answer["quoted"][end] for end in ("high", "low"))
                middle = answer["peak"] / answer["quoted"]["value"]
                print(f"peak over quoted      {middle:.2f} [{low:.2f}, {high:.2f}] ({side}x{side}, {strategy})")
        for few, many in MESHES:
            triangles(Path(folder), few, many, options.repeats)


def triangles(folder: Path, few: int, many: int, repeats: int) -> None:
    """Print what each triangle adds, between two sizes of the same terrain."""
    answers = []
    for count in (few, many):
        scene = str(write_terrain(folder, count))
        answers.append([fresh(scene=scene) for _ in range(repeats)])
    more = answers[1][0]["triangles"] - answers[0][0]["triangles"]
    for key, words in (
        ("scene_bytes", "by the core's account"),
        ("built", "resident once built"),
        ("peak", "at the peak"),
    ):
        values = [(b[key] - a[key]) / more for a, b in zip(*answers, strict=True)]
        print(f"a triangle, {few:>9,} to {many:,}: {text(median_interval(values), 4)} bytes {words}")


if __name__ == "__main__":
    main()
