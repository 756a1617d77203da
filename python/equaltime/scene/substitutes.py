"""Replaces, on request, plugins and parameters that equaltime cannot render by similar ones, and lists them.

A substitute does not make the same image. It keeps the shape of objects, and the colours that can be carried over. A
plugin without a similar substitute is left out. Without the request (``--substitute``), a scene with such plugins is
refused, and the error names each with file and line. Tables list the plugins of Mitsuba 3 and Mitsuba 0.6 by name.
Missing images are replaced on request, too: textures by grey, skies by a constant one. So are images of glTF files
that cannot be decoded. Missing meshes are errors.
"""

from __future__ import annotations

import dataclasses
import math
import operator
import re
from collections.abc import Callable, Iterator, Mapping
from typing import Final

from equaltime.scene.lost_images import GREY, Lost
from equaltime.scene.model import OUTPUTS, OWN_OUTPUTS, PLUGINS, Kind
from equaltime.scene.tree import Child, Object, Place, Plain, Ref
from equaltime.words import nearest

__all__ = ["MITSUBA", "OLD", "SCENE_HINTS", "Substitution", "has_substitute", "mitsuba_kind", "substituted"]

_NAMES: dict[Kind, str] = {
    "bsdf": "blendbsdf bumpmap circular conductor dielectric diffuse hair mask measured measured_polarized null "
    "normalmap plastic polarizer pplastic principled principledthin retarder roughconductor roughdielectric "
    "roughplastic thindielectric twosided",
    "emitter": "area constant directional directionalarea envmap point projector spot sunsky timed_sunsky",
    "film": "hdrfilm specfilm",
    "integrator": "aov depth direct direct_projective moment path prb prb_basic prb_projective prbvolpath ptracer "
    "stokes volpath volpathmis volprim_rf_basic",
    "medium": "heterogeneous homogeneous",
    "phase": "blendphase hg isotropic rayleigh sggx tabphase",
    "rfilter": "box catmullrom gaussian lanczos mitchell tent",
    "sampler": "independent ldsampler multijitter orthogonal stratified",
    "sensor": "batch distant irradiancemeter orthographic perspective radiancemeter thinlens",
    "shape": "blender bsplinecurve cube cylinder disk ellipsoids ellipsoidsmesh instance linearcurve merge obj ply "
    "rectangle sdfgrid serialized shapegroup sphere",
    "texture": "bitmap blackbody checkerboard d65 irregular mesh_attribute rawconstant regular srgb uniform volume",
    "volume": "constvolume gridvolume",
}
MITSUBA = {kind: frozenset(names.split()) for kind, names in _NAMES.items()}
"""The plugins that Mitsuba 3 documents, by family."""
_OLD_NAMES: dict[Kind, str] = {
    "bsdf": "coating difftrans hk irawan mixturebsdf phong roughcoating rtrans ward",
    "emitter": "collimated sky sun",
    "integrator": "adaptive ao bdpt dipole erpt irrcache mlt motion multichannel photonmapper ppm pssmlt "
    "singlescatter sppm vpl",
    "phase": "kkay microflake mixturephase",
    "sensor": "fluencemeter perspective_rdist spherical telecentric",
    "shape": "deformable hair heightfield",
    "texture": "curvature gridtexture scale wireframe",
    "volume": "hgridvolume volcache",
}
OLD = {kind: frozenset(names.split()) for kind, names in _OLD_NAMES.items()}
"""Plugins of Mitsuba 0.6 that Mitsuba 3 does not have, by family."""
SCENE_HINTS = frozenset({"allow_thread_reordering", "embree_use_robust_intersections"})
"""Switches of a scene that tell Mitsuba how to trace rays; they have no meaning here."""


def mitsuba_kind(name: str) -> Kind | None:
    """Return the family, such as ``bsdf``, of the Mitsuba 3 plugin `name`; None if Mitsuba 3 has no such plugin."""
    return next((kind for kind, names in MITSUBA.items() if name in names), None)


Made = tuple[Object | None, str]
"""Substitute of an object and the substitute's description; the substitute is None if the object is left out."""


