"""The list of hard cases: scene, parameters and known image of each.

Scene files are in ``scenes/`` of the source tree, or in the installed package.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, Final

from equaltime.examples import scenes_folder
from equaltime.experiments.peers.common import with_box_filter
from equaltime.scene import Scene, load_file
from equaltime.words import suggestion

__all__ = ["CASES", "Case", "chosen", "load_case"]


@dataclass(frozen=True)
class Case:
    """A scene with a known image: the mean of its pixels is known, or a changed scene must give the same image.

    A change is another unit of length or light, another number of threads, or a crop.
    """

    id: str
    """Id in the catalogue of hard cases, such as ``T1``; several cases may share one."""
    name: str
    stresses: str
    """Difficulty that the case tests, in words, such as ``1 - cos of a small angle``."""
    scene: str
    """File of the scene, below `equaltime.examples.scenes_folder`."""
    expected: float | None = None
    """Known mean of all pixels; None if the image is compared with the image of a changed scene."""
    spp: int = 64
    seeds: int = 16
    """Number of independent renders; their spread gives the error."""
    peer_spp: int | None = None
    """Samples per pixel of a peer (another renderer); None stands for ``spp``. Cases that compare bits need few
    samples, but a peer is tested by its means, which need many."""
    define: Mapping[str, object] = field(default_factory=lambda: MappingProxyType({}), hash=False)
    strategy: str = "best"
    """Strategy of equaltime for the case; other renderers use their own."""
    size: tuple[int, int] | None = None
    length: int = 0
    """Exponent of the change of lengths: they are multiplied by two to this power; 0 for no change."""
    light: int = 0
    """Exponent of the change of brightness: it is multiplied by two to this power; 0 for no change."""
    threads: int = 0
    """Number of worker threads of the changed render; 0 for no change."""
    crop: tuple[int, int, int, int] | None = None
    """Window that is rendered separately and compared with the whole image (x, y, width, height, in pixels); None for
    no change."""

    @property
    def for_peers(self) -> bool:
        """Whether peers (other renderers) run the case, too.

        False for changes of threads or crop: these need equal bits, which peers do not guarantee.
        """
        return self.threads == 0 and self.crop is None


def _cornell(name: str, stresses: str, id: str = "G3", **change: Any) -> Case:
    return Case(id, name, stresses, "cornell-box.toml", size=(24, 24), spp=64, seeds=24, **change)


def _furnace(
    shape: str, rho: float, id: str = "T1", stresses: str = "energy over bounces", spp: int = 64, **define: Any
) -> Case:
    define |= {"rho": rho, "glow": 1.0 - rho}
    expected = 1.0 - rho ** define["max_depth"] if "max_depth" in define else 1.0
    name = f"{shape.removeprefix('furnace-')} furnace, rho {rho:g}"
    return Case(id, name, stresses, f"hard/{shape}.toml", expected, define=define, spp=spp)


def _ball_lamp(ratio: float, id: str = "S5", stresses: str = "1 - cos of a small angle") -> Case:
    define = {"radius": ratio, "radiance": ratio**-2}
    return Case(id, f"lamp {ratio:g} of its distance", stresses, "hard/ball-lamp.toml", 0.25, define=define)


def _ball(name: str, stresses: str, id: str, **define: object) -> Case:
    return Case(id, name, stresses, "hard/ball-in-sky.toml", 0.5, define=define)


def _from(distance: float) -> dict[str, object]:
    return {"eye": [0.6 * distance, 0, 0.8 * distance], "fov": 50.0 / distance}


def _sized(radius: float) -> dict[str, object]:
    return _from(10.0 * radius) | {"radius": radius, "fov": 5.0}


def _rough(alpha: float) -> Case:
    return Case("S13", f"roughness {alpha:g}", "GGX's digits", "hard/rough-mirror.toml", 1.0, define={"alpha": alpha})


def _glass(ior: float) -> Case:
    id, name = ("S16", f"glass of index {ior:.9g}") if ior < 1.1 else ("S17", f"glass of index {ior:g}")
    return Case(id, name, "Fresnel's equations", "hard/glass.toml", 1.0, define={"ior": ior}, seeds=2)


def _dense(sigma_t: float) -> Case:
    name, stresses = f"extinction of {sigma_t:g} in a cube", "distances shorter than offsets"
    return Case("G20", name, stresses, "hard/dense-cube.toml", 0.43612354135962916, define={"sigma_t": sigma_t})


def _mirrors(bounces: int) -> Case:
    """Return the case of a path between mirrors: noise-free without roulette, which the scene's rr_depth avoids too."""
    name, scene, strategy = f"mirrors, {bounces} bounces", "hard/furnace-mirrors.toml", "best,roulette=none"
    return Case("T5", name, "long paths", scene, 1.0 - (1.0 - 2.0**-10) ** bounces, spp=4, seeds=2, strategy=strategy)


_UNITS = "thresholds that are lengths"
_SLIVER: dict[str, Any] = {"stretch": [50, 5e-4, 1], "eye": [0.2, 1e-4, 0.3], "towards": [0.5, 5e-5, -0.2]}
_STRIP = 0.5 / math.pi * (0.5 + math.pi / 4)
_FAR = {"place": [1e6, -1e6, 1e6]}
_INSIDE = {"shape": "sphere", "ior": 1.5, "eye": [-0.1, 0.2, 0.3]}

