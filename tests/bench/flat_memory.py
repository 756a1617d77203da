"""Whether memory depends on the samples: the peak of a process that renders few, and of one that renders very many.

A film of 1024x1024 pixels is rendered with 1, 4 and `--spp` samples a pixel (one alone has no error to be estimated,
and leaves out what that takes); and, since 100 000 would take a day, one
of 16x16 pixels with as many passes as they have: what a pass left behind would show there 100 000 times.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

from measuring import SCENES, arguments, parsed
from workers import fresh

FEW = 4


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--spp", type=int, default=64, help="of the large film [%(default)s]")
    parser.add_argument("--many", type=int, default=100_000, help="samples a pixel of the small film [%(default)s]")
    options = parsed(parser, spp=16, many=10_000)
    for size, most in ((1024, options.spp), (16, options.many)):
        one, few, many = (peak(size, spp, options.threads) for spp in (1, FEW, most))
        print(
            f"  {size}x{size}: {one / 1e6:.1f} MB with 1 sample a pixel, {few / 1e6:.1f} MB with {FEW}, "
            f"{many / 1e6:.1f} MB with {most}: {many / few:.3f} of those with {FEW}"
        )


def peak(size: int, spp: int, threads: int) -> int:
    """Return the most memory, in bytes, that a process held which renders and saves such an image."""
    with tempfile.TemporaryDirectory(prefix="equaltime-") as folder:
        question = {"scene": str(SCENES / "cornell-box.toml"), "size": [size, size], "max_depth": 4}
        return int(fresh(**question, spp=spp, threads=threads, save=str(Path(folder) / "a.exr"))["peak"])


if __name__ == "__main__":
    main()
