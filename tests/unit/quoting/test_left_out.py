"""Renders that leave something out: named as biased, by an amount that is measured and in the error."""

import json
import math
import re
from pathlib import Path

import numpy as np
import pytest

import equaltime as et
from equaltime.cli import main
from equaltime.images.metrics import Reference
from equaltime.quoting import left_out
from equaltime.quoting.left_out import LeftOut, choose, measured
from equaltime.quoting.pairs import Versus, change_of, products, run_in_turn
from equaltime.scene.effects.leaving import leave_out
from equaltime.statistics.intervals import Interval

BOX = Path(__file__).parents[3] / "scenes" / "cornell-box.toml"


@pytest.fixture(scope="module")
def box() -> et.Scene:
    return et.load(BOX).with_(size=(24, 24))


@pytest.fixture(scope="module")
def within(box: et.Scene) -> LeftOut:
    return choose(box, et.Strategy(), 0.05, threads=1)


@pytest.mark.parametrize(
    ("time", "said"),
    [
        (Interval(0.12, 0.05, 0.2), "saves 12 % of the time (5 to 20)"),
        (Interval(-0.19, -0.3, 0.08), "saves no measurable time (at most 8 %)"),
        (Interval(-0.19, -0.3, -0.09), "saves no measurable time (at most 0 %)"),
    ],
)
def test_the_time_that_is_saved_has_no_negative_share(time: Interval, said: str) -> None:
    nothing = Interval(0.0, 0.0, 0.0)
    assert left_out._saved(Versus(time, nothing, nothing, 0, np.zeros((1, 1, 3)))) == said


def test_a_render_without_long_paths_says_so_and_its_error_has_the_bias(box: et.Scene) -> None:
    said: list[str] = []
    result = et.render(box, spp=16, without=["long_paths=3"], threads=1, observer=et.Observer.of(decided=said.extend))
    saves = r"(saves [\d.e+]+ % of the time \([\d.e+]+ to [\d.e+]+\)|saves no measurable time \(at most [\d.e+]+ %\))"
    assert re.fullmatch(f"without long_paths=3: {saves}", said[0]), "a busy machine measures no share"
    plain = et.render(box, spp=16, strategy="best,truncate=3", threads=1)
    assert np.array_equal(result.image, plain.image)
    assert result.origin.biased
    assert result.origin.without == ("long_paths=3",)
    assert result.bias is not None
    assert 0.15 < result.bias.low < result.bias.value < result.bias.high < 0.35
    assert result.error.value == pytest.approx(math.hypot(plain.error.value, result.bias.value))
    assert result.error.high == pytest.approx(math.hypot(plain.error.high, result.bias.high))
    assert result.record["without"] == ["long_paths=3"]
    assert result.record["bias"]["value"] == result.bias.value


@pytest.mark.parametrize(("truncate", "name"), [(3, "long_paths=3"), (5, "long_paths=3"), (3, "long_paths=5")])
def test_what_the_strategy_cuts_is_measured_with_long_paths(box: et.Scene, truncate: int, name: str) -> None:
    plain = et.render(box, spp=4, without=["long_paths=3"], threads=1)
    both = et.render(box, spp=4, strategy=f"best,truncate={truncate}", without=[name], threads=1)
    assert np.array_equal(both.image, plain.image)
    assert (both.origin, both.bias, both.error) == (plain.origin, plain.bias, plain.error)


def test_what_is_quoted_has_the_bias_too(box: et.Scene) -> None:
    quotes: list[et.Quote] = []
    result = et.render(
        box, error=0.5, without=["long_paths=3"], observer=et.Observer.of(quoted=quotes.append), threads=1
    )
    assert result.bias is not None
    assert quotes[0].error.low > result.bias.low
    assert quotes[0].error.value > result.bias.value
    assert quotes[0].error.high > result.bias.high


@pytest.mark.parametrize("samples", [1, 2, 4, 16])
def test_few_samples_measure_the_same_bias(monkeypatch: pytest.MonkeyPatch, samples: int) -> None:
    """Denominators by the same images as the differences would make it too small: by a third with one sample."""
    box = et.load(BOX).with_(size=(64, 64))
    monkeypatch.setattr(left_out, "PILOT_SAMPLES", samples * 64 * 64)
    found = [measured(box, et.Strategy(), ("long_paths=3",), seed, 1).bias for seed in range(3)]
    truth = 0.2463  # by 6 times 1600 samples a pixel, within 0.0003
    assert all(bias.low < truth < bias.high for bias in found), found
    whole, less = run_in_turn(box, et.Strategy(), {"": ("long_paths=3",)}, 6, samples, 1, 1)
    moved = less[""].images - whole.images
    alike = change_of(products(moved, moved, Reference.of_images(whole.images).denominator), samples)
    assert samples == 16 or alike.value < 0.95 * truth, "the twin: denominators that share the noise"


def test_the_measured_bias_is_that_of_a_converged_image(box: et.Scene) -> None:
    """1024 samples a pixel leave a noise far below a bias of 20 %."""
    left = measured(box, et.Strategy(), ("long_paths=3",), threads=1)
    whole, less = (
        et.render(s, spp=1024, strategy=t, seed=9).image.astype(float)
        for s, t in ((box, et.Strategy()), (left.scene, left.strategy))
    )
    truth = math.sqrt(np.mean((less - whole) ** 2 / (whole**2 + (0.1 * whole.mean()) ** 2)))
    assert left.bias.low < truth < left.bias.high
    assert not left.bias.low < 1.1 * truth < left.bias.high