@dataclasses.dataclass(frozen=True, slots=True)
class Substitution:
    """A plugin or parameter that was replaced or left out, with its file and line; ``str()`` gives a sentence."""

    place: str
    what: str
    """The replaced plugin or parameter, such as ``bsdf 'measured'``."""
    by: str
    """The substitute, such as ``'diffuse'``; empty if there is none, and `what` was left out."""

    def __str__(self) -> str:
        done = f"is replaced by {self.by}" if self.by else "is left out"
        return f"{self.place}: the {self.what} {done}"


def has_substitute(kind: Kind, type: str) -> bool:
    """Tell whether the plugin `type` of Mitsuba 3 or Mitsuba 0.6 can be replaced or left out on request."""
    return type in SUBSTITUTES.get(kind, {}) or (kind in FALLBACKS and _is_known(kind, type))


def substituted(root: Object, lost: Callable[[str], Lost | None]) -> tuple[Object, tuple[Substitution, ...]]:
    """Replace all plugins and parameters in the scene `root` that cannot be rendered, or leave them out.

    `lost` returns what replaces an image by its name, or None if the image can be read. Return the new root, and the
    list of replaced or omitted plugins, parameters and images. A substitute is a similar plugin, but does not give the
    same image.
    """
    replacer = _Replacer(root, lost)
    scene = replacer.contents(root)
    done = (*replacer.done, *replacer.images())
    return replacer.without_references(scene) if replacer.gone else scene, done


