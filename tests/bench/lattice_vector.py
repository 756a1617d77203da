"""Makes the vector of the sampler `lattice` (cpp/equaltime/sampling/lattice_vector.h), or compares it with others.

An embedded rank-1 lattice in base 2 (Cools, Kuo and Nuyens 2006, "Constructing embedded lattice rules for multivariable
integration"). The vector is built component by component: of all odd numbers the one is taken whose worst ratio, over
the sizes 2^2 to 2^12, of what it adds to the squared worst-case error, over the least that any could add at that size,
is smallest. Larger sizes, to 2^20, each choose one more bit. The error is the shift-averaged one in the unanchored
Sobolev space with product weights: the mean over the points of the product of 1 + g w(x), w = 2 pi^2 B2(x), less 1.

The weights g say how much each number matters to a path: the first vertices matter most. The light point and the BSDF
direction of a vertex share their components, with shifts of their own, since no product in the radiance has both. The
choice of a light and the choice of a lobe share theirs for the same reason.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

SMALLEST, SEARCHED, LARGEST = 2, 12, 20
"""Logarithms of sizes: those that count when a component is searched for, and to what it is continued."""
BOUNCES = 8
"""Vertices whose numbers are in the lattice: kDimensionBounces of the core."""
FALLS = 0.8
"""The weight of a bounce, as a share of the weight of the bounce before."""
FILE = Path(__file__).resolve().parents[2] / "cpp/equaltime/sampling/lattice_vector.h"


def components() -> list[tuple[str, float]]:
    """Return the use of each component, and its weight."""
    found = [("pixel", 0.05)] * 2
    for bounce in range(BOUNCES):
        found += [(f"direction {bounce}", 0.1 * FALLS**bounce)] * 2 + [(f"choice {bounce}", 0.03 * FALLS**bounce)]
    found += [("lens", 0.05)] * 2 + [("time", 0.05)]
    for name, count in (("roulette", 1), ("material", 1), ("medium", 2)):
        for bounce in range(BOUNCES):
            found += [(f"{name} {bounce}", 0.03 * FALLS**bounce)] * count
    return found


def kernel(size: int) -> Array:
    """Return w at the multiples of 1 / 2^size."""
    x = np.arange(1 << size) / (1 << size)
    return np.asarray(2 * np.pi**2 * (x * x - x + 1 / 6))


def searched(weights: Sequence[float]) -> list[int]:
    """Return the components for up to 2^SEARCHED points."""
    count, w = 1 << SEARCHED, kernel(SEARCHED)
    k = np.arange(count)
    # the size of the smallest lattice that has point k
    first = np.array([SEARCHED - ((i & -i).bit_length() - 1 if i else SEARCHED) for i in range(count)])
    order = np.argsort(first, kind="stable")
    ends = np.cumsum(np.bincount(first, minlength=SEARCHED + 1)) - 1
    product, vector = np.ones(count), list[int]()
    for g in weights:
        choices = np.arange(1, count // 2, 2) if vector else np.array([1])  # z and 2^n - z are alike
        adds = np.empty((len(choices), SEARCHED + 1))
        for row, z in enumerate(choices):
            adds[row] = np.cumsum((product * w[k * z % count])[order])[ends]
        relative = (adds / adds.min(axis=0))[:, SMALLEST:]
        vector.append(int(choices[relative.max(axis=1).argmin()]))
        product *= 1 + g * w[k * vector[-1] % count]
    return vector


def continued(vector: Sequence[int], weights: Sequence[float]) -> list[int]:
    """Return the components with the bits that more points need."""
    found = list(vector)
    for size in range(SEARCHED + 1, LARGEST + 1):
        k, w, product = np.arange(1 << size, dtype=np.int64), kernel(size), np.ones(1 << size)
        for i, g in enumerate(weights):
            choices = (found[i], found[i] + (1 << (size - 1)))
            values = [w[k * z & ((1 << size) - 1)] for z in choices]
            best = int(np.argmin([product @ value for value in values])) if i else 0
            found[i] = choices[best]
            product *= 1 + g * values[best]
    return found


def squared_error(vector: Sequence[int], weights: Sequence[float], size: int) -> float:
    """Return the squared worst-case error of 2^size points."""
    k, w, product = np.arange(1 << size, dtype=np.int64), kernel(size), np.ones(1 << size)
    for z, g in zip(vector, weights, strict=True):
        product *= 1 + g * w[k * z & ((1 << size) - 1)]
    return float(product.mean() - 1)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="write nothing; compare with random vectors")
    options = parser.parse_args()
    names, weights = zip(*components(), strict=True)
    vector = continued(searched(weights), weights)
    random = np.random.default_rng(1)
    print("points       error²     of random vectors, least and median")
    for size in range(SMALLEST, LARGEST + 1, 2):
        others = [
            squared_error([1, *(2 * random.integers(0, 1 << 19, len(vector) - 1) + 1)], weights, size)
            for _ in range(8 if size > 16 else 32)
        ]
        print(f"2^{size:<2} {squared_error(vector, weights, size):14.6g} {min(others):14.6g} {np.median(others):14.6g}")
    if not options.check:
        FILE.write_text(header(names, vector))
        print(f"wrote {FILE}")


def header(names: Sequence[str], vector: Sequence[int]) -> str:
    """Return the C++ file of the vector."""
    rows = [f"    {z},  // {name}" for name, z in zip(names, vector, strict=True)]
    return "\n".join(
        [
            "// The vector of the rank-1 lattice, for up to 2^20 points: made by tests/bench/lattice_vector.py, which",
            "// says how it is constructed.",
            "#pragma once",
            "",
            "#include <cstdint>",
            "",
            '#include "equaltime/sampling/dimensions.h"',
            "",
            "namespace equaltime::lattice {",
            "",
            "inline constexpr std::uint32_t kVector[kDimensions] = {",
            *rows,
            "};",
            "",
            "}  // namespace equaltime::lattice",
            "",
        ]
    )


if __name__ == "__main__":
    main()