def test_what_the_scene_does_not_call_for_leaves_the_render_unbiased_and_its_bits(box: et.Scene) -> None:
    said: list[str] = []
    result = et.render(
        box, spp=4, without=["lens", "textures"], threads=1, observer=et.Observer.of(decided=said.extend)
    )
    assert not result.origin.biased
    assert result.bias is None
    assert "without" not in result.record
    assert np.array_equal(result.image, et.render(box, spp=4, threads=1).image)
    assert said == ["lens: the scene does not call for it", "textures: the scene does not call for it"]


def test_within_an_error_paths_are_cut_and_the_bias_is_less(within: LeftOut) -> None:
    assert within.strategy.truncate is not None
    assert 4 <= within.strategy.truncate <= 9
    assert 0.0 < within.bias.high <= 0.05
    assert any(line.startswith("left out: paths longer than") for line in within.why)


def test_what_is_left_out_makes_half_of_the_error_asked_for_at_most(box: et.Scene) -> None:
    result = et.render(box, error=0.4, within=0.9, threads=1)
    assert result.stopped_by == "error"
    assert result.error.high <= 0.4
    assert result.bias is not None
    assert 0.1 < result.bias.high <= 0.2


def test_less_is_left_out_within_a_smaller_error(box: et.Scene, within: LeftOut) -> None:
    assert within.strategy.truncate is not None
    finer = choose(box, et.Strategy(), 0.01, threads=1)
    assert finer.strategy.truncate is None or finer.strategy.truncate > within.strategy.truncate
    assert finer.bias.high <= 0.01


def test_the_choice_is_the_same_whenever_it_is_made(box: et.Scene, within: LeftOut) -> None:
    again = choose(box, et.Strategy(), 0.05, threads=2)
    assert (again.names, again.bias) == (within.names, within.bias)


def test_an_error_below_the_bias_is_refused_before_rendering(box: et.Scene) -> None:
    with pytest.raises(et.EffectError, match="an error of 5 % cannot be reached: the effects left out make"):
        et.render(box, error=0.05, without=["long_paths"], threads=1)


def test_both_ways_of_leaving_out_are_not_asked_for_at_once(box: et.Scene) -> None:
    with pytest.raises(et.EffectError, match="not both"):
        et.render(box, spp=1, without=["lens"], within=0.01)


def test_a_biased_render_is_taken_up_with_the_same_bias_and_by_nothing_else(box: et.Scene, tmp_path: Path) -> None:
    file = tmp_path / "a.exr"
    et.render(box, spp=8, without=["long_paths=3"], threads=1).save(file)
    more = et.render(box, spp=16, without=["long_paths=3"], threads=1, resume=file)
    whole = et.render(box, spp=16, without=["long_paths=3"], threads=1)
    assert np.array_equal(more.image, whole.image)
    assert more.error == whole.error
    with pytest.raises(et.ImageError, match=r"it has strategy .*; left out long_paths=3, not nothing$"):
        et.render(box, spp=16, threads=1, resume=file)


def test_a_lens_with_blades_is_left_out_like_a_round_one(box: et.Scene) -> None:
    lens = {
        "type": "thinlens",
        "aperture_radius": 0.1,
        "focus_distance": 5.0,
        "blades": 6,
        "rotation": 20.0,
        "fov": 30.0,
    }
    scene = et.load_dict({"type": "scene", "sensor": lens, "ball": {"type": "sphere"}})
    left, _ = leave_out(scene, et.Strategy(), ("lens",))
    assert left.model.sensor.type == "perspective"
    assert left.model.sensor.fov == 30.0  # type: ignore[union-attr]


def test_merged_renders_keep_the_bias(box: et.Scene, tmp_path: Path) -> None:
    files = [tmp_path / f"{seed}.exr" for seed in range(2)]
    parts = [et.render(box, spp=8, seed=seed, without=["long_paths=3"], threads=1) for seed in range(2)]
    for part, file in zip(parts, files, strict=True):
        part.save(file)
    merged = et.merge(files)
    assert merged.bias is not None
    assert merged.bias.high == max(part.bias.high for part in parts if part.bias)
    assert merged.error.value > merged.bias.value
    assert merged.origin.without == ("long_paths=3",)


def test_the_command_line_names_the_bias(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = str(tmp_path / "out.exr")
    small = ["render", str(BOX), "-o", out, "--size", "12x12", "--spp", "4", "--threads", "1"]
    assert main([*small, "--without", "long_paths=3", "--without", "lens"]) == 0
    text = capsys.readouterr().out
    assert "lens: the scene does not call for it" in text
    assert "biased: without long_paths=3, which makes " in text
    assert main([*small, "--within", "10%", "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    assert record["biased"]
    assert record["without"][0].startswith("long_paths=")
    assert record["bias"]["high"] <= 0.1
    assert record["decisions"][0].startswith("left out: paths longer than ")
    assert record["phases"]["pilot"] > 0.0
    assert main([*small, "--without", "specular"]) == 2
    assert "cannot be left out" in capsys.readouterr().err
