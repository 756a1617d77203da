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

NUMBERS: Final = {
    **dict.fromkeys(("anisotropic", "spec_tint", "sheen", "sheen_tint", "flatness", "clearcoat"), 0.0),
    **{"base_color": [0.5, 0.5, 0.5], "roughness": 0.5, "metallic": 0.2, "spec_trans": 0.4, "ior": 1.5},
    "clearcoat_gloss": 0.5,
}
BEYOND: Final[dict[str, tuple[list[float], list[float]]]] = {
    "base_color": ([0.7, -0.2, 0.1], [0.7, 0.0, 0.1]),
    **{name: ([-0.3] * 3, [0.0] * 3) for name in NUMBERS if name not in {"base_color", "ior"}},
    **{f"{name} above": ([1.4] * 3, [1.0] * 3) for name in NUMBERS if name not in {"base_color", "ior"}},
}


def sphere(b: _core.SceneBuilder, parameter: str, texel: list[float]) -> None:
    b.add_constant_environment([1.0, 0.8, 0.6])
    bsdf = b.add_principled(**NUMBERS)
    b.keep_uvs()
    b.bind(bsdf, parameter, b.add_bitmap(np.full((2, 2, 3), texel, np.float32), srgb=False))
    b.add_sphere([0.0, 0.0, 3.0], 1.0, flip_normals=False, front=bsdf, back=bsdf, radiance=None)


@pytest.mark.parametrize("case", BEYOND)
def test_texels_beyond_the_range_are_as_its_end(case: str) -> None:
    beyond, end = (
        render(build(partial(sphere, parameter=case.split()[0], texel=t), size=(8, 8)), 16) for t in BEYOND[case]
    )
    assert beyond.tobytes() == end.tobytes()
