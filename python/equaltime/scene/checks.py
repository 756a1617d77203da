"""Reads the files that a valid scene names, and collects warnings about odd but harmless parameters and files."""

from __future__ import annotations

from collections.abc import Iterator

from equaltime.scene import deforming, geometry
from equaltime.scene.assets import Assets
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
from equaltime.scene.out_of_range import of_mesh, of_textures
from equaltime.scene.resolve import Resolved
from equaltime.scene.tree import Object, Plain, Report
from equaltime.scene.unsupported import Unsupported

__all__ = ["check_parts"]


def check_parts(resolved: Resolved, assets: Assets, report: Report) -> tuple[str, ...]:
    """Read all meshes and images that the scene names, and return warnings for the user, one line each.

    Files that cannot be used are problems, and go to `report`. A plugin that the core cannot use is skipped here.
    """
    told: dict[str, dict[str, None]] = {}
    for node, part in resolved.parts:
        try:
            for place, message in _check_part(node, part, assets):
                told.setdefault(message, {})[place] = None
        except Unsupported:
            continue  # compiling refuses it; until then the scene can be inspected and converted
        except ValueError as error:
            report.add(node.place_of("filename"), str(error))
    return tuple(_one_line(message, list(places)) for message, places in told.items())


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
            along = f"its radius is that along x, {part.world_radius:g}"
            yield str(node.place), f"a sphere is not stretched, here as in Mitsuba: {along}"
    elif isinstance(part, EnvMap):
        yield from ((str(assets.path(part.filename)), text) for text in assets.told_of_image(part))
    elif isinstance(part, Bitmap):
        yield from ((str(assets.path(part.filename)), text) for text in assets.texture(part).told)
    elif isinstance(part, Spot) and part.beam_width is not None and part.beam_width > part.cutoff_angle:
        wide = "beam_width is beyond cutoff_angle: the light falls nowhere in the cone"
        yield str(node.place_of("beam_width")), wide
    elif isinstance(part, Path) and part.max_depth == 0:
        yield str(node.place_of("max_depth")), "a max_depth of 0 sees nothing: the image is black"
    elif isinstance(part, HdrFilm) and part.component_format == "uint32":
        yield str(node.place_of("component_format")), "whole numbers are not written: the picture has 32-bit floats"
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
