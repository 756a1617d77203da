"""What special cases of the core are worth: seconds and relMSE of this build over those of a build without one of them.

walls         spheres that enclose all else are met beside Embree's tree, two at a time: a room made of balls
moving        up to two moving instances are met beside the tree: a ball that rolls
lamp-pictures integrals of a texture over a lamp's triangle are exact: a lamp with a few bright texels among dark ones
"""

from __future__ import annotations

import tempfile
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np
from builds import TWO_ROWS, Variant, build
from measuring import SCENES, Floats, arguments, noise, print_conditions, ratio, rounds, text
from workers import Worker

from equaltime.images.image_files import write_exr

POINT_SAMPLED = (
    "cpp/equaltime/textures/triangle_distribution.cpp",
    r"(?s)  double sum = 0;\n  const auto value = \[&\].*?return 2 \* sum;",
    "  const double s = (near + far) / 2;\n"
    "  return (far * far - near * near) * (high - low) * bright({f.uv_at({1 - s, s * (low + high) / 2})});",
)
VARIANTS = {
    "walls": Variant(
        TWO_ROWS,
        [
            (
                "cpp/equaltime/accel/accel.cpp",
                r"impl_->walls = EnclosingSpheres\(spheres, impl_->geometries.meshes\);",
                "",
            )
        ],
    ),
    "moving": Variant(TWO_ROWS, [("cpp/equaltime/accel/moving_instance.h", r"kFewMoving = 2", "kFewMoving = 0")]),
    "lamp-pictures": Variant(TWO_ROWS, [POINT_SAMPLED]),
}
LAMP_SIZE, LAMPS = 256, 24
STARS = """
[integrator]
type = "path"
max_depth = 2

[sensor]
type = "perspective"
fov = 45
to_world = [{ look_at = { origin = [0, 4, 6], target = [0, 0, 0], up = [0, 1, 0] } }]
film = { type = "hdrfilm", width = 128, height = 128 }

[floor]
type = "rectangle"
to_world = [{ rotate = { axis = [1, 0, 0], angle = -90 } }, { scale = 3 }]
bsdf = { type = "diffuse", reflectance = 0.5 }

[lamp]
type = "obj"
filename = "lamp.obj"
to_world = [{ translate = [0, 2, 0] }]
emitter = { type = "area", radiance = { type = "bitmap", filename = "stars.exr" } }
"""
LAMP = """v -1 0 -1
v 1 0 -1
v 1 0 1
v -1 0 1
vt 0 0
vt 1 0
vt 1 1
vt 0 1
f 1/1 2/2 3/3
f 1/1 3/3 4/4
"""


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("cases", nargs="*", default=list(VARIANTS), metavar="CASE")
    parser.add_argument("--builds", type=Path, help="folder to keep the builds in, and to take them from")
    options = parser.parse_args()
    with ExitStack() as stack:
        scratch = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        folder = options.builds or scratch / "builds"
        files = {"this": build(Variant(TWO_ROWS), folder / "this")}
        files |= {name: build(VARIANTS[name], folder / name) for name in options.cases}
        print_conditions(options)
        cores = {name: stack.enter_context(Worker("core_worker.py", ["--core", file])) for name, file in files.items()}
        scenes = {
            "walls": {"scene": str(SCENES / "montelight" / "simple.toml")},
            "moving": {"scene": str(SCENES / "experiments" / "motion.toml"), "define": {"ball": 20.0}},
            "lamp-pictures": {"scene": str(starry_lamp(scratch))},
        }
        for name in options.cases:
            compare(name, cores["this"], cores[name], scenes[name], options)


def starry_lamp(folder: Path) -> Path:
    """Write a scene with a square lamp of two triangles, of whose texels a few shine."""
    stars = np.zeros((LAMP_SIZE, LAMP_SIZE, 3), np.float32)
    places = np.random.default_rng(1).integers(LAMP_SIZE, size=(LAMPS, 2))
    stars[places[:, 0], places[:, 1]] = 100
    write_exr(folder / "stars.exr", stars)
    (folder / "lamp.obj").write_text(LAMP)
    scene = folder / "stars.toml"
    scene.write_text(STARS)
    return scene


def compare(name: str, this: Worker, without: Worker, scene: dict[str, Any], options: Any) -> None:
    """Render a scene with both builds in turn, with the same numbers, and print the ratios."""
    with tempfile.NamedTemporaryFile(suffix=".npy") as image:
        question = {**scene, "threads": options.threads, "size": [128, 128], "image": image.name}
        spp = max(4, round(0.5 / this.ask(**question, spp=4)["seconds"]) * 4)
        workers = {"with": this, "without": without}
        images: dict[str, list[Floats]] = {key: [] for key in workers}

        def seconds(key: str, seed: int) -> float:
            answer = workers[key].ask(**question, spp=spp, seed=seed)
            images[key].append(np.load(image.name).astype(np.float64))
            return float(answer["seconds"])

        times = rounds(workers, seconds, options.repeats)
    error = noise(images["with"]) / noise(images["without"])
    speed = text(ratio(times["with"], times["without"]))
    print(f"{name:14} {speed} x the seconds, {error:.3f} x the relMSE of a build without it, {spp} spp")


if __name__ == "__main__":
    main()
