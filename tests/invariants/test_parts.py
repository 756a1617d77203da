"""An image taken apart: its parts add up to it, and those of short paths to the image that is cut there."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import equaltime as et
from equaltime.quoting.light_parts import KINDS_OF_PARTS
from equaltime.quoting.surface_groups import SurfaceGroups
from equaltime.rendering.core import make_renderer, split_light

ROOT = Path(__file__).parents[2]
TURN = {"rotate": {"axis": [1, 0, 0], "angle": -90}}
FOG: dict[str, Any] = {
    "type": "scene",
    "integrator": {"type": "volpath", "max_depth": 8},
    "sensor": {"type": "perspective", "fov": 50.0, "to_world": [{"translate": [0.0, 0.0, -4.0]}]},
    "floor": {
        "type": "rectangle",
        "to_world": [{"rotate": {"axis": [1, 0, 0], "angle": 90}}, {"translate": [0, -1, 0]}],
    },
    "ball": {
        "type": "sphere",
        "bsdf": {"type": "null"},
        "interior": {"type": "homogeneous", "sigma_t": 1.5, "albedo": 0.9},
    },
    "point": {"type": "point", "position": [0.0, 3.0, 0.0]},
    "sky": {"type": "constant", "radiance": 0.2},
}
SCENES = {
    "box": ROOT / "scenes" / "cornell-box.toml",
    "glass": ROOT / "tests" / "golden" / "glass.toml",
    "veils": ROOT / "scenes" / "hard" / "veils.toml",
    "fog": None,
}
STRATEGY = et.Strategy(roulette_depth=3)


def scene(path: Path | None) -> et.Scene:
    return (et.load_dict(FOG) if path is None else et.load(path)).with_(size=(16, 12))


def image(scene: et.Scene, strategy: et.Strategy) -> NDArray[Any]:
    renderer = make_renderer(scene, strategy, 3, 1)
    renderer.advance(8)
    mean: NDArray[Any] = renderer.moments["mean"].mean(axis=0)
    return mean


@pytest.mark.parametrize("path", SCENES.values(), ids=SCENES.keys())
@pytest.mark.parametrize("depth", [2, 3, 5])
def test_parts_add_up_to_the_image_and_short_paths_to_the_image_cut_there(path: Path | None, depth: int) -> None:
    loaded = scene(path)
    names, parts = split_light(loaded, STRATEGY, 3, 1, 8)
    whole = image(loaded, STRATEGY)
    for kind in KINDS_OF_PARTS:
        chosen = [i for i, (k, _) in enumerate(names) if k == kind]
        assert np.allclose(parts[:, :, chosen].sum(axis=2), whole, rtol=1e-5, atol=1e-6 * whole.max()), kind
    short = [i for i, (k, what) in enumerate(names) if k == "length" and int(what) <= depth]
    cut = image(loaded, et.Strategy(roulette_depth=3, truncate=depth))
    assert np.allclose(parts[:, :, short].sum(axis=2), cut, rtol=1e-5, atol=1e-6 * whole.max())


def stage() -> et.Scene:
    """A scene in which each shape has its own BSDF; one moves, one is in a group, and one holds a medium."""

    def coated(kind: str) -> dict[str, Any]:
        return {"bsdf": {"type": "twosided", "bsdf": {"type": kind}}}

    keys = [{"time": t, "transform": [{"translate": [1.2, t, 0]}]} for t in (0.0, 1.0)]
    world = {
        **FOG,
        "floor": {**FOG["floor"], **coated("diffuse")},
        "mirror": {"type": "disk", "to_world": [{"scale": 3}, {"translate": [0, 0, 2]}], **coated("conductor")},
        "slider": {"type": "cube", "to_world": {"animation": keys}, **coated("plastic")},
        "shelf": {"type": "shapegroup", "cone": {"type": "cylinder", "radius": 0.4, **coated("roughplastic")}},
        "placed": {
            "type": "instance",
            "to_world": [{"translate": [-1.2, 0, 0]}],
            "shelf": {"type": "ref", "id": "shelf"},
        },
    }
    return et.load_dict(world).with_(size=(48, 36), shutter=(0.0, 1.0))


@pytest.mark.parametrize("roulette", ["throughput", "efficiency"])
def test_where_each_shape_has_its_own_bsdf_both_kinds_of_parts_are_the_same(roulette: str) -> None:
    loaded = stage()
    groups = SurfaceGroups.of(loaded)
    strategy = et.Strategy.parse(f"best,roulette={roulette}")
    names, parts = split_light(loaded, strategy, 3, 1, 8, surface_groups=groups.of_shape)
    part = {name: parts[:, :, i] for i, name in enumerate(names)}
    owners = {"diffuse": "floor", "conductor": "mirror", "plastic": "slider", "roughplastic": "cylinder"}
    for bsdf, owner in owners.items():
        group = next(i for i, name in enumerate(groups.names) if name.split()[2] == owner)
        assert part["bsdf", bsdf].any()
        assert (part["surface", str(group)] == part["bsdf", bsdf]).all(), bsdf
    assert (part["surface", "medium"] == part["bsdf", "isotropic"]).all()
    assert (part["surface", "none"] == part["bsdf", "none"]).all()
    assert (part["surface", "0"] != part["bsdf", "conductor"]).any(), "the twin"


@pytest.mark.parametrize(
    ("lamps", "sky", "last"),
    [
        (24, False, ["light 23"]),
        (25, False, ["others"]),
        (24, True, ["light 23", "environment"]),
        (25, True, ["others", "environment"]),
    ],
)
def test_lights_have_their_names_until_there_are_more_than_24(lamps: int, sky: bool, last: list[str]) -> None:
    world: dict[str, Any] = {
        "type": "scene",
        "sensor": {"type": "perspective", "film": {"type": "hdrfilm", "width": 2, "height": 2}},
        **{f"lamp_{i}": {"type": "point", "position": [i, 0, 3], "intensity": 1.0} for i in range(lamps)},
    }
    if sky:
        world["sky"] = {"type": "constant", "radiance": 1.0}
    names, parts = split_light(et.load_dict(world), et.Strategy(), 1, 1, 2)
    lights = [name for kind, name in names if kind == "light"]
    assert lights[-len(last) :] == last
    assert len(lights) == 24 + sky
    assert parts.shape[2] == len(names)
