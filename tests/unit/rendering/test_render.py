"""`render` on the compiled core: what comes in, what comes out, and how it stops."""

import copy
import os
import signal
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import equaltime as et
from equaltime import _core
from equaltime.rendering import session
from equaltime.rendering.budget import StoppedBy
from equaltime.rendering.session import Session

BALL: dict[str, Any] = {
    "type": "scene",
    "integrator": {"type": "path", "max_depth": 6},
    "sensor": {
        "type": "perspective",
        "fov": 45.0,
        "to_world": {"look_at": {"origin": [0, 0, 4], "target": [0, 0, 0], "up": [0, 1, 0]}},
        "film": {"type": "hdrfilm", "width": 32, "height": 24, "rfilter": {"type": "box"}},
    },
    "ball": {"type": "sphere", "bsdf": {"type": "diffuse"}},
    "lamp": {
        "type": "sphere",
        "center": [2, 3, 3],
        "radius": 0.5,
        "emitter": {"type": "area", "radiance": {"type": "rgb", "value": [20, 20, 20]}},
    },
}


@pytest.fixture(scope="module")
def scene() -> et.Scene:
    return et.load_dict(BALL)


def test_shapes_and_types_are_as_documented(scene: et.Scene) -> None:
    result = et.render(scene, spp=4)
    assert result.image.shape == (24, 32, 3)
    assert result.image.dtype == np.dtype(np.float32)
    assert result.standard_error.shape == (24, 32, 3)
    assert result.standard_error.dtype == np.dtype(np.float32)
    assert result.samples.shape == (24, 32)
    assert result.samples.dtype == np.dtype(np.int64)
    assert (result.samples == 4).all()
    assert 0.0 < result.error.low < result.error.value < result.error.high < np.inf
    assert result.stats.paths == 4 * 24 * 32
    assert result.stats.rays > 0
    assert result.stats.shadow_rays > 0
    assert {"load", "build", "render", "estimate"} <= set(result.stats.phases)


def test_a_scene_a_dict_and_a_file_give_the_same_bits(scene: et.Scene, tmp_path: Path) -> None:
    path = tmp_path / "ball.xml"
    path.write_text(
        '<scene version="3.0.0"><integrator type="path"><integer name="max_depth" value="6"/></integrator>'
        '<sensor type="perspective"><float name="fov" value="45"/><transform name="to_world">'
        '<lookat origin="0,0,4" target="0,0,0" up="0,1,0"/></transform><film type="hdrfilm">'
        '<integer name="width" value="32"/><integer name="height" value="24"/><rfilter type="box"/></film></sensor>'
        '<shape type="sphere"><bsdf type="diffuse"/></shape>'
        '<shape type="sphere"><point name="center" x="2" y="3" z="3"/><float name="radius" value="0.5"/>'
        '<emitter type="area"><rgb name="radiance" value="20,20,20"/></emitter></shape></scene>'
    )
    images = [et.render(source, spp=4).image for source in (scene, copy.deepcopy(BALL), path, str(path))]
    for image in images[1:]:
        np.testing.assert_array_equal(image, images[0])


def test_without_limits_the_scene_s_sample_count_holds_or_64(scene: et.Scene) -> None:
    assert et.render(scene).spp == 64
    asking = copy.deepcopy(BALL)
    asking["sensor"]["sampler"] = {"type": "independent", "sample_count": 5}
    assert et.render(asking).spp == 5


def test_another_seed_is_another_image_with_the_same_meaning(scene: et.Scene) -> None:
    a, b = et.render(scene, spp=64, seed=1), et.render(scene, spp=64, seed=2)
    assert (a.image != b.image).any()
    z = (a.image - b.image) / np.hypot(a.standard_error, b.standard_error).clip(1e-30)
    # pooled errors: heavier tails than a normal, but z² has mean 1 where there is noise
    noisy = a.standard_error > 1e-4
    assert 0.8 < np.square(z[noisy]).mean() < 1.25


def test_an_odd_sample_count_is_taken_as_it_is(scene: et.Scene) -> None:
    result = et.render(scene, spp=3)
    assert (result.samples == 3).all()
    assert result.error.known


def test_one_sample_has_an_image_but_no_error(scene: et.Scene) -> None:
    result = et.render(scene, spp=1)
    assert result.image.any()
    assert not result.error.known
    assert np.isinf(result.standard_error).all()


