"""What specular surfaces do to light: lamps seen in mirrors, lamps that are focused, and the doubt that follows."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import equaltime as et
from equaltime.film.focus import Focus
from equaltime.film.lamps import Lamps
from equaltime.film.sums import focused_light, mirrored_lamps
from equaltime.rendering.core import core_settings, make_renderer
from equaltime.scene.effects.focusing import focusing_surfaces
from equaltime.strategy import Strategy
from equaltime.strict_json import to_json

SIDE, Z_LIMIT = 12, 4.9
ALONE = Strategy.parse("bsdf,sampler=independent")
MIRROR, GLASS = {"type": "conductor", "material": "none"}, {"type": "dielectric"}
GLOSSY = {"type": "roughconductor", "alpha": 0.1}
NEARLY_SPECULAR = {"type": "roughconductor", "alpha": 0.005, "material": "none"}


def room(bsdf: dict[str, Any], radius: float = 0.05, **more: Any) -> et.Scene:
    """Return a panel that the camera looks at, and a small lamp behind the camera that the panel mirrors."""
    film = {"type": "hdrfilm", "width": SIDE, "height": SIDE, "rfilter": {"type": "box"}}
    look = {"look_at": {"origin": [0, 0, 0], "target": [0, 0, 4], "up": [0, 1, 0]}}
    return et.load_dict(
        {
            "type": "scene",
            "sensor": {"type": "perspective", "fov": 30, "to_world": [look], "film": film},
            "panel": {
                "type": "rectangle",
                "to_world": [{"rotate": {"axis": [0, 1, 0], "angle": 180}}, {"translate": [0, 0, 4]}],
                "bsdf": bsdf,
            },
            "lamp": {
                "type": "sphere",
                "center": [0.21, 0.33, -1],
                "radius": radius,
                "emitter": {"type": "area", "radiance": [40.0, 20.0, 10.0]},
            },
            **more,
        }
    )


def focus_of(scene: et.Scene) -> Focus:
    return Focus.of(scene.core, core_settings(scene, ALONE), 1, 1)


def worst(looked_at: et.Scene, rendered: et.Scene) -> float:
    """Return the largest z of what lamps in mirrors are said to add to pixels, against samples of another scene."""
    chains, samples = 1 << 20, 1 << 12
    pixels, moments, points = mirrored_lamps(looked_at.core, core_settings(looked_at, ALONE), 3, 1, chains)
    said, noise = np.zeros((SIDE * SIDE, 3)), np.zeros((SIDE * SIDE, 3))
    said[pixels], noise[pixels] = moments[:, 0], moments[:, 0] ** 2 / points[:, None]
    renderer = make_renderer(rendered, ALONE, 1, 1)
    renderer.advance(samples)
    image = renderer.moments["mean"].mean(axis=0).reshape(-1, 3)
    noise += 40.0 * np.maximum(image, said) / samples + 40.0**2 / samples**2
    return float((np.abs(said - image) / np.sqrt(noise)).max())


def test_lamps_in_a_mirror_are_what_samples_see_of_them() -> None:
    assert worst(room(MIRROR), room(MIRROR)) < Z_LIMIT


def test_lamps_a_little_larger_are_seen_to_be_others() -> None:
    assert worst(room(MIRROR), room(MIRROR, radius=0.065)) > Z_LIMIT


def test_half_of_the_chains_look_where_the_others_met_lamps() -> None:
    """Evenly spread chains would meet lamps as often as one of them on average, times their number."""
    scene, chains = room(MIRROR), 1 << 16
    _, moments, points = mirrored_lamps(scene.core, core_settings(scene, ALONE), 3, 1, chains)
    shares = (moments[:, 0].sum(axis=-1) ** 2 / (3.0 * moments[:, 1].sum(axis=-1))) / SIDE**2
    assert points.sum() > 3.0 * chains * shares.sum() > 0.0


@pytest.mark.parametrize(("radius", "agrees"), [(0.05, True), (0.065, False)])
def test_squares_of_pixels_that_share_a_chain_miss_no_light(radius: float, agrees: bool) -> None:
    """The mean over a film of 256 x 256 pixels, in squares of 4 x 4, is that of a film with a chain for each pixel."""
    means, variances = [], []
    for side, lamp in ((SIDE, 0.05), (256, radius)):
        scene = room(MIRROR, radius=lamp).with_(size=(side, side))
        _, moments, points = mirrored_lamps(scene.core, core_settings(scene, ALONE), 3, 1, 1 << 20)
        means.append(moments[:, 0, 0].sum() / side**2)
        variances.append((moments[:, 0, 0] ** 2 / points).sum() / side**4)
    z = abs(means[0] - means[1]) / math.sqrt(sum(variances))
    assert (z < Z_LIMIT) == agrees


def test_only_specular_surfaces_show_lamps() -> None:
    settings = core_settings(room(MIRROR), ALONE)
    found = {
        name: mirrored_lamps(room(bsdf).core, settings, 0, 1, 1 << 16)[0].size
        for name, bsdf in {
            "mirror": MIRROR,
            "nearly": NEARLY_SPECULAR,
            "glossy": GLOSSY,
            "matte": {"type": "diffuse"},
        }.items()
    }
    assert found["mirror"] > 0
    assert found["nearly"] > 0
    assert (found["glossy"], found["matte"]) == (0, 0)


def test_a_lamp_in_plain_sight_is_none_in_a_mirror() -> None:
    front = {"type": "sphere", "center": [0, 0, 2], "radius": 0.01, "emitter": {"type": "area", "radiance": 5.0}}
    alone = room({"type": "diffuse"}, bulb=front)
    assert mirrored_lamps(alone.core, core_settings(alone, ALONE), 0, 1, 1 << 16)[0].size == 0


def test_lamps_in_mirrors_are_searched_once_for_a_scene_and_a_depth(monkeypatch: pytest.MonkeyPatch) -> None:
    searches: list[int] = []

    def counted(scene: Any, settings: Any, seed: int, threads: int, chains: int) -> Any:
        searches.append(settings.max_depth)
        return mirrored_lamps(scene, settings, seed, threads, chains)

    monkeypatch.setattr("equaltime.film.lamps.mirrored_lamps", counted)
    deep = room(MIRROR)
    found = [
        Lamps.of(scene.core, core_settings(scene, ALONE), seed, 1, mirrors=True).lit.size > 0
        for scene in (deep, deep.with_(max_depth=2), deep.with_(max_depth=1), room(MIRROR))
        for seed in (0, 1)
    ]
    assert searches[1:3] == [2, 1]
    assert len(searches) == 4
    assert found == [True, True, True, True, False, False, True, True]


def test_too_few_chains_say_nothing() -> None:
    scene = room(MIRROR)
    assert mirrored_lamps(scene.core, core_settings(scene, ALONE), 0, 1, 1)[0].size == 0


def solid_angle(radius: float) -> float:
    """The mean of the lamp's solid angle over the panel as the camera sees it, all of which is specular."""
    edge = 4.0 * math.tan(math.radians(15))
    x, y = np.meshgrid(*[edge * (np.arange(400) / 200.0 - 1.0)] * 2)
    inside = (np.abs(x) <= 1.0) & (np.abs(y) <= 1.0)
    squared = (x - 0.21) ** 2 + (y - 0.33) ** 2 + 25.0
    return float((2.0 * math.pi * (1.0 - np.sqrt(1.0 - radius**2 / squared)))[inside].mean())


