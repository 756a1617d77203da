"""Scenes that the scripts about errors share, their options, and the light that few paths find."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from measuring import SCENES, arguments
from trial_scenes import TRIALS, trial_scene

import equaltime as et

__all__ = ["CASES", "Case", "case_arguments"]


@dataclass(frozen=True)
class Case:
    """A scene, how it is rendered, and the errors that are worth asking of it at a small size."""

    path: str
    """In the folder of scenes; or the name of a trial scene, which has its own depth."""
    max_depth: int = 0
    strategy: str = "best"
    define: Mapping[str, Any] = field(default_factory=dict)
    targets: tuple[float, ...] = (0.10, 0.05, 0.02, 0.01)

    def scene(self, side: int) -> et.Scene:
        """Load the scene, with so many pixels along each side."""
        if self.path in TRIALS:
            return trial_scene(self.path, side)
        loaded = et.load_dict(rare_light()) if self.path == "" else et.load(SCENES / self.path, **self.define)
        return loaded.with_(size=(side, side), max_depth=self.max_depth)


def rare_light() -> dict[str, Any]:
    """Return a floor under a lamp that fills 2 % of what its middle sees, by the cosine: r² / (r² + h²)."""
    camera = {"origin": [0, 0.8, 1.6], "target": [0, 0, 0], "up": [0, 1, 0]}
    down = [{"scale": 0.1428}, {"rotate": {"axis": [1, 0, 0], "angle": 90}}, {"translate": [0, 1, 0]}]
    return {
        "type": "scene",
        "integrator": {"type": "path"},
        "sensor": {
            "type": "perspective",
            "fov": 25,
            "to_world": [{"look_at": camera}],
            "film": {"type": "hdrfilm", "width": 32, "height": 32, "rfilter": {"type": "box"}},
        },
        "floor": {
            "type": "rectangle",
            "to_world": [{"rotate": {"axis": [1, 0, 0], "angle": -90}}, {"scale": 4}],
            "bsdf": {"type": "diffuse", "reflectance": 0.5},
        },
        "lamp": {"type": "disk", "to_world": down, "emitter": {"type": "area", "radiance": 50}},
    }


FEW = (0.20, 0.10, 0.05)
CASES: Mapping[str, Case] = {
    "rare light": Case("", 2, "bsdf,sampler=sobol"),
    "cornell-box": Case("cornell-box.toml", 4),
    "independent": Case("cornell-box.toml", 3, "best,sampler=independent"),
    "plate": Case("experiments/plate.toml", 3),
    "stadium": Case("hard/stadium.toml", 2),
    "terrain": Case("terrain/terrain.toml", 4),
    "squares": Case("hard/touching-squares.toml", 4),
    "ball": Case("experiments/ball.toml", 2),
    "opening": Case("experiments/opening.toml", 4, targets=FEW),
    "caustic": Case("experiments/caustic.toml", 6, targets=FEW),
    "lens": Case("experiments/lens.toml", 4, define={"aperture": "8"}, targets=FEW),
    "simple": Case("montelight/simple.toml", 4),
    "small lamps": Case("montelight/complex.toml", 4),
    "glossy plates": Case("veach-mis.toml", 3, targets=FEW),
    "trial flat": Case("flat", targets=(0.05, 0.03, 0.02)),
    "trial cornell": Case("cornell", targets=(0.2, 0.12)),
    "trial mis": Case("mis", targets=(0.4, 0.2)),
    "trial door": Case("door", targets=(0.9, 0.6)),
    "trial caustic": Case("caustic", targets=(0.2, 0.1)),
}
"""By name: light that 2 % of paths find, scenes of even noise and of uneven, one with independent samples; and scenes
whose errors are easy to misjudge (`trial_scenes`), which run only if they are named."""


EVERYDAY = [name for name, case in CASES.items() if case.path not in TRIALS]


def case_arguments(
    description: str | None, seeds: int, size: int, scenes: list[str] | None = None, threads: int = 0
) -> argparse.ArgumentParser:
    """Return a parser with the options of a script that renders these scenes, or some, with many seeds."""
    parser = arguments(description, threads=threads)
    parser.add_argument("--seeds", type=int, default=seeds, help="[%(default)s]")
    parser.add_argument("--size", type=int, default=size, help="pixels along each side [%(default)s]")
    parser.add_argument("--scenes", nargs="*", default=scenes or EVERYDAY, choices=list(CASES))
    return parser
