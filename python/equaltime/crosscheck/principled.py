"""Values of the principled BSDF, by Burley's formulas with Mitsuba 3's parameters, in float64 and local coordinates.

As in `equaltime.crosscheck.interfaces`, the normal is +z on the viewer's side, and values include the cosine of wi.
"""

from __future__ import annotations

import math

import numpy as np

from equaltime.crosscheck.bsdfs import constant, fresnel_dielectric, microfacets, smith
from equaltime.crosscheck.vectors import Array, dot, normalize
from equaltime.scene.model import Principled, RoughConductor

__all__ = ["coat_alpha2", "coat_facets", "main_facets", "principled"]

LEAST_ALPHA = 1e-3
LUMINANCE = np.array([0.212671, 0.715160, 0.072169])


def principled(bsdf: Principled, wo: Array, wi: Array, front: bool = True) -> Array:
    """Return the BSDF times the cosine of wi (N, 3), for local unit directions wo and wi (N, 3).

    The value is for radiance: refraction scales it by 1/eta^2. `front` tells whether the viewer is on the front side.
    """
    front = front or not bsdf.transmits
    eta = bsdf.ior if front else 1.0 / bsdf.ior
    above = wi[:, 2] > 0.0
    m = normalize(wo + np.where(above, 1.0, eta)[:, None] * wi)
    m *= np.where(m[:, 2:] < 0.0, -1.0, 1.0)
    o, i = np.clip(dot(wo, m), 1e-12, 1.0), dot(wi, m)
    right = (dot(wo, m) > 0.0) & np.where(above, True, i < 0.0)
    value = _facets(bsdf, wo, wi, m, o, i, eta, front)
    if front:
        value = value + np.where(above[:, None], _coat(bsdf, wo, wi, m, o) + _diffuse(bsdf, wo, wi, o), 0.0)
    if not bsdf.transmits:
        right = right & above
    return np.where(right[:, None], value, 0.0)


def main_facets(bsdf: Principled) -> RoughConductor:
    """Return a rough conductor with the GGX facets of the BSDF's main lobe, to compute with these facets."""
    rough, aspect = float(constant(bsdf.roughness)), math.sqrt(1.0 - 0.9 * float(constant(bsdf.anisotropic)))
    u, v = max(LEAST_ALPHA, rough**2 / aspect), max(LEAST_ALPHA, rough**2 * aspect)
    return RoughConductor(distribution="ggx", alpha_u=u, alpha_v=v)


def coat_alpha2(bsdf: Principled) -> float:
    """Return the squared roughness alpha^2 of the clear coat, from the parameter ``clearcoat_gloss``."""
    gloss = float(constant(bsdf.clearcoat_gloss))
    return (0.1 * (1.0 - gloss) + 0.001 * gloss) ** 2


def coat_facets(bsdf: Principled, m: Array) -> Array:
    """Return the microfacet distribution D (N,) of the clear coat at normals m (N, 3): Burley's GTR1."""
    alpha2 = coat_alpha2(bsdf)
    return np.asarray((alpha2 - 1.0) / (math.pi * math.log(alpha2) * (1.0 + (alpha2 - 1.0) * m[:, 2] ** 2)))


def _color(bsdf: Principled) -> Array:
    return np.array(constant(bsdf.base_color))


def _tint(bsdf: Principled) -> Array:
    color = _color(bsdf)
    luminance = float(color @ LUMINANCE)
    return color / luminance if luminance > 0.0 else np.ones(3)


def _schlick_weight(cosine: Array) -> Array:
    return np.asarray(np.clip(1.0 - cosine, 0.0, 1.0) ** 5)


def _schlick(r0: Array | float, cosine: Array, ior: float) -> Array:
    """Return Schlick's reflectance (N, 3 or 1); on the denser side it uses the cosine of refraction."""
    inside = np.sqrt(np.maximum(0.0, 1.0 - (1.0 - cosine**2) / ior**2))
    weight = _schlick_weight(cosine if ior > 1.0 else inside)[:, None]
    return np.asarray(weight + np.asarray(r0) * (1.0 - weight))


def _facets(bsdf: Principled, wo: Array, wi: Array, m: Array, o: Array, i: Array, eta: float, front: bool) -> Array:
    """Return the value of the main lobe: GGX facets that reflect (plain, tinted or as metal) and refract."""
    metal, glass, tinted = (float(constant(x)) for x in (bsdf.metallic, bsdf.spec_trans, bsdf.spec_tint))
    facets = main_facets(bsdf)
    above = wi[:, 2] > 0.0
    fresnel, _ = fresnel_dielectric(o, np.full(len(o), eta))
    if front:
        reflected = (1.0 - metal) * (1.0 - tinted) * fresnel[:, None] + metal * _schlick(_color(bsdf), o, bsdf.ior)
        r0 = _tint(bsdf) * ((eta - 1.0) / (eta + 1.0)) ** 2
        reflected = reflected + (1.0 - metal) * tinted * _schlick(r0, o, bsdf.ior)
    else:
        reflected = ((1.0 - metal) * glass * fresnel)[:, None]
    refracted = np.sqrt(_color(bsdf)) * ((1.0 - metal) * glass * (1.0 - fresnel))[:, None]
    shape = microfacets(facets, m) * smith(facets, wo) * smith(facets, np.where(above[:, None], wi, -wi)) / wo[:, 2]
    turn = np.where(above, 0.25, np.abs(i) * o / np.where(above, 1.0, (o + eta * i) ** 2))
    return np.asarray(np.where(above[:, None], reflected, refracted) * (shape * turn)[:, None])


def _coat(bsdf: Principled, wo: Array, wi: Array, m: Array, o: Array) -> Array:
    """Return the value of the clear coat: reflectance of 4 % at normal incidence, masking of roughness 0.25."""
    mask, d = RoughConductor(distribution="ggx", alpha=0.25), coat_facets(bsdf, m)
    up = np.where(wi[:, 2:] > 0.0, wi, -wi)
    shape = 0.25 * float(constant(bsdf.clearcoat)) * d * smith(mask, wo) * smith(mask, up) * wi[:, 2]
    return np.asarray(_schlick(0.04, o, bsdf.ior) * shape[:, None])


def _diffuse(bsdf: Principled, wo: Array, wi: Array, o: Array) -> Array:
    """Return the value of sheen plus the body: retro-reflective, blended to Hanrahan and Krueger's flat look."""
    metal, glass, rough = (float(constant(x)) for x in (bsdf.metallic, bsdf.spec_trans, bsdf.roughness))
    flat, lit, seen = float(constant(bsdf.flatness)), _schlick_weight(wi[:, 2]), _schlick_weight(wo[:, 2])
    retro = 2.0 * rough * o**2
    look = (1.0 - 0.5 * lit) * (1.0 - 0.5 * seen) + retro * (lit + seen + lit * seen * (retro - 1.0))
    grazing = 0.5 * retro - 1.0
    flatter = (1.0 + grazing * lit) * (1.0 + grazing * seen)
    slant = np.maximum(wi[:, 2] + wo[:, 2], 1e-12)
    look = look + flat * (1.25 * (flatter * (1.0 / slant - 0.5) + 0.5) - look)
    share = float(constant(bsdf.sheen_tint))
    sheen = (1.0 - share + share * _tint(bsdf)) * (float(constant(bsdf.sheen)) * (1.0 - metal))
    body = _color(bsdf) * ((1.0 - metal) * (1.0 - glass) / math.pi)
    return np.asarray((body * look[:, None] + sheen * _schlick_weight(o)[:, None]) * wi[:, 2:])