@pytest.mark.parametrize(("radius", "agrees"), [(0.5, True), (0.51, False)])
def test_the_solid_angle_of_a_lamp_is_that_of_its_cone(radius: float, agrees: bool) -> None:
    """Of 4096 vertices, over which the angle varies by 4 %, a mean differs by 0.06 %; the twin is 4 % larger."""
    scene = room(MIRROR, radius=0.5)
    vertices, radiance, angle = focused_light(scene.core, core_settings(scene, ALONE), 1, 1, 4096)
    assert vertices > 3000
    assert (abs(angle / solid_angle(radius) - 1.0) < 0.005) == agrees
    assert radiance == pytest.approx(angle / math.pi * (0.212671 * 40 + 0.71516 * 20 + 0.072169 * 10), rel=1e-3)


def lobe(alpha: float) -> float:
    """Solid angle of Beckmann's reflected lobe in directions of more than 100 a steradian, seen as the panel is.

    The density of such a direction is ``exp(-u) / (4 pi alpha^2 cos)``, with u exponentially distributed.
    """
    edge = 4.0 * math.tan(math.radians(15))
    x, y = np.meshgrid(*[edge * (np.arange(400) / 200.0 - 1.0)] * 2)
    inside = (np.abs(x) <= 1.0) & (np.abs(y) <= 1.0)
    peak = float(np.sqrt(1.0 + (x**2 + y**2) / 16.0)[inside].mean()) / (4.0 * math.pi * alpha**2)
    return 2.0 * (1.0 - 100.0 / peak) / (peak * (1.0 - (100.0 / peak) ** 2))


