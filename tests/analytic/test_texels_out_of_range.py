"""Texels that no reflectance can be, which colours beyond the primaries and sharpened images have, are as the nearest
that can: the principled model has roots of its base colour and probabilities of its weights.
"""

from __future__ import annotations

from functools import partial
from typing import Final

import numpy as np
import pytest

from equaltime import _core

from ..statistical.worlds import build, render

WEIGHTS: Final = (
    *("roughness", "metallic", "spec_trans", "anisotropic", "spec_tint", "sheen", "sheen_tint", "flatness"),
    *("clearcoat", "clearcoat_gloss"),
)
BEYOND: Final[dict[str, tuple[list[float], list[float]]]] = {
    "base_color": ([0.7, -0.2, 0.1], [0.7, 0.0, 0.1]),
    **{name: ([-0.3] * 3, [0.0] * 3) for name in WEIGHTS},
    **{f"{name} above": ([1.4] * 3, [1.0] * 3) for name in WEIGHTS},
}


def sphere(b: _core.SceneBuilder, parameter: str, texel: list[float]) -> None:
    b.add_constant_environment([1.0, 0.8, 0.6])
    bsdf = b.add_bsdf("principled", [0.6, 0.5, 0.3], ior=1.5, **dict.fromkeys(WEIGHTS, 0.4))
    b.keep_uvs()
    b.bind(bsdf, parameter, b.add_bitmap(np.full((2, 2, 3), texel, np.float32), srgb=False))
    b.add_sphere([0.0, 0.0, 3.0], 1.0, flip_normals=False, front=bsdf, back=bsdf, radiance=None)


@pytest.mark.parametrize("case", BEYOND)
def test_texels_beyond_the_range_are_as_its_end(case: str) -> None:
    def pixels(texel: list[float]) -> bytes:
        return render(build(partial(sphere, parameter=case.split()[0], texel=texel), size=(8, 8)), 16).tobytes()

    beyond, end = BEYOND[case]
    assert pixels(beyond) == pixels(end)
    assert pixels(beyond) != pixels([0.5] * 3), "the twin"
