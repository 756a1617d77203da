"""Charts of single lobes of BSDFs, for `chi2`: sharp ones by themselves, and what is left without them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .charts import TAU, turn, unit
from .chi2 import Chart

__all__ = ["Part", "RefractionChart", "stretched_slope"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Part:
    """The part of a chart's directions for which a function says so."""

    chart: Chart
    inside: Callable[[Array], NDArray[np.bool_]]

    def directions(self, square: Array) -> tuple[Array, Array]:
        directions, jacobian = self.chart.directions(square)
        return directions, np.where(self.inside(directions), jacobian, 0.0)

    def places(self, directions: Array) -> Array:
        return self.chart.places(directions)


def microfacet_normal(wo: Array, wi: Array, eta: float = 1.0) -> Array:
    """Return the normals, upwards, of the facets that mirror or refract wo to wi; eta is the index ahead of wi."""
    m = unit(wo + wi * np.where(wi[:, 2] > 0, 1.0, eta)[:, None])
    return np.asarray(m * np.where(m[:, 2] > 0, 1.0, -1.0)[:, None])


def stretched_slope(wo: Array, wi: Array, alpha_u: float, alpha_v: float, eta: float = 1.0) -> Array:
    """Return how steep the facet between two directions is, in units of roughness."""
    m = microfacet_normal(wo, wi, eta)
    return np.asarray(np.hypot(m[:, 0] / alpha_u, m[:, 1] / alpha_v) / m[:, 2])


@dataclass(frozen=True, eq=False)
class RefractionChart:
    """Directions refracted by microfacets: how steep the facet is, in units of roughness, and which way it leans.

    As `HalfVectorChart`, for the other side: eta is the index there over that on the side of wo.
    """

    wo: Array
    distribution: str
    alpha_u: float
    alpha_v: float
    eta: float

    def directions(self, square: Array) -> tuple[Array, Array]:
        left = (1.0 - square[:, 0]) ** 2
        ggx = self.distribution == "ggx"
        r2 = (1.0 - left) / left if ggx else -np.log(left)
        derivative = 2.0 * (1.0 - square[:, 0]) / (left**2 if ggx else left)  # of r2 along the first coordinate
        r, phi = np.sqrt(r2), TAU * square[:, 1]
        m = unit(np.stack([self.alpha_u * r * np.cos(phi), self.alpha_v * r * np.sin(phi), np.ones_like(r)], axis=-1))
        facing = m @ self.wo
        across2 = 1.0 - (1.0 - facing**2) / self.eta**2
        across = np.sqrt(np.maximum(across2, 0.0))
        wi = (facing / self.eta - across)[:, None] * m - self.wo / self.eta
        stretch = (facing - self.eta * across) ** 2 / (self.eta**2 * np.maximum(across, 1e-30))
        jacobian = stretch * m[:, 2] ** 3 * self.alpha_u * self.alpha_v * 0.5 * derivative * TAU
        return wi, np.where((facing > 0) & (across2 > 0) & (wi[:, 2] < 0), jacobian, 0.0)

    def places(self, directions: Array) -> Array:
        m = microfacet_normal(self.wo, directions, self.eta)
        x, y = m[:, 0] / m[:, 2] / self.alpha_u, m[:, 1] / m[:, 2] / self.alpha_v
        r2 = x * x + y * y
        left = 1.0 / (1.0 + r2) if self.distribution == "ggx" else np.exp(-r2)
        return np.stack([1.0 - np.sqrt(left), turn(y, x)], axis=-1)
