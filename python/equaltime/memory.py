"""What memory a process that renders takes at its peak.

That is not while paths are traced, but where the error is estimated, the file is written, or some pixels are probed.
"""

from __future__ import annotations

import os
from pathlib import Path

from equaltime.error_estimate import Estimate

__all__ = ["memory_bytes", "peak_bytes", "resident_bytes"]

# Bytes, what is expected and from least to most: of films of 512x512 to 1024x1024 pixels, plain and adaptive, saved as
# EXR with their moments, over those of 16x16 (measured on four scenes). A render that is asked for an error and tells
# its price has a probe; one that does not tell has none.
_A_PIXEL = (330.0, 260.0, 410.0)
_A_PIXEL_IF_PROBED = (500.0, 260.0, 560.0)
# Loaded on the way: quantiles, and what writes images.
_LOADED = (25e6, 10e6, 40e6)


def resident_bytes() -> int:
    """Return what this process has in memory now; 0 where the system does not tell."""
    try:
        return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    except OSError:
        return 0


def memory_bytes(groups: Path = Path("/sys/fs/cgroup")) -> int:
    """Return the bytes of memory that this process may have: the machine's, or fewer where a container limits it."""
    present = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    own = [""]
    try:
        lines = Path("/proc/self/cgroup").read_text().splitlines()
        own += [f"{line.split(':', 2)[2].lstrip('/')}" for line in lines if ":memory:" in line or line[:3] == "0::"]
    except OSError:
        pass
    files = [
        folder / name
        for inner in own
        for step in (Path(inner), *Path(inner).parents)
        for folder, name in ((groups / step, "memory.max"), (groups / "memory" / step, "memory.limit_in_bytes"))
    ]
    return min([present, *filter(None, map(_limit, files))])


def _limit(file: Path) -> int | None:
    """Return the number in a file of a cgroup; None if there is no such file, or no limit (``max``)."""
    try:
        return int(file.read_text())
    except (OSError, ValueError):
        return None


def peak_bytes(before: int, pixels: int, probed: bool) -> Estimate:
    """Return the most that a process will have which renders an image and saves it.

    Parameters
    ----------
    before
        What it has with the scene loaded, without any film.
    probed
        Whether it may quote the render by a probe (`equaltime.probe`).
    """
    each = _A_PIXEL_IF_PROBED if probed else _A_PIXEL
    value, low, high = (before + loaded + pixels * each_pixel for loaded, each_pixel in zip(_LOADED, each, strict=True))
    return Estimate(value, low, high, unit="MB")
