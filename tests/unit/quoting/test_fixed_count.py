"""Counts that a pilot with samples of its own chooses for an error: rendered whatever the image shows, and kept."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import equaltime as et
from equaltime.cli import main
from equaltime.cli.messages import Written, bias
from equaltime.cli.render_outcome import outcome
from equaltime.film.focus import Focus
from equaltime.quoting import fixed_count
from equaltime.quoting.fixed_count import Chosen, pilot_seed
from equaltime.rendering.budget import Limits, Stop
from equaltime.rendering.job import Job
from equaltime.rendering.passes import Progress
from equaltime.rendering.render_file import read_picture
from equaltime.rendering.saved import SavedRender
from equaltime.rendering.session import Session

SCENE = Path(__file__).parents[3] / "scenes" / "cornell-box.toml"
DARK: dict[str, Any] = {"type": "scene", "sensor": {"type": "perspective"}, "ball": {"type": "sphere"}}


@pytest.fixture(scope="module")
def scene() -> et.Scene:
    return et.load(SCENE).with_(size=(24, 20), max_depth=4)


@pytest.fixture(scope="module")
def fixed(scene: et.Scene) -> et.Result:
    return et.render(scene, error=0.3, stop="fixed", threads=1)


def chosen(result: et.Result) -> Stop:
    assert result.stop is not None
    return result.stop


def count(result: et.Result) -> int:
    spp = chosen(result).spp
    assert spp is not None
    return spp


def same_moments(a: et.Result, b: et.Result) -> bool:
    assert a.moments is not None
    assert b.moments is not None
    return a.moments.tobytes() == b.moments.tobytes()


@pytest.mark.parametrize("strategy", ["best", "best,adaptive=error", "bsdf,sampler=independent"])
def test_the_image_is_the_one_of_so_many_samples(scene: et.Scene, strategy: str) -> None:
    larger = scene.with_(size=(32, 32))  # of fewer pixels none adapts
    result = et.render(larger, error=0.5, stop="fixed", strategy=strategy, seed=3, threads=1)
    assert result.stopped_by == "count"
    assert result.looks == ()
    assert same_moments(result, et.render(larger, spp=count(result), strategy=strategy, seed=3))


def test_the_same_seed_chooses_the_same_count_and_another_may_choose_another(scene: et.Scene, fixed: et.Result) -> None:
    assert count(et.render(scene, error=0.3, stop="fixed")) == count(fixed)
    assert len({count(et.render(scene, error=0.3, stop="fixed", seed=seed)) for seed in range(6)}) > 1


def test_the_count_depends_on_no_sample_of_the_image(
    scene: et.Scene, fixed: et.Result, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Another seed whose pilot has the same samples has the same count, and another image."""
    monkeypatch.setattr(fixed_count, "pilot_seed", lambda seed: pilot_seed(0))
    other = et.render(scene, error=0.3, stop="fixed", seed=77)
    assert count(other) == count(fixed)
    assert (other.image != fixed.image).any()


def test_pilots_have_seeds_that_nobody_gives() -> None:
    seeds = [*range(1000), *(2**63 + n for n in range(100)), 2**64 - 1]
    pilots = [pilot_seed(seed) for seed in seeds]
    assert len({*pilots, *seeds}) == 2 * len(seeds)
    assert all(2**32 < seed < 2**64 for seed in pilots)


def test_the_record_tells_the_rule_the_count_and_the_pilot(fixed: et.Result, tmp_path: Path) -> None:
    fixed.save(tmp_path / "a.exr")
    saved = read_picture(tmp_path / "a.exr").record
    stop = saved["stop"]
    assert stop == {
        "rule": "fixed",
        "selects": False,
        "error": 0.3,
        "spp": int(fixed.spp),
        "pilot_seed": pilot_seed(0),
        "pilot_spp": chosen(fixed).pilot_spp,
        "pilot_seconds": chosen(fixed).pilot_seconds,
    }
    assert saved["stopped_by"] == "count"
    assert saved["phases"]["stop_pilot"] == stop["pilot_seconds"] > 0.0


