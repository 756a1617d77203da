"""What choices of the build and of the source are worth: paths per second of this core over those of a variant of it.

v3, v4       these levels of x86-64 instead of v2; Embree takes the best that the machine has in all of them
one-kernel   the kernel for all effects only, without those that leave out what a scene lacks
near-lights  light sources count as near, and their solid angle is sampled, up to twice the distance

The price of stability, undone piece by piece (their images are not to be trusted):

fast-rays    Embree's fast intersection instead of the robust one
float-hits   points on triangles in float32 instead of float64
squared-mis  MIS weights from squares of densities instead of from their ratio
unstable     all three
"""

from __future__ import annotations

import tempfile
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np
from builds import ONE_ROW, Variant, build
from measuring import SHIPPED, arguments, noise, print_conditions, ratio, rounds, text
from workers import Worker

FAST_RAYS = ("cpp/equaltime/bindings/bind_scene.cpp", r'"intersection"_a = "robust"', '"intersection"_a = "fast"')
FLOAT_HITS = (
    "cpp/equaltime/scene/recompute_hit.h",
    r"Vec3d p = plane\.meet\(ray\);",
    "const Vec3f fo(ray.origin), fd(ray.direction), fn(plane.n); "
    "Vec3d p(fo + fd * ((static_cast<float>(plane.d) - dot(fo, fn)) / dot(fd, fn)));",
)
SQUARED_MIS = (
    "cpp/equaltime/sampling/mis.h",
    r"(?s)const float ratio = other / pdf;.*?;\n",
    "return heuristic == Heuristic::power ? pdf * pdf / (pdf * pdf + other * other) : pdf / (pdf + other);\n",
)
VARIANTS = {
    "v3": Variant({"EQUALTIME_ISA": "v3"}),
    "v4": Variant({"EQUALTIME_ISA": "v4"}),
    "one-kernel": Variant(ONE_ROW),
    "near-lights": Variant({}, [("cpp/equaltime/lights/flat_light.h", r"(kNearSquared) = 1;", r"\1 = 4;")]),
    "fast-rays": Variant({}, [FAST_RAYS]),
    "float-hits": Variant({}, [FLOAT_HITS]),
    "squared-mis": Variant({}, [SQUARED_MIS]),
    "unstable": Variant({}, [FAST_RAYS, FLOAT_HITS, SQUARED_MIS]),
}


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("variants", nargs="*", default=list(VARIANTS), metavar="VARIANT")
    parser.add_argument("--scenes", nargs="+", default=list(map(str, SHIPPED)))
    parser.add_argument("--builds", type=Path, help="folder to keep the builds in, and to take them from")
    parser.add_argument("--build-only", action="store_true", help="time nothing")
    options = parser.parse_args()
    with ExitStack() as stack:
        folder = options.builds or Path(stack.enter_context(tempfile.TemporaryDirectory()))
        folder_of = {name: folder / name for name in ("this", *options.variants)}
        files = {name: build(VARIANTS.get(name, Variant({})), place) for name, place in folder_of.items()}
        if options.build_only:
            return
        print_conditions(options)
        cores = {name: stack.enter_context(Worker("core_worker.py", ["--core", file])) for name, file in files.items()}
        for scene in options.scenes:
            compare(scene, cores, options, str(folder / "image.npy"))


def compare(scene: str, cores: dict[str, Worker], options: Any, image: str) -> None:
    """Render one scene with every build in turn, with the same numbers, and print ratios."""
    question = {"scene": scene, "threads": options.threads, "size": [256, 256], "image": image}
    pilot = cores["this"].ask(**question, spp=4)
    spp = max(4, round(0.5 / pilot["seconds"]) * 4)
    images: dict[str, list[Any]] = {name: [] for name in cores}

    def seconds(name: str, seed: int) -> float:
        answer = cores[name].ask(**question, spp=spp, seed=seed)
        images[name].append(np.load(image).astype(np.float64))
        return float(answer["seconds"])

    times = rounds(images, seconds, options.repeats)
    print(f"\n{scene}, {spp} spp")
    for name in options.variants:
        speed, error = ratio(times["this"], times[name]), noise(images[name]) / noise(images["this"])
        print(f"  {name:12} {text(speed)} x the paths/s of this build, {error:.3f} x its relMSE at equal samples")


if __name__ == "__main__":
    main()
