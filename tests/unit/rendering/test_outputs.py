"""Outputs that are this renderer's own: what a pixel costs, and what each bounce brings."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import equaltime as et
from equaltime.cli.messages import left_by_interrupt
from equaltime.pricing import derive
from equaltime.pricing import output_costs as extras
from equaltime.pricing.output_costs import ALL, measure_outputs
from equaltime.rendering import session
from equaltime.rendering.passes import Progress

AOVS = "cost:rays, far:depth, seconds:time_from_rays, light:bounces"


def scene(aovs: str = AOVS, **integrator: Any) -> et.Scene:
    film = {"type": "hdrfilm", "width": 8, "height": 6, "rfilter": {"type": "box"}}
    white = {"type": "diffuse", "reflectance": 0.8}
    path = {"type": "path", "max_depth": 4} | integrator
    return et.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "aov", "aovs": aovs, "path": path},
            "sensor": {"type": "perspective", "fov": 60.0, "film": film},
            "room": {"type": "sphere", "center": [0, 0, 2], "radius": 4.0, "bsdf": {"type": "twosided", "b": white}},
            "lamp": {
                "type": "sphere",
                "center": [0, 0.3, 4],
                "radius": 0.5,
                "emitter": {"type": "area", "radiance": 5.0},
            },
        }
    )


def plain() -> et.Scene:
    return et.load_dict({"type": "scene", "sensor": {"type": "perspective"}, "sky": {"type": "constant"}}).with_(
        size=(8, 6)
    )


@pytest.fixture(scope="module")
def result() -> et.Result:
    return et.render(scene(), spp=8, seed=3)


def test_all_are_there_by_name_and_in_order(result: et.Result) -> None:
    bounces = [f"light.{number}.{letter}" for number in (1, 2, 3, 4) for letter in "RGB"]
    assert list(result.aovs) == ["cost.N", "far.T", "seconds.T", *bounces]
    assert all(plane.shape == (6, 8) and plane.dtype == np.float32 for plane in result.aovs.values())


def test_the_bounces_add_up_to_the_image(result: et.Result) -> None:
    image = [sum(result.aovs[f"light.{number}.{letter}"] for number in (1, 2, 3, 4)) for letter in "RGB"]
    np.testing.assert_allclose(np.stack(image, axis=-1), result.image, rtol=1e-5, atol=1e-7)
    assert result.aovs["light.1.R"].max() > 2.0, "the lamp"
    assert (result.aovs["light.3.R"] > 0).any()


def test_they_end_where_paths_end() -> None:
    assert "light.2.B" in (found := et.render(scene("light:bounces", max_depth=2), spp=1).aovs)
    assert "light.3.R" not in found
    assert len(et.render(scene("light:bounces", max_depth=-1), spp=1).aovs) == 48


def test_rays_are_counted_and_the_time_is_shared_out_by_them(result: et.Result) -> None:
    rays, seconds = result.aovs["cost.N"].astype(float), result.aovs["seconds.T"].astype(float)
    counted = result.stats.rays + result.stats.shadow_rays
    assert rays.sum() * 8 == pytest.approx(counted, rel=1e-6)
    assert (rays >= 1).all()
    np.testing.assert_allclose(seconds / seconds.sum(), rays / rays.sum(), rtol=1e-4)
    assert seconds.sum() == pytest.approx(result.stats.seconds * result.stats.threads, rel=1e-4)
    assert np.array_equal(et.render(scene(), spp=8, seed=3).aovs["cost.N"], result.aovs["cost.N"])


def test_ctrl_c_while_they_are_taken_loses_no_image(result: et.Result, monkeypatch: pytest.MonkeyPatch) -> None:
    def stopped(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(session, "outputs", stopped)
    found = et.render(scene(), spp=8, seed=3)
    assert (found.stopped_by, found.aovs) == ("interrupt", {})
    np.testing.assert_array_equal(found.image, result.image)


def test_after_ctrl_c_they_are_not_rendered(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    def interrupt(progress: Progress) -> None:
        if progress.samples >= 4:
            raise KeyboardInterrupt

    found = et.render(scene(), spp=100_000, seed=3, observer=et.Observer.of(progress=interrupt))
    assert (found.stopped_by, found.aovs) == ("interrupt", {})
    assert "outputs" not in found.stats.phases
    found.save(path := tmp_path / "cut.exr")
    goal = int(found.samples.max()) + 2
    whole = et.render(scene(), spp=goal, seed=3, resume=path)
    assert "far.T" in whole.aovs, "they come when the image is finished"
    (told,) = left_by_interrupt(found, scene())
    assert told.startswith("the outputs beside the image were not rendered; --resume")
    assert left_by_interrupt(whole, scene()) == []
    assert left_by_interrupt(replace(whole, stopped_by="interrupt", aovs={}), plain()) == [], "none were asked for"


def test_their_time_is_a_phase_beyond_that_of_the_render(result: et.Result, monkeypatch: pytest.MonkeyPatch) -> None:
    assert result.stats.phases["outputs"] > 0.0
    assert "outputs" not in et.render(plain(), spp=4).stats.phases
    slow = session.outputs

    def slower(*arguments: Any) -> Any:
        time.sleep(0.3)
        return slow(*arguments)

    monkeypatch.setattr(session, "outputs", slower)
    phases = et.render(scene(), spp=8, time=10.0).record["phases"]
    assert phases["outputs"] >= 0.3


def test_outputs_are_an_effect_with_a_place() -> None:
    assert [str(reason) for reason in derive(scene())["outputs"]] == ["integrator: integrator 'aov'"]


def test_a_word_that_is_near_is_proposed() -> None:
    with pytest.raises(et.SceneError, match="did you mean 'bounces'"):
        scene("light:bounce")


def test_each_has_a_price_beside_the_time_of_the_image(monkeypatch: pytest.MonkeyPatch) -> None:
    """By a clock of its own: of what takes 1, 3 and 5 hours, beside an image that takes no time, all take 9 in all."""
    hours = {"depth": 1.0, "rays": 3.0, "bounces": 5.0}
    now = 0.0

    def made(*arguments: Any) -> None:
        nonlocal now
        now += sum(3600.0 * hours[what] for _, what in arguments[-1])

    monkeypatch.setattr(extras, "perf_counter", lambda: now)
    monkeypatch.setattr(extras, "outputs", made)
    found = measure_outputs(scene("far:depth, cost:rays, light:bounces"), et.Strategy(), 4, 1, threads=1)
    expected = {"far:depth": 1.0, "cost:rays": 3.0, "light:bounces": 5.0, ALL: 9.0}
    assert {name: share.value for name, share in found.items()} == pytest.approx(
        {name: hours / 9.0 for name, hours in expected.items()}, abs=1e-3
    )


def test_the_price_list_has_them() -> None:
    found = et.effects(scene(), quick=True, threads=1)
    assert list(found.outputs) == ["cost:rays", "far:depth", "seconds:time_from_rays", "light:bounces"]
    (together,) = (price.time for price in found.prices if price.kind.name == "outputs")
    assert together is not None
    assert all(share.value > 0.0 for share in (*found.outputs.values(), together))
    assert found.as_dict()["outputs"].keys() == found.outputs.keys()
    nothing = et.load_dict({"type": "scene", "sensor": {"type": "perspective"}})
    assert measure_outputs(nothing, et.Strategy(), 3, 1) == {}
