"""Time is sampled like everything else: the image of what moves is the mean of its stills, whatever is seen of it.

Seeds are fixed. All comparisons together have a false-alarm rate of 0.1 %, and the same comparisons reject shadows of
what stands still, and rotations whose matrices are interpolated.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, Final

import numpy as np
import pytest
from numpy.typing import NDArray

import equaltime as et
from equaltime import _core
from equaltime.scene.model import Animation, SceneModel, as_array
from equaltime.scene.motion import at_time, pose
from equaltime.statistics.agreement import LEVEL, equality_test, share

Array = NDArray[np.float64]

SIZE: Final = (24, 16)
SEEDS, SAMPLES, STILLS, BLOCK = 16, 32, 16, 8
VIEW = {"look_at": {"origin": [0, -4, 1.5], "target": [0, 0, 0.5], "up": [0, 0, 1]}}
FLOOR = {"type": "rectangle", "to_world": [{"scale": 3}]}
BULB = {"type": "point", "position": [0, 0, 6], "intensity": 60}
DOWN = {"rotate": {"axis": [1, 0, 0], "angle": 180}}


def animated(*transforms: Any) -> dict[str, Any]:
    times = np.linspace(0, 1, len(transforms))
    return {"animation": [{"time": t, "transform": list(x)} for t, x in zip(times, transforms, strict=True)]}


def turn(angle: float) -> dict[str, Any]:
    return {"rotate": {"axis": [0, 0, 1], "angle": angle}}


def moved(x: float, y: float, z: float) -> dict[str, Any]:
    return {"translate": [x, y, z]}


ROD = {"type": "cube", "bsdf": {"type": "diffuse", "reflectance": [0.8, 0.3, 0.2]}}
SPINNING = animated(
    [{"scale": [0.9, 0.1, 0.1]}, moved(0, 0, 0.5)], [{"scale": [0.9, 0.1, 0.2]}, turn(160), moved(0, 0.2, 0.7)]
)
ABOVE = animated([{"scale": [0.5, 0.3, 0.1]}, moved(-1.5, 0, 4)], [{"scale": [0.5, 0.3, 0.1]}, moved(1, 0.5, 4)])
SWINGING = animated([DOWN, {"scale": 0.4}, moved(-1.2, 0, 2)], [DOWN, {"scale": 0.3}, turn(50), moved(1, 0.3, 1.4)])
LAMP = {"type": "rectangle", "to_world": SWINGING, "emitter": {"type": "area", "radiance": 8}}
BOARD = {"type": "checkerboard", "color0": [1, 0.1, 0.1], "color1": [0.1, 0.2, 1]}
TURNED = BOARD | {"color0": BOARD["color1"], "color1": BOARD["color0"]}
ROLLING = animated([{"scale": 0.3}, moved(-0.8, 0, 0.6)], [{"scale": 0.4}, turn(120), moved(0.8, 0, 0.5)])
PANNING = animated([VIEW], [VIEW, turn(12), moved(0.2, 0, 0)])
SCENES: Final[dict[str, dict[str, Any]]] = {
    "a rod that spins": {"rod": ROD | {"to_world": SPINNING}, "bulb": BULB},
    "a shadow of what is not seen": {"rod": ROD | {"to_world": ABOVE}, "bulb": BULB},
    "a lamp that swings over a ball": {"lamp": LAMP, "ball": {"type": "sphere", "center": [0, 0, 0.4], "radius": 0.4}},
    "pictures that swing and roll": {
        "picture": LAMP | {"emitter": {"type": "area", "radiance": BOARD}},
        "ball": {"type": "sphere", "to_world": ROLLING, "emitter": {"type": "area", "radiance": BOARD}},
    },
    "a camera that pans": {"rod": ROD | {"to_world": [{"scale": 0.4}]}, "bulb": BULB, "sensor": {"to_world": PANNING}},
    "parallel rays that turn": {
        "rod": ROD | {"to_world": [{"scale": 0.4}]},
        "bulb": BULB,
        "sensor": {
            "type": "orthographic",
            "to_world": animated([{"scale": 2}, VIEW], [{"scale": 1.5}, VIEW, turn(20)]),
        },
    },
    "all through a lens": {
        "rod": ROD | {"to_world": SPINNING},
        "lamp": LAMP,
        "sensor": {"type": "thinlens", "aperture_radius": 0.1, "focus_distance": 3.5, "to_world": PANNING},
    },
}
EACH: Final = share(LEVEL, len(SCENES))


def scene(parts: dict[str, Any]) -> et.Scene:
    sensor: dict[str, Any] = {"type": "perspective", "to_world": [VIEW], "shutter_close": 1} | parts.get("sensor", {})
    if sensor["type"] != "orthographic":
        sensor["fov"] = 40
    whole = {"type": "scene", "integrator": {"type": "path", "max_depth": 3}, "floor": FLOOR} | parts
    return et.load_dict(whole | {"sensor": sensor}).with_(size=SIZE)


def image(loaded: et.Scene, samples: int, seed: int) -> Array:
    renderer = _core.Renderer(loaded.core, _core.Settings(max_depth=3), seed=seed, threads=1)
    assert renderer.advance(samples)
    moments = renderer.moments
    total = moments["count"].sum(axis=0)[..., None]
    mean: Array = (moments["mean"] * moments["count"][..., None]).sum(axis=0) / total
    return mean


def blurred(loaded: et.Scene) -> Iterator[Array]:
    return (image(loaded, SAMPLES, seed) for seed in range(SEEDS))


def averaged(loaded: et.Scene, at: Callable[[SceneModel, float], SceneModel] = at_time) -> Iterator[Array]:
    """Iterate over means of stills at random times, one in each part of the shutter's."""
    for seed in range(SEEDS):
        times = (np.arange(STILLS) + np.random.default_rng(seed).random(STILLS)) / STILLS
        stills = (loaded.replaced(at(loaded.model, time)) for time in times)
        yield np.mean([image(s, 2, 1000 + STILLS * seed + i) for i, s in enumerate(stills)], axis=0)


