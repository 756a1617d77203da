"""Names: the plugins of Mitsuba 3, the known name nearest to a misspelt word, and values as messages show them."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Final, cast

if TYPE_CHECKING:
    from equaltime.scene.model.base import Kind

__all__ = ["MITSUBA", "OLD", "SCENE_HINTS", "a", "mitsuba_kind", "nearest", "shortened", "suggestion"]

MOST_NAMES: Final = 512
LONGEST_NAME: Final = 100
"""Limits for `nearest`: the number of names, and the letters of a word. Its time grows with their product."""
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
    "bsdf": "coating difftrans hk irawan mixturebsdf phong roughcoating roughdiffuse rtrans ward",
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

_BRACKETS: Mapping[type[object], tuple[str, str]] = {list: ("[", "]"), tuple: ("(", ")"), dict: ("{", "}")}


def mitsuba_kind(name: str) -> Kind | None:
    """Return the family of the Mitsuba 3 plugin `name`, or None if there is none."""
    return next((kind for kind, names in MITSUBA.items() if name in names), None)


def a(noun: str) -> str:
    """Return a noun with its article."""
    return f"an {noun}" if noun[0] in "aeiou" else f"a {noun}"


def nearest(word: str, known: Iterable[str]) -> str | None:
    """Return the known name that is most similar to `word`, if one is near."""
    names = sorted(known)
    if len(names) > MOST_NAMES or len(word) > LONGEST_NAME:
        return None
    for candidate in (word, word.lower()):
        if found := difflib.get_close_matches(candidate, names, n=1, cutoff=0.6):
            return found[0]
    return None


def suggestion(word: str, known: Iterable[str]) -> str:
    """Return "; did you mean 'x'?" if a known name is near, else "; expected one of ..."."""
    names = sorted(known)
    if near := nearest(word, names):
        return f"; did you mean '{near}'?"
    if not names:
        return ""
    listed = ", ".join(f"'{name}'" for name in names[:12]) + (", ..." if len(names) > 12 else "")
    return f"; expected {'one of ' if len(names) > 1 else ''}{listed}"


def shortened(value: object, width: int) -> str:
    """Return ``repr(value)`` cut to `width` characters; the rest of a large value is never formatted."""
    text = ""
    for piece in _pieces(value, width):
        text += piece
        if len(text) > width:
            return text[: width - 3] + "..."
    return text


def _pieces(value: object, width: int) -> Iterator[str]:
    """Yield the text of a value piece by piece, so that a huge list, or one that contains itself, can be cut short."""
    if isinstance(value, str | bytes):
        yield repr(value[: width + 1])
    elif (brackets := _BRACKETS.get(type(value))) is not None:
        opening, closing = brackets
        yield opening
        for number, item in enumerate(cast(Iterable[object], value)):
            yield ", " if number else ""
            yield from _pieces(item, width)
            if isinstance(value, dict):
                yield ": "
                yield from _pieces(value[item], width)
        yield "," + closing if isinstance(value, tuple) and len(value) == 1 else closing
    else:
        yield _plain(value)


def _plain(value: object) -> str:
    try:
        return repr(value)
    except Exception as error:  # a user's object may raise anything
        if isinstance(value, int) and isinstance(error, ValueError):  # Python refuses more than 4300 digits
            return "a number of thousands of digits"
        return f"an object of type {type(value).__name__}"
