"""All BSDFs of the cross-check: evaluation and sampling, in local coordinates.

As in `bsdfs`, the normal is +z on the side of the viewer; wo points to the viewer (z > 0), wi to the light. BSDFs
missing in `bsdfs` are sampled by a mixture of lobes: diffuse lobes by the cosine, microfacets by their distribution D.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from equaltime.crosscheck import bsdfs
from equaltime.crosscheck.bsdfs import (
    Scattered,
    constant,
    draw_cosine,
    draw_microfacets,
    fresnel_dielectric,
    microfacets,
)
from equaltime.crosscheck.interfaces import mirror_share, plastic, rough_dielectric, rough_plastic, thin_reflectance
from equaltime.crosscheck.principled import coat_alpha2, coat_facets, main_facets, principled
from equaltime.crosscheck.vectors import Array, Mask, dot, normalize
from equaltime.scene.model import (
    Bsdf,
    Plastic,
    Principled,
    RoughConductor,
    RoughDielectric,
    RoughPlastic,
    ThinDielectric,
)

__all__ = ["evaluate", "is_single", "sample"]

Mixed = Plastic | Principled | RoughDielectric
Generator = np.random.Generator


def is_single(bsdf: Bsdf) -> bool:
    """Tell whether the BSDF is a mirror or clear glass: it scatters into discrete directions only.

    If so, light sampling contributes nothing and can be left out.
    """
    return bsdf.title in ("conductor", "dielectric", "thindielectric")


def evaluate(bsdf: Bsdf, wo: Array, wi: Array, front: Mask) -> tuple[Array, Array]:
    """Return the BSDF times the cosine of wi (N, 3), and the density per solid angle (N,) with which `sample` draws wi.

    `wo` (to the viewer) and `wi` (to the light) are unit local directions (N, 3). `front` (N,) is True where the viewer
    is on the front side.
    """
    if not isinstance(bsdf, Mixed):
        return bsdfs.evaluate(bsdf, wo, wi)
    value, pdf = np.zeros_like(wi), np.zeros(len(wi))
    for side in (True, False):
        rows = np.flatnonzero((front == side) & ((wi[:, 2] > 0.0) | (bsdf.transmits & (wi[:, 2] < 0.0))))
        if rows.size:
            value[rows] = _value(bsdf, wo[rows], wi[rows], side)
            pdf[rows] = sum(lobe.share * lobe.density(wo[rows], wi[rows]) for lobe in _lobes(bsdf, wo[rows], side))
    return value, pdf


def sample(bsdf: Bsdf, wo: Array, front: Mask, rng: Generator) -> Scattered:
    """Draw a direction wi to the light for each local direction wo (N, 3) to the viewer.

    Returns the directions with weights and densities. `front` (N,) is True where the viewer is on the front side.
    """
    if isinstance(bsdf, ThinDielectric):
        return _pane(bsdf, wo, rng)
    if not isinstance(bsdf, Mixed):
        return bsdfs.sample(bsdf, wo, front, rng)
    wi, single = wo * (-1.0, -1.0, 1.0), np.zeros(len(wo), np.bool_)
    valid = np.ones(len(wo), np.bool_)
    for side in (True, False):
        rows = np.flatnonzero(front == side)
        lobes = _lobes(bsdf, wo[rows], side)
        choice = (rng.random(rows.size) >= np.cumsum([lobe.share for lobe in lobes], axis=0)).sum(axis=0)
        for number, lobe in enumerate(lobes):
            chosen = rows[choice == number]
            wi[chosen], valid[chosen] = lobe.draw(wo[chosen], rng)
        single[rows[choice == len(lobes)]] = True  # the rest of the shares belongs to the mirror
    wi[~valid] = (0.0, 0.0, 1.0)
    value, pdf = evaluate(bsdf, wo, wi, front)
    weight = np.divide(value, pdf[:, None], out=np.zeros_like(value), where=(valid & (pdf > 0.0))[:, None])
    if isinstance(bsdf, Plastic) and single.any():
        seen, _ = fresnel_dielectric(wo[single, 2], np.full(single.sum(), bsdf.int_ior / bsdf.ext_ior))
        color, share = np.array(constant(bsdf.specular_reflectance)), mirror_share(bsdf, wo[single])
        weight[single], pdf[single] = color * (seen / share)[:, None], np.inf
    return Scattered(wi, weight, pdf)


def _value(bsdf: Mixed, wo: Array, wi: Array, front: bool) -> Array:
    if isinstance(bsdf, Principled):
        return principled(bsdf, wo, wi, front)
    if isinstance(bsdf, RoughDielectric):
        return rough_dielectric(bsdf, wo, wi, front)[0]
    return (rough_plastic(bsdf, wo, wi) if isinstance(bsdf, RoughPlastic) else plastic(bsdf, wo, wi))[0]


def _pane(bsdf: ThinDielectric, wo: Array, rng: Generator) -> Scattered:
    mirrors = (rng.random(len(wo)) < thin_reflectance(bsdf, wo))[:, None]
    wi = np.where(mirrors, wo * (-1.0, -1.0, 1.0), -wo)
    weight = np.where(mirrors, constant(bsdf.specular_reflectance), constant(bsdf.specular_transmittance))
    return Scattered(wi, weight, np.full(len(wo), np.inf))


# ---- lobes ----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, eq=False)
class _Lobe:
    share: Array
    """Share of the samples that are drawn from the lobe (N,)."""
    draw: Callable[[Array, Generator], tuple[Array, Mask]]
    """Function of wo that returns directions wi (N, 3), and flags of the valid ones (N,)."""
    density: Callable[[Array, Array], Array]
    """Density of wi per solid angle (N,), as a function of wo and wi."""


@dataclass(frozen=True, slots=True, eq=False)
class _Facets:
    draw: Callable[[int, Generator], Array]
    density: Callable[[Array], Array]
    """Density per solid angle of the normal."""


def _lobes(bsdf: Mixed, wo: Array, front: bool) -> list[_Lobe]:
    if isinstance(bsdf, Principled):
        return _of_principled(bsdf, wo, front)
    if isinstance(bsdf, RoughDielectric):
        eta = bsdf.int_ior / bsdf.ext_ior if front else bsdf.ext_ior / bsdf.int_ior
        alpha_u, alpha_v = map(constant, bsdf.alphas)
        facets = _by_d(RoughConductor(distribution=bsdf.distribution, alpha_u=alpha_u, alpha_v=alpha_v))
        mirror = np.clip(fresnel_dielectric(wo[:, 2], np.full(len(wo), eta))[0], 0.1, 0.9)
        return [_mirrored(mirror, facets), _refracted(1.0 - mirror, facets, eta)]
    if isinstance(bsdf, RoughPlastic):
        half = np.full(len(wo), 0.5)
        facets = _by_d(RoughConductor(distribution=bsdf.distribution, alpha=constant(bsdf.alpha)))
        return [_mirrored(half, facets), _cosine(1.0 - half)]
    return [_cosine(1.0 - mirror_share(bsdf, wo))]


def _of_principled(bsdf: Principled, wo: Array, front: bool) -> list[_Lobe]:
    metal, glass, coat = (float(constant(x)) for x in (bsdf.metallic, bsdf.spec_trans, bsdf.clearcoat))
    front = front or not bsdf.transmits
    main, eta = _by_d(main_facets(bsdf)), bsdf.ior if front else 1.0 / bsdf.ior
    body = (1.0 - metal) * (1.0 - glass) + 0.1 if front else 0.0
    parts = np.array([0.5, body, 0.25 * coat if front else 0.0, (1.0 - metal) * glass])
    mirror, diffuse, coated, through = np.repeat((parts / parts.sum())[:, None], len(wo), axis=1)
    lobes = [_mirrored(mirror, main), _cosine(diffuse), _mirrored(coated, _coat(bsdf)), _refracted(through, main, eta)]
    return [lobe for lobe, part in zip(lobes, parts, strict=True) if part > 0.0]


def _cosine(share: Array) -> _Lobe:
    def draw(wo: Array, rng: Generator) -> tuple[Array, Mask]:
        return draw_cosine(len(wo), rng), np.ones(len(wo), np.bool_)

    return _Lobe(share, draw, lambda _, wi: np.maximum(wi[:, 2], 0.0) / math.pi)


def _mirrored(share: Array, facets: _Facets) -> _Lobe:
    def draw(wo: Array, rng: Generator) -> tuple[Array, Mask]:
        m = facets.draw(len(wo), rng)
        wi = 2.0 * dot(wo, m)[:, None] * m - wo
        return wi, wi[:, 2] > 0.0

    def density(wo: Array, wi: Array) -> Array:
        up = np.flatnonzero(wi[:, 2] > 0.0)
        m = normalize(wo[up] + wi[up])
        found = np.zeros(len(wi))
        found[up] = facets.density(m) / (4.0 * dot(wo[up], m))
        return found

    return _Lobe(share, draw, density)


def _refracted(share: Array, facets: _Facets, eta: float) -> _Lobe:
    def draw(wo: Array, rng: Generator) -> tuple[Array, Mask]:
        m = facets.draw(len(wo), rng)
        o = dot(wo, m)
        _, refracted = fresnel_dielectric(np.clip(o, 1e-12, 1.0), np.full(len(wo), eta))
        wi = m * (o / eta - refracted)[:, None] - wo / eta
        return wi, (o > 0.0) & (refracted > 0.0) & (wi[:, 2] < 0.0)

    def density(wo: Array, wi: Array) -> Array:
        down = np.flatnonzero(wi[:, 2] < 0.0)
        m = normalize(wo[down] + eta * wi[down])
        m *= np.where(m[:, 2:] < 0.0, -1.0, 1.0)
        o, i = dot(wo[down], m), dot(wi[down], m)
        found = np.zeros(len(wi))
        found[down] = np.where((o > 0.0) & (i < 0.0), facets.density(m) * eta**2 * np.abs(i) / (o + eta * i) ** 2, 0.0)
        return found

    return _Lobe(share, draw, density)


def _by_d(bsdf: RoughConductor) -> _Facets:
    return _Facets(
        lambda count, rng: draw_microfacets(bsdf, count, rng), lambda m: np.asarray(microfacets(bsdf, m) * m[:, 2])
    )


def _coat(bsdf: Principled) -> _Facets:
    """Return the coat's facets; the distribution of GTR1's cosines has a closed inverse (Burley 2012, appendix B.2)."""

    def draw(count: int, rng: Generator) -> Array:
        alpha2, phi = coat_alpha2(bsdf), rng.uniform(0.0, 2.0 * math.pi, count)
        square = (1.0 - alpha2 ** (1.0 - rng.random(count))) / (1.0 - alpha2)
        r = np.sqrt(1.0 - square)
        return np.stack([r * np.cos(phi), r * np.sin(phi), np.sqrt(square)], axis=1)

    return _Facets(draw, lambda m: np.asarray(coat_facets(bsdf, m) * m[:, 2]))
