"""Golden images: which scenes there are, and how an image is stored with the variance of its every pixel."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

import equaltime as et

__all__ = ["SCENES", "Golden", "load_scene"]

HERE = Path(__file__).parent
SHIPPED = HERE.parents[1] / "scenes"
SCENES: Mapping[str, tuple[Path, tuple[int, int], int]] = {
    "cornell-box": (SHIPPED / "cornell-box.toml", (64, 64), 8),
    "veach-mis": (SHIPPED / "veach-mis.toml", (72, 48), 3),
    "montelight-complex": (SHIPPED / "montelight" / "complex.toml", (64, 64), 5),
    "glass": (HERE / "glass.toml", (64, 64), 12),
}
"""File, film size and max_depth, which is less than the files' where paths are long. In Veach's scene the smallest
light fills 2 % to 5 % of each of four pixels: where one as bright grazes a pixel, means of few samples are not normal.
"""


def load_scene(name: str, albedo: float = 1.0) -> et.Scene:
    """Return a scene in the size of its golden image, with all its reflectances times `albedo`."""
    path, size, max_depth = SCENES[name]
    tables = tomllib.loads(path.read_text())
    tables = _scaled(tables, albedo, tables.pop("default", {}))
    return et.load_dict({"type": "scene", **tables}).with_(size=size, max_depth=max_depth)


def _scaled(table: dict[str, Any], factor: float, variables: Mapping[str, Any]) -> dict[str, Any]:
    """Return a scene's tables with other reflectances, and with the variables' values in their places."""
    scaled = {}
    for key, value in table.items():
        if isinstance(value, dict):
            scaled[key] = _scaled(value, factor, variables)
        elif isinstance(value, list) and any(isinstance(item, dict) for item in value):
            scaled[key] = [_scaled(item, factor, variables) for item in value]
        elif isinstance(value, str) and value.startswith("$"):
            scaled[key] = variables[value[1:]]
        elif key in ("reflectance", "specular_reflectance") and factor != 1.0:
            scaled[key] = (np.multiply(value, factor)).tolist()
        else:
            scaled[key] = value
    return scaled


@dataclass(frozen=True, eq=False)
class Golden:
    """An image that is known well, and how well."""

    mean: NDArray[np.float32]
    """(height, width, 3)"""
    variance: NDArray[np.float32]
    """Of the mean, estimated from the spread of independent renders."""
    degrees: float
    """How many renders less one."""

    @classmethod
    def of(cls, images: Iterable[ArrayLike]) -> Golden:
        """Return what independent renders of equal weight say; only one at a time is in memory."""
        mean, squares, count = np.zeros(1), np.zeros(1), 0
        for image in images:
            count += 1
            step = np.asarray(image, dtype=np.float64) - mean
            mean = mean + step / count
            squares = squares + step * step * (count - 1) / count
        variance = squares / (count * (count - 1))
        return cls(mean.astype(np.float32), variance.astype(np.float32), count - 1.0)

    @classmethod
    def load(cls, name: str) -> Golden:
        """Return the stored image of a scene."""
        with np.load(HERE / f"{name}.npz") as stored:
            return cls(stored["mean"], stored["variance"], float(stored["degrees"]))

    def save(self, name: str) -> Path:
        """Store the image of a scene and return its place."""
        path = HERE / f"{name}.npz"
        np.savez_compressed(path, mean=self.mean, variance=self.variance, degrees=self.degrees)
        return path

    @property
    def relative_error(self) -> float:
        """The error of the image as the command line says it: 0.01 is 1 %."""
        denominator = self.mean**2 + (0.1 * self.mean.mean()) ** 2
        return math.sqrt(float(np.mean(self.variance / denominator)))
