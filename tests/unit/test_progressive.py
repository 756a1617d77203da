"""Renders that the caller drives, pass by pass."""

from itertools import islice
from pathlib import Path

import numpy as np
import pytest

import equaltime as et

SCENE = Path(__file__).parents[2] / "scenes" / "cornell-box.toml"


@pytest.fixture(scope="module")
def scene() -> et.Scene:
    return et.load(SCENE).with_(size=(24, 20), max_depth=4)


def test_passes_end_where_render_ends_with_the_same_bits(scene: et.Scene) -> None:
    session = et.progressive(scene, spp=20)
    states = list(session)
    assert [int(state.spp) for state in states] == [2, 4, 6, 8, 10, 12, 14, 16, 20]
    assert states[0].stopped_by == "unfinished"
    assert session.result.stopped_by == "spp"
    np.testing.assert_array_equal(session.result.image, et.render(scene, spp=20).image)


def test_the_caller_may_stop_change_the_target_and_go_on(scene: et.Scene) -> None:
    session = et.progressive(scene)
    for state in session:
        if state.spp >= 12:
            break
    assert session.result.stopped_by == "unfinished"
    session.aim(spp=32)
    assert [int(state.spp) for state in session] == [14, 16, 20, 24, 28, 32]
    np.testing.assert_array_equal(session.result.image, et.render(scene, spp=32).image)


def test_an_error_may_be_asked_for_on_the_way(scene: et.Scene) -> None:
    session = et.progressive(scene, spp=8)
    list(session)
    session.aim(error=0.4)
    for state in islice(session, 100):
        assert state.error.known
    assert session.result.stopped_by == "error"
    assert session.result.error.value < 0.4


def test_a_state_stays_what_it_was(scene: et.Scene, tmp_path: Path) -> None:
    first = next(iter(states := list(et.progressive(scene, spp=16))))
    assert not np.array_equal(first.image, states[-1].image)
    first.save(tmp_path / "first.exr")
    np.testing.assert_array_equal(et.render(scene, spp=16, resume=tmp_path / "first.exr").image, states[-1].image)


def test_arguments_are_checked(scene: et.Scene) -> None:
    with pytest.raises(ValueError, match="spp must be"):
        et.progressive(scene, spp=0)
    with pytest.raises(ValueError, match="needs an end"):
        et.progressive(scene).aim()