def in_a_sun(bsdf: dict[str, Any], irradiance: float, **more: Any) -> et.Scene:
    """Return the panel in the light of a sun without extent, and no lamp."""
    sun = {"type": "directional", "direction": [0.0, 0.0, 1.0], "irradiance": irradiance}
    return room(bsdf, lamp=sun, **more)


@pytest.mark.parametrize(("alpha", "agrees"), [(0.005, True), (0.0055, False)])
def test_a_narrow_lobe_makes_a_sun_without_extent_as_large_as_itself(alpha: float, agrees: bool) -> None:
    """Densities vary by 58 %, so a mean of 4096 differs by 0.9 %; the twin's lobe is 21 % larger."""
    scene = in_a_sun(NEARLY_SPECULAR, 6.0)
    vertices, radiance, angle = focused_light(scene.core, core_settings(scene, ALONE), 1, 1, 4096)
    assert vertices > 3000
    assert (abs(angle / lobe(alpha) - 1.0) < 0.035) == agrees
    assert radiance == pytest.approx(6.0 / math.pi, rel=1e-3)


def test_a_sun_without_extent_is_focused_by_narrow_lobes_alone() -> None:
    assert not focus_of(in_a_sun(MIRROR, 6.0)).possible
    nearly = focus_of(in_a_sun(NEARLY_SPECULAR, 6.0))
    assert nearly.rarely_met
    assert "samples meet them by chance" in nearly.doubt(64, 0.01, 1.0)


@pytest.mark.parametrize(
    ("scene", "possible"),
    [
        (room(MIRROR), True),
        (room(GLASS), True),
        (room({"type": "plastic"}), True),
        (room(GLOSSY), False),
        (room({"type": "diffuse"}), False),
        (room({"type": "thindielectric"}), True),
        (room(MIRROR, radius=0.9, sky={"type": "constant", "radiance": 50.0}), False),
    ],
    ids=["mirror", "glass", "plastic", "glossy", "matte", "a pane that mirrors", "a bright sky"],
)
def test_only_small_emitters_by_specular_surfaces_are_focused(scene: et.Scene, possible: bool) -> None:
    assert focus_of(scene).possible == possible


def test_a_crop_tells_of_itself_unless_the_whole_film_is_asked_for() -> None:
    corner = room(MIRROR).with_(crop=(0, 0, 1, 1))  # the panel fills a third of it
    settings = core_settings(corner, ALONE)
    assert focus_of(corner).paths < 0.5 < 0.8 < focus_of(room(MIRROR)).paths
    assert Focus.of(corner.core, settings, 1, 1, whole_film=True) == focus_of(room(MIRROR))


