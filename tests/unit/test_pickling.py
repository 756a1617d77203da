"""Errors and scenes go to other processes and come back."""

from __future__ import annotations

import copy
import pickle
from pathlib import Path

import pytest

import equaltime as et
from equaltime.errors import (
    BrightImage,
    EqualtimeError,
    ExperimentError,
    FaultySample,
    NonFiniteSample,
    Problem,
    SceneError,
)

CORNELL = Path(__file__).parents[2] / "scenes" / "cornell-box.toml"


@pytest.mark.parametrize(
    "error",
    [
        SceneError((Problem("a.xml:3", "wrong"), Problem("", "odd"))),
        ExperimentError((Problem("e.toml", "wrong"),)),
        NonFiniteSample((1, 2), 3, 4, None, ("equaltime", "replay", "a b.xml")),
        FaultySample((1, 2), 3, 4, None, (), "division by zero"),
        BrightImage("pixel 0,0", 1e39, None, "a.exr"),
    ],
)
def test_an_error_survives_pickling(error: EqualtimeError) -> None:
    again = pickle.loads(pickle.dumps(error))
    assert type(again) is type(error)
    assert str(again) == str(error)
    assert vars(again) == vars(error)


def test_a_scene_that_was_built_can_be_pickled_and_copied() -> None:
    scene = et.load(CORNELL).with_(size=(8, 8))
    image = et.render(scene, spp=2, threads=1).image
    for again in (pickle.loads(pickle.dumps(scene)), copy.deepcopy(scene)):
        assert again.digest == scene.digest
        assert (et.render(again, spp=2, threads=1).image == image).all()
        assert again.place_of(again.model.shapes[0].bsdf) == scene.place_of(scene.model.shapes[0].bsdf) != ""
