"""Translates objects of files older than Mitsuba 2 into the names of Mitsuba 3.

Three changes are made as in Mitsuba 3. Names change from camelCase to snake_case. ``diffuse_reflectance`` becomes
``reflectance`` where a plugin has that parameter. Scale and offset of texture coordinates become ``to_uv``. In
addition, old names with exactly the meaning of a new name are replaced, and parameters that never changed the image are
left out. Any other old name is refused when the model is made.
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable
from typing import Final

from equaltime.scene import transforms
from equaltime.scene.model import METALS, PLUGINS, SpectralCurve, Spectrum
from equaltime.scene.model.ior import as_ior
from equaltime.scene.report import Report
from equaltime.scene.tree import Child, Node, Object, Plain

__all__ = ["upgraded"]

TYPES: Final = {
    "bump": "bumpmap",
    "lambertian": "diffuse",
    "ldrfilm": "hdrfilm",
    "mfilm": "hdrfilm",
    "tiledhdrfilm": "hdrfilm",
    "volpath_simple": "volpath",
    "sobol": "ldsampler",
    "halton": "ldsampler",
    "hammersley": "ldsampler",
}
"""New names of old plugins with the same effect on the image."""
WITHOUT_EFFECT: Final = {
    "emitter": {"cache"},
    "film": {"attach_log", "burn", "exposure", "gamma", "high_quality_edges", "key", "tonemap_method"},
    "integrator": {"strict_normals"},
    "sampler": {"dimension", "scramble"},
    "shape": {"collapse"},
    "texture": {"cache", "max_anisotropy"},
}
"""Parameters, by family, that do not change the radiance in the image, or that only changed features which no longer
exist."""
OF_THE_FILE: Final = {"digits", "file_format", "variable"}
"""Parameters of old films for the format of the output file, which the output's name now decides."""
PIXELS: Final = {"luminancealpha": "luminance_alpha", "spectrum": "rgb", "spectrumalpha": "rgba"}


def upgraded(node: Object, report: Report) -> Object:
    """Return the object `node`, from a file older than Mitsuba 2, with the names of Mitsuba 3.

    The type and the parameters of the object itself are renamed. Parameters that are left out, and types that are
    replaced, give warnings in `report`.
    """
    node = _with(node, [_renamed(child) for child in node.children])
    steps = (_without_effect, _pixels, _box, _type, _reflectance, _bent, _vertex_colors, _to_uv, _wrap, _filter, _gamma)
    for step in (*steps, _outside):
        node = step(node, report)
    return node


def snake_case(name: str) -> str:
    """Return the camelCase `name` in snake_case: ``to_world`` for ``toWorld``, ``int_ior`` for ``intIOR``."""
    return re.sub(r"(?<=[a-z])[A-Z]+", lambda capitals: "_" + capitals[0].lower(), name)


def _with(node: Object, children: list[Child]) -> Object:
    return dataclasses.replace(node, children=children)


def _renamed(child: Child) -> Child:
    return child if child.name is None else child._replace(name=snake_case(child.name))


def _type(node: Object, report: Report) -> Object:
    new = TYPES.get(node.type)
    if new is None:
        return node
    report.note(f"{node.place}: '{node.type}' is read as '{new}'")
    return dataclasses.replace(node, type=new)


def _without_effect(node: Object, report: Report) -> Object:
    gone = WITHOUT_EFFECT.get(node.kind or "", set()) | (OF_THE_FILE if node.type in ("ldrfilm", "mfilm") else set())
    for child in node.children:
        if child.name in gone:
            report.note(f"{child.node.place}: '{child.name}' of '{node.type}' is left out: it has no meaning any more")
    return _with(node, [child for child in node.children if child.name not in gone])


def _reflectance(node: Object, _report: Report) -> Object:
    plugin = PLUGINS.get(node.type)
    if plugin is None or "reflectance" not in plugin.model_fields:
        return node
    names = {"diffuse_reflectance": "reflectance"}
    return _with(node, [c._replace(name=names.get(c.name or "", c.name)) for c in node.children])


def _pixels(node: Object, _report: Report) -> Object:
    given = _strings(node, "pixel_format").get("pixel_format", "").lower()
    new = PIXELS.get(given) if node.kind == "film" else None
    return node if new is None else _replaced(node, {"pixel_format"}, ("pixel_format", new))


def _box(node: Object, _report: Report) -> Object:
    """Leave out a box filter's width of one pixel; the model refuses other widths."""
    is_pixel = node.type == "box" and _numbers(node, "radius").get("radius") == 0.5
    return _replaced(node, {"radius"}) if is_pixel else node


def _bent(node: Object, _report: Report) -> Object:
    """Give the texture that bends normals its new name; a ``scale`` texture around heights becomes a factor."""
    name = {"bumpmap": "texture", "normalmap": "normalmap"}.get(node.type)
    textures = [child for child in node.children if isinstance(child.node, Object) and child.node.kind == "texture"]
    if name is None or len(textures) != 1:
        return node
    child, others = textures[0], [child for child in node.children if child is not textures[0]]
    texture, factor = child.node, 1.0
    while node.type == "bumpmap" and isinstance(texture, Object) and (inner := _scaled_texture(texture)) is not None:
        texture, factor = inner[0], factor * inner[1]
    node = _with(node, [Child(name, texture), *others])
    if factor == 1.0:
        return node
    return _replaced(node, {"scale"}, ("scale", factor * _numbers(node, "scale").get("scale", 1.0)))


