"""Reports on values of textures and mesh attributes outside the range of the parameter that uses them.

A plain number outside the range is an error. Values of textures are only counted for a warning. Sharpening, for
example, may have raised one pixel of a photograph in a million beyond white.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from equaltime.scene.assets import Assets
from equaltime.scene.model import Bitmap, MeshAttribute, MeshFile, Plugin

__all__ = ["Outside", "of_mesh", "of_textures"]

FACTORS: Final = frozenset(
    {
        *("reflectance", "diffuse_reflectance", "specular_reflectance", "specular_transmittance", "base_color"),
        *("roughness", "anisotropic", "metallic", "spec_trans", "spec_tint", "sheen", "sheen_tint", "flatness"),
        *("clearcoat", "clearcoat_gloss", "weight", "opacity"),
    }
)
"""Parameters that lie in [0, 1]."""
POSITIVE: Final = frozenset({"alpha", "alpha_u", "alpha_v", "radiance", "eta", "k", "color0", "color1"})
"""Parameters that are not negative."""


@dataclass(frozen=True, slots=True)
class Outside:
    """Report on one texture with values outside the range of the parameter that uses it; ``str()`` gives a warning."""

    node: Plugin
    """The plugin that has the parameter."""
    name: str
    """The parameter's name."""
    texture: Bitmap | MeshAttribute
    count: int
    """Number of texels, vertices or faces with a value that is not allowed."""
    least: float
    most: float
    """Smallest and largest of all values of the texture: `least` and `most`."""

    def __str__(self) -> str:
        allowed = "lies in [0, 1]" if self.name in FACTORS else "is not negative"
        what = "texels" if isinstance(self.texture, Bitmap) else f"values of {self.texture.name}"
        numbers = f"{self.count:,} {what} are beyond it; all reach from {self.least:.4g} to {self.most:.4g}"
        return f"used as {self.name}, which {allowed}: {numbers}"


def of_textures(node: Plugin, assets: Assets) -> Iterator[Outside]:
    """Yield a report for each parameter of `node` whose bitmap has texels outside the parameter's range."""
    for name, texture in _parameters(node):
        bitmap = texture.times if isinstance(texture, MeshAttribute) else texture
        if isinstance(bitmap, Bitmap):
            texels = assets.texture(bitmap).texels
            if texels.dtype != np.uint8:
                yield from _outside(node, name, bitmap, texels)


def of_mesh(shape: Plugin, assets: Assets) -> Iterator[Outside]:
    """Yield a report for each parameter whose mesh attribute has values outside the parameter's range.

    Parameters of all plugins in `shape`, such as its BSDF and emitter, are examined. A shape that is no mesh gives no
    reports.
    """
    if not isinstance(shape, MeshFile):
        return
    for node in shape.nodes():
        for name, texture in _parameters(node):
            if isinstance(texture, MeshAttribute):
                values = assets.mesh(shape).attributes.get(texture.name)
                if values is not None:
                    yield from _outside(node, name, texture, texture.numbers(values))


def _parameters(node: Plugin) -> Iterator[tuple[str, Any]]:
    for name in type(node).model_fields:
        if name in FACTORS or name in POSITIVE:
            yield name, getattr(node, name)


def _outside(node: Plugin, name: str, texture: Bitmap | MeshAttribute, values: NDArray[Any]) -> Iterator[Outside]:
    least, most = float(values.min(initial=np.inf)), float(values.max(initial=-np.inf))
    if least < 0.0 or (name in FACTORS and most > 1.0):
        wrong = (values < 0.0) | ((values > 1.0) if name in FACTORS else False)
        yield Outside(node, name, texture, int(wrong.any(axis=-1).sum()), least, most)