def test_the_record_of_a_render_that_looks_says_that_it_selects(scene: et.Scene) -> None:
    assert et.render(scene, error=0.5).record["stop"] == {"rule": "look", "selects": True, "error": 0.5}
    assert et.render(scene, error=1e-3, spp=4).record["stop"]["selects"]
    assert et.render(scene, spp=4).record["stop"] is None
    *_, last = et.progressive(scene, error=0.5)
    assert last.record["stop"]["selects"]


def test_what_was_merged_of_images_that_were_selected_says_so(scene: et.Scene, tmp_path: Path) -> None:
    files = [tmp_path / name for name in ("a.exr", "b.exr", "c.exr")]
    limits: tuple[dict[str, Any], ...] = ({"spp": 4}, {"error": 0.6}, {"spp": 4})
    for seed, (file, limit) in enumerate(zip(files, limits, strict=True)):
        et.render(scene, seed=seed, **limit).save(file)
    assert et.merge(files).record["stop"]["selects"]
    assert et.merge(files[::2]).record["stop"] is None


def test_a_render_that_was_cut_goes_on_to_the_count_that_was_chosen(
    scene: et.Scene, fixed: et.Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupt(progress: Progress) -> None:
        if progress.target == count(fixed) and progress.samples >= 8:
            raise KeyboardInterrupt

    cut = et.render(scene, error=0.3, stop="fixed", observer=et.Observer.of(progress=interrupt))
    assert cut.stopped_by == "interrupt"
    cut.save(tmp_path / "a.exr")
    monkeypatch.setattr(fixed_count, "Pilot", None)  # there must be none
    rest = et.render(scene, error=0.3, stop="fixed", resume=tmp_path / "a.exr")
    assert (rest.stopped_by, rest.stop) == ("count", cut.stop)
    assert same_moments(rest, fixed)
    rest.save(tmp_path / "a.exr")
    assert same_moments(et.render(scene, error=0.3, stop="fixed", resume=tmp_path / "a.exr"), fixed)


def test_checkpoints_have_the_count(scene: et.Scene, tmp_path: Path) -> None:
    rule = Stop("fixed", 0.1, 64, 5, 16, 1.5)
    session = Session(Job(scene=scene, strategy=et.Strategy(), threads=1, limits=Limits(spp=8), stop=rule))
    session.passes.run()
    session.result("unfinished").save(tmp_path / "a.exr")
    assert SavedRender.read(tmp_path / "a.exr").stop == rule


def test_another_error_takes_another_count(scene: et.Scene, fixed: et.Result, tmp_path: Path) -> None:
    fixed.save(tmp_path / "a.exr")
    stricter = et.render(scene, error=0.15, stop="fixed", resume=tmp_path / "a.exr")
    assert count(stricter) > count(fixed)
    assert same_moments(stricter, et.render(scene, spp=count(stricter)))


def test_an_image_that_looked_at_its_error_is_taken_up_only_where_that_decides_nothing(
    scene: et.Scene, tmp_path: Path
) -> None:
    et.render(scene, error=0.3).save(tmp_path / "a.exr")
    with pytest.raises(et.ImageError, match=r"a\.exr: cannot be resumed with a fixed count: it looked at its own"):
        et.render(scene, error=0.9, stop="fixed", resume=tmp_path / "a.exr")
    rest = et.render(scene, error=0.1, stop="fixed", resume=tmp_path / "a.exr")
    assert same_moments(rest, et.render(scene, spp=count(rest)))


def test_other_limits_end_it_too(scene: et.Scene) -> None:
    few = et.render(scene, error=0.01, spp=8, stop="fixed")
    assert (few.spp, few.stopped_by) == (8.0, "spp")
    assert count(few) > 8
    short = et.render(scene, error=1e-4, time=0.3, stop="fixed")
    assert short.stopped_by == "time"
    assert short.stats.seconds < 0.4
    assert short.stats.seconds + chosen(short).pilot_seconds < 0.6


def test_a_pilot_that_took_all_of_the_time_leaves_the_image_its_own() -> None:
    stop = Stop("fixed", 0.1, 64, 5, 16, 2.0)
    assert Chosen(stop, seconds=2.0).limits(Limits(seconds=1.0, error=0.1)) == Limits(64, 0.75)
    assert Chosen(stop, seconds=0.1).limits(Limits(32, 1.0, 0.1)) == Limits(32, 0.9)
    assert Chosen(stop, seconds=0.1).limits(Limits(error=0.1)) == Limits(64)


def test_a_time_that_is_too_short_for_a_pilot_ends_the_render_alone(scene: et.Scene) -> None:
    result = et.render(scene.with_(size=(512, 512)), error=0.1, time=0.05, stop="fixed")
    assert result.stopped_by == "time"
    assert (chosen(result).rule, chosen(result).spp) == ("fixed", None)
    assert result.record["stop"]["spp"] is None


def test_a_pilot_that_meets_no_light_says_what_to_do(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fixed_count, "_MOST_IN_THE_DARK", 16)
    pixel = et.load(SCENE).with_(size=(1, 1))
    with pytest.raises(
        et.RenderError, match=r"a pilot of 16 samples .* error of 5 %: the pilot saw no light.*give a number"
    ):
        et.render(pixel, error=0.05, stop="fixed")
    limited = et.render(pixel, error=0.05, spp=4, stop="fixed")
    assert (limited.stopped_by, limited.spp, chosen(limited).spp) == ("spp", 4.0, None)


@pytest.mark.filterwarnings("ignore:the picture is black")
def test_where_there_is_no_noise_any_count_is_enough() -> None:
    black = et.load_dict(DARK).with_(size=(8, 8))
    result = et.render(black, error=0.05, stop="fixed")
    assert (result.stopped_by, result.error.high) == ("count", 0.0)
    assert result.spp == count(result) == 8


def test_an_error_beyond_all_samples_is_refused(scene: et.Scene) -> None:
    with pytest.raises(et.RenderError, match="beyond reach"):
        et.render(scene, error=1e-8, stop="fixed")


def test_what_is_quoted_is_the_count(scene: et.Scene) -> None:
    quotes: list[et.Quote] = []
    result = et.render(scene, error=0.3, stop="fixed", observer=et.Observer.of(quoted=quotes.append))
    assert len(quotes) == 1
    assert quotes[0].spp.low == quotes[0].spp.value == quotes[0].spp.high == result.spp
    assert 0.0 < quotes[0].error.value < quotes[0].error.high <= 0.3


def test_what_is_left_out_leaves_less_for_the_noise(scene: et.Scene) -> None:
    less = et.render(scene, error=0.7, stop="fixed", without=["long_paths=2"], threads=1)
    assert less.bias is not None
    assert chosen(less).error == pytest.approx(np.sqrt(0.7**2 - less.bias.high**2))


def test_a_fixed_count_takes_an_error(scene: et.Scene, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(ValueError, match=r"^stop='fixed' takes its number of samples from an error: give error"):
        et.render(scene, spp=4, stop="fixed")
    with pytest.raises(ValueError, match=r"^stop must be one of look, fixed, found 'never'"):
        et.render(scene, error=0.5, stop="never")  # type: ignore[arg-type]
    output = tmp_path / "a.exr"
    assert main(["render", str(SCENE), "-o", str(output), "--stop", "fixed"]) == 2
    assert "Invalid value for --stop: needs an error to reach: give --error" in capsys.readouterr().err
    assert not output.exists()


def test_the_command_tells_the_count_and_its_pilot(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    command = ["render", str(SCENE), "-o", str(tmp_path / "a.exr"), "--size", "16x16", "--error", "50%"]
    assert main([*command, "--stop", "fixed", "-v"]) == 0
    said = capsys.readouterr().out
    spp = read_picture(tmp_path / "a.exr").record["stop"]["spp"]
    assert f"\nDone with the {spp} samples a pixel that a pilot chose for 50 %: error " in said
    assert ", stop_pilot " in said
    assert main([*command, "--stop", "fixed", "--resume", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["stop"]["spp"] == spp


def test_another_limit_that_ends_it_is_said_beside_the_count(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["render", str(SCENE), "-o", str(tmp_path / "a.exr"), "--size", "16x16", "--error", "50%", "--spp", "2"]
    assert main([*command, "--stop", "fixed"]) == 0
    spp = read_picture(tmp_path / "a.exr").record["stop"]["spp"]
    said = f"\nended before the {spp} samples a pixel that a pilot chose for 50 %\n"
    assert said in capsys.readouterr().out


def lit_ball(lamp: float, bsdf: dict[str, Any]) -> et.Scene:
    """Return a ball on a table under a lamp of a radius, whose power is the same for all."""
    looks = {"origin": [0, 2.4, 4], "target": [0, 0.4, 0], "up": [0, 1, 0]}
    lying = [{"rotate": {"axis": [1, 0, 0], "angle": -90}}, {"scale": 4}]
    light = {"type": "area", "radiance": 4.0 / lamp**2}
    return et.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "path", "max_depth": 6},
            "sensor": {"type": "perspective", "fov": 40, "to_world": [{"look_at": looks}]},
            "table": {"type": "rectangle", "to_world": lying, "bsdf": {"type": "diffuse"}},
            "ball": {"type": "sphere", "center": [0, 0.7, 0], "radius": 0.7, "bsdf": bsdf},
            "lamp": {"type": "sphere", "center": [-1.2, 4, 0.5], "radius": lamp, "emitter": light},
        }
    ).with_(size=(16, 16))


@pytest.mark.parametrize(
    ("lamp", "bsdf", "limits", "said"),
    [
        (0.1, "dielectric", {"error": 0.5}, True),
        (0.1, "dielectric", {"error": 0.5, "stop": "fixed"}, False),
        (0.1, "dielectric", {"error": 1e-3, "spp": 16}, False),
        (0.1, "diffuse", {"error": 0.5}, False),
        (2.5, "dielectric", {"error": 0.5}, False),
    ],
    ids=["small lamp through glass", "fixed count", "ended by its samples", "no glass", "large lamp"],
)
def test_a_stop_that_selects_says_so_where_light_may_not_have_been_met(
    lamp: float, bsdf: str, limits: dict[str, Any], said: bool
) -> None:
    result = et.render(lit_ball(lamp, {"type": bsdf}), threads=1, **limits)
    lines = [*outcome(result, Written(()), None, resumable=False)]
    assert any("favours images that have not met rare light" in line for line in lines) is said


@pytest.mark.parametrize(("end", "exact"), [("error", False), ("merge", False), ("spp", True)])
def test_caustics_are_never_called_unbiased_once_the_error_has_ended_the_render(end: str, exact: bool) -> None:
    """Samples may have met all the light at last, but the looks before that favoured dark images."""
    result = et.render(lit_ball(2.5, {"type": "diffuse"}), threads=1, error=0.5)
    met = replace(result, focus=Focus(paths=0.2, light=1.0, share=0.2), samples=result.samples + 10_000, stopped_by=end)
    assert not met.focus.rare(met.spp)
    assert (bias(met) == ["unbiased"]) is exact
    assert bias(replace(met, focus=Focus.none())) == ["unbiased"]


def test_many_samples_have_met_what_is_rare() -> None:
    focus = Focus(paths=0.2, light=1.0, share=0.01)
    assert focus.rare(999)
    assert not focus.rare(1000)
    assert not Focus.none().rare(1)
