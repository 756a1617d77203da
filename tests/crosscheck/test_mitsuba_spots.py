"""What spot lights send to places in and around their cones, against Mitsuba 3, from the same description.

Nothing is statistical: both evaluate the same formulas in float32. Twins show that a picture the wrong way round is
seen, and a percent.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import equaltime as et
from equaltime._core import parts

mi = pytest.importorskip("mitsuba")
mi.set_variant("scalar_rgb")

from .scene_parts import Dict, at, rgb, slide, towards  # noqa: E402

Array = NDArray[np.float64]
COUNT = 300
INTENSITY = np.array([2.0, 3.0, 4.0])
FLOAT = 1e-4
"""Of what leaves along the axis: directions from places of 24 bits, some near the light, at the slopes of a narrow cone
and of texels of very unlike values."""


def squares(**extra: Any) -> Dict:
    return {"type": "checkerboard", "color0": rgb(0.1, 0.5, 0.9), "color1": rgb(0.9, 0.2, 0.1), **extra}


def spot(texture: Dict | None, **extra: Any) -> Dict:
    projected = {} if texture is None else {"texture": texture}
    return (
        {"type": "spot", "intensity": rgb(*INTENSITY.tolist()), "cutoff_angle": 30.0, "beam_width": 12.0}
        | projected
        | extra
    )


def cases(folder: Path) -> dict[str, Dict]:
    picture = {"type": "bitmap", "filename": slide(folder / "slide.exr"), "raw": True}
    return {
        "no slide": spot(None),
        "a slide": spot(picture),
        "a turned slide": spot(picture, to_world=at(1, 2, 3, turn=70)),
        "looking at something": spot(picture, to_world=towards((3, 2, 1))),
        "a mirrored slide": spot(picture, to_world=at(1, 2, 3, [-1.0, 1.0, 1.0], 70)),
        "a large one": spot(picture, to_world=at(1, 2, 3, 5.0, 70)),
        "texels without an edge": spot(picture | {"filter_type": "nearest"}, cutoff_angle=80.0, beam_width=80.0),
        "a slide set smaller": spot(
            picture | {"wrap_mode": "mirror", "to_uv": mi.ScalarTransform3f().scale([3.0, 2.0])}, cutoff_angle=13.0
        ),
        "a beam beyond its cone": spot(None, beam_width=50.0),
        "squares": spot(squares()),
    }


def places(emitter: Dict) -> tuple[Array, Array]:
    """Within one and a half times the cone, at distances from 0.1 to 10, or five times that; and the distances."""
    rng = np.random.default_rng(3)
    theta = np.radians(emitter["cutoff_angle"]) * np.minimum(1.5 * rng.random(COUNT), np.pi / 2)
    phi, distance = 2 * np.pi * rng.random(COUNT), 10.0 ** rng.uniform(-1, 1, COUNT)
    local = distance * np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])
    to_world = np.eye(4) if "to_world" not in emitter else np.array(emitter["to_world"].matrix, dtype=np.float64)
    world: Array = (to_world[:3, :3] @ local).T + to_world[:3, 3]
    world = world.astype(np.float32).astype(np.float64)
    return world, np.linalg.norm(world - to_world[:3, 3], axis=1)


def ours(emitter: Dict, at_places: Array) -> Array:
    scene = et.load_dict({"type": "scene", "sensor": {"type": "perspective"}, "lamp": emitter})
    return np.asarray(parts.sample_lights(scene.core, "power", at_places, 1)["radiance"])


def theirs(emitter: Dict, at_places: Array) -> Array:
    light, it = mi.load_dict(emitter), mi.SurfaceInteraction3f()
    found = []
    for place in at_places:
        it.p = mi.Point3f(place)
        found.append(np.asarray(light.sample_direction(it, mi.Point2f(0.5, 0.5))[1]))
    return np.array(found)


def off(a: Array, b: Array, distance: Array) -> float:
    """The share of places where two fluxes differ."""
    share = np.abs(a - b) * distance[:, None] ** 2 / INTENSITY
    return float((share > FLOAT).any(axis=1).mean())


NAMES = (
    *("no slide", "a slide", "a turned slide", "looking at something", "a mirrored slide", "a large one"),
    *("texels without an edge", "a slide set smaller", "squares"),
)


@pytest.mark.parametrize("name", NAMES)
def test_what_a_spot_light_sends_is_mitsubas(name: str, tmp_path: Path) -> None:
    emitter = cases(tmp_path)[name]
    at_places, distance = places(emitter)
    found, expected = ours(emitter, at_places), theirs(emitter, at_places)
    lit = expected.any(axis=1)
    assert 0.4 < lit.mean() < 1.0
    assert off(found, expected, distance) == 0.0
    assert off(1.01 * found, expected, distance) > 0.4, "the twin"


def test_a_picture_the_wrong_way_round_is_seen(tmp_path: Path) -> None:
    emitter = cases(tmp_path)["a slide"]
    at_places, distance = places(emitter)
    expected = theirs(emitter, at_places)
    for turned in ([-1, 1, 1], [1, -1, 1], [-1, -1, 1]):
        assert off(ours(emitter, at_places * turned), expected, distance) > 0.4