class _Replacer:
    def __init__(self, root: Object, lost: Callable[[str], Lost | None]) -> None:
        self.done: list[Substitution] = []
        self.gone: set[str] = set()
        """Names of objects that are left out."""
        self._lost = lost
        self._made: dict[Object, Object | None] = {}
        self._constants: dict[tuple[str, str], dict[Place, None]] = {}
        """Places of the textures that are replaced by a constant, by the missing image and the constant in words."""
        top = {child.name: child.node for child in root.children if child.name and isinstance(child.node, Object)}
        self._named = top | {node.id: node for node in root.objects() if node.id is not None}

    def images(self) -> Iterator[Substitution]:
        """Yield the missing images of textures, each once, with its first place and the number of others."""
        for (image, by), (first, *others) in self._constants.items():
            more = f", here and in {len(others)} more place{'s' * (len(others) > 1)}" if others else ""
            yield Substitution(str(first), image, f"{by}{more}")

    def contents(self, node: Object) -> Object:
        """Return `node` with its contents replaced where needed."""
        children: list[Child] = []
        for child in node.children:
            if not isinstance(child.node, Object):
                children.append(child)
            elif (made := self._object(child.node)) is not None:
                if node.type == "mesh_attribute" and self._lost_image(child.node):
                    made = _squares(made)
                children.append(child if made is child.node else Child(child.name, made))
            else:
                self.gone |= {name for name in (child.node.id, child.name) if name}
        return self._parameters(_holding(node, children))

    def without_references(self, node: Object) -> Object:
        """Return `node` without references to objects that are left out."""
        children = [
            Child(child.name, self.without_references(child.node)) if isinstance(child.node, Object) else child
            for child in node.children
            if not self._is_lost(child, node)
        ]
        return _holding(node, children)

    def _is_lost(self, child: Child, parent: Object) -> bool:
        """Tell whether a child names an object that is left out, by a reference or by a string in its place."""
        if isinstance(child.node, Ref):
            return child.node.id in self.gone
        plugin, word = PLUGINS.get(parent.type), child.node.data if isinstance(child.node, Plain) else None
        takes = plugin is not None and (child.name in plugin.slots() or child.name in plugin.roles.values())
        return takes and isinstance(word, str) and word in self.gone

    def _object(self, node: Object) -> Object | None:
        """Return the substitute of `node`, or `node` itself; None if it is left out. Each object has one substitute."""
        if node not in self._made:
            self._made[node] = node  # for objects that contain themselves, which are refused later
            self._made[node] = self._substitute(node)
        return self._made[node]

    def _substitute(self, node: Object) -> Object | None:
        if lost := self._lost_image(node):
            return self._without_image(node, lost)
        inner = self.contents(node)
        kind = _family(node)
        if kind is None:
            return inner
        step = SUBSTITUTES.get(kind, {}).get(node.type)
        if step is None and kind in FALLBACKS and node.type not in PLUGINS and not _misspelt(kind, node.type):
            step = FALLBACKS[kind]
        if step is None:
            return inner
        asked = dataclasses.replace(inner, kind=kind)
        made, words = step(asked)
        if made is asked:
            return inner
        self.done.append(Substitution(str(node.place), f"{kind} '{node.type}'", words))
        return made

    def _target(self, child: Child) -> Object | None:
        """Return the object that a child is or names; None for other values."""
        if isinstance(child.node, Object):
            return child.node
        name = child.node.id if isinstance(child.node, Ref) else child.node.data
        return self._named.get(name) if isinstance(name, str) else None

    def _lost_image(self, node: Object) -> Lost | None:
        """Return the image that a texture or sky shows, or that `node` needs, if it is lost; else None."""
        if node.type in ("bitmap", "envmap"):
            names = (c.node.data for c in node.children if c.name == "filename" and isinstance(c.node, Plain))
            return next(filter(None, (self._lost(name) for name in names if isinstance(name, str))), None)
        if node.type not in ("bumpmap", "mask", "normalmap", "spot"):  # these do not take a grey
            return None
        textures = [inner for child in node.children if (inner := self._target(child)) and inner.type == "bitmap"]
        found = next(filter(None, map(self._lost_image, textures)), None)
        return None if found is not None and found.of_material and node.type == "mask" else found

    def _without_image(self, node: Object, lost: Lost) -> Object | None:
        """Return the substitute of `node`, whose image is lost."""
        if node.type == "bitmap":
            self._constants.setdefault((lost.image, lost.by), {})[node.place_of("filename")] = None
            return _constant(node, lost.value)
        kind: Kind = "emitter" if node.type in ("envmap", "spot") else "bsdf"
        made: Object | None
        if node.type == "envmap":
            made, words = _as(kind, "constant", radiance=1.0)(node)
        elif node.type == "spot":
            made, words = _as(kind, "spot", _same(*_BEAM))(node)[0], "one without an image"
        elif surface := next(filter(None, map(self._surface, node.children)), None):
            made, words = dataclasses.replace(surface, id=node.id, key=node.key), f"the '{surface.type}' in it"
        else:
            made, words = _diffuse(dataclasses.replace(node, kind=kind))
        self.done.append(Substitution(str(node.place), f"{kind} '{node.type}' of the {lost.image}", words))
        return made

    def _surface(self, child: Child) -> Object | None:
        """Return the BSDF that a child is or names, after substitution; None for other children."""
        found = self._target(child)
        return self._object(found) if found is not None and _family(found) == "bsdf" else None

    def _parameters(self, node: Object) -> Object:
        """Return `node` without the parameters that are known but not supported."""
        plugin = PLUGINS.get(node.type)
        gone = plugin.later | plugin.old if plugin is not None else frozenset[str]()
        kept: list[Child] = []
        for child in node.children:
            if child.name in gone:
                self.done.append(Substitution(str(child.node.place), f"parameter '{child.name}' of '{node.type}'", ""))
            else:
                kept.append(child)
        return _holding(node, kept)


def _holding(node: Object, children: list[Child]) -> Object:
    """Return `node` with these children; `node` itself if the children are unchanged."""
    same = len(children) == len(node.children) and all(map(operator.is_, children, node.children))
    return node if same else dataclasses.replace(node, children=children)


def _is_known(kind: Kind, type: str) -> bool:
    return type in MITSUBA[kind] or type in OLD.get(kind, ())


def _misspelt(kind: Kind, type: str) -> bool:
    """Tell whether the name is of no plugin, but similar to the name of a plugin of Mitsuba 3."""
    return not _is_known(kind, type) and nearest(type, MITSUBA[kind]) is not None


