"""Diffuse, metal and glass BSDFs by Mitsuba's formulas, in local coordinates; `scattering` covers all BSDFs.

The normal is +z, on the side of the viewer; wo points to the viewer (z > 0), wi to the light. `evaluate` returns
the BSDF f(wo, wi) times the cosine of wi, and the density per solid angle with which `sample` draws wi. Mirrors and
glass scatter into discrete directions: `evaluate` gives zero for them, and `sample` gives an infinite density.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from equaltime.crosscheck.vectors import Array, Mask, dot, normalize
from equaltime.scene.model import (
    Bsdf,
    Conductor,
    Dielectric,
    Diffuse,
    RoughConductor,
    RoughDiffuse,
    Texture,
    TexturePlugin,
)

__all__ = [
    "Scattered",
    "constant",
    "draw_cosine",
    "draw_microfacets",
    "evaluate",
    "fresnel_conductor",
    "fresnel_dielectric",
    "microfacets",
    "sample",
    "smith",
]

T = TypeVar("T")


def constant(value: Texture | T) -> T:
    """Return `value`, which may be a texture by its type, typed as a constant.

    `equaltime.crosscheck.tracer.check` has refused scenes with textures, so the type is certain.
    """
    assert not isinstance(value, TexturePlugin), "textures are refused before"
    return value


@dataclass(frozen=True, slots=True, eq=False)
class Scattered:
    """Directions drawn from a BSDF by `sample`, with weights and densities; each array has one row per path."""

    wi: Array
    """Unit directions to the light (N, 3)."""
    weight: Array
    """Weight of each path: BSDF f times cosine over the density (N, 3)."""
    pdf: Array
    """Density per solid angle (N,); infinite for discrete directions."""


def evaluate(bsdf: Bsdf, wo: Array, wi: Array) -> tuple[Array, Array]:
    """Return the BSDF times the cosine of wi (N, 3), and the density per solid angle (N,) with which `sample` draws wi.

    `wo` (to the viewer) and `wi` (to the light) are unit local directions (N, 3).
    """
    value, pdf = np.zeros_like(wi), np.zeros(len(wi))
    up = np.flatnonzero(wi[:, 2] > 0.0)
    if isinstance(bsdf, Diffuse):
        pdf[up] = wi[up, 2] / math.pi
        rho = _grooves(bsdf, wo[up], wi[up]) if isinstance(bsdf, RoughDiffuse) else np.array(bsdf.reflectance)
        value[up] = rho * pdf[up, None]
    elif isinstance(bsdf, RoughConductor):
        value[up], pdf[up] = _rough(bsdf, wo[up], wi[up])
    return value, pdf


def sample(bsdf: Bsdf, wo: Array, front: Mask, rng: np.random.Generator) -> Scattered:
    """Draw a direction wi to the light for each local direction wo (N, 3) to the viewer.

    Returns the directions with weights and densities, one row per path. `front` (N,) is True where the viewer is on the
    front side.
    """
    if isinstance(bsdf, Dielectric):
        return _glass(bsdf, wo, front, rng)
    mirrored = wo * (-1.0, -1.0, 1.0)
    if isinstance(bsdf, RoughConductor):
        m = draw_microfacets(bsdf, len(wo), rng)
        wi = 2.0 * dot(wo, m)[:, None] * m - wo
    elif isinstance(bsdf, Conductor):
        reflectance = np.array(bsdf.specular_reflectance) * fresnel_conductor(wo[:, 2], bsdf)
        return Scattered(mirrored, reflectance, np.full(len(wo), np.inf))
    else:
        wi = draw_cosine(len(wo), rng)
    value, pdf = evaluate(bsdf, wo, wi)
    weight = np.divide(value, pdf[:, None], out=np.zeros_like(value), where=pdf[:, None] > 0.0)
    return Scattered(wi, weight, pdf)


def draw_cosine(count: int, rng: np.random.Generator) -> Array:
    """Return local directions (count, 3) whose density per solid angle is their cosine with the normal over pi.

    Uses Malley's method: uniform points of the unit disk are lifted to the hemisphere.
    """
    square, phi = rng.random(count), rng.uniform(0.0, 2.0 * math.pi, count)
    r = np.sqrt(square)
    return np.stack([r * np.cos(phi), r * np.sin(phi), np.sqrt(1.0 - square)], axis=1)


def _grooves(bsdf: RoughDiffuse, wo: Array, wi: Array) -> Array:
    """Return pi times the BSDF of a rough diffuse surface (N, 3), by the formulas and names of Oren and Nayar 1994.

    Values below 0, which the formulas give where both directions graze a very rough surface, become 0.
    """
    rho, variance = np.array(bsdf.reflectance), 0.5 * constant(bsdf.alpha) ** 2
    angles = np.arccos(np.clip([wo[:, 2], wi[:, 2]], -1.0, 1.0))
    alpha, beta = angles.max(axis=0), angles.min(axis=0)
    cos_phi = np.cos(np.arctan2(wo[:, 1], wo[:, 0]) - np.arctan2(wi[:, 1], wi[:, 0]))
    spread = variance / (variance + 0.09)
    c1 = 1.0 - 0.5 * variance / (variance + 0.33)
    if bsdf.use_fast_approx:
        c2 = 0.45 * spread * np.sin(alpha)
        return np.asarray(rho * (c1 + np.maximum(cos_phi, 0.0) * c2 * np.tan(beta))[:, None])
    c2 = 0.45 * spread * (np.sin(alpha) - np.where(cos_phi < 0.0, (2.0 * beta / math.pi) ** 3, 0.0))
    c3 = 0.125 * spread * (4.0 * alpha * beta / math.pi**2) ** 2
    once = c1 + cos_phi * c2 * np.tan(beta) + (1.0 - np.abs(cos_phi)) * c3 * np.tan(0.5 * (alpha + beta))
    twice = 0.17 * variance / (variance + 0.13) * (1.0 - cos_phi * (2.0 * beta / math.pi) ** 2)
    value: Array = np.maximum(rho * once[:, None] + rho**2 * twice[:, None], 0.0)
    return value


# ---- rough conductor ------------------------------------------------------------------------------------------------


def microfacets(bsdf: RoughConductor, m: Array) -> Array:
    """Return the microfacet distribution D (N,) of a rough metal at facet normals m (N, 3).

    D is the area of facets per solid angle of their normals and per area of the surface.
    """
    alpha_u, alpha_v = map(constant, bsdf.alphas)
    across, z2 = (m[:, 0] / alpha_u) ** 2 + (m[:, 1] / alpha_v) ** 2, m[:, 2] ** 2
    if bsdf.distribution == "ggx":
        return 1.0 / (math.pi * alpha_u * alpha_v * (across + z2) ** 2)
    density: Array = np.exp(-across / z2) / (math.pi * alpha_u * alpha_v * z2**2)
    return density


def smith(bsdf: RoughConductor, v: Array) -> Array:
    """Return Smith's masking function G1 (N,): the share of microfacets visible from unit directions v (N, 3).

    For Beckmann facets G1 is the usual rational approximation. See Walter et al. 2007, eq. 27 and 34. Callers multiply
    the shares of both directions, as if they were independent: G = G1(wo) G1(wi).
    """
    alpha_u, alpha_v = map(constant, bsdf.alphas)
    slope = np.hypot(alpha_u * v[:, 0], alpha_v * v[:, 1]) / v[:, 2]  # roughness times the tangent of the angle
    if bsdf.distribution == "ggx":
        return 2.0 / (1.0 + np.sqrt(1.0 + slope**2))
    a = 1.0 / np.maximum(slope, 1e-30)
    with np.errstate(over="ignore", invalid="ignore"):
        rational = (3.535 * a + 2.181 * a**2) / (1.0 + 2.276 * a + 2.577 * a**2)
    return np.where(a < 1.6, rational, 1.0)


def _rough(bsdf: RoughConductor, wo: Array, wi: Array) -> tuple[Array, Array]:
    m = normalize(wo + wi)
    cosine = dot(wo, m)
    d = microfacets(bsdf, m)
    reflectance = np.array(bsdf.specular_reflectance) * fresnel_conductor(cosine, bsdf)
    value = reflectance * (d * smith(bsdf, wo) * smith(bsdf, wi) / (4.0 * wo[:, 2]))[:, None]
    return value, d * m[:, 2] / (4.0 * cosine)


def draw_microfacets(bsdf: RoughConductor, count: int, rng: np.random.Generator) -> Array:
    """Return `count` random microfacet normals (count, 3), with the density D times the normal's cosine.

    D is the microfacet distribution of the BSDF. Slopes are drawn for an isotropic surface, then scaled by the
    roughness along u and v.
    """
    u, phi = rng.random(count), rng.uniform(0.0, 2.0 * math.pi, count)
    r = np.sqrt(u / (1.0 - u)) if bsdf.distribution == "ggx" else np.sqrt(-np.log1p(-u))
    alpha_u, alpha_v = map(constant, bsdf.alphas)
    return normalize(np.stack([alpha_u * r * np.cos(phi), alpha_v * r * np.sin(phi), np.ones(count)], axis=1))


def fresnel_conductor(cosine: Array, metal: Conductor | RoughConductor) -> Array:
    """Return the reflectance (N, 3) of a metal for unpolarised light at cosines of incidence (N,).

    The formulas are Fresnel's equations with a complex index of refraction.
    """
    eta, k = map(constant, metal.ior)
    index = np.array(eta) + 1j * np.array(k)
    c = cosine[:, None]
    refracted = np.sqrt(index**2 - (1.0 - c**2))  # index times the complex cosine of refraction
    with np.errstate(invalid="ignore"):
        s = (c - refracted) / (c + refracted)
        p = (index**2 * c - refracted) / (index**2 * c + refracted)
        reflectance: Array = 0.5 * (np.abs(s) ** 2 + np.abs(p) ** 2)
    return np.where(np.isnan(reflectance), 1.0, reflectance)  # an index of 0 at normal incidence: 0/0


# ---- glass ----------------------------------------------------------------------------------------------------------


def fresnel_dielectric(cosine: Array, eta: Array) -> tuple[Array, Array]:
    """Return the Fresnel reflectance and the cosine of refraction (0 under total reflection), each (N,).

    `cosine` is the cosine of incidence (N,). `eta` is the index of refraction behind the surface, divided by the index
    on the side of incidence.
    """
    refracted = np.sqrt(np.maximum(0.0, 1.0 - (1.0 - cosine**2) / eta**2))
    s = (cosine - eta * refracted) / (cosine + eta * refracted)
    p = (eta * cosine - refracted) / (eta * cosine + refracted)
    return 0.5 * (s**2 + p**2), refracted


def _glass(bsdf: Dielectric, wo: Array, front: Mask, rng: np.random.Generator) -> Scattered:
    """Reflect with the probability of Fresnel's reflectance, else refract.

    Refraction changes the solid angle, and so scales radiance by 1/eta^2.
    """
    ior = bsdf.int_ior / bsdf.ext_ior
    eta = np.where(front, ior, 1.0 / ior)
    reflectance, refracted = fresnel_dielectric(wo[:, 2], eta)
    reflects = (rng.random(len(wo)) < reflectance)[:, None]
    through = np.stack([-wo[:, 0] / eta, -wo[:, 1] / eta, -refracted], axis=1)
    wi = np.where(reflects, wo * (-1.0, -1.0, 1.0), through)
    transmitted = np.array(bsdf.specular_transmittance) / eta[:, None] ** 2
    weight = np.where(reflects, np.array(bsdf.specular_reflectance), transmitted)
    return Scattered(wi, weight, np.full(len(wo), np.inf))