@pytest.mark.parametrize("name", SCENES)
def test_the_image_of_what_moves_is_the_mean_of_its_stills(name: str) -> None:
    loaded = scene(SCENES[name])
    assert loaded.core.effects()["motion"]
    assert equality_test(blurred(loaded), averaged(loaded), BLOCK) > EACH


def test_a_shadow_of_what_stands_at_the_shutters_centre_is_found_wrong() -> None:
    """The twin: shadow rays that know no time, of a thing that nothing else meets."""
    loaded = scene(SCENES["a shadow of what is not seen"])
    assert equality_test(blurred(loaded), averaged(loaded, lambda model, _: at_time(model, 0.5)), BLOCK) < EACH


def test_pictures_that_are_turned_are_found_wrong() -> None:
    """The twin: what shines shows its picture turned."""
    parts = SCENES["pictures that swing and roll"]
    wrong = {name: part | {"emitter": {"type": "area", "radiance": TURNED}} for name, part in parts.items()}
    assert equality_test(blurred(scene(parts)), averaged(scene(wrong)), BLOCK) < EACH


def by_matrices(model: SceneModel, time: float) -> SceneModel:
    """The twin: rotations that are interpolated entry by entry."""

    def between(placement: Any) -> Any:
        if not isinstance(placement, Animation):
            return placement
        first, last = (as_array(matrix) for matrix in placement.matrices)
        return (1 - time) * first + time * last

    return model.replace(shapes=tuple(shape.replace(to_world=between(shape.to_world)) for shape in model.shapes))


def test_rotations_interpolated_entry_by_entry_are_found_wrong() -> None:
    loaded = scene(SCENES["a rod that spins"])
    assert equality_test(blurred(loaded), averaged(loaded, by_matrices), BLOCK) < EACH


@pytest.mark.parametrize("kind", ["cube", "sphere", "disk", "rectangle"])
def test_no_ray_that_leaves_what_moves_meets_it_again(kind: str) -> None:
    """White and convex under a white sky: every sample of it is 1, however it moves and wherever the camera is."""
    sizes: list[Any] = [1.5, 0.75] if kind == "sphere" else [[1.5, 0.2, 1], [0.5, 1.5, 0.1]]
    far = np.array([300.0, -200.0, 100.0])
    keys = animated(
        [{"scale": sizes[0]}, moved(*(far - 0.2))],
        [{"scale": sizes[1]}, {"rotate": {"axis": [1, 2, 3], "angle": 170}}, moved(*(far + 0.3))],
    )
    white = {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": 1.0}}
    parts = {"it": {"type": kind, "to_world": keys, "bsdf": white}, "sky": {"type": "constant", "radiance": 1.0}}
    anchor = {"type": "sphere", "center": [-200, 0, 0], "radius": 0.1, "bsdf": white}
    for eye in (far + np.array([0.0, -6.0, 2.0]), np.zeros(3)):
        view = {"look_at": {"origin": eye.tolist(), "target": far.tolist(), "up": [0, 0, 1]}}
        zoom = {"type": "perspective", "to_world": [view], "shutter_close": 1, "fov": 30 if eye[0] else 0.4}
        whole = {"type": "scene", "sensor": zoom, "integrator": {"type": "path", "max_depth": 2}, "anchor": anchor}
        loaded = et.load_dict(whole | parts).with_(size=(64, 64))
        settings = _core.Settings(max_depth=2, technique="bsdf", sampler="independent")
        renderer = _core.Renderer(loaded.core, settings, seed=4, threads=1)
        assert renderer.advance(8)
        moments = renderer.moments
        assert 0.99 < moments["mean"].min() < moments["mean"].max() < 1.01


def test_the_pose_of_a_key_is_the_key() -> None:
    placement = scene(SCENES["a rod that spins"]).model.shapes[1].to_world
    assert isinstance(placement, Animation)
    assert (pose(placement, 1.0) == as_array(placement.matrices[1])).all()
