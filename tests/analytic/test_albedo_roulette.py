"""Roulette by the albedo keeps what rough glass lets through where smooth glass of its index reflects everything.

From within, close to the glass and along it, most facets are met beyond the critical angle; those that lean are not.
Of glass that reflects nothing, all light is of these. The false-alarm rate is 0.1 %.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from scipy import stats

from equaltime import _core

from ..statistical.chi2 import LEVEL
from ..statistical.worlds import Estimate, build, estimate, looking

EYE: Final = (0.0, 0.0, 0.9)
SPP: Final = 1 << 18


def glass(b: _core.SceneBuilder) -> None:
    b.add_constant_environment([1.0, 1.0, 1.0])
    bsdf = b.add_bsdf("roughdielectric", "ggx", 0.4, 0.4, 1.5, [0.0] * 3, [1.0] * 3)
    b.add_sphere([0.0, 0.0, 0.0], 1.0, flip_normals=False, front=bsdf, back=bsdf, radiance=None)


def test_rough_glass_beyond_the_critical_angle_keeps_its_light() -> None:
    scene = build(glass, camera=looking(EYE, (1.0, 0.0, 0.9), up=(0.0, 1.0, 0.0)), fov=5.0)
    always = estimate(scene, SPP, 1, roulette="none")
    assert (always.mean > 20 * always.error).all()
    by_albedo = estimate(scene, SPP, 2, roulette="albedo", roulette_depth=1)
    assert p_of_equality(by_albedo, always) > LEVEL, (by_albedo, always)
    assert p_of_equality(by_albedo, always, brighter=1.05) < LEVEL, "the twin"


def p_of_equality(a: Estimate, b: Estimate, brighter: float = 1.0) -> float:
    """Return the p-value of one expectation, of all channels alike, by a z-test; `a` may be made brighter."""
    off = np.abs(brighter * a.mean - b.mean) / np.hypot(brighter * a.error, b.error)
    return 2.0 * float(stats.norm.sf(off.max()))
