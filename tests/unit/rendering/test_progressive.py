"""Renders that the caller drives, pass by pass."""

import threading
import time
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import equaltime as et

SCENE = Path(__file__).parents[3] / "scenes" / "cornell-box.toml"


@pytest.fixture(scope="module")
def scene() -> et.Scene:
    return et.load(SCENE).with_(size=(24, 20), max_depth=4)


def test_passes_end_where_render_ends_with_the_same_bits(scene: et.Scene) -> None:
    session = et.progressive(scene, spp=20)
    states = list(session)
    assert [int(state.spp) for state in states] == [2, 4, 8, 16, 20]
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
    assert [int(state.spp) for state in session] == [20, 24, 28, 32]
    np.testing.assert_array_equal(session.result.image, et.render(scene, spp=32).image)


def test_an_error_may_be_asked_for_on_the_way(scene: et.Scene) -> None:
    session = et.progressive(scene, spp=8)
    list(session)
    session.aim(error=0.4)
    for state in islice(session, 100):
        assert state.error.known
    assert session.result.stopped_by == "error"
    assert session.result.error.value < 0.4


def test_the_time_is_that_of_all_loops_and_of_nothing_else(scene: et.Scene) -> None:
    session = et.progressive(scene, spp=8)
    list(session)
    first = session.result.stats.seconds
    time.sleep(0.05)
    assert session.result.stats.seconds == first > 0.0
    session.aim(spp=10)
    begin = time.perf_counter()
    for state in session:
        assert state.stats.seconds > first
    took = time.perf_counter() - begin
    assert first < session.result.stats.seconds <= first + took


def test_an_error_that_nobody_knows_has_no_time_left(scene: et.Scene) -> None:
    """A single pixel shows no spread from place to place: its upper limit is infinite."""
    session = et.progressive(scene.with_(size=(1, 1)))
    session.aim(error=0.05)
    for state in islice(session, 12):
        assert state.error.high == np.inf
        assert session.time_left is None


def test_cancelling_ends_the_loop_and_another_goes_on(scene: et.Scene) -> None:
    session = et.progressive(scene)
    threading.Timer(0.2, session.cancel).start()
    for _ in session:
        pass
    assert session.result.stopped_by == "interrupt"
    goal = int(session.result.samples.max()) + 2
    session.aim(spp=goal)
    assert [int(state.spp) for state in session][-1] == goal


def test_the_time_left_falls_and_follows_the_target(scene: et.Scene) -> None:
    session = et.progressive(scene, spp=4096)
    assert session.time_left is None
    lefts: list[float | None] = []
    for state in session:
        lefts.append(session.time_left)
        if state.spp >= 64:
            break
    assert lefts[0] is not None
    assert lefts[-1] is not None
    before = lefts[-1]
    session.aim(spp=128)
    assert 0.0 < (session.time_left or 0.0) < 0.1 * before
    session.aim(time=100.0)
    assert 0.0 < (session.time_left or 0.0) <= 100.0


@pytest.mark.parametrize("limit", [{"error": 0.4}, {"spp": 12}, {"time": 0.05}])
def test_no_time_is_left_at_the_end(scene: et.Scene, limit: dict[str, Any]) -> None:
    session = et.progressive(scene, **limit)
    list(session)
    assert session.result.stopped_by in limit
    assert session.time_left == 0.0
    session.aim(spp=2**20)
    assert session.time_left is not None
    assert session.time_left > 0.0


def test_a_state_stays_what_it_was(scene: et.Scene, tmp_path: Path) -> None:
    first = next(iter(states := list(et.progressive(scene, spp=16))))
    assert not np.array_equal(first.image, states[-1].image)
    first.save(tmp_path / "first.exr")
    np.testing.assert_array_equal(et.render(scene, spp=16, resume=tmp_path / "first.exr").image, states[-1].image)


def test_a_result_stays_what_it_was_while_its_render_goes_on(scene: et.Scene, tmp_path: Path) -> None:
    session = et.progressive(scene, spp=8)
    list(session)
    result = session.result
    assert result.moments is not None
    before = result.moments.tobytes()
    session.aim(spp=16)
    for _ in session:
        pass
    assert result.moments.tobytes() == before
    assert (result.moments["count"].sum(axis=0) == result.samples).all()
    result.save(tmp_path / "kept.exr")
    np.testing.assert_array_equal(et.render(scene, spp=16, resume=tmp_path / "kept.exr").image, session.result.image)


def test_a_result_that_is_kept_does_not_keep_the_renderer(scene: et.Scene) -> None:
    session = et.progressive(scene, spp=4)
    for result in (*session, session.result, et.render(scene, spp=4)):
        assert result.moments is not None
        assert result.moments.base is None


def test_no_array_of_a_result_can_be_written_to(scene: et.Scene, tmp_path: Path) -> None:
    depth = et.load_dict({"type": "scene", "sensor": {"type": "perspective"}, "integrator": {"type": "depth"}})
    small = depth.with_(size=(8, 8))
    for seed in range(2):
        et.render(small, spp=4, seed=seed).save(tmp_path / f"{seed}.exr")
    merged = et.merge([tmp_path / "0.exr", tmp_path / "1.exr"])
    for result in (*et.progressive(scene, spp=4), et.render(small, spp=4), merged):
        arrays = (result.image, result.standard_error, result.samples, result.moments, result.parts)
        for array in (*arrays, *result.missed.values(), *result.aovs.values()):
            assert array is None or not array.flags.writeable
    assert et.render(small, spp=4).aovs
    with pytest.raises(ValueError, match="read-only"):
        merged.image[0, 0] = 1.0


def test_arguments_are_checked(scene: et.Scene) -> None:
    for aim in (et.progressive(scene).aim, partial(et.progressive, scene)):
        with pytest.raises(ValueError, match=r"error=1 is 100 %.*: did you mean 0\.01, which is 1 %\?"):
            aim(error=1)
    with pytest.raises(ValueError, match="spp must be"):
        et.progressive(scene, spp=0)
    with pytest.raises(ValueError, match=r"spp must be .* found 1\.5"):
        et.progressive(scene).aim(spp=1.5)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="needs an end"):
        et.progressive(scene).aim()