def test_a_time_limit_holds(scene: et.Scene) -> None:
    result = et.render(scene, time=0.3)
    assert result.stopped_by == "time"
    assert 0.3 <= result.stats.seconds < 0.5


@pytest.mark.slow
def test_a_time_limit_of_ten_seconds_is_met_within_two_percent(scene: et.Scene) -> None:
    """Case E12, on a machine that has nothing else to do."""
    result = et.render(scene.with_(size=(256, 256)), time=10.0)
    assert result.stopped_by == "time"
    assert 10.0 <= result.stats.seconds < 10.2


def test_a_time_limit_shorter_than_a_pass_leaves_pixels_empty_and_says_so(scene: et.Scene) -> None:
    result = et.render(scene.with_(size=(1024, 768)), time=0.002)
    assert result.stopped_by == "time"
    assert result.samples.min() == 0
    assert not result.error.known
    assert not result.image[result.samples == 0].any()


def test_ctrl_c_stops_within_a_fifth_of_a_second_and_keeps_what_is_finished(
    scene: et.Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The fastest of three counts: until the samples end by the clock, and then without the error's estimate.

    Work after the samples is counted in seconds of the process, which the load of other processes does not change.
    """
    result, estimate, marks = Session.result, session.make_result, list[tuple[float, float]]()

    def mark() -> None:
        marks.append((time.perf_counter(), time.process_time()))

    def marked_result(self: Session, stopped_by: StoppedBy) -> et.Result:
        mark()
        return result(self, stopped_by)

    def marked_estimate(*given: Any, **named: Any) -> et.Result:
        mark()
        made = estimate(*given, **named)
        mark()
        return made

    monkeypatch.setattr(Session, "result", marked_result)
    monkeypatch.setattr(session, "make_result", marked_estimate)
    took = []
    for _ in range(3):
        marks.clear()
        _render_until_ctrl_c(scene, mark)
        mark()
        sent, ended, begun, estimated, done = marks
        took.append(ended[0] - sent[0] + begun[1] - ended[1] + done[1] - estimated[1])
    assert min(took) < 0.2


def _render_until_ctrl_c(scene: et.Scene, mark: Callable[[], None]) -> None:
    """Render until Ctrl-C, 0.4 s after the first progress; ``mark`` is called when the signal is sent."""

    def interrupt() -> None:
        mark()
        os.kill(os.getpid(), signal.SIGINT)

    timer = threading.Timer(0.4, interrupt)

    def begun(_: et.Progress) -> None:
        if not timer.ident:
            timer.start()

    result = et.render(scene.with_(size=(640, 480)), time=60.0, observer=et.Observer.of(progress=begun))
    timer.join()
    assert result.stopped_by == "interrupt"
    assert result.samples.max() >= 2


def test_other_python_threads_run_during_a_render(scene: et.Scene) -> None:
    ticks = []
    stop = threading.Event()

    def tick() -> None:
        while not stop.wait(0.005):
            ticks.append(1)

    thread = threading.Thread(target=tick)
    thread.start()
    et.render(scene, time=0.4)
    stop.set()
    thread.join()
    assert len(ticks) > 20


def test_progress_ends_at_the_target(scene: et.Scene) -> None:
    seen: list[et.Progress] = []
    et.render(scene, spp=64, observer=et.Observer.of(progress=seen.append))
    assert (seen[-1].samples, seen[-1].fraction) == (64, 1.0)
    assert [p.samples for p in seen] == sorted(p.samples for p in seen)


def test_progress_does_not_change_a_bit(scene: et.Scene) -> None:
    a, b = et.render(scene, spp=32), et.render(scene, spp=32, observer=et.Observer.of(progress=lambda progress: None))
    np.testing.assert_array_equal(a.image, b.image)


def test_numbers_of_numpy_do_as_well(scene: et.Scene, tmp_path: Path) -> None:
    result = et.render(scene, spp=np.int64(2), time=np.float32(10.0), seed=np.uint64(3), threads=np.int32(1))
    result.save(tmp_path / "a.exr")
    np.testing.assert_array_equal(result.image, et.render(scene, spp=2, seed=3).image)


def test_a_truncated_strategy_is_named_as_biased(scene: et.Scene) -> None:
    result = et.render(scene, spp=2, strategy="best,truncate=2")
    assert (result.origin.strategy, result.origin.biased) == ("best,truncate=2", True)


class FaultyRenderer:
    """The core's renderer, which claims that one sample was not a number: no scene is known that makes it so."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        self._renderer = RENDERER(*arguments, **options)

    @property
    def nonfinite(self) -> list[tuple[int, int, int]]:
        return [(5, 6, 1)] if self._renderer.counters["paths"] else []

    def __getattr__(self, name: str) -> Any:
        return getattr(self._renderer, name)


RENDERER = _core.Renderer


def test_a_sample_that_is_not_a_number_is_raised_with_what_replays_it(
    scene: et.Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(_core, "Renderer", FaultyRenderer)
    with pytest.raises(et.NonFiniteSample, match="pixel 5,6, sample 1, seed 3") as caught:
        et.render(scene, spp=8, seed=3, strategy="best,adaptive=none")
    assert isinstance(caught.value.result, et.Result)
    assert caught.value.result.stopped_by == "nonfinite"
    assert caught.value.result.spp == 2


def test_radiance_beyond_single_precision_is_refused_with_its_pixel() -> None:
    glaring = copy.deepcopy(BALL)
    glaring["lamp"] = {"type": "constant", "radiance": 3e38}
    glaring["ball"]["bsdf"]["reflectance"] = 0.9
    with pytest.raises(et.RenderError, match=r"^pixel \d+,\d+ is .*e\+38, more than an image of float32 can hold$"):
        et.render(glaring, spp=8, strategy="light")


@pytest.mark.parametrize("name", ["error", "within"])
def test_per_cent_are_not_taken_for_a_fraction(scene: et.Scene, name: str) -> None:
    with pytest.raises(ValueError, match=rf"{name}=2 is 200 %.*: did you mean 0\.02, which is 2 %\?"):
        et.render(scene, **{name: 2})
    with pytest.raises(ValueError, match=f"{name}=150 is 15000 %, and an error to be reached is below 100 %$"):
        et.render(scene, **{name: 150})


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("spp", 0),
        ("time", 0.0),
        ("time", float("nan")),
        ("seed", -1),
        ("seed", 2**64),
        ("threads", -1),
        ("backend", ""),
        ("spp", 1.5),
        ("spp", "4"),
        ("spp", True),
        ("time", "10s"),
        ("error", "2%"),
        ("seed", 1.5),
        ("threads", 1.5),
        ("within", "5%"),
        ("within", 0.0),
        ("without", "lens"),
        ("without", [1]),
        ("without", None),
        ("checkpoint_every", 0.0),
        ("checkpoint_every", "1m"),
    ],
)
def test_an_argument_out_of_range_is_refused(scene: et.Scene, name: str, value: Any) -> None:
    with pytest.raises(ValueError, match=f"{name} must be"):
        et.render(scene, **{name: value})


