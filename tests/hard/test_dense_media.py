"""Media whose mean free path is a small share of the scene: distances in them are those from where the path is, and not
from where Embree's ray may begin.

A statement that holds is rejected with a probability of 1e-4 a test, with fixed seeds.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import equaltime as et
from equaltime.scene.lint import lint

from ..statistical.worlds import Estimate, estimate

Array = NDArray[np.float64]
LEVEL = 1e-4
ALBEDO = 0.9
COSINE = math.cos(math.radians(30.0))
TURN = [{"rotate": {"axis": [1, 2, 3], "angle": 40}}]
EXTENT = 3.1
"""Of the turned cube, roughly, along the axis where it is longest."""
LOST = 0.03
"""A share of the light that the tests must see missing: rays that began an offset deeper lost it at a mean free path of
1e-5 of the scene, and all of it below 1e-9."""


def chandrasekhar(albedo: float, cosine: float, nodes: int = 200) -> float:
    """Return what a half-space of isotropic scatterers reflects of light from everywhere: 1 - sqrt(1 - w) H(mu).

    Chandrasekhar, Radiative Transfer, 1960: section 38.
    """
    x, weights = np.polynomial.legendre.leggauss(nodes)
    x, weights = (x + 1.0) / 2.0, weights / 2.0
    root = math.sqrt(1.0 - albedo)

    def of(mu: Array, h: Array) -> Array:
        at: Array = 1.0 / (root + 0.5 * albedo * (weights * x * h / (x + mu[:, None])).sum(axis=1))
        return at

    h = np.ones(nodes)
    for _ in range(500):
        h = of(x, h)
    return 1.0 - root * float(of(np.array([cosine]), h)[0])


def medium(free_path: float, albedo: float = ALBEDO) -> dict[str, Any]:
    """Return a medium by its mean free path as a share of the extent."""
    return {"type": "homogeneous", "albedo": albedo, "sigma_t": 1.0 / (free_path * EXTENT)}


def filled(shape: str, inside: dict[str, Any]) -> dict[str, Any]:
    solid = {"bsdf": {"type": "null"}, "interior": inside}
    if shape == "instance":
        group = {"type": "shapegroup", "id": "group", "cube": {"type": "cube", **solid}}
        return {"group": group, "it": {"type": "instance", "to_world": TURN, "part": {"type": "ref", "id": "group"}}}
    return {"it": {"type": shape, "to_world": TURN, **solid}}


def seen_askew(**parts: Any) -> et.Scene:
    """Return a scene whose camera looks at a small part of a side of the turned cube, 30 degrees off its normal; the
    same of the unit ball."""
    eye = {"look_at": {"origin": [2, 0.3, 0.2], "target": [0, 0.3, 0.2], "up": [0, 1, 0]}}
    if parts.get("it", {}).get("type") == "sphere":
        eye = {"look_at": {"origin": [2, 0.5, 0], "target": [0, 0.5, 0], "up": [0, 0, 1]}}
        place = [{"scale": [1e-3, 1e-3, 1]}, eye, *TURN]
    else:
        place = [{"scale": [0.02, 0.02, 1]}, eye, {"rotate": {"axis": [0, 1, 0], "angle": 30}}, *TURN]
    film = {"type": "hdrfilm", "width": 8, "height": 8, "rfilter": {"type": "box"}}
    return et.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "volpath", "max_depth": -1},
            "sensor": {"type": "orthographic", "to_world": place, "film": film},
            "sky": {"type": "constant", "radiance": 1.0},
            **parts,
        }
    )


def reflected(shape: str, free_path: float, albedo: float = ALBEDO, **settings: Any) -> Estimate:
    return estimate(seen_askew(**filled(shape, medium(free_path, albedo))).core, 1024, max_depth=-1, **settings)


@pytest.mark.parametrize("albedo", [0.5, ALBEDO, 0.99])
@pytest.mark.parametrize(
    ("shape", "free_path"),
    [("cube", 1e-3), ("cube", 1e-5), ("cube", 1.2e-7), ("instance", 1e-5), ("instance", 1.2e-7), ("sphere", 1.2e-7)],
)
def test_a_dense_medium_reflects_as_a_half_space(shape: str, free_path: float, albedo: float) -> None:
    found = reflected(shape, free_path, albedo)
    exact = chandrasekhar(albedo, COSINE)
    assert found.p(np.full(3, exact)) > LEVEL, found
    assert found.p(np.full(3, exact * (1.0 - LOST))) < LEVEL, "the twin: the light that was lost is seen"


@pytest.mark.parametrize("technique", ["bsdf", "light", "mixture"])
def test_all_techniques_see_the_same_dense_medium(technique: str) -> None:
    found = reflected("cube", 1.2e-7, technique=technique)
    exact = chandrasekhar(ALBEDO, COSINE)
    assert found.p(np.full(3, exact)) > LEVEL, found
    assert found.p(np.full(3, exact * (1.0 - 2 * LOST))) < LEVEL, "the twin"


def without_absorption(shape: str, free_path: float, spp: int) -> Estimate:
    film = {"type": "hdrfilm", "width": 8, "height": 8, "rfilter": {"type": "box"}}
    view = [{"look_at": {"origin": [0, 0, 6], "target": [0, 0, 0], "up": [0, 1, 0]}}]
    scene = seen_askew(
        **filled(shape, medium(free_path, 1.0)),
        sensor={"type": "perspective", "fov": 40.0, "to_world": view, "film": film},
    )
    return estimate(scene.core, spp, max_depth=-1, technique="bsdf", roulette="none")


@pytest.mark.parametrize("shape", ["cube", "instance", "sphere"])
def test_a_medium_without_absorption_is_not_seen(shape: str) -> None:
    """Each path comes out, to light of one radiance, so that there is no noise: what is lost is seen."""
    found = without_absorption(shape, 1e-1, 16)
    assert found.least == pytest.approx(1.0, rel=1e-5)
    assert found.most == pytest.approx(1.0, rel=1e-5)


@pytest.mark.parametrize("shape", ["cube", "instance", "sphere"])
def test_a_dense_medium_without_absorption_loses_nothing_on_the_mean(shape: str) -> None:
    """Some paths have more than a thousand vertices here, where roulette always takes part: the mean is right."""
    found = without_absorption(shape, 1e-2, 64)
    assert found.p(np.ones(3)) > LEVEL, found
    assert found.p(np.full(3, 0.99)) < LEVEL, "the twin"


@pytest.mark.parametrize("free_path", [1e-1, 1e-3, 1e-5, 1e-7])
def test_a_medium_that_absorbs_weakens_a_wall_by_the_exponential(free_path: float) -> None:
    """Before a wall that shines, one and a half mean free paths away, in a scene of extent 1."""
    tau = 1.5
    glow = {"type": "area", "radiance": 1.0}
    wall = {"type": "rectangle", "to_world": [{"scale": 0.5}, {"translate": [0, 0, -tau * free_path]}], "emitter": glow}
    fog = {"type": "homogeneous", "albedo": 0.0, "sigma_t": 1.0 / free_path}
    film = {"type": "hdrfilm", "width": 4, "height": 4, "rfilter": {"type": "box"}}
    view = {"type": "perspective", "fov": 0.01, "to_world": [{"rotate": {"axis": [0, 1, 0], "angle": 180}}]}
    scene = seen_askew(sensor={**view, "film": film, "medium": fog}, wall=wall, sky={"type": "constant", "radiance": 0})
    found = estimate(scene.core, 4, max_depth=-1)
    assert found.least == pytest.approx(math.exp(-tau), rel=1e-5)
    assert found.most == pytest.approx(math.exp(-tau), rel=1e-5)


def over_a_lamp(free_path: float, technique: str) -> Estimate:
    """A lamp within the turned cube, two mean free paths below its side."""
    below = [{"scale": 0.9}, {"rotate": {"axis": [0, 1, 0], "angle": 90}}]
    depth = [{"translate": [1.0 - 2.0 * free_path * EXTENT, 0, 0]}, *TURN]
    lamp = {"type": "rectangle", "to_world": [*below, *depth], "emitter": {"type": "area", "radiance": 1.0}}
    scene = seen_askew(**filled("cube", medium(free_path)), lamp=lamp, sky={"type": "constant", "radiance": 0.0})
    return estimate(scene.core, 4096, max_depth=-1, technique=technique)


@pytest.mark.parametrize("free_path", [1e-4, 1e-6, 1.2e-7])
def test_a_lamp_in_a_dense_medium_is_the_same_to_all_techniques(free_path: float) -> None:
    bsdf = over_a_lamp(free_path, "bsdf")
    for technique in ("light", "mis"):
        other = over_a_lamp(free_path, technique)
        both = Estimate(other.mean, np.hypot(bsdf.error, other.error), other.least, other.most)
        assert both.p(bsdf.mean) > LEVEL, (technique, bsdf, other)
        assert both.p(bsdf.mean * 1.02) < LEVEL, "the twin"


def test_a_medium_that_is_too_dense_is_refused_with_its_number_and_lint_explains() -> None:
    dense = seen_askew(**filled("cube", {**medium(2.5e-8), "id": "milk"}))
    with pytest.raises(et.SceneError, match=r"it\.interior.*mean free path is 2\.\d+e-08 of the scene's extent.*1e-07"):
        et.render(dense, spp=1)
    found = {finding.check: finding for finding in lint(dense)}
    assert found["dense-media"].severity == "warning"
    assert "e-08 of the scene" in found["dense-media"].what
    assert "milk" in found["dense-media"].where[0]


def test_a_medium_that_is_dense_enough_is_not() -> None:
    assert "dense-media" not in {finding.check for finding in lint(seen_askew(**filled("cube", medium(1.2e-7))))}