def _family(node: Object) -> Kind | None:
    """Return the family of `node`, if the file states it or its type is known."""
    if kind := node.kind or mitsuba_kind(node.type):
        return kind
    if node.type in PLUGINS:
        return PLUGINS[node.type].kind
    return next((kind for kind, steps in SUBSTITUTES.items() if node.type in steps), None)


# -- the substitutes ---------------------------------------------------------------------------------------------------


def _as(kind: Kind, type: str, names: Mapping[str, str] | None = None, **extra: object) -> Callable[[Object], Made]:
    """Return a function that makes a `type` of an object, and keeps the parameters in `names`, renamed."""

    def make(node: Object) -> Made:
        renamed = names or {}
        children = [Child(renamed[c.name], c.node) for c in node.children if c.name is not None and c.name in renamed]
        children += [Child(name, Plain(node.place, value)) for name, value in extra.items()]
        return dataclasses.replace(node, type=type, kind=kind, variable=None, children=children), f"'{type}'"

    return make


def _same(*names: str) -> dict[str, str]:
    return {name: name for name in names}


def _constant(node: Object, value: tuple[float, ...]) -> Object | None:
    """Return a texture that is the same everywhere: one number, or a colour in linear sRGB."""
    if len(value) == 1:
        return _as("texture", "uniform", value=value[0])(node)[0]
    return _as("texture", "srgb", color=value)(node)[0]


def _squares(constant: Object) -> Object:
    """Return a checkerboard of one colour, the only constant by which a mesh attribute can be multiplied."""
    value = constant.children[0].node
    colors = [Child(name, value) for name in ("color0", "color1")]
    return dataclasses.replace(constant, type="checkerboard", children=colors)


def _nothing(_node: Object) -> Made:
    return None, ""


def _inner(node: Object) -> Made:
    """Return the first inner object of the same family, or else the family's fallback."""
    for child in node.children:
        if isinstance(child.node, Object) and (child.node.kind or mitsuba_kind(child.node.type)) == node.kind:
            named = dataclasses.replace(child.node, id=node.id, key=node.key)
            return named, f"the '{child.node.type}' in it"
    return FALLBACKS[node.kind or "bsdf"](node)


def _outputs(node: Object) -> Made:
    """Keep the outputs that can be written; if there are none, return the integrator inside."""
    aovs = next((str(c.node.data) for c in node.children if c.name == "aovs" and isinstance(c.node, Plain)), "")
    pairs = [pair for pair in re.split(r"[\s,]+", aovs) if pair]
    kept = [pair for pair in pairs if pair.partition(":")[2] in {**OUTPUTS, **OWN_OUTPUTS}]
    if kept == pairs:
        return node, ""
    if not kept:
        return _inner(node)
    others = [child for child in node.children if child.name != "aovs"]
    children = [Child("aovs", Plain(node.place, ", ".join(kept))), *others]
    return dataclasses.replace(node, children=children), f"one that has only {', '.join(kept)}"


def _phong(node: Object) -> Made:
    exponent = next((c.node.data for c in node.children if c.name == "exponent" and isinstance(c.node, Plain)), 30.0)
    alpha = math.sqrt(2.0 / (float(exponent) + 2.0)) if isinstance(exponent, int | float) and exponent > 0 else 0.25
    return _as("bsdf", "roughplastic", _same("diffuse_reflectance"), alpha=alpha)(node)


def _blend(node: Object) -> Made:
    """Blend the first two BSDFs of a mixture by their weights, and leave out the others."""
    weights = next((str(c.node.data) for c in node.children if c.name == "weights" and isinstance(c.node, Plain)), "")
    numbers = [float(word) for word in re.findall(r"[0-9.]+(?:[eE][-+]?[0-9]+)?", weights)][:2]
    nested = [child for child in node.children if not isinstance(child.node, Plain)][:2]
    if len(nested) < 2 or len(numbers) < 2 or sum(numbers) <= 0.0:
        return _inner(node)
    weight = Child("weight", Plain(node.place, numbers[1] / sum(numbers)))
    return dataclasses.replace(node, type="blendbsdf", children=[weight, *nested]), "'blendbsdf'"


