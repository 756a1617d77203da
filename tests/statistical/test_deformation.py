"""The image of a mesh that deforms is the mean of its stills, and agrees with the cross-check.

Seeds are fixed. All comparisons together have a false-alarm rate of 0.1 %, and the same comparisons reject the pose in
the middle of the shutter, and poses that are at other times.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import numpy as np
import pytest
from numpy.typing import NDArray

import equaltime as et
from equaltime import crosscheck
from equaltime.scene.model import SceneModel
from equaltime.scene.motion import at_time
from equaltime.statistics.agreement import LEVEL, equality_test, share

from .sheets import deformation, write
from .test_motion_blur import BLOCK, BULB, LAMP, animated, averaged, blurred, moved, scene

Array = NDArray[np.float64]

KINDS: Final = ("a sheet and its shadow", "a sheet that moves, too", "a sheet before a lamp that swings")
EACH: Final = share(LEVEL, len(KINDS) + 1)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("sheets")
    write(path)
    return path


def parts(kind: str, folder: Path, *numbers: int) -> dict[str, Any]:
    paper = {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": [0.8, 0.3, 0.2]}}
    sheet = {"type": "ply", "filename": deformation(folder, *numbers), "bsdf": paper}
    if kind == "a sheet that moves, too":
        sheet["to_world"] = animated([moved(-0.4, 0, 0)], [{"rotate": {"axis": [0, 0, 1], "angle": 70}}])
    light = {"lamp": LAMP} if kind == "a sheet before a lamp that swings" else {"bulb": BULB}
    return {"sheet": sheet, **light}


@pytest.mark.parametrize("kind", [KINDS[0], *(pytest.param(kind, marks=pytest.mark.slow) for kind in KINDS[1:])])
def test_the_image_of_what_deforms_is_the_mean_of_its_stills(kind: str, folder: Path) -> None:
    loaded = scene(parts(kind, folder))
    assert loaded.core.effects()["motion"]
    assert equality_test(blurred(loaded), averaged(loaded), BLOCK) > EACH


def early(model: SceneModel, time: float) -> SceneModel:
    """The twin: poses that are reached a fifth too early."""
    return at_time(model, min(1.2 * time, 1.0))


def middle(model: SceneModel, _: float) -> SceneModel:
    """The twin: nothing but the pose in the middle of the shutter."""
    return at_time(model, 0.5)


@pytest.mark.parametrize("wrong", [early, pytest.param(middle, marks=pytest.mark.slow)])
def test_poses_at_other_times_are_found_wrong(wrong: Callable[[SceneModel, float], SceneModel], folder: Path) -> None:
    loaded = scene(parts(KINDS[0], folder))
    assert equality_test(blurred(loaded), averaged(loaded, wrong), BLOCK) < EACH


def agreement(moving: et.Scene, core: et.Scene) -> float:
    ours = (et.render(core, spp=16, seed=seed).image.astype(np.float64) for seed in range(24))
    theirs = (crosscheck.render(moving, 6, seed=seed)[0] for seed in range(24))
    return equality_test(ours, theirs)


@pytest.mark.slow
def test_what_deforms_agrees_with_the_cross_check_and_with_its_poses_in_another_order_does_not(folder: Path) -> None:
    loaded = scene(parts(KINDS[1], folder))
    assert agreement(loaded, loaded) > EACH
    assert agreement(loaded, scene(parts(KINDS[1], folder, 0, 2, 1))) < EACH
