"""Values of BSDFs against Mitsuba 3's, from the same description, over random pairs of directions on both sides.

Nothing is statistical: both evaluate the same formulas in float32. What a model is allowed to differ by, and why,
stands beside it; a twin shows that a tenth of a percent is seen. Sampling is not compared: it is tested by itself
(tests/statistical).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import equaltime as et
from equaltime._core import parts

mi = pytest.importorskip("mitsuba")

try:
    mi.set_variant("llvm_ad_rgb")
except ImportError:
    mi.set_variant("scalar_rgb")

Array = NDArray[np.float64]
COUNT = 20_000 if mi.variant() == "llvm_ad_rgb" else 300
FLOAT = 2e-5
"""What float32 leaves of a value: directions have 24 bits, and the sharpest lobes here turn an error of direction into
one some hundred times as large."""
FRESNEL = 3e-4
"""What Mitsuba's Fresnel reflectance of a dielectric loses by cancellation close to total reflection, and at grazing
incidence."""
TABLES = 1e-3
"""What two quadratures of a rough interface's transmittance leave."""
REFRACTION = 1e-3
"""The same; and where facets are seen edge-on their cosines, and with them the smallest of values, are rounding."""
TINTED = 1e-3
"""The same for the sum of all lobes of the principled model."""
COAT = 4 * 2.0**-24 / 1e-6
"""Mitsuba forms the sharpest coat's distribution, of alpha = 0.001, as 1 / (1 - (1 - alpha^2) cos^2): at the peak four
roundings of 1 are left over alpha^2 (case S13; which of them happen depends on its variant)."""


@dataclass(frozen=True)
class Case:
    """A BSDF, and how far values may be apart: relative to the value, and relative to the largest of all."""

    type: str
    parameters: dict[str, Any] = field(default_factory=dict)
    relative: float = FLOAT
    absolute: float = 1e-7

    def __str__(self) -> str:
        return "-".join([self.type, *(f"{k}={v}" for k, v in self.parameters.items() if not isinstance(v, dict))])

    @property
    def description(self) -> dict[str, Any]:
        return {"type": self.type, **self.parameters}


def rgb(*value: float) -> dict[str, Any]:
    return {"type": "rgb", "value": list(value)}


ORANGE, PALE = rgb(0.9, 0.5, 0.1), rgb(0.8, 0.9, 1.0)
PRINCIPLED: dict[str, Any] = {"base_color": ORANGE, "roughness": 0.4}
PRINCIPLEDS: tuple[dict[str, Any], ...] = (
    *({}, {"roughness": 0.05}, {"roughness": 1.0}, {"specular": 0.0}, {"eta": 1.8}, {"eta": 0.8}),
    *({"metallic": 1.0}, {"metallic": 0.6, "anisotropic": 0.8}),
    *({"spec_trans": 1.0}, {"spec_trans": 0.5, "eta": 1.4, "metallic": 0.3}, {"spec_trans": 0.7, "eta": 0.75}),
    *({"spec_tint": 0.7}, {"spec_tint": 1.0, "metallic": 0.5, "base_color": rgb(0.0, 0.0, 0.0)}),
    *({"sheen": 1.0}, {"sheen": 0.7, "sheen_tint": 0.8}, {"flatness": 0.8}),
    *({"clearcoat": 1.0}, {"clearcoat": 1.0, "clearcoat_gloss": 0.5}),
    {
        **{"anisotropic": 0.5, "metallic": 0.2, "spec_trans": 0.3, "spec_tint": 0.4, "sheen": 0.5, "sheen_tint": 0.6},
        **{"flatness": 0.7, "clearcoat": 0.8, "clearcoat_gloss": 0.2, "specular": 0.9},
    },
)
CASES = [
    Case("diffuse", {"reflectance": ORANGE}),
    *(
        Case("roughconductor", {"distribution": d, "material": m, **alpha, "specular_reflectance": PALE})
        for d in ("ggx", "beckmann")
        for m in ("Au", "none")
        for alpha in ({"alpha": 0.3}, {"alpha_u": 0.6, "alpha_v": 0.1})
    ),
    *(
        Case("plastic", {"nonlinear": n, **ior, "diffuse_reflectance": ORANGE}, FRESNEL)
        for n in (False, True)
        for ior in ({}, {"int_ior": 1.9, "ext_ior": 1.1}, {"int_ior": 1.2, "ext_ior": 1.6})
    ),
    *(
        Case(
            "pplastic",
            {"distribution": d, **alpha, "diffuse_reflectance": ORANGE, "specular_reflectance": PALE},
            FRESNEL,
        )
        for d in ("ggx", "beckmann")
        for alpha in ({"alpha": 0.1}, {"alpha": 0.8, "int_ior": 1.9}, {"alpha_u": 0.5, "alpha_v": 0.2})
    ),
    *(Case("principled", PRINCIPLED | extra, TINTED, 1e-6) for extra in PRINCIPLEDS),
    Case("principled", PRINCIPLED | {"clearcoat": 0.6, "clearcoat_gloss": 1.0}, COAT, 1e-6),
    *(
        Case("roughdielectric", {"distribution": d, **ior, **alpha, "specular_transmittance": PALE}, REFRACTION, 1e-6)
        for d in ("ggx", "beckmann")
        for ior in ({"int_ior": 1.5, "ext_ior": 1.0}, {"int_ior": 1.2, "ext_ior": 1.6})
        for alpha in ({"alpha": 0.1}, {"alpha": 0.8}, {"alpha_u": 0.5, "alpha_v": 0.2})
    ),
    *(
        Case("roughplastic", {"distribution": d, "alpha": a, "nonlinear": n, "diffuse_reflectance": ORANGE}, TABLES)
        for d in ("ggx", "beckmann")
        for a, n in ((0.05, False), (0.3, True), (0.9, False))
    ),
]


