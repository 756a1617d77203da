"""BSDF values and densities of dielectric surfaces, bare or over a diffuse body, by Mitsuba 3's formulas.

As in `equaltime.crosscheck.bsdfs`, the normal is +z on the side of the viewer, and values include the cosine of wi.
Directions are local unit vectors (N, 3). Densities of rough surfaces are for visible normals, as the core draws them.
Tests compare these densities with the core's; the cross-check itself samples by other densities.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from equaltime.crosscheck.bsdfs import constant, fresnel_dielectric, microfacets, smith
from equaltime.crosscheck.vectors import Array, dot, normalize
from equaltime.scene.model import Plastic, RoughConductor, RoughDielectric, RoughPlastic, ThinDielectric

__all__ = ["mirror_share", "plastic", "rough_dielectric", "rough_plastic", "thin_reflectance"]

KNOTS = 64
"""Number of knots of a rough interface's table of transmittance by the cosine. As in Mitsuba, the table is interpolated
linearly."""


def thin_reflectance(bsdf: ThinDielectric, wo: Array) -> Array:
    """Return the reflectance (N,) of a thin sheet, including all internal reflections: a geometric series.

    `wo` (N, 3) are unit local directions to the viewer.
    """
    one, _ = fresnel_dielectric(wo[:, 2], np.full(len(wo), bsdf.int_ior / bsdf.ext_ior))
    return np.asarray(one + (1.0 - one) ** 2 * one / np.where(one < 1.0, 1.0 - one**2, 1.0))


def mirror_share(bsdf: Plastic, wo: Array) -> Array:
    """Return the probability (N,) in [0, 1] that a sample is the mirror reflection, not from the diffuse body.

    `wo` (N, 3) are unit local directions to the viewer.
    """
    ior = bsdf.int_ior / bsdf.ext_ior
    seen, _ = fresnel_dielectric(np.maximum(wo[:, 2], 0.0), np.full(len(wo), ior))
    mirror = np.mean(constant(bsdf.specular_reflectance)) * seen
    rest = _body(bsdf, _diffuse_fresnel(1.0 / ior), ior).mean() * (1.0 - _diffuse_fresnel(ior)) * (1.0 - seen)
    return np.asarray(mirror / np.maximum(mirror + rest, 1e-300))


def plastic(bsdf: Plastic, wo: Array, wi: Array) -> tuple[Array, Array]:
    """Return BSDF value (N, 3) and density per solid angle (N,) of the diffuse body under a smooth interface.

    `wo` (to the viewer) and `wi` (to the light) are unit local directions (N, 3). The value includes the cosine of wi.
    The mirror reflection is left out, since its direction is discrete. The density includes the probability of sampling
    the body.
    """
    ior = bsdf.int_ior / bsdf.ext_ior
    index = np.full(len(wo), ior)
    seen, lit = (fresnel_dielectric(np.maximum(v[:, 2], 0.0), index)[0] for v in (wo, wi))
    cosine = np.maximum(wi[:, 2], 0.0) / math.pi
    body = _body(bsdf, _diffuse_fresnel(1.0 / ior), ior)
    return body * ((1.0 - seen) * (1.0 - lit) * cosine)[:, None], (1.0 - mirror_share(bsdf, wo)) * cosine


def rough_plastic(bsdf: RoughPlastic, wo: Array, wi: Array) -> tuple[Array, Array]:
    """Return BSDF value (N, 3) and density per solid angle (N,) of a rough interface over a diffuse body.

    `wo` (to the viewer) and `wi` (to the light) are unit local directions (N, 3). The value includes the cosine of wi.
    """
    ior = bsdf.int_ior / bsdf.ext_ior
    facets = RoughConductor(distribution=bsdf.distribution, alpha=bsdf.alpha)
    outside, entering, internal = _interface(facets, ior)
    seen, lit = (np.interp(v[:, 2], np.arange(KNOTS) / (KNOTS - 1), outside) for v in (wo, wi))
    body, cosine = _body(bsdf, internal, ior), np.maximum(wi[:, 2], 0.0) / math.pi
    m = normalize(wo + wi)
    c = dot(wo, m)
    reflectance, _ = fresnel_dielectric(c, np.full(len(wo), ior))
    d = microfacets(facets, m)
    mirror = reflectance * d * smith(facets, wo) * smith(facets, wi) / (4.0 * wo[:, 2])
    value = np.array(constant(bsdf.specular_reflectance)) * mirror[:, None] + body * (cosine * seen * lit)[:, None]
    share = np.mean(constant(bsdf.specular_reflectance)) * (1.0 - seen)
    share = share / np.maximum(share + body.mean() * entering * seen, 1e-300)
    return value, share * d * visible(facets, wo) / (4.0 * wo[:, 2]) + (1.0 - share) * cosine


def rough_dielectric(bsdf: RoughDielectric, wo: Array, wi: Array, front: bool = True) -> tuple[Array, Array]:
    """Return BSDF value (N, 3) and density per solid angle (N,) of reflecting and refracting facets.

    `wo` (to the viewer) and `wi` (to the light) are unit local directions (N, 3). The formulas are from Walter et al.
    2007. The value includes the cosine of wi, and is for radiance: refraction scales it by 1/eta^2. `front` tells
    whether the viewer is on the front side.
    """
    ior = bsdf.int_ior / bsdf.ext_ior
    eta = ior if front else 1.0 / ior
    alpha_u, alpha_v = map(constant, bsdf.alphas)
    facets = RoughConductor(distribution=bsdf.distribution, alpha_u=alpha_u, alpha_v=alpha_v)
    mirrors = wi[:, 2] > 0.0
    m = normalize(wo + np.where(mirrors, 1.0, eta)[:, None] * wi)
    m *= np.where(m[:, 2:] < 0.0, -1.0, 1.0)
    o, i = dot(wo, m), dot(wi, m)
    right = (o > 0.0) & np.where(mirrors, True, i < 0.0)
    reflectance, _ = fresnel_dielectric(np.clip(o, 1e-12, 1.0), np.full(len(wo), eta))
    d, masked = microfacets(facets, m), visible(facets, wo)
    g = smith(facets, wo) * smith(facets, np.where(mirrors[:, None], wi, -wi))
    turn = np.where(mirrors, 0.25, np.abs(i) * o / (o + eta * i) ** 2)
    share = np.where(mirrors, reflectance, 1.0 - reflectance)
    color = np.where(mirrors[:, None], constant(bsdf.specular_reflectance), constant(bsdf.specular_transmittance))
    value = color * (share * d * g * turn / wo[:, 2])[:, None]
    density = share * d * masked / wo[:, 2] * turn * np.where(mirrors, 1.0, eta**2)
    return np.where(right[:, None], value, 0.0), np.where(right, density, 0.0)


def visible(facets: RoughConductor, v: Array) -> Array:
    """Return the share (N,) of microfacets visible from unit directions v (N, 3), without approximation.

    The density with which visible normals are sampled is divided by this share. For Beckmann facets, `smith` only
    approximates the share.
    """
    if facets.distribution == "ggx":
        return smith(facets, v)
    alpha_u, alpha_v = map(constant, facets.alphas)
    a = v[:, 2] / np.maximum(np.hypot(alpha_u * v[:, 0], alpha_v * v[:, 1]), 1e-30)
    erf = np.array([math.erf(x) for x in a])
    return np.asarray(2.0 / (1.0 + erf + np.exp(-(np.minimum(a, 30.0) ** 2)) / (a * math.sqrt(math.pi))))


def _body(bsdf: Plastic, internal: float, ior: float) -> Array:
    rho = np.array(constant(bsdf.diffuse_reflectance))
    return np.asarray(rho / ((1.0 - (rho * internal if bsdf.nonlinear else internal)) * ior**2))


def _diffuse_fresnel(eta: float) -> float:
    """Return an interface's reflectance for diffuse light, by the fits that Mitsuba uses (d'Eon & Irving 2011)."""
    x = 1.0 / eta
    if eta < 1.0:
        return 0.6681 + eta * (0.7099 - 1.4399 * eta) + 0.0636 * x
    return float(np.polyval([-1.36881, 4.98554, -7.80989, 6.75335, -3.4793, 0.919317], x))


@lru_cache(maxsize=64)
def _interface(facets: RoughConductor, ior: float) -> tuple[Array, float, float]:
    """Return a rough interface's transmittance by cosine, the transmittance's mean, and the mean inner reflectance."""
    cosines = np.maximum(np.arange(KNOTS) / (KNOTS - 1), 1e-6)
    outside = np.array([_let_through(facets, c, ior) for c in cosines])
    inside = np.array([_sent_back(facets, c, 1.0 / ior) for c in cosines])
    return outside, float(2.0 / KNOTS * outside @ cosines), float(2.0 / KNOTS * inside @ cosines)


def _normals(facets: RoughConductor, cosine: float) -> tuple[Array, Array, Array]:
    """Return the viewer's direction (1, 3), normals (N, 3) on a grid, and their shares of the visible area (N,)."""
    side = 64
    t, turn = np.meshgrid((np.arange(4 * side) + 0.5) / (4 * side), (np.arange(side) + 0.5) / side)
    rest = t**2  # share of steeper slopes: the grid is denser for steep slopes, for the tails of GGX
    r = np.sqrt((1.0 - rest) / rest) if facets.distribution == "ggx" else np.sqrt(-np.log(rest))
    alpha = constant(facets.alphas[0])
    slope = alpha * r * np.cos(math.pi * turn), alpha * r * np.sin(math.pi * turn)
    m = normalize(np.stack([*slope, np.ones_like(r)], axis=-1).reshape(-1, 3))
    wo = np.array([[math.sqrt(1.0 - cosine**2), 0.0, cosine]])
    weight = 2.0 * t.ravel() * visible(facets, wo) * np.maximum(dot(wo, m), 0.0) / (cosine * m[:, 2]) / len(m)
    return wo, m, weight


def _let_through(facets: RoughConductor, cosine: float, eta: float) -> float:
    wo, m, weight = _normals(facets, cosine)
    c = np.clip(dot(wo, m), 1e-12, 1.0)
    reflectance, refracted = fresnel_dielectric(c, np.full(len(m), eta))
    wi = m * (c / eta - refracted)[:, None] - wo / eta
    return float((weight * (1.0 - reflectance) * np.where(wi[:, 2] < 0.0, smith(facets, -wi), 0.0)).sum())


def _sent_back(facets: RoughConductor, cosine: float, eta: float) -> float:
    wo, m, weight = _normals(facets, cosine)
    c = np.clip(dot(wo, m), 1e-12, 1.0)
    reflectance, _ = fresnel_dielectric(c, np.full(len(m), eta))
    wi = 2.0 * c[:, None] * m - wo
    return float((weight * reflectance * np.where(wi[:, 2] > 0.0, smith(facets, wi), 0.0)).sum())
