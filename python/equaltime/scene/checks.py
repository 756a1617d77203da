"""Reads the files that a valid scene names, and collects warnings about odd but harmless parameters and files.

A plain number outside the range of its parameter is an error. For values of textures and mesh attributes, a warning
tells how many are outside. Sharpening, for example, may have raised one pixel in a million of a photograph beyond
white.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from equaltime.scene import deforming, geometry
from equaltime.scene.assets import Assets
from equaltime.scene.core import Unsupported
from equaltime.scene.model import (
    Bitmap,
    BlendBsdf,
    EnvMap,
    HdrFilm,
    Mask,
    MeshAttribute,
    MeshFile,
    Path,
    Plugin,
    Solid,
    Spectrum,
    Sphere,
    Spot,
    mesh_files,
)
from equaltime.scene.model.values import as_number
from equaltime.scene.report import Report
from equaltime.scene.resolve import Resolved
from equaltime.scene.tree import Object, Place, Plain

__all__ = ["Outside", "check_parts", "of_mesh", "of_textures"]


def check_parts(resolved: Resolved, assets: Assets, report: Report) -> tuple[str, ...]:
    """Read all meshes and images that the scene `resolved` names, and return warnings for the user, one line each.

    `assets` reads the files. Files that cannot be used are problems, and go to `report`. Each is told once, with the
    first place that names the file, and the number of others. A plugin that the core cannot use is skipped here.
    """
    told: dict[str, dict[str, None]] = {}
    wrong: dict[str, dict[Place, str]] = {}
    for node, part in resolved.parts:
        try:
            for place, message in _check_part(node, part, assets):
                told.setdefault(message, {})[place] = None
        except Unsupported:
            continue  # compiling refuses it; until then the scene can be inspected and converted
        except ValueError as error:
            message, names = str(error), isinstance(part, Bitmap | EnvMap | MeshFile)
            if names or message not in wrong:  # a surface repeats the problem of its texture, which comes before it
                wrong.setdefault(message, {})[node.place_of("filename")] = _hint(part, assets)
    for message, places in wrong.items():
        (first, hint), *others = places.items()
        more = f" (and {len(others)} more place{'s' * (len(others) > 1)})" if others else ""
        said = message.removeprefix(f"{first.file}: ")  # a glTF file has both the scene and its meshes
        closer = said != message and said.startswith(first.path)
        report.add(Place(first.file) if closer else first, f"{said}{more}{hint}")
    return tuple(_one_line(message, list(places)) for message, places in told.items())


def _hint(part: Plugin, assets: Assets) -> str:
    """Return how to go on without a missing image; empty for other problems."""
    lost = isinstance(part, Bitmap | EnvMap) and assets.lost(part.filename) is not None
    return "; --substitute replaces it" if lost else ""


def _one_line(message: str, places: list[str]) -> str:
    """Return one line for a message that holds at all these places; it names the first."""
    more = f" (and {len(places) - 1} more)" if len(places) > 1 else ""
    return f"{places[0]}: {message}{more}"


def _check_part(node: Object, part: Plugin, assets: Assets) -> Iterator[tuple[str, str]]:
    """Read the file that `part` names, if any, and yield its warnings as pairs of place and message."""
    yield from ((_file(outside.texture, assets), str(outside)) for outside in of_textures(part, assets))
    if isinstance(part, MeshFile):
        yield from deforming.check(part, assets)
        yield from ((mesh_files(part.filename)[0], str(outside)) for outside in of_mesh(part, assets))
    elif isinstance(part, Solid):
        geometry.surface(part, assets)
        if isinstance(part, Sphere) and part.is_stretched:
            along = f"its radius is scaled as along x, to {part.world_radius:g}"
            yield str(node.place), f"a sphere is not stretched, as in Mitsuba: {along}"
    elif isinstance(part, EnvMap):
        yield from ((str(assets.path(part.filename)), text) for text in assets.told_of_image(part))
    elif isinstance(part, Bitmap):
        yield from ((str(assets.path(part.filename)), text) for text in assets.texture(part).told)
    elif isinstance(part, Spot) and part.beam_width is not None and part.beam_width > part.cutoff_angle:
        wide = "beam_width is larger than cutoff_angle: the intensity is constant in the cone"
        yield str(node.place_of("beam_width")), wide
    elif isinstance(part, Path) and part.max_depth == 0:
        yield str(node.place_of("max_depth")), "a max_depth of 0 sees nothing: the image is black"
    elif isinstance(part, HdrFilm) and part.component_format == "uint32":
        yield str(node.place_of("component_format")), "integers are not written: the image has 32-bit floats"
    elif isinstance(part, Mask | BlendBsdf):
        yield from _cut(node, part, "opacity" if isinstance(part, Mask) else "weight")


def _file(texture: Bitmap | MeshAttribute, assets: Assets) -> str:
    return str(assets.path(texture.filename)) if isinstance(texture, Bitmap) else ""


def _cut(node: Object, part: Mask | BlendBsdf, name: str) -> Iterator[tuple[str, str]]:
    """Yield a warning for each number of `part` that was clamped, with its value before."""
    given = [child.node for child in node.children if child.name == name and isinstance(child.node, Plain)]
    for value in given:
        if isinstance(value.data, int | float | Spectrum) and (was := as_number(value.data)) != getattr(part, name):
            yield str(value.place), f"{name} is cut to {getattr(part, name):g}, as in Mitsuba, from {was:g}"


# -- values of textures ------------------------------------------------------------------------------------------------

FACTORS: Final = frozenset(
    {
        *("reflectance", "diffuse_reflectance", "specular_reflectance", "specular_transmittance", "base_color"),
        *("roughness", "anisotropic", "metallic", "spec_trans", "spec_tint", "sheen", "sheen_tint", "flatness"),
        *("clearcoat", "clearcoat_gloss", "weight", "opacity"),
    }
)
"""Parameters whose values lie in [0, 1]."""
POSITIVE: Final = frozenset({"alpha", "alpha_u", "alpha_v", "radiance", "eta", "k", "color0", "color1"})
"""Parameters whose values are not negative."""


@dataclass(frozen=True, slots=True)
class Outside:
    """A texture with values outside the range of the parameter that uses it; ``str()`` gives a warning for the user."""

    node: Plugin
    """The plugin, such as a BSDF, that has the parameter."""
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
        numbers = f"{self.count:,} {what} are outside; all values range from {self.least:.4g} to {self.most:.4g}"
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
