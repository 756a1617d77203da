"""Every scene that is shipped, in other units, with other lights, and in other hands: one image, to the bit.

A few every day; all of them with -m slow.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Final

import pytest

import equaltime as et
from equaltime.film.moments import deviations, stored

from ..statistical.changed import changed
from .shipped import DEPTH, FOLDER, Moments, renderer, same_bits

SAMPLES: Final = 5
LONGER_SIDE: Final = 20
EVERYDAY: Final = ("terrain/terrain.toml", "hard/stretched-instance.toml", "hard/veils.toml", "hard/glass.toml")
SCENES: Final = [
    pytest.param(path, id=name, marks=[] if name in EVERYDAY else [pytest.mark.slow])
    for path in sorted([*FOLDER.rglob("*.toml"), *FOLDER.rglob("*.xml")])
    if not (name := str(path.relative_to(FOLDER))).startswith("experiments")
]
CHANGES: Final[tuple[dict[str, float], ...]] = (
    {"length": 2.0**20},
    {"length": 2.0**-20},
    {"light": 2.0**40},
    {"light": 2.0**-40},
    {"length": 2.0**-20, "light": 2.0**40},
)


@cache
def scene_at(path: Path) -> et.Scene:
    scene = et.load(path, **({"integrator": "path"} if path.suffix == ".xml" else {}))
    width, height = (max(1, round(n * LONGER_SIDE / max(scene.size))) for n in scene.size)
    return scene.with_(size=(width, height), max_depth=DEPTH)


@cache
def whole(path: Path) -> Moments:
    """Return what one thread makes of the whole film at once, in one tile."""
    subject = renderer(scene_at(path).core, threads=1, tile=1000)
    assert subject.advance(SAMPLES)
    assert not subject.nonfinite
    return subject.moments.copy()


@pytest.mark.parametrize("path", SCENES)
def test_other_units_and_other_lights_change_no_bit(path: Path) -> None:
    for change in CHANGES:
        subject = renderer(changed(scene_at(path), **change))
        assert subject.advance(SAMPLES)
        moments, light = subject.moments.copy(), change.get("light", 1.0)
        moments["mean"] /= light
        moments["deviation"] = stored(deviations(moments) / light)
        assert same_bits(moments, whole(path)), change


@pytest.mark.parametrize("path", SCENES)
def test_threads_tiles_passes_and_crops_change_no_bit(path: Path) -> None:
    for threads, tile, split in ((2, 5, (1, 2)), (3, 1, (4,)), (7, 16, ())):
        subject = renderer(scene_at(path).core, threads=threads, tile=tile)
        for samples in (*split, SAMPLES):
            assert subject.advance(samples)
        assert same_bits(subject.moments, whole(path)), (threads, tile, split)
    width, height = scene_at(path).size
    x, y = width // 3, height // 2
    crop = scene_at(path).with_(crop=(x, y, width - x, height - y))
    subject = renderer(crop.core, tile=3)
    assert subject.advance(SAMPLES)
    assert same_bits(subject.moments, whole(path)[:, y:, x:])


@pytest.mark.parametrize("change", [{"length": 3.0}, {"light": 3.0}])
def test_what_is_no_power_of_two_is_seen(change: dict[str, float]) -> None:
    """The twin; of scenes that are all of one brightness it sees nothing."""
    path = FOLDER / EVERYDAY[0]
    subject = renderer(changed(scene_at(path), **change))
    assert subject.advance(SAMPLES)
    assert not same_bits(subject.moments, whole(path))
