"""Alpha against Mitsuba's, pixel by pixel: each is a mean of samples that are 0 or 1, so their noise is binomial.

All pixels together are rejected by chance in 1e-4 of runs; the seeds are fixed.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.stats import chi2

import equaltime as et

mi = pytest.importorskip("mitsuba")
pytestmark = pytest.mark.usefixtures("scalar_mitsuba")

SIZE, SPP = 16, 1024
LEVEL = 1e-4
GREY = {"type": "diffuse", "reflectance": 0.5}


def scene(opacity: float) -> dict[str, Any]:
    """A ball behind a mask that leans across half of the view, and a lamp that is hidden."""
    film = {"type": "hdrfilm", "width": SIZE, "height": SIZE, "pixel_format": "rgba", "rfilter": {"type": "box"}}
    mask = {"type": "mask", "opacity": opacity, "bsdf": {"type": "twosided", "bsdf": GREY}}
    leaning = [{"rotate": {"axis": [0, 1, 0], "angle": 30}}, {"translate": [0.8, 0.3, 1.5]}]
    return {
        "type": "scene",
        "integrator": {"type": "path", "hide_emitters": True, "max_depth": 4},
        "sensor": {
            "type": "perspective",
            "fov": 40.0,
            "to_world": [{"look_at": {"origin": [0, 0, 5], "target": [0, 0, 0], "up": [0, 1, 0]}}],
            "film": film,
        },
        "ball": {"type": "sphere", "bsdf": GREY},
        "sheet": {"type": "rectangle", "to_world": leaning, "bsdf": mask},
        "lamp": {
            "type": "sphere",
            "center": [-1.2, 1.0, 1.0],
            "radius": 0.3,
            "emitter": {"type": "area", "radiance": 3.0},
        },
        "sky": {"type": "constant", "radiance": 1.0},
    }


def test_mitsuba_sees_the_same_alpha() -> None:
    loaded = et.load_dict(scene(0.3))
    ours = et.render(loaded, spp=SPP, seed=2, strategy="best,sampler=independent").alpha
    assert ours is not None
    plain = et.scene.export.with_transforms(loaded.to_dict(), mi.ScalarTransform4f)
    theirs = np.array(mi.render(mi.load_dict(plain), spp=SPP, seed=3))[..., 3].astype(np.float64)
    assert p_of_all(ours.astype(np.float64), theirs) > LEVEL
    twin = et.render(et.load_dict(scene(0.36)), spp=SPP, seed=2, strategy="best,sampler=independent").alpha
    assert p_of_all(np.asarray(twin, np.float64), theirs) < LEVEL, "a mask that is a fifth more opaque"


def p_of_all(a: np.ndarray[Any, Any], b: np.ndarray[Any, Any]) -> float:
    """Return the probability of such differences where both are means of SPP samples; ours have less noise."""
    mean = 0.5 * (a + b)
    sure = (mean == 0.0) | (mean == 1.0)
    squares = (a - b)[~sure] ** 2 / (2 * (mean * (1 - mean))[~sure] / SPP)
    return float(chi2.sf(squares.sum(), squares.size))
