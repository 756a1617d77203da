"""The limit ratio and the gain from a second thread, on the shipped scenes and on a mesh of a million triangles.

The same as `equaltime bench SCENE... --threads 1,2`, with a generated scene among them.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

from large_scenes import write_terrain
from measuring import SHIPPED, arguments, print_conditions, text

import equaltime as et
from equaltime.bench import measure


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--triangles", type=int, default=1_000_000, help="of the generated terrain [%(default)s]")
    parser.add_argument("--strategy", default="best")
    options = parser.parse_args()
    print_conditions(options)
    threads = (options.threads,) if options.threads else (1, 2)
    with tempfile.TemporaryDirectory() as folder:
        paths = (*SHIPPED, write_terrain(Path(folder), options.triangles))
        report = measure(
            [et.load(path) for path in paths], threads=threads, repeats=options.repeats, strategy=options.strategy
        )
    for row in report.scenes:
        print(
            f"{Path(row.name).name:18} {row.threads} threads: limit ratio {text(row.limit_ratio)}, "
            f"{row.paths_per_s.value / 1e6:.3g} M paths/s, scaling {text(row.scaling)}; "
            f"{row.triangles} triangles, {row.rays_per_path:.2f} rays a path, kernel {row.kernel}"
        )


if __name__ == "__main__":
    main()
