"""Random numbers at the ends of the unit interval, and next to them: every BSDF, filter, lens and medium (S4, S25).

What comes out is finite, and no floating-point fault is raised on the way. For warps and for shapes that shine,
cpp/tests/sampling/test_warps.cpp says the same.
"""

from __future__ import annotations

from itertools import product
from typing import Any, Final

import numpy as np
import pytest
from numpy.typing import NDArray

from equaltime import _core
from equaltime._core import parts

from ..statistical.leaves import LEAVES, scene_of

Array = NDArray[np.float64]
MOST: Final = 1.0 - 2.0**-24
"""The largest number that a sampler gives; 1 - 2^-32 would be 1 in single precision."""
NEAR_HALF: Final = (0.5 - 2.0**-25, 0.5, 0.5 + 2.0**-24)
NEAR_NOTHING: Final = (0.0, 2.0**-32, float(np.nextafter(np.float32(2.0**-32), 1)), 2.0**-24, 2.0**-23)
ENDS: Final = np.array([*NEAR_NOTHING, *NEAR_HALF, 1.0 - 2.0**-23, MOST])
NUMBERS: Final = np.array(list(product(ENDS, repeat=3)))
COSINES: Final = (1.0, float(np.nextafter(np.float32(1), 0)), 0.7, 1e-2, 1e-4)
SIDES: Final = [(name, front) for name, leaf in LEAVES.items() for front in (True, False) if front or leaf.transmits]


def towards(cosine: float, azimuth: float) -> Array:
    sine = np.sqrt(1 - cosine**2)
    return np.array([np.cos(azimuth) * sine, np.sin(azimuth) * sine, cosine])


@pytest.mark.parametrize(("name", "front"), SIDES)
def test_bsdfs_give_finite_values_without_a_fault(name: str, front: bool) -> None:
    scene = scene_of(name)
    for cosine, azimuth in product(COSINES, (0.0, 0.5 * np.pi, 2.0)):
        wo = np.broadcast_to(towards(cosine, azimuth), NUMBERS.shape)
        parts.take_faults()
        drawn = parts.sample_bsdf(scene, 0, wo, NUMBERS, front)
        assert parts.take_faults() == "", (cosine, azimuth)
        assert np.isfinite(drawn["weight"]).all()
        assert np.isfinite(drawn["wi"]).all()
        smooth = drawn["valid"] & ~drawn["delta"]
        assert (drawn["pdf"][smooth] > 0).all()
        if smooth.any():
            parts.take_faults()
            value = parts.eval_bsdf(scene, 0, wo[smooth], drawn["wi"][smooth], front)
            assert parts.take_faults() == "", (cosine, azimuth)
            assert np.isfinite(value["f"]).all()
            assert np.isfinite(value["pdf"]).all()


def test_faults_are_seen() -> None:
    """The twin: densities whose squares overflow."""
    parts.take_faults()
    parts.mis_weight("power", 1e-10, 1e20)
    assert parts.take_faults() == "overflow"
    assert parts.take_faults() == ""


def small_scene(lens: dict[str, Any], filter_name: str, parameter: float) -> _core.Scene:
    builder = _core.SceneBuilder()
    builder.set_perspective(np.eye(4), 40.0, **lens)
    builder.set_film(4, 4, (0, 0, 4, 4), filter_name, parameter)
    return builder.build()


@pytest.mark.parametrize(("name", "parameter"), [("box", 0.5), ("tent", 1.0), ("gaussian", 0.5)])
def test_filters_and_lenses_give_finite_places_without_a_fault(name: str, parameter: float) -> None:
    scene = small_scene({"aperture_radius": 0.1, "focus_distance": 2.0}, name, parameter)
    u = np.array(list(product(ENDS, repeat=2)))
    parts.take_faults()
    placed = parts.sample_filter(scene, u)
    rays = parts.camera_rays(scene, np.full_like(u, 1.5), u)
    assert parts.take_faults() == ""
    for values in (placed["offset"], placed["weight"], rays["origin"], rays["direction"]):
        assert np.isfinite(values).all()
