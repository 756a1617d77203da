"""Variance pictures of a report: beside the images, on one scale, of the strategies that tell their variance."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from equaltime.experiments.model.summary import SceneResult
from equaltime.experiments.report.gallery import Series, kinds_of
from equaltime.experiments.report.looks import looks
from equaltime.experiments.report.pictures import Pictures, load_pictures
from equaltime.statistics.in_words import figure

from .fake_summary import CONSTANTS, scene_result


@pytest.fixture
def scene(tmp_path: Path) -> SceneResult:
    return scene_result(tmp_path)


def series(scene: SceneResult) -> tuple[Series, ...]:
    pictures = load_pictures(scene)
    assert isinstance(pictures, Pictures)
    return kinds_of(scene, pictures, looks([*CONSTANTS], scene.baseline), 640)


def test_the_variances_stand_after_the_images_on_one_scale(scene: SceneResult) -> None:
    images, variances, *_ = series(scene)
    assert (images.name, variances.name) == ("Image", "Variance")
    assert [frame.label for frame in variances.frames] == [frame.label for frame in images.frames[1:]]
    assert {frame.label: frame.caption for frame in variances.frames} == {
        label: f"mean {figure(constant**2)}" for label, constant in CONSTANTS.items()
    }
    assert variances.bar is not None
    assert variances.bar.colours[0] == "#ffffff"
    assert variances.bar.colours[-1] == "#000000"
    assert (
        f"from {variances.bar.ticks[0]} (white) or less to {variances.bar.ticks[-1]} (black)" in variances.explanation
    )
    low, _, high = map(float, variances.bar.ticks)
    assert low < min(CONSTANTS.values()) ** 2 <= max(CONSTANTS.values()) ** 2 <= 1.1 * high


def test_a_strategy_that_tells_none_has_no_picture(scene: SceneResult) -> None:
    silent, *telling = scene.strategies
    _, variances, *_ = series(replace(scene, strategies=(replace(silent, variances=()), *telling)))
    assert silent.label not in [frame.label for frame in variances.frames]
    none = replace(scene, strategies=tuple(replace(each, variances=()) for each in scene.strategies))
    assert "Variance" not in [kind.name for kind in series(none)]


def test_variances_are_means_of_repeats_and_may_be_unknown(scene: SceneResult) -> None:
    best = next(each for each in scene.strategies if each.label == "best")
    np.save(best.variances[0], 3.0 * np.load(best.variances[0]))
    repeats = len(best.variances)
    caption = f"mean {figure(CONSTANTS['best'] ** 2 * (repeats + 2) / repeats)}"
    assert caption in [frame.caption for frame in series(scene)[1].frames]
    np.save(best.variances[0], np.full_like(np.load(best.variances[0]), np.inf))
    assert "not known" in [frame.caption for frame in series(scene)[1].frames]