CASES: Final = (
    _cornell("Cornell box at 2^-10", _UNITS, length=-10, peer_spp=512),
    _cornell("Cornell box at 2^-20", _UNITS, length=-20),
    _cornell("Cornell box at 2^20", _UNITS, length=20),
    _cornell("light times 2^-40", "thresholds that are radiances", id="T4", light=-40),
    _cornell("light times 2^40", "thresholds that are radiances", id="T4", light=40),
    _cornell("1 thread and 3", "order of threads", id="C1", threads=3),
    _cornell("a crop by itself", "numbers keyed by pixels", id="C1", crop=(5, 7, 11, 9)),
    _furnace("furnace-box", 0.5),
    _furnace("furnace-box", 0.9),
    _furnace("furnace-box", 0.99, id="T2", stresses="roulette that lets weights grow", spp=8),
    _furnace("furnace-box", 0.9, id="T11", stresses="paths of at most 6 segments", max_depth=6),
    _furnace("furnace-box", 0.5, id="G7", stresses="triangles 1e5 times as long as wide", **_SLIVER),
    _furnace("furnace-sphere", 0.5, id="S28", stresses="a lamp all round that touches"),
    _furnace("furnace-sphere", 0.9, id="S28", stresses="a lamp all round that touches"),
    _furnace("furnace-glass", 0.5, id="S17", stresses="energy through glass"),
    _mirrors(3000),
    Case("S8", "squares that face", "light sampling", "hard/facing-squares.toml", 0.19982489569838743),
    Case("S8", "squares that touch", "1 / d² next to a lamp", "hard/touching-squares.toml", 0.20004377607540316),
    Case("G4", "squares 1e6 away", "room for digits", "hard/facing-squares.toml", 0.19982489569838743, define=_FAR),
    *(_ball_lamp(ratio) for ratio in (1e-1, 1e-3, 1e-5, 1e-7)),
    _ball_lamp(1e-10, id="S1", stresses="squares of densities overflow"),
    Case("S10", "ceiling 1e6 gaps wide", "half a world of light", "hard/ceiling.toml", 0.5),
    Case("S11", "strip 2000 times as long as wide", "angles that cancel", "hard/strip-lamp.toml", _STRIP),
    Case("S7", "ground in a lamp's plane", "a cosine of 0", "hard/edge-on.toml", 0.0, seeds=2),
    Case("G13", "sun at 0.01°", "offsets along the ground", "hard/low-sun.toml", math.sin(math.radians(0.01)), seeds=2),
    Case("G16", "disk over ground 1e9 wider", "offsets by the size of triangles", "hard/stadium.toml", 0.1, spp=256),
    Case("G17", "lid 1e-5 before a lamp", "shadow rays that end early", "hard/covered-lamp.toml", 0.0, seeds=2),
    Case("G11", "cage of 512 triangles", "edges that leak", "hard/cage.toml", 0.0, spp=256, seeds=2),
    Case("G14", "lamp behind a bent wall", "which side is which", "hard/bent-wall.toml", 0.0, seeds=2),
    Case("G2", "shell 1e-6 around", "offsets wider than a gap", "hard/shell.toml", 0.5),
    Case("G10", "three squares in one place", "which is met", "hard/coincident.toml", 0.5),
    Case("G21", "lamp in a wall", "which is met", "hard/lamp-in-wall.toml", 0.19982489569838743),
    *(_dense(sigma_t) for sigma_t in (1e3, 1e5, 3e6)),
    *(_ball(f"ball from {d:g} away", "digits of long rays", "G5", **_from(d)) for d in (1e2, 1e4, 1e7)),
    *(_ball(f"ball of size {r:g}", "sizes next to others", "G6", **_sized(r)) for r in (1e-6, 1e6)),
    Case("S28", "ball in a lamp 1e6 wide", "squares of distances", "hard/great-lamp.toml", 0.5),
    *(_rough(alpha) for alpha in (1e-3, 1e-4, 1e-5)),
    *(_glass(ior) for ior in (1.0, 1.0000001, 1.5, 3.0)),
    Case("T8", "camera in glass", "where paths start", "hard/glass.toml", 1.5**2, define=_INSIDE, seeds=2),
    Case("S3", "bulb behind glass", "paths of no density", "hard/bulb-behind-glass.toml", 0.0, seeds=2),
    Case("T14", "six veils", "roulette by throughput", "hard/veils.toml", 1.0, spp=512),
    Case("G18", "instance scaled -1e-3 … 1e3", "bounds through transforms", "hard/stretched-instance.toml", 0.5),
    Case("E1", "2e7 samples of 0.1", "sums that stop growing", "hard/one-pixel.toml", 0.1, spp=20_000_000, seeds=1),
)


def load_case(case: Case) -> Scene:
    """Read the scene of a case, and set a box filter, for which all renderers have the same expected image."""
    scene = load_file(scenes_folder() / case.scene, case.define)
    return with_box_filter(scene if case.size is None else scene.with_(size=case.size))


def chosen(only: Sequence[str]) -> tuple[Case, ...]:
    """Return the cases with these ids or names, in the order of the list; all cases if ``only`` is empty.

    Raises ValueError for an unknown id or name.
    """
    known = {word for case in CASES for word in (case.id, case.name)}
    for word in only:
        if word not in known:
            raise ValueError(f"there is no case '{word}'{suggestion(word, known)}")
    return tuple(case for case in CASES if not only or case.id in only or case.name in only)