@pytest.mark.parametrize(
    ("bsdf", "words"),
    [
        (MIRROR, "mirrors"),
        (GLASS, "glass"),
        ({"type": "thindielectric"}, "glass"),
        ({"type": "roughdielectric", "alpha": 0.01}, "glass"),
        (NEARLY_SPECULAR, "rough metal"),
        ({"type": "roughconductor", "alpha_u": 0.9, "alpha_v": 0.01}, "rough metal"),
        ({"type": "roughconductor", "alpha": 0.3}, ""),
        ({"type": "plastic"}, "plastics"),
        ({"type": "roughplastic", "alpha": 0.3}, ""),
        ({"type": "blendbsdf", "weight": 0.5, "first": MIRROR, "second": GLASS}, "mirrors and glass"),
        ({"type": "principled", "roughness": 0.1, "metallic": 1.0}, "rough metal"),
        ({"type": "principled", "roughness": 0.1}, "glossy surfaces"),
        ({"type": "principled", "roughness": 0.9, "metallic": 1.0}, ""),
        ({"type": "principled", "roughness": 0.9, "clearcoat": 1.0}, "clear coats"),
        ({"type": "diffuse"}, ""),
    ],
)
def test_the_surfaces_that_may_focus_light_are_named(bsdf: dict[str, Any], words: str) -> None:
    assert focusing_surfaces(room(bsdf)) == words


def test_the_doubt_names_what_the_scene_has() -> None:
    """The doubt of a render whose panel is rough metal: the scene has neither glass nor a mirror."""
    sun = in_a_sun(NEARLY_SPECULAR, 6.0, sky={"type": "constant", "radiance": 0.1})
    told = et.render(sun, spp=2, strategy=ALONE).error.doubt
    assert told.startswith("small bright emitters reach the image by way of rough metal, where samples meet them by")
    assert "by way of specular surfaces" in RARE.doubt(samples=100.0, error=0.1, mean=0.3), "of an unknown kind"


RARE = Focus(paths=0.2, light=0.3, share=1e-3)


def test_an_error_is_in_doubt_while_few_samples_meet_the_light() -> None:
    assert "at most one in 1,000" in RARE.doubt(samples=100.0, error=0.1, mean=0.3)
    assert RARE.doubt(samples=100.0, error=0.1, mean=0.3).endswith(
        "; more samples, or larger and dimmer emitters, bring it in"
    )
    assert "light that the 1,610 samples of a pixel" in RARE.doubt(samples=1610.4, error=0.05, mean=0.3)
    assert RARE.doubt(samples=20_000.0, error=1e-4, mean=0.3) == ""


def test_light_that_could_not_change_the_error_is_no_reason_for_doubt() -> None:
    assert RARE.doubt(samples=100.0, error=1.0, mean=0.3) == ""
    assert RARE.doubt(samples=100.0, error=0.1, mean=300.0) == ""


def test_a_scene_without_specular_surfaces_leaves_no_doubt() -> None:
    assert Focus.none().doubt(samples=2.0, error=1e-6, mean=1.0) == ""


def test_it_comes_back_from_json() -> None:
    assert Focus.from_dict(to_json(RARE)) == RARE
    glass = replace(RARE, surfaces="glass")
    assert Focus.from_dict(to_json(glass)) == glass
    assert Focus.from_dict({"paths": 0.2, "light": 0.3, "share": 1e-3}) == RARE, "of an earlier version"
    assert Focus.from_dict(None) == Focus.none()


def test_scaling_the_light_by_a_power_of_two_changes_no_doubt() -> None:
    bright = Focus(0.2, 0.3 * 2.0**40, 1e-3)
    assert bright.doubt(100.0, 0.1, 0.3 * 2.0**40) == RARE.doubt(100.0, 0.1, 0.3)
