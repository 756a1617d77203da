"""Brings objects of files older than Mitsuba 2 into today's words.

Names go from camelCase to snake_case, ``diffuse_reflectance`` of a diffuse surface becomes ``reflectance``, and scale
and offset of texture coordinates become ``to_uv``: what Mitsuba 3 does when it reads such files. Beyond that, old
words that mean exactly what a new one means are replaced, and those that never touched the image are left out. Any
other is left for the model to refuse by its name.
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable
from typing import Final

from equaltime.scene import transforms
from equaltime.scene.model import METALS, Curve, Spectrum
from equaltime.scene.model.ior import as_ior
from equaltime.scene.tree import Child, Object, Report, Value

__all__ = ["upgraded"]

TYPES: Final = {
    "ldrfilm": "hdrfilm",
    "volpath_simple": "volpath",
    "sobol": "ldsampler",
    "halton": "ldsampler",
    "hammersley": "ldsampler",
}
"""Plugins that have another name now, as far as the image is concerned."""
WITHOUT_EFFECT: Final = {
    "film": {"attach_log", "burn", "exposure", "gamma", "high_quality_edges", "key", "tonemap_method"},
    "integrator": {"strict_normals"},
    "sampler": {"dimension", "scramble"},
    "texture": {"cache", "max_anisotropy"},
}
"""Parameters of each family that do not change the radiance in the image, or only in a way that is gone."""


def upgraded(node: Object, report: Report) -> Object:
    """Return `node`, with its children, in today's words; what was left out or replaced is noted."""
    node = _with(node, [_renamed(child) for child in node.children])
    for step in (_without_effect, _type, _reflectance, _to_uv, _filter, _gamma, _outside):
        node = step(node, report)
    return node


def snake_case(name: str) -> str:
    """Return ``toWorld`` as ``to_world`` and ``intIOR`` as ``int_ior``."""
    return re.sub(r"(?<=[a-z])[A-Z]+", lambda capitals: "_" + capitals[0].lower(), name)


def _with(node: Object, children: list[Child]) -> Object:
    return dataclasses.replace(node, children=children)


def _renamed(child: Child) -> Child:
    return child if child.name is None else dataclasses.replace(child, name=snake_case(child.name))


def _type(node: Object, report: Report) -> Object:
    new = TYPES.get(node.type)
    if new is None:
        return node
    report.note(f"{node.place}: '{node.type}' is read as '{new}'")
    return dataclasses.replace(node, type=new)


def _without_effect(node: Object, report: Report) -> Object:
    gone = WITHOUT_EFFECT.get(node.kind or "", set())
    for child in node.children:
        if child.name in gone:
            report.note(f"{child.node.place}: '{child.name}' of '{node.type}' is left out: it has no meaning any more")
    return _with(node, [child for child in node.children if child.name not in gone])


def _reflectance(node: Object, _report: Report) -> Object:
    if node.type != "diffuse":
        return node
    names = {"diffuse_reflectance": "reflectance"}
    return _with(node, [dataclasses.replace(c, name=names.get(c.name or "", c.name)) for c in node.children])


def _numbers(node: Object, *names: str) -> dict[str, float]:
    """Return those parameters of `node` that have these names and are numbers."""
    found = {child.name: child.node.data for child in node.children if child.name and isinstance(child.node, Value)}
    return {name: float(v) for name, v in found.items() if name in names and isinstance(v, int | float)}


def _replaced(node: Object, gone: set[str], *values: tuple[str, object]) -> Object:
    """Return `node` without the parameters `gone`, and with these values where the first of them stood."""
    place = next((child.node.place for child in node.children if child.name in gone), node.place)
    kept = [child for child in node.children if child.name not in gone]
    return _with(node, kept + [Child(name, Value(place, data)) for name, data in values])


def _to_uv(node: Object, _report: Report) -> Object:
    given = _numbers(node, "uscale", "vscale", "uoffset", "voffset")
    if not given or any(child.name == "to_uv" for child in node.children):
        return node
    offset = transforms.translate((given.get("uoffset", 0.0), given.get("voffset", 0.0), 0.0))
    scale = transforms.scale((given.get("uscale", 1.0), given.get("vscale", 1.0), 1.0))
    return _replaced(node, set(given), ("to_uv", transforms.compose([offset, scale])))


def _filter(node: Object, report: Report) -> Object:
    if node.type != "bitmap":
        return node
    children = list(node.children)
    for i, child in enumerate(children):
        if child.name == "filter_type" and isinstance(child.node, Value) and child.node.data in ("ewa", "trilinear"):
            report.note(
                f"{child.node.place}: the filter '{child.node.data}' is read as 'bilinear': samples do the rest"
            )
            children[i] = Child(child.name, Value(child.node.place, "bilinear"))
    return _with(node, children)


def _gamma(node: Object, _report: Report) -> Object:
    """Read a gamma of 1 as raw data and one of -1, the file's own, as nothing; others are refused by the model."""
    gamma = _numbers(node, "gamma").get("gamma") if node.type in ("bitmap", "envmap") else None
    if gamma == 1.0 and node.type == "bitmap":
        return _replaced(node, {"gamma"}, ("raw", True))
    return _replaced(node, {"gamma"}) if gamma in (-1.0, 1.0) else node


def _outside(node: Object, _report: Report) -> Object:
    """Divide the index of a metal by that of what is around it; today's ``eta`` and ``k`` are relative to that."""
    values = {child.name: child.node.data for child in node.children if child.name and isinstance(child.node, Value)}
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
    if isinstance(data, Curve):
        return Curve(data.wavelengths, tuple(map(scale, data.values)))
    if isinstance(data, Spectrum):
        return Spectrum(scale(data.value))
    if isinstance(data, tuple):
        return tuple(_scaled(item, scale) for item in data)
    return scale(data) if isinstance(data, int | float) else data
