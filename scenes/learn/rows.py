"""The pictures of the page: one row for each claim."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final


@dataclass(frozen=True)
class Picture:
    """One picture: a scene of the folder ``scenes``, and how it is rendered."""

    label: str
    scene: str
    strategy: str
    spp: int | None = None
    """Samples a pixel; None for as many as the row's rays buy."""
    define: Mapping[str, Any] = field(default_factory=dict)
    show: str = "image"
    """``image``, or ``samples`` for the map of samples a pixel."""


@dataclass(frozen=True)
class Row:
    """Pictures that are compared."""

    pictures: tuple[Picture, ...]
    rays: float = 0.0
    """Rays a pixel that each picture may take."""
    stops: float = 0.0
    """Exposure of all pictures of the row."""
    parts: Mapping[str, tuple[float, float, float, float]] = field(default_factory=dict)
    """Windows of the pictures whose error the table has too, by name: left, top, width and height, as fractions."""


SIMPLE, COMPLEX, BALL = "montelight/simple.toml", "montelight/complex.toml", "experiments/roughness.toml"
PLATES, ROOM, LENS, MOTION = "veach-mis.toml", "cornell-box.toml", "experiments/lens.toml", "experiments/motion.toml"
PLAIN = "roulette=albedo,roulette_depth=5"

ROWS: Final[Mapping[str, Row]] = {
    "samples": Row(
        tuple(Picture(f"{spp} samples", SIMPLE, "naive,sampler=independent", spp) for spp in (4, 16, 64, 256)),
        stops=-4,
    ),
    "directions": Row(
        (
            Picture("uniform, matte", BALL, "bsdf,technique=uniform", 64, {"material": "matte"}),
            Picture("by the BSDF, matte", BALL, "bsdf", 64, {"material": "matte"}),
            Picture("uniform, shiny", BALL, "bsdf,technique=uniform", 64, {"alpha": 0.1}),
            Picture("by the BSDF, shiny", BALL, "bsdf", 64, {"alpha": 0.1}),
        ),
    ),
    "lamps": Row(
        (
            Picture("by chance", COMPLEX, f"bsdf,{PLAIN}"),
            Picture("aimed at", COMPLEX, f"light,{PLAIN}"),
        ),
        rays=400.0,
        stops=-1,
    ),
    "both": Row(
        (
            Picture("directions by the BSDF", PLATES, "bsdf"),
            Picture("aimed at lamps", PLATES, "light"),
            Picture("both, weighted (MIS)", PLATES, "mis"),
        ),
        rays=100.0,
        parts={
            "the highest plate reflects the large lamp": (0.6, 0.37, 0.1, 0.14),
            "the third plate reflects the small lamp": (0.32, 0.68, 0.08, 0.08),
        },
    ),
    "depth": Row(
        (
            *(Picture(f"cut at depth {n}", SIMPLE, f"best,roulette=none,truncate={n}", 128) for n in (2, 3, 5)),
            Picture("Russian roulette", SIMPLE, "best", 128),
        ),
        stops=-4,
    ),
    "adaptive": Row(
        (
            Picture("equal counts", LENS, "best,adaptive=none", define={"aperture": 8.0}),
            Picture("more where it is noisy", LENS, "best,adaptive=error", define={"aperture": 8.0}),
            Picture("its samples", LENS, "best,adaptive=error", define={"aperture": 8.0}, show="samples"),
        ),
        rays=400.0,
        stops=-1,
    ),
    "lens": Row(
        (
            Picture("a pinhole", LENS, "best", 256, {"aperture": 0.0}),
            Picture("a lens, focus in front", LENS, "best", 256, {"aperture": 8.0, "focus": 170.0}),
            Picture("a lens, focus at the back", LENS, "best", 256, {"aperture": 8.0, "focus": 256.0}),
            Picture("a wide angle", LENS, "best", 256, {"fov": 57.6}),
        ),
        stops=-1,
    ),
    "motion": Row(
        (
            Picture("nothing moves", MOTION, "best", 256),
            Picture("the ball rolls", MOTION, "best", 256, {"ball": 24.0}),
            Picture("the lamp swings", MOTION, "best", 256, {"lamp": 30.0}),
            Picture("the camera turns", MOTION, "best", 256, {"turn": 4.0}),
        ),
    ),
    "numbers": Row(
        tuple(
            Picture(label, ROOM, f"best,roulette=throughput,adaptive=none,sampler={sampler}", 64)
            for label, sampler in (
                ("independent", "independent"),
                ("stratified", "stratified"),
                ("Sobol", "sobol"),
                ("a lattice", "lattice"),
            )
        ),
        stops=1,
    ),
}
