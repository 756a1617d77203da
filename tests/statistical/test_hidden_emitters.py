"""`hide_emitters`: the camera sees through what shines, and light falls on everything else as ever.

Where a render must equal another, both are taken to a mean over pixels; differences are judged by the standard errors
of both, at 4.5 of them (false alarms: 1 in 100 000 a comparison). Everything else is exact.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import equaltime as et
from equaltime.scene.effects.kinds import derive
from equaltime.scene.effects.leaving import leave_out

Dict = dict[str, Any]
MOST = 4.5

SKY: Dict = {"type": "constant", "radiance": 0.3}
WALL: Dict = {"type": "rectangle", "bsdf": {"type": "diffuse", "reflectance": 0.5}}
GLOW: Dict = {"type": "area", "radiance": 5.0}


def at(z: float, scale: float) -> list[list[float]]:
    return [[scale, 0, 0, 0], [0, scale, 0, 0], [0, 0, scale, z], [0, 0, 0, 1]]


def lamp(z: float, scale: float = 0.2, shape: str = "rectangle") -> Dict:
    return {"type": shape, "to_world": at(z, scale), "emitter": GLOW}


def pane(**bsdf: Any) -> Dict:
    return {"type": "rectangle", "to_world": at(2.0, 4.0), "bsdf": bsdf}


def scene(*shapes: Dict, integrator: str = "path", hide: bool = True, size: int = 8, **extra: Any) -> et.Scene:
    """Shapes seen from z = 5 towards -z, by half a radian or so."""
    film = {"type": "hdrfilm", "width": size, "height": size, "rfilter": {"type": "box"}}
    view = [[-1, 0, 0, 0], [0, 1, 0, 0], [0, 0, -1, 5], [0, 0, 0, 1]]
    parts = {f"shape{i}": shape for i, shape in enumerate(shapes)}
    how = {"type": integrator, "hide_emitters": hide}
    sensor = {"type": "perspective", "fov": 36.0, "to_world": view, "film": film}
    return et.load_dict({"type": "scene", "integrator": how, "sensor": sensor} | parts | extra)


def middle(loaded: et.Scene, spp: int = 256, seed: int = 1, strategy: str = "best") -> tuple[float, float]:
    """The mean of the four pixels in the middle and its standard error, where all errors are independent."""
    result = et.render(loaded, spp=spp, seed=seed, strategy=strategy)
    half = slice(loaded.size[0] // 2 - 1, loaded.size[0] // 2 + 1)
    image, error = result.image[half, half, 0], result.standard_error[half, half, 0]
    return float(image.mean()), float(np.sqrt((error.astype(np.float64) ** 2).mean() / error.size))


def deviation(one: tuple[float, float], other: tuple[float, float]) -> float:
    return abs(one[0] - other[0]) / max(1e-12, float(np.hypot(one[1], other[1])))


def test_what_is_all_around_is_black_and_lights_as_ever() -> None:
    image = et.render(scene(WALL, sky=SKY), spp=4).image
    assert image[0, 0].tolist() == [0, 0, 0]  # beyond the wall
    shown = et.render(scene(WALL, sky=SKY, hide=False), spp=4).image
    assert np.allclose(shown[0, 0], 0.3)
    assert np.array_equal(image[3:5, 3:5], shown[3:5, 3:5])
    assert image[3:5, 3:5].all()


def clipped(loaded: et.Scene, near: float) -> et.Scene:
    """The same from where nothing is in the way."""
    model = loaded.model
    return loaded.replaced(model.replace(sensor=model.sensor.replace(near_clip=near)))


def check_looks_through(lamps: tuple[Dict, ...], beyond: float, strategy: str, spp: int = 512) -> None:
    """The wall behind lamps is as one sees it past them; a darker one would be found."""
    past = middle(clipped(scene(WALL, *lamps, sky=SKY, hide=False), beyond), spp, seed=2, strategy=strategy)
    darker = WALL | {"bsdf": {"type": "diffuse", "reflectance": 0.4}}
    assert deviation(middle(scene(WALL, *lamps, sky=SKY), spp, strategy=strategy), past) < MOST
    assert deviation(middle(scene(darker, *lamps, sky=SKY), spp, strategy=strategy), past) > MOST


@pytest.mark.parametrize("shape", ["rectangle", "disk", "sphere", "cube"])
@pytest.mark.parametrize("strategy", ["best", "technique=bsdf", "technique=light"])
def test_the_camera_looks_through_a_light_at_what_it_lights(shape: str, strategy: str) -> None:
    check_looks_through((lamp(2.0, shape=shape),), 3.5, strategy)


def test_lights_behind_lights_are_looked_through_too() -> None:
    check_looks_through((lamp(1.0, shape="sphere"), lamp(2.0, shape="sphere")), 4.3, "best", spp=1024)


@pytest.mark.filterwarnings("ignore:the picture is black")
def test_all_that_lights_is_hidden_where_there_is_nothing_else() -> None:
    assert not et.render(scene(lamp(1.0), sky=SKY), spp=4).image.any()


@pytest.mark.parametrize("bsdf", [{"type": "null"}, {"type": "mask", "opacity": 0.0, "in": {"type": "diffuse"}}])
@pytest.mark.parametrize("integrator", ["path", "volpath"])
@pytest.mark.filterwarnings("ignore:the picture is black")
def test_nothing_is_no_reason_to_see_what_is_all_around(bsdf: Dict, integrator: str) -> None:
    assert not et.render(scene(pane(**bsdf), sky=SKY, integrator=integrator), spp=4).image.any()


@pytest.mark.parametrize(("integrator", "seen"), [("path", 5.0), ("volpath", 0.0)])
@pytest.mark.filterwarnings("ignore:the picture is black")
def test_a_light_behind_nothing_is_seen_where_crossings_are_vertices_as_in_mitsuba(
    integrator: str, seen: float
) -> None:
    image = et.render(scene(pane(type="null"), lamp(1.0, 0.5), integrator=integrator), spp=4).image
    assert np.allclose(image[3:5, 3:5], seen)


@pytest.mark.parametrize(
    "bsdf",
    [
        {"type": "null"},
        {"type": "thindielectric"},
        {"type": "blendbsdf", "weight": 0.5, "one": {"type": "null"}, "other": {"type": "diffuse"}},
    ],
)
def test_direct_light_is_refused_where_mitsuba_hides_in_another_way(bsdf: Dict) -> None:
    refused = r"integrator: hide_emitters of 'direct' is not supported where "
    with pytest.raises(et.SceneError, match=refused + r"'constant' behind '\w+' would be seen"):
        _ = scene(pane(**bsdf), sky=SKY, integrator="direct").core
    with pytest.raises(et.SceneError, match=refused + "'area' would be seen"):
        _ = scene(WALL, lamp(1.0), sky=SKY, integrator="direct").core
    assert not scene(pane(**bsdf), lamp(1.0), sky=SKY, hide=False, integrator="direct").core.effects()[
        "hidden_emitters"
    ]


def test_direct_light_hides_what_is_all_around_as_paths_of_two_segments_do() -> None:
    direct = et.render(scene(WALL, sky=SKY, integrator="direct"), spp=4).image
    assert not direct[0, 0].any()
    assert np.array_equal(direct, et.render(scene(WALL, sky=SKY).with_(max_depth=2), spp=4).image)


def test_thin_glass_reflects_what_is_all_around_and_shows_none_of_it() -> None:
    """A sheet of index 1.5 reflects 0.077 head on: 2 R / (1 + R) with R = 0.04."""
    value, error = middle(scene(pane(type="thindielectric", int_ior=1.5, ext_ior=1.0), sky=SKY), spp=4096)
    assert abs(value - 0.3 * 0.08 / 1.04) < MOST * error + 1e-5  # of float32, and what is not quite head on
    assert np.allclose(middle(scene(pane(type="thindielectric"), sky=SKY, hide=False), spp=64)[0], 0.3)


def test_glass_with_a_body_shows_what_is_all_around_as_in_mitsuba() -> None:
    block = {"type": "cube", "to_world": at(0.0, 1.0), "bsdf": {"type": "dielectric"}}
    value, error = middle(scene(block, sky=SKY), spp=1024)
    assert abs(value - 0.3) < MOST * error + 1e-5  # of float32, where no path differs


def test_copies_of_a_forked_path_see_what_is_all_around() -> None:
    hiding = scene(WALL, lamp(2.0), sky=SKY, size=16)
    assert deviation(middle(hiding, strategy="roulette=efficiency"), middle(hiding, seed=2)) < MOST
    dim = scene(WALL, lamp(2.0), sky=SKY | {"radiance": 0.27}, size=16)
    assert deviation(middle(dim, strategy="roulette=efficiency"), middle(hiding, seed=2)) > MOST


def test_it_is_an_effect_with_a_reason_that_can_be_left_out() -> None:
    hiding = scene(WALL, sky=SKY)
    assert [reason.what for reason in derive(hiding)["hidden_emitters"]] == ["integrator 'path'"]
    assert "hidden_emitters" not in derive(scene(WALL, sky=SKY, hide=False))
    assert "hidden_emitters" not in derive(scene(WALL))  # nothing shines
    shown, _ = leave_out(hiding, et.Strategy(), ["hidden_emitters"])
    assert not shown.model.integrator.hides_emitters
