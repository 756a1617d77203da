"""What scenes with very many of something take: processor seconds to build and render, and the memory at the peak.

Each row is one scene, made for one way in which work may grow faster than the scene; each figure comes from a fresh
process. ``--core FILE`` takes another build of the core, to compare it with.
"""

from __future__ import annotations

from measuring import arguments, print_conditions, text
from workers import Worker

from equaltime.statistics.intervals import median_interval

CASES = {
    "instances of a bottle with an interior": {"kind": "instances", "count": 10_000, "medium": True},
    "instances of a mesh": {"kind": "instances", "count": 10_000},
    "groups of one instance": {"kind": "groups", "count": 10_000},
    "beads with priorities": {"kind": "beads", "count": 100_000},
    "columns of a sky, half as many rows": {"kind": "sky", "count": 4096},
    "triangles of a glass that moves past the camera": {"kind": "moving", "count": 100_000, "medium": True, "spp": 1},
    "keys of a motion": {"kind": "keys", "count": 1000, "spp": 16},
    "triangles with normals and texture coordinates": {"kind": "mesh", "count": 6_000_000},
    "triangles in fog that let no light pass": {"kind": "fog", "count": 100_000, "spp": 16},
    "materials of an OBJ of 100,000 faces": {"kind": "materials", "count": 200},
}


def main() -> None:
    parser = arguments(__doc__, repeats=3, threads=1)
    parser.add_argument("--core", metavar="FILE", help="another build of the core")
    parser.add_argument("--share", type=float, default=1.0, help="of the counts [%(default)s]")
    parser.add_argument("--only", metavar="WORD", default="", help="rows that have this word")
    options = parser.parse_args()
    print_conditions(options)
    for name, question in CASES.items():
        if options.only not in name:
            continue
        count = max(2, round(options.share * int(str(question["count"]))))
        answers = []
        for _ in range(options.repeats):
            with Worker("many_worker.py", ["--core", options.core] if options.core else []) as worker:
                answers.append(worker.ask(**question | {"count": count}))
        print(f"{count:,} {name}")
        print(f"  build   {text(median_interval([a['build'] for a in answers]))} s")
        if "spp" in question:
            print(f"  render  {text(median_interval([a['render'] for a in answers]))} s, mean {answers[0]['mean']!r}")
        print(f"  peak    {text(median_interval([a['peak'] / 2**20 for a in answers]), 4)} MB")
        more = median_interval([a["more"] / 2**20 for a in answers])
        print(f"  more    {text(more, 4)} MB at the peak than before building")
        print(f"  scene   {answers[0]['account'] / 2**20:.4g} MB by the core's account")


if __name__ == "__main__":
    main()
