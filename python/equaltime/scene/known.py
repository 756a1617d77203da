"""Names of the plugins of Mitsuba 3 and Mitsuba 0.6, by family such as ``bsdf``."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from equaltime.scene.model.base import Kind

__all__ = ["MITSUBA", "OLD", "SCENE_HINTS", "mitsuba_kind"]

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


def mitsuba_kind(name: str) -> Kind | None:
    """Return the family, such as ``bsdf``, of the Mitsuba 3 plugin `name`; None if Mitsuba 3 has no such plugin."""
    return next((kind for kind, names in MITSUBA.items() if name in names), None)