def test_an_image_that_the_machine_cannot_hold_is_refused(scene: et.Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "sysconf", lambda name: 1000)
    with pytest.raises(et.SceneError, match=r"320x240 pixels: .* GB of memory needed, 0\.001 GB allowed by"):
        et.render(scene.with_(size=(320, 240)), spp=2)


def test_the_cross_check_backend_agrees_on_the_mean_and_brings_its_own_error(scene: et.Scene) -> None:
    pytest.importorskip("embreex")
    check, core = et.render(scene, spp=64, backend="embreex"), et.render(scene, spp=256)
    assert (check.stopped_by, check.origin.backend, check.origin.strategy) == ("spp", "embreex", "crosscheck")
    assert 0.0 < check.error.low < check.error.value < check.error.high < np.inf
    noise = np.sqrt(sum(np.square(r.standard_error.astype(np.float64)).sum() for r in (check, core)))
    # channels share their noise: three times the variance of independent ones at most; false alarms below 1e-5
    assert abs((check.image - core.image).sum(dtype=np.float64)) < 4.4 * np.sqrt(3.0) * noise


def test_the_cross_check_backend_has_no_strategies_and_no_clock(scene: et.Scene) -> None:
    ignored = ({"threads": 1}, {"without": ["long_paths=2"]}, {"within": 0.1}, {"traps": "check"}, {"resume": "a.exr"})
    for options in ({"strategy": "bsdf", "spp": 2}, {"time": 1.0}, *ignored):
        with pytest.raises(et.StrategyError, match="embreex backend"):
            et.render(scene, backend="embreex", **options)
