"""BSDFs of several lobes by name, and trials of them: what a sampler drew from one direction and what `eval` says."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from equaltime import _core
from equaltime._core import parts

from .chi2 import uniforms

__all__ = ["LEAVES", "Leaf", "Trial"]

Array = NDArray[np.float64]
WHITE = [1.0, 1.0, 1.0]


@dataclass(frozen=True)
class Leaf:
    """A call of the builder."""

    call: str
    arguments: tuple[Any, ...] = ()
    named: Any = None
    """Arguments by name, or None."""
    transmits: bool = False
    distribution: str = ""
    alphas: tuple[float, float] = (0.0, 0.0)
    """Of the microfacets, if there are some."""
    ior: float = 1.5
    lossless: bool = False
    """Reflects and transmits all light, but for the slack."""
    most: float = 1.0
    """The largest albedo that the model itself has, by its definition."""
    slack: float = 1e-5
    """By how much what a lossless model scatters may be off 1, for what its approximations leave."""


def rough_plastic(distribution: str, alpha: float, ior: float, diffuse: Any, specular: Any, nonlinear: bool) -> Leaf:
    arguments = (distribution, alpha, ior, diffuse, specular, nonlinear)
    return Leaf("roughplastic", arguments, None, False, distribution, (alpha, alpha), ior)


ROUGH_PLASTICS: dict[str, Any] = {
    "glossy plastic": ("ggx", 0.1, 1.49, [0.8, 0.5, 0.1], WHITE, False),
    "sharp plastic": ("ggx", 1e-3, 1.49, [0.5, 0.5, 0.1], WHITE, True),
    "dull plastic": ("beckmann", 0.5, 1.9, [0.9, 0.5, 0.1], [0.5, 0.8, 1.0], True),
    "glazed plastic": ("beckmann", 0.01, 1.3, [0.5, 0.5, 0.1], WHITE, False),
    "dry plastic": ("ggx", 1.0, 0.75, WHITE, WHITE, False),
    "mirror-like plastic": ("ggx", 1e-6, 1.5, WHITE, WHITE, False),
}


def rough_dielectric(distribution: str, alpha_u: float, alpha_v: float, ior: float) -> Leaf:
    arguments = (distribution, alpha_u, alpha_v, ior, WHITE, WHITE)
    alphas = (alpha_u, alpha_v)
    return Leaf("roughdielectric", arguments, None, True, distribution, alphas, ior, lossless=max(alphas) < 1e-5)


ROUGH_DIELECTRICS: dict[str, Any] = {
    "frosted glass": ("ggx", 0.3, 0.3, 1.5),
    "sharp glass": ("ggx", 1e-3, 1e-3, 1.5),
    "ground glass": ("beckmann", 0.2, 0.2, 1.8),
    "brushed glass": ("ggx", 0.5, 0.1, 0.7),
    "sandy glass": ("beckmann", 1.0, 1.0, 1.33),
    "faint glass": ("ggx", 0.1, 0.1, 1.001),
    "mirror-like glass": ("ggx", 1e-6, 1e-6, 1.5),
}


def principled(**numbers: float) -> Leaf:
    """An orange material; its lobes' sharpness is that of the facets.

    Burley's sum of lobes is not made to keep energy: at grazing incidence it gives back half more than came.
    """
    none = dict.fromkeys(
        ("anisotropic", "metallic", "spec_trans", "spec_tint", "sheen", "sheen_tint", "flatness", "clearcoat"), 0.0
    )
    named = none | {"clearcoat_gloss": 0.0, "roughness": 0.5, "ior": 1.5, "base_color": [0.9, 0.5, 0.1]} | numbers
    alpha = max(1e-3, named["roughness"] ** 2)
    glass = named["spec_trans"] > 0
    return Leaf("principled", (), named, glass, "ggx", (alpha, alpha), named["ior"], most=1.55)


PRINCIPLEDS: dict[str, dict[str, float]] = {
    "clay": {"roughness": 1.0, "sheen": 0.8, "sheen_tint": 0.5, "flatness": 0.6},
    "gold leaf": {"metallic": 1.0, "roughness": 0.5, "anisotropic": 0.7},
    "lacquer": {"clearcoat": 1.0, "clearcoat_gloss": 0.3, "roughness": 0.7, "spec_tint": 0.5},
    "amber": {"spec_trans": 0.7, "roughness": 0.6, "ior": 1.4},
    "polished": {"roughness": 0.02},
    "everything": {
        **{"anisotropic": 0.5, "metallic": 0.3, "spec_trans": 0.4, "spec_tint": 0.6, "sheen": 0.5, "sheen_tint": 0.3},
        **{"flatness": 0.4, "clearcoat": 0.7, "clearcoat_gloss": 0.1, "roughness": 0.6, "ior": 0.8},
    },
}
LEAVES: dict[str, Leaf] = {
    "pane": Leaf("thindielectric", (1.5, WHITE, WHITE), transmits=True, lossless=True),
    "thin film": Leaf("thindielectric", (0.7, WHITE, WHITE), transmits=True, lossless=True),
    "plastic": Leaf("plastic", (1.49, [0.8, 0.5, 0.1], WHITE, False)),
    "deep plastic": Leaf("plastic", (1.9, [0.9, 0.5, 0.1], [0.5, 0.8, 1.0], True)),
    "bubble plastic": Leaf("plastic", (0.75, [0.8, 0.5, 0.1], WHITE, False)),
    "lacquered wood": Leaf("pplastic", ("ggx", 0.2, 0.2, 1.5, [0.8, 0.5, 0.1], WHITE), None, False, "ggx", (0.2, 0.2)),
    "plaster": Leaf("roughdiffuse", ([0.9, 0.5, 0.1], 0.5, False), most=1.051),
    "white plaster": Leaf("roughdiffuse", (WHITE, 0.43, False), most=1.051),
    "gravel": Leaf("roughdiffuse", ([0.8, 0.5, 0.01], 3.0, False)),
    "plaster in short": Leaf("roughdiffuse", (WHITE, 0.3, True), most=1.016),
    "white plastic": Leaf("plastic", (1.5, WHITE, WHITE, False), lossless=True, slack=2e-3),
    **{name: rough_plastic(*arguments) for name, arguments in ROUGH_PLASTICS.items()},
    **{name: rough_dielectric(*arguments) for name, arguments in ROUGH_DIELECTRICS.items()},
    **{name: principled(**numbers) for name, numbers in PRINCIPLEDS.items()},
    "white deep plastic": Leaf("plastic", (1.5, WHITE, WHITE, True), lossless=True, slack=2e-3),
}


@cache
def scene_of(name: str) -> _core.Scene:
    builder = _core.SceneBuilder()
    leaf = LEAVES[name]
    builder.add_bsdf(leaf.call, *leaf.arguments, **(leaf.named or {}))
    builder.set_perspective(np.eye(4), 40.0)
    builder.set_film(1, 1, (0, 0, 1, 1), "box", 0.5)
    return builder.build()


class Trial:
    """Samples of a leaf seen from `wo`, on its front or its back."""

    def __init__(self, name: str, wo: Array, front: bool = True, samples: int = 1 << 18, seed: int = 1) -> None:
        self.name, self.wo, self.front = name, wo, front
        u = uniforms(samples, 3, seed)
        self.drawn = parts.sample_bsdf(scene_of(name), 0, np.broadcast_to(wo, (samples, 3)), u, front)
        self.continuous = self.drawn["valid"] & ~self.drawn["delta"]
        """The samples of the lobes that have a density."""
        self.wi = self.drawn["wi"][self.continuous]

    def eval(self, wi: Array) -> dict[str, Array]:
        wo = np.broadcast_to(self.wo, wi.shape)
        value: dict[str, Array] = parts.eval_bsdf(scene_of(self.name), 0, wo, wi, self.front)
        return value
