"""The principled model of the cross-check, in float64, by value against the core's, lobe by lobe and all together."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import equaltime as et
from equaltime._core import parts
from equaltime.crosscheck.principled import principled
from equaltime.scene.model import Principled

from .test_interfaces import directions

LOBES: dict[str, dict[str, Any]] = {
    "body": {"roughness": 0.6, "specular": 0.0},
    "flat": {"roughness": 0.8, "flatness": 0.7},
    "cloth": {"roughness": 0.5, "sheen": 0.8, "sheen_tint": 0.6},
    "metal": {"roughness": 0.4, "metallic": 0.8, "anisotropic": 0.5},
    "tinted": {"roughness": 0.4, "spec_tint": 0.7},
    "coat": {"roughness": 0.5, "clearcoat": 1.0, "clearcoat_gloss": 0.3},
    "glass": {"roughness": 0.5, "spec_trans": 0.9, "eta": 1.4},
    "all": {
        **{"roughness": 0.5, "anisotropic": 0.3, "metallic": 0.3, "spec_trans": 0.4, "eta": 1.6, "spec_tint": 0.2},
        **{"sheen": 0.3, "sheen_tint": 0.5, "flatness": 0.3, "clearcoat": 0.6, "clearcoat_gloss": 0.1},
    },
}


@pytest.mark.parametrize("name", LOBES)
@pytest.mark.parametrize("front", [True, False])
def test_values_are_those_of_the_core(name: str, front: bool) -> None:
    """Half-vectors of refraction are differences, which magnify float32's rounding; the rest is good to 2e-4."""
    bsdf = Principled(base_color=(0.8, 0.4, 0.1), **LOBES[name])
    if not front and not bsdf.transmits:
        pytest.skip("without glass there is no inside")
    wo, wi = directions(7, below=True)
    wall = {"type": "rectangle", "bsdf": {"type": "principled", "base_color": [0.8, 0.4, 0.1], **LOBES[name]}}
    scene = et.load_dict({"type": "scene", "sensor": {"type": "perspective"}, "wall": wall})
    core = parts.eval_bsdf(scene.core, 0, wo, wi, front)["f"]
    ours = principled(bsdf, wo, wi, front)
    rtol = 2e-3 if bsdf.transmits else 2e-4
    np.testing.assert_allclose(ours, core, rtol=rtol, atol=1e-6 * float(core.max()))
    assert np.abs(ours * 1.02 - core).max() > rtol * core.max(), "the twin"


@pytest.mark.parametrize("name", sorted(set(LOBES) - {"glass", "all"}))
def test_reflection_is_reciprocal(name: str) -> None:
    bsdf = Principled(base_color=(0.8, 0.4, 0.1), **LOBES[name])
    wo, wi = (v / np.linalg.norm(v, axis=1, keepdims=True) for v in directions(8))
    there, back = principled(bsdf, wo, wi), principled(bsdf, wi, wo)
    np.testing.assert_allclose(there / wi[:, 2:], back / wo[:, 2:], rtol=1e-9)