DISNEY: Final = {
    **_same("roughness", "anisotropic", "metallic", "sheen", "clearcoat", "eta"),
    **{"baseColor": "base_color", "base_color": "base_color"},
    **{"specularTransmission": "spec_trans", "specular_transmission": "spec_trans"},
    **{"subsurface": "flatness", "specularTint": "spec_tint", "specular_tint": "spec_tint"},
    **{"sheenTint": "sheen_tint", "sheen_tint": "sheen_tint"},
    **{"clearcoatGloss": "clearcoat_gloss", "clearcoat_gloss": "clearcoat_gloss"},
}
"""Parameters of the Disney BSDF, in the spellings in use; parameters without an equivalent here are missing."""
THIN: Final = ("base_color", "roughness", "anisotropic", "spec_tint", "sheen", "sheen_tint", "flatness", "eta")
_BEAM: Final = ("to_world", "intensity", "cutoff_angle", "beam_width")
_diffuse = _as("bsdf", "diffuse", {"reflectance": "reflectance"})
_path = _as("integrator", "path", _same("max_depth", "rr_depth", "hide_emitters"))

SUBSTITUTES: Final[Mapping[Kind, Mapping[str, Callable[[Object], Made]]]] = {
    "bsdf": {
        "measured": _diffuse,
        "measured_polarized": _diffuse,
        "hair": _as("bsdf", "roughplastic"),
        "principledthin": _as("bsdf", "principled", _same(*THIN)),
        "circular": _as("bsdf", "null"),
        "polarizer": _as("bsdf", "null"),
        "retarder": _as("bsdf", "null"),
        "phong": _phong,
        "ward": _as("bsdf", "roughplastic", _same("diffuse_reflectance")),
        "difftrans": _as("bsdf", "diffuse", {"transmittance": "reflectance"}),
        "mixturebsdf": _blend,
        "coating": _inner,
        "roughcoating": _inner,
        "disneybsdf": _as("bsdf", "principled", DISNEY),
        "disneydiffuse": _as("bsdf", "principled", DISNEY, specular=0.0),
        "disneymetal": _as("bsdf", "principled", DISNEY, metallic=1.0),
        "disneyglass": _as("bsdf", "principled", DISNEY, spec_trans=1.0),
        "disneyclearcoat": _as("bsdf", "principled", DISNEY, base_color=0.0, clearcoat=1.0),
        "disneysheen": _as("bsdf", "principled", DISNEY, sheen=1.0),
    },
    "emitter": {
        "sunsky": _as("emitter", "constant", radiance=1.0),
        "timed_sunsky": _as("emitter", "constant", radiance=1.0),
        "sky": _as("emitter", "constant", radiance=1.0),
        "sun": _nothing,
        "projector": _as("emitter", "spot", _same("to_world")),
        "directionalarea": _as("emitter", "area", _same("radiance")),
    },
    "integrator": {
        "adaptive": _inner,
        "irrcache": _inner,
        "multichannel": _inner,
        "aov": _outputs,
        **dict.fromkeys(("prb", "prb_basic", "prb_projective", "prbvolpath", "ptracer", "stokes"), _path),
        "direct_projective": _as("integrator", "direct", _same("hide_emitters")),
    },
    "film": {"specfilm": _as("film", "hdrfilm", _same("width", "height"))},
    "medium": {"heterogeneous": _nothing},
    "shape": dict.fromkeys(
        ("bsplinecurve", "linearcurve", "sdfgrid", "ellipsoids", "ellipsoidsmesh", "blender", "heightfield", "hair"),
        _nothing,
    ),
    "texture": {"scale": _inner, "volume": _as("texture", "uniform", value=0.5)},
}
"""Functions that make the substitute of a plugin that cannot be rendered, by family and plugin."""
FALLBACKS: Final[Mapping[Kind, Callable[[Object], Made]]] = {
    "bsdf": _diffuse,
    "integrator": _path,
    "sampler": _as("sampler", "independent", _same("sample_count")),
    "texture": _as("texture", "uniform", value=GREY),
}
"""Functions that make the substitute of any other unknown plugin, by family."""
