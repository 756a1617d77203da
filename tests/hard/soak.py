"""Soak: a great many samples of scenes: python -m tests.hard.soak [--samples 1e9] [SCENE ...].

Where none is named, those that are shipped are taken, hard ones first. Each is rendered again and again with other
seeds, all for about as long. Of all samples none may be NaN or infinite; memory may not grow after the first quarter;
and the mean of the second half of the renders is that of the first, by Welch's test at one level of 0.1 % over all
scenes. Ends with 1 if anything of this fails.
"""

from __future__ import annotations

import argparse
import math
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from scipy import stats

import equaltime as et
from equaltime import _core

__all__ = ["LEVEL", "Soaked", "drift", "growth", "shipped", "soak"]

SCENES: Final = Path(__file__).parents[2] / "scenes"
LEVEL: Final = 1e-3
SIZE: Final = 64
LEAST_ROUNDS: Final = 16
MOST_GROWTH: Final = 8 << 20
"""Bytes that the allocator may keep for itself."""
DEPTH: Final = 256
"""Where a scene sets no limit: none of the light that a test could see is beyond."""


@dataclass(frozen=True)
class Soaked:
    """What many renders of one scene came to."""

    samples: int
    nonfinite: int
    growth: int
    """Bytes."""
    p_value: float
    """That the halves have one mean."""
    seconds: float

    def passes(self, level: float) -> bool:
        """Tell whether nothing went wrong."""
        return self.nonfinite == 0 and self.growth <= MOST_GROWTH and self.p_value >= level


def shipped() -> Iterator[Path]:
    """Yield the scenes."""
    for folder in ("hard", "."):
        for path in sorted((SCENES / folder).rglob("*.toml")):
            if "experiments" not in path.parts and (folder == "hard") == (path.parent.name == "hard"):
                yield path


def shown(path: Path) -> str:
    """Return a scene's place as it is printed."""
    return str(path.relative_to(SCENES) if path.is_relative_to(SCENES) else path)


def drift(means: Sequence[float]) -> float:
    """Return the p-value of one mean in both halves; 1 where nothing varies."""
    first, second = np.array_split(np.asarray(means), 2)
    if np.ptp(means) <= 1e-12 * np.abs(means).max():
        return 1.0
    return float(stats.ttest_ind(first, second, equal_var=False).pvalue)


def growth(resident: Sequence[int]) -> int:
    """Return by how much memory grew from the end of the first quarter on."""
    return max(0, resident[-1] - max(resident[: max(1, len(resident) // 4)]))


def resident_bytes() -> int:
    """Return what this process holds, as Linux tells it."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * 4096


def prepared(path: Path) -> tuple[_core.Scene, _core.Settings]:
    """Load a scene as it is rendered here."""
    scene = et.load(path)
    width, height = (max(1, round(n * SIZE / max(scene.size))) for n in scene.size)
    depth = scene.max_depth if scene.max_depth > 0 else DEPTH
    return scene.with_(size=(width, height)).core, _core.Settings(lights="tree", max_depth=depth)


def speed(path: Path) -> float:
    """Return samples in a second of one processor, by a few samples a pixel."""
    core, settings = prepared(path)
    renderer = _core.Renderer(core, settings, threads=1)
    begin = time.process_time()
    renderer.advance(2)
    return 2.0 * math.prod(core.film_shape) / (time.process_time() - begin)


def soak(path: Path, samples: int, threads: int = 0) -> Soaked:
    """Render a scene until it has had so many samples in all."""
    core, settings = prepared(path)
    height, width = core.film_shape
    spp = max(2, samples // (width * height * LEAST_ROUNDS))
    rounds = max(LEAST_ROUNDS, min(samples // (width * height * spp), 256))
    means, resident, nonfinite = [], [], 0
    begin = time.perf_counter()
    for seed in range(rounds):
        renderer = _core.Renderer(core, settings, seed=seed, threads=threads)
        renderer.advance(spp)
        means.append(float(renderer.moments["mean"].mean()))
        nonfinite += renderer.counters["nonfinite"]
        resident.append(resident_bytes())
    seconds = time.perf_counter() - begin
    return Soaked(rounds * spp * width * height, nonfinite, growth(resident), drift(means), seconds)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", type=Path, help="files of scenes [all that are shipped]")
    parser.add_argument("--samples", type=float, default=1e9, help="in all [%(default)g]")
    parser.add_argument("--threads", type=int, default=0, help="worker threads; 0: one a processor [%(default)s]")
    options = parser.parse_args()
    paths = options.scenes or list(shipped())
    speeds = [speed(path) for path in paths]
    total, failed = 0, 0
    for path, fast in zip(paths, speeds, strict=True):
        found = soak(path, round(options.samples * fast / sum(speeds)), options.threads)
        total += found.samples
        failed += not (good := found.passes(LEVEL / len(paths)))
        print(
            f"{shown(path):34} {found.samples / 1e6:8.1f} M samples, {found.nonfinite} not finite, "
            f"{found.growth / 2**20:5.1f} MiB more, p {found.p_value:.3g}, {found.seconds:6.1f} s"
            f"{'' if good else '   FAILED'}",
            flush=True,
        )
    print(f"{total / 1e6:.1f} M samples of {len(paths)} scenes, {failed} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
