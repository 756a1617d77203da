"""Values of phase functions against Mitsuba 3's, from the same description, over random pairs of directions.

Nothing is statistical: both evaluate the same formulas in float32. A twin shows that a tenth of a percent is seen.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import equaltime as et
from equaltime._core import parts

mi = pytest.importorskip("mitsuba")
mi.set_variant("scalar_rgb")

Array = NDArray[np.float64]
COUNT = 300
FLOAT = 2e-5
"""What float32 leaves of a value: the sharpest lobe turns an error of direction into one ten times as large."""
AIR: dict[str, Any] = {"type": "rayleigh"}
DUST: dict[str, Any] = {"type": "hg", "g": 0.7}


def blend(weight: Any, first: dict[str, Any], second: dict[str, Any]) -> dict[str, Any]:
    return {"type": "blendphase", "weight": weight, "one": first, "another": second}


CASES = {
    "isotropic": {"type": "isotropic"},
    "hg": DUST,
    "hg as it is": {"type": "hg"},
    "rayleigh": AIR,
    "tabphase": {"type": "tabphase", "values": "0.5, 0.25, 1, 3"},
    "blendphase": blend(0.3, AIR, DUST),
    "blendphase the other way round": blend(0.3, DUST, AIR),
    "nested": blend(0.6, blend(0.25, AIR, {"type": "hg", "g": -0.5}), blend(0.1, DUST, {"type": "isotropic"})),
    "of nothing": blend(0.0, AIR, DUST),
    "of all": blend(1.0, AIR, DUST),
}


def our_values(phase: dict[str, Any], wo: Array, wi: Array) -> Array:
    medium = {"type": "homogeneous", "phase": phase}
    sensor = {"type": "perspective", "medium": medium}
    scene = et.load_dict({"type": "scene", "integrator": {"type": "volpath"}, "sensor": sensor})
    cosine = (wo * wi).sum(axis=1)
    turned = np.stack([np.sqrt(np.maximum(1 - cosine**2, 0)), 0 * cosine, cosine], axis=1)
    return np.asarray(parts.eval_bsdf(scene.core, 0, np.broadcast_to([0.0, 0.0, 1.0], wo.shape), turned)["pdf"])


def their_values(phase: dict[str, Any], wo: Array, wi: Array) -> Array:
    plugin, context = mi.load_dict(phase), mi.PhaseFunctionContext(None)
    found = []
    for towards, source in zip(wo, wi, strict=True):
        it = mi.MediumInteraction3f()
        it.wi = mi.Vector3f(towards)
        it.sh_frame = mi.Frame3f(it.wi)
        value, pdf = plugin.eval_pdf(context, it, mi.Vector3f(source))
        np.testing.assert_allclose(np.asarray(value), pdf, rtol=1e-6)
        found.append(pdf)
    return np.array(found)


@pytest.mark.parametrize("name", CASES)
def test_values_are_mitsubas(name: str) -> None:
    v = np.random.default_rng(5).standard_normal((2, COUNT, 3))
    v[1, COUNT // 2 :] = 0.1 * v[1, COUNT // 2 :] - v[0, COUNT // 2 :]  # near straight on
    wo, wi = v / np.linalg.norm(v, axis=-1, keepdims=True)
    ours, theirs = our_values(CASES[name], wo, wi), their_values(CASES[name], wo, wi)
    np.testing.assert_allclose(ours, theirs, rtol=FLOAT)
    assert (np.abs(1.001 * ours - theirs) > FLOAT * theirs).all(), "the twin"