def random_directions(seed: int) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Return viewers (all on the side of the normal), directions on either side, and whether that side is the front."""
    rng = np.random.default_rng(seed)
    v = rng.standard_normal((2, COUNT, 3))
    v[:, : COUNT // 4, 2] *= 0.1  # grazing
    near = slice(COUNT // 2, None)  # close to the mirror direction, where the sharp lobes are
    v[1, near] = v[0, near] * [-1, -1, 1] + 0.1 * v[1, near]
    v /= np.linalg.norm(v, axis=-1, keepdims=True)
    v[0, :, 2] = np.abs(v[0, :, 2])
    rounded = v.astype(np.float32).astype(np.float64)
    return rounded[0], rounded[1], rng.random(COUNT) < 0.5


def their_values(bsdf: Any, wo: Array, wi: Array, front: NDArray[np.bool_]) -> Array:
    side = np.where(front, 1.0, -1.0)[:, None] * [0.0, 0.0, 1.0] + [1.0, 1.0, 0.0]
    if mi.variant() == "scalar_rgb":
        return np.array([_one_value(bsdf, o, i) for o, i in zip(wo * side, wi * side, strict=True)])
    import drjit as dr

    si = dr.zeros(mi.SurfaceInteraction3f, len(wo))
    si.wi = mi.Vector3f((wo * side).T.astype(np.float32))
    value = bsdf.eval(mi.BSDFContext(), si, mi.Vector3f((wi * side).T.astype(np.float32)))
    return np.asarray(value, dtype=np.float64).T


def _one_value(bsdf: Any, wo: Array, wi: Array) -> Array:
    si = mi.SurfaceInteraction3f()
    si.wi = mi.Vector3f(wo)
    return np.asarray(bsdf.eval(mi.BSDFContext(), si, mi.Vector3f(wi)), dtype=np.float64)


def our_values(description: dict[str, Any], wo: Array, wi: Array, front: NDArray[np.bool_]) -> Array:
    scene = et.load_dict(
        {"type": "scene", "sensor": {"type": "perspective"}, "it": {"type": "rectangle", "bsdf": description}}
    )
    value = np.zeros_like(wo)
    for side in (True, False):
        if side or scene.model.shapes[0].bsdf.transmits:
            at = front == side
            value[at] = parts.eval_bsdf(scene.core, 0, wo[at], wi[at], side)["f"]
    return value


@pytest.mark.parametrize("case", CASES, ids=str)
def test_values_are_mitsubas(case: Case) -> None:
    wo, wi, front = random_directions(7)
    ours = our_values(case.description, wo, wi, front)
    theirs = their_values(mi.load_dict(case.description), wo, wi, front)
    assert (theirs > 0.0).any()
    tolerance = case.relative * theirs + case.absolute * theirs.max()
    off = np.abs(ours - theirs) > tolerance
    assert not off.any(), (off.mean(), wo[off.any(axis=1)][:3], wi[off.any(axis=1)][:3], ours[off][:3], theirs[off][:3])
    assert (np.abs((1.001 + 2.0 * case.relative) * ours - theirs) > tolerance)[theirs > 0.01 * theirs.max()].all(), (
        "the twin"
    )


def test_a_principled_metal_of_index_1_is_black_as_mitsubas() -> None:
    description = Case("principled", PRINCIPLED | {"metallic": 1.0, "specular": 0.0}).description
    wo, wi, front = random_directions(7)
    assert not our_values(description, wo, wi, front).any()
    assert not their_values(mi.load_dict(description), wo, wi, front).any()