def _scaled_texture(node: Object) -> tuple[Node, float] | None:
    """Return the texture inside a ``scale`` texture, and its factor; None if the factor is not a number."""
    inner = [child.node for child in node.children if not isinstance(child.node, Plain)]
    factor = _numbers(node, "scale").get("scale")
    return (inner[0], factor) if node.type == "scale" and len(inner) == 1 and factor is not None else None


def _vertex_colors(node: Object, report: Report) -> Object:
    if node.type != "vertexcolors":
        return node
    report.note(f"{node.place}: 'vertexcolors' is read as 'mesh_attribute'")
    named = Child("name", Plain(node.place, "vertex_color"))
    return dataclasses.replace(node, type="mesh_attribute", children=[*node.children, named])


def _strings(node: Object, *names: str) -> dict[str, str]:
    """Return the parameters of `node` that have these names and are strings."""
    found = {child.name: child.node.data for child in node.children if child.name and isinstance(child.node, Plain)}
    return {name: v for name, v in found.items() if name in names and isinstance(v, str)}


def _numbers(node: Object, *names: str) -> dict[str, float]:
    """Return the parameters of `node` that have these names and are numbers."""
    found = {child.name: child.node.data for child in node.children if child.name and isinstance(child.node, Plain)}
    return {name: float(v) for name, v in found.items() if name in names and isinstance(v, int | float)}


def _replaced(node: Object, gone: set[str], *values: tuple[str, object]) -> Object:
    """Return `node` without the parameters `gone`, and with `values`, which get the place of the first of them."""
    place = next((child.node.place for child in node.children if child.name in gone), node.place)
    kept = [child for child in node.children if child.name not in gone]
    return _with(node, kept + [Child(name, Plain(place, data)) for name, data in values])


def _to_uv(node: Object, _report: Report) -> Object:
    given = _numbers(node, "uscale", "vscale", "uoffset", "voffset")
    if not given or any(child.name == "to_uv" for child in node.children):
        return node
    offset = transforms.translate((given.get("uoffset", 0.0), given.get("voffset", 0.0), 0.0))
    scale = transforms.scale((given.get("uscale", 1.0), given.get("vscale", 1.0), 1.0))
    return _replaced(node, set(given), ("to_uv", transforms.compose([offset, scale])))


def _wrap(node: Object, _report: Report) -> Object:
    """Merge equal wrap modes of both axes into one; the model refuses different modes."""
    axes = _strings(node, "wrap_mode_u", "wrap_mode_v")
    both = _strings(node, "wrap_mode").get("wrap_mode", "repeat")
    modes = {axes.get("wrap_mode_u", both), axes.get("wrap_mode_v", both)}
    if not axes or len(modes) > 1:
        return node
    return _replaced(node, {*axes, "wrap_mode"}, ("wrap_mode", modes.pop()))


def _filter(node: Object, report: Report) -> Object:
    if node.type != "bitmap":
        return node
    children = list(node.children)
    for i, child in enumerate(children):
        if child.name == "filter_type" and isinstance(child.node, Plain) and child.node.data in ("ewa", "trilinear"):
            report.note(
                f"{child.node.place}: the filter '{child.node.data}' is read as 'bilinear': samples do the rest"
            )
            children[i] = Child(child.name, Plain(child.node.place, "bilinear"))
    return _with(node, children)


def _gamma(node: Object, _report: Report) -> Object:
    """Read a bitmap's gamma of 1 as raw data; drop other values without effect. The model refuses the rest."""
    gamma = _numbers(node, "gamma").get("gamma") if node.type in ("bitmap", "envmap") else None
    if gamma == 1.0 and node.type == "bitmap":
        return _replaced(node, {"gamma"}, ("raw", True))
    return _replaced(node, {"gamma"}) if gamma in (-1.0, 1.0) else node


def _outside(node: Object, _report: Report) -> Object:
    """Divide a metal's index by that of the exterior medium; today's ``eta`` and ``k`` are relative to it."""
    values = {child.name: child.node.data for child in node.children if child.name and isinstance(child.node, Plain)}
    if node.type not in ("conductor", "roughconductor") or "ext_eta" not in values:
        return node
    try:
        outside = as_ior(values["ext_eta"])
    except ValueError:
        return node
    if not isinstance(outside, int | float) or outside <= 0.0:
        return node
    metal = METALS.get(str(values.get("material", "none")))
    eta, k = metal if metal is not None else (values.get("eta", 0.0), values.get("k", 1.0))
    new = [(name, _scaled(data, lambda v: v / outside)) for name, data in (("eta", eta), ("k", k))]
    return _replaced(node, {"ext_eta", "material", "eta", "k"}, *new)


def _scaled(data: object, scale: Callable[[float], float]) -> object:
    if isinstance(data, SpectralCurve):
        return SpectralCurve(data.wavelengths, tuple(map(scale, data.values)))
    if isinstance(data, Spectrum):
        return Spectrum(scale(data.value))
    if isinstance(data, tuple):
        return tuple(_scaled(item, scale) for item in data)
    return scale(data) if isinstance(data, int | float) else data
