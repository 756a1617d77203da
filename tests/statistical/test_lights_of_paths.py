"""Light that a path aims at is what its rays would meet: at the path's time, at its depth, where there is any.

Means over all pixels of two ways to sample one scene are held against each other, each with the scatter of its seeds;
a test has a false-alarm rate of 1e-4, and beside it what it must reject: a scene that is a little different.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio  # noqa: N813
import pytest
from scipy import stats

import equaltime as et

Dict = dict[str, Any]
LEVEL = 1e-4
SEEDS = 24
FILM: Dict = {"type": "hdrfilm", "width": 12, "height": 12, "rfilter": {"type": "box"}}
WHITE: Dict = {"type": "diffuse", "reflectance": 0.7}
BLACK: Dict = {"type": "diffuse", "reflectance": 0.0}


def means(scene: et.Scene, strategy: str, spp: int = 64, first: int = 0) -> list[float]:
    return [
        float(et.render(scene, spp=spp, strategy=strategy, seed=seed).image.mean())
        for seed in range(first, first + SEEDS)
    ]


def p_value(first: list[float], second: list[float]) -> float:
    return float(stats.ttest_ind(first, second, equal_var=False).pvalue)


def room_with_a_lamp_that_moves(reach: float = 0.6) -> et.Scene:
    """A lamp that moves along its normal: where it is now it would block itself as it is at another time."""

    def key(time: float, z: float) -> Dict:
        return {"time": time, "transform": [{"scale": 0.5}, {"translate": [0, 0, z]}]}

    lamp = {
        "type": "rectangle",
        "to_world": {"animation": [key(0.0, -1.0), key(1.0, -1.0 + reach)]},
        "emitter": {"type": "area", "radiance": 5.0},
        "bsdf": BLACK,
    }
    view = {"look_at": {"origin": [2.5, 0, 1], "target": [0, 0, 2], "up": [0, 1, 0]}}
    sensor = {"type": "perspective", "fov": 60.0, "shutter_close": 1.0, "film": FILM, "to_world": [view]}
    wall = {"type": "sphere", "radius": 3.0, "flip_normals": True, "bsdf": WHITE}
    integrator = {"type": "path", "max_depth": 4}
    return et.load_dict({"type": "scene", "integrator": integrator, "sensor": sensor, "lamp": lamp, "wall": wall})


@pytest.mark.parametrize("technique", ["mis", "light"])
def test_a_path_that_forks_aims_at_lamps_as_they_are_at_its_time(technique: str) -> None:
    scene = room_with_a_lamp_that_moves()
    plain = means(scene, f"best,technique={technique},sampler=independent")
    forked = means(scene, f"best,technique={technique},sampler=independent,roulette=efficiency", first=100)
    assert p_value(plain, forked) > LEVEL
    elsewhere = means(room_with_a_lamp_that_moves(0.8), f"best,technique={technique},sampler=independent", first=200)
    assert p_value(plain, elsewhere) < LEVEL, "the twin"


def behind_a_pane(max_depth: int) -> et.Scene:
    """A floor, seen through a lamp that the camera does not see, and lit by another from behind a pane with holes."""
    view = [[-1, 0, 0, 0], [0, 1, 0, 0], [0, 0, -1, 5], [0, 0, 0, 1]]

    def at(z: float, scale: float, x: float = 0.0, turn: float = 0.0) -> list[Dict]:
        turned = {"rotate": {"axis": [0, 1, 0], "angle": turn}}
        return [{"scale": scale}, turned, {"translate": [x, 0, z]}]

    return et.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "path", "max_depth": max_depth, "hide_emitters": True},
            "sensor": {"type": "perspective", "fov": 20.0, "to_world": view, "film": FILM},
            "floor": {"type": "rectangle", "to_world": at(0.0, 3.0), "bsdf": WHITE},
            "seen through": {
                "type": "rectangle",
                "to_world": at(3.0, 1.5, turn=180.0),
                "emitter": {"type": "area", "radiance": 0.01},
            },
            "pane": {
                "type": "rectangle",
                "to_world": at(1.0, 0.8, 2.0),
                "bsdf": {"type": "mask", "opacity": 0.5, "bsdf": BLACK},
            },
            "lamp": {
                "type": "rectangle",
                "to_world": at(1.5, 0.5, 2.0, 180.0),
                "emitter": {"type": "area", "radiance": 20.0},
            },
        }
    )


@pytest.mark.parametrize("technique", ["mis", "light"])
def test_what_a_path_has_crossed_unseen_does_not_shorten_its_shadow_rays(technique: str) -> None:
    """The floor is vertex 1, the pane 2, the lamp 3."""
    scattered = means(behind_a_pane(3), "bsdf", spp=256)
    aimed = means(behind_a_pane(3), f"best,technique={technique}", first=100)
    assert p_value(scattered, aimed) > LEVEL
    assert p_value(scattered, means(behind_a_pane(2), "bsdf", spp=256, first=200)) < LEVEL, "the twin"


def lamp_in_glass(priority: int) -> et.Scene:
    """A lamp in a ball of rough glass, which is there or not by its priority."""
    glass = {"type": "roughdielectric", "alpha": 0.3, "int_ior": 1.5}
    view = [[-1, 0, 0, 0], [0, 1, 0, 0], [0, 0, -1, 4], [0, 0, 0, 1]]
    return et.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "path", "max_depth": 6},
            "sensor": {"type": "perspective", "fov": 40.0, "to_world": view, "film": FILM},
            "ball": {"type": "sphere", "bsdf": glass, "priority": 2},
            "lamp": {
                "type": "sphere",
                "radius": 0.4,
                "priority": priority,
                "emitter": {"type": "area", "radiance": 9.0},
            },
        }
    )


@pytest.mark.parametrize("technique", ["mis", "light", "bsdf", "mixture"])
@pytest.mark.filterwarnings("ignore:the picture is black")
def test_a_lamp_that_is_not_there_lights_nothing(technique: str) -> None:
    """T7: nor do points on it that are aimed at. The twin is a lamp of higher priority, which is there."""
    strategy = f"best,technique={technique}" if technique != "bsdf" else "bsdf"
    assert not et.render(lamp_in_glass(0), spp=64, strategy=strategy).image.any()
    assert et.render(lamp_in_glass(3), spp=64, strategy=strategy).image.any()


def test_glass_whose_index_is_one_in_float32_is_finite() -> None:
    """The nearest that has facets stands for it, as for exactly 1."""
    images = []
    for eta in (1.0, 1.00000001):
        ball = {"type": "sphere", "bsdf": {"type": "principled", "spec_trans": 1.0, "eta": eta, "roughness": 0.4}}
        sensor = {"type": "perspective", "fov": 40.0, "to_world": [{"translate": [0, 0, -4]}], "film": FILM}
        sky = {"type": "constant", "radiance": 1.0}
        images.append(
            et.render(et.load_dict({"type": "scene", "sensor": sensor, "ball": ball, "sky": sky}), spp=16).image
        )
    np.testing.assert_array_equal(*images)


def unlit_spot(folder: Path) -> Dict:
    """Return a large picture, turned, whose one lit texel is at none of the 1024^2 points where such are looked at."""
    side, turn = 4096, np.radians(45.0)
    x, y = np.meshgrid(*[(np.arange(1024) + 0.5) / 1024] * 2)
    u, v = np.cos(turn) * x - np.sin(turn) * y, np.sin(turn) * x + np.cos(turn) * y
    met = np.zeros((side, side), np.bool_)
    for rows in (v, 1.0 - v):
        met[np.floor(rows % 1.0 * side).astype(int) % side, np.floor(u % 1.0 * side).astype(int) % side] = True
    row, column = np.argwhere(~met)[5000]
    texels = np.zeros((side, side, 1), np.uint8)
    texels[row, column] = 255
    output = oiio.ImageOutput.create(str(folder / "spot.png"))
    assert output.open(str(folder / "spot.png"), oiio.ImageSpec(side, side, 1, "uint8"))
    assert output.write_image(texels)
    output.close()
    turned = [{"rotate": {"axis": [0, 0, 1], "angle": 45}}]
    return {"type": "bitmap", "filename": str(folder / "spot.png"), "filter_type": "nearest", "to_uv": turned}


@pytest.mark.filterwarnings("ignore:the picture is black")
def test_a_picture_whose_light_no_look_has_met_is_a_light(tmp_path: Path) -> None:
    """Its weights summed to nothing, so that there was a light without a table to pick it by, and no memory there."""
    lamp = {"type": "rectangle", "emitter": {"type": "area", "radiance": unlit_spot(tmp_path)}}
    sensor = {"type": "perspective", "fov": 60.0, "to_world": [{"translate": [0, 0, -3]}], "film": FILM}
    place = [{"scale": 5}, {"rotate": {"axis": [0, 1, 0], "angle": 180}}, {"translate": [0, 0, 2]}]
    wall = {"type": "rectangle", "to_world": place, "bsdf": WHITE}
    scene = et.load_dict({"type": "scene", "sensor": sensor, "wall": wall, "lamp": lamp})
    for lights in ("power", "uniform", "tree"):
        assert np.isfinite(et.render(scene, spp=8, strategy=f"best,lights={lights}").image).all()
