"""Quotes: the law on errors that the test decides, and the command on a small scene."""

import json
import math
import re
import shlex
from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import pytest

import equaltime as et
from equaltime.cli import main
from equaltime.cli.quote_answer import Asked, answer
from equaltime.quoting import pilot
from equaltime.quoting.law import fit
from equaltime.quoting.noise_light import NoiseLight
from equaltime.statistics.intervals import Interval

SCENE = Path(__file__).parents[3] / "scenes" / "cornell-box.toml"
NO_SHARES: Mapping[str, Interval] = MappingProxyType({})


def observed(exponent: float, doubt: float, counts: tuple[int, ...] = (2, 4, 8)) -> dict[int, Interval]:
    factor = math.exp(1.96 * doubt)
    return {n: Interval(n**-exponent, n**-exponent / factor, n**-exponent * factor) for n in counts}


@pytest.mark.parametrize("exponent", [0.5, 0.55, 0.6])
def test_the_law_is_found_again(exponent: float) -> None:
    counts = (2, 4, 8, 16, 32, 64)
    law = fit(observed(exponent, 0.001, counts), {n: 0.1 * n for n in counts}, "sobol")
    assert abs(law.exponent - exponent) < 0.05
    low, high = law.error_at(1000).low, law.error_at(1000).high
    assert low < 1000**-exponent < high
    assert law.seconds_per_sample == pytest.approx(0.1)


def test_a_rough_pilot_leaves_the_exponent_to_what_is_known_of_the_sampler() -> None:
    law = fit(observed(0.9, 0.3), {2: 1.0, 4: 2.0, 8: 3.0}, "sobol")
    assert 0.55 < law.exponent < 0.7


def test_independent_samples_have_their_exponent_whatever_the_pilot_shows() -> None:
    law = fit(observed(0.7, 0.05), {2: 1.0, 4: 2.0, 8: 3.0}, "independent")
    assert law.exponent == pytest.approx(0.5, abs=0.01)


def test_the_time_without_the_start_is_what_a_sample_costs() -> None:
    counts = (2, 4, 8)
    law = fit(observed(0.5, 0.05), {n: 3.0 + 0.5 * n for n in counts}, "sobol")
    assert law.seconds_per_sample == pytest.approx(0.5)


def test_the_farther_the_target_the_wider_the_interval() -> None:
    law = fit(observed(0.55, 0.02, (2, 4, 8, 16)), {n: 0.1 * n for n in (2, 4, 8, 16)}, "sobol")
    widths = [law.samples_until(error) for error in (0.1, 0.05, 0.01)]
    ratios = [estimate.high / estimate.low for estimate in widths]
    assert ratios == sorted(ratios)
    assert all(estimate.low < estimate.value < estimate.high for estimate in widths)


def test_a_quote_holds_what_the_render_then_takes() -> None:
    scene = et.load(SCENE).with_(size=(96, 96))
    quote = et.quote(scene, error=0.1)
    result = et.render(scene, error=0.1)
    assert quote.spp.low <= result.spp <= quote.spp.high
    assert quote.error.low <= result.error.value <= quote.error.high


@pytest.mark.parametrize("spp", [2, 4, 6])
def test_fewer_samples_than_the_pilots_have_a_larger_error(spp: int) -> None:
    """The pilot has 8 samples a pixel, and 4 have one and a half times its error."""
    scene = et.load(SCENE).with_(size=(96, 96))
    quote, result, pilots = (et.quote(scene, spp=spp), et.render(scene, spp=spp), et.quote(scene, spp=8))
    assert quote.error.low <= result.error.value <= quote.error.high
    assert quote.error.value > 1.1 * pilots.error.value
    assert quote.spp == Interval(spp, spp, spp)


def test_one_sample_has_no_error(capsys: pytest.CaptureFixture[str]) -> None:
    scene = et.load(SCENE).with_(size=(48, 48))
    assert not et.quote(scene, spp=1).error.known
    assert main(["quote", str(SCENE), "--size", "48x48", "--spp", "1"]) == 0
    first = capsys.readouterr().out.splitlines()[0]
    assert first.startswith("With 1 sample a pixel: no error can be known: it takes 2 samples a pixel, which take ")


@pytest.mark.parametrize("spp", [26, 82])
def test_a_quote_tells_the_samples_that_adaptive_counts_take(spp: int) -> None:
    """Adaptive counts are 26.3 and 83.2 samples a pixel here; even ones are those ordered."""
    scene = et.load(SCENE).with_(size=(64, 64))
    quote, result = et.quote(scene, spp=spp, seed=1), et.render(scene, spp=spp, seed=1)
    assert result.spp > spp + 0.1
    assert quote.spp.value == pytest.approx(result.spp, rel=1e-3)
    assert quote.spp.low <= result.spp <= quote.spp.high <= quote.spp.low + 2.0
    even = et.quote(scene, spp=82, strategy="best,adaptive=none")
    assert even.spp == Interval(82.0, 82.0, 82.0)


def test_a_quote_of_a_caustic_says_that_it_is_in_doubt(capsys: pytest.CaptureFixture[str]) -> None:
    scene = SCENE.parent / "experiments" / "caustic.toml"
    assert main(["quote", str(scene), "--error", "99%", "--size", "48x48"]) == 0
    assert "small bright emitters reach the image by way of " in " ".join(capsys.readouterr().out.split())


def test_a_quote_of_a_time_says_the_error() -> None:
    quote = et.quote(et.load(SCENE).with_(size=(48, 48)), time=2.0)
    assert quote.seconds == Interval(2.0, 2.0, 2.0)
    assert quote.error.low < quote.error.value < quote.error.high
    assert quote.pilot_seconds < 2.0


def test_a_quote_of_a_sample_count_says_the_error_and_the_time(capsys: pytest.CaptureFixture[str]) -> None:
    scene = et.load(SCENE).with_(size=(48, 48))
    found, more = et.quote(scene, spp=64), et.quote(scene, spp=4096)
    assert 64.0 <= found.spp.low <= found.spp.high <= 66.0  # adaptive counts: a mean of a little more
    assert found.error.low <= et.render(scene, spp=64).error.value <= found.error.high
    assert more.error.high < found.error.low
    assert found.seconds.high < more.seconds.low
    assert main(["quote", str(SCENE), "--size", "32x24", "--spp", "64", "--error", "20%"]) == 0
    first, second = capsys.readouterr().out.splitlines()[:2]
    assert first.startswith("With 64 samples a pixel: error ")
    assert second.startswith("Error surely below 20 % after ")


def test_an_error_that_is_asked_for_is_not_quoted_to_be_exceeded() -> None:
    found = et.quote(et.load(SCENE).with_(size=(24, 24)), error=0.05, why=False).error
    assert found.low < found.value < found.high <= 0.05


@pytest.mark.parametrize("limit", [{"time": np.float32(0.1)}, {"time": Fraction(1, 10)}, {"error": np.float32(0.2)}])
def test_quotes_of_any_kind_of_number_are_json(limit: dict[str, Any]) -> None:
    found = et.quote(et.load(SCENE).with_(size=(8, 8)), why=False, **limit)
    data = json.loads(json.dumps(found.as_dict()))
    for name in ("seconds", "spp", "error", "memory"):
        said = getattr(found, name)
        assert Interval.from_dict(data[name]) == said
    assert [Interval.from_dict(price["seconds"]) for price in data["prices"]] == [*found.prices.values()]


def test_what_is_quoted_is_printed_in_its_own_unit() -> None:
    quote = et.quote(et.load(SCENE).with_(size=(24, 24)), error=0.3)
    first, *prices = str(quote).splitlines()
    assert f"{quote.error:%}" in first
    assert first.endswith(f" after {quote.seconds:s}, {quote.spp:spp}, {quote.memory:MB} of memory")
    assert f"surely below 5 % after {quote.prices[0.05]:s}" in prices


def test_a_quote_of_nothing_is_of_thirty_seconds_and_one_of_both_ends_at_the_first() -> None:
    small = et.load(SCENE).with_(size=(8, 8))
    assert et.quote(small, why=False).seconds == Interval(30.0, 30.0, 30.0)
    assert et.quote(small, error=0.3, time=1e4, why=False).seconds.high < 1e4


@pytest.mark.parametrize(
    ("name", "value"),
    [
        *(("error", value) for value in (0.0, -1.0, math.nan, math.inf, "2%")),
        *(("time", value) for value in (0.0, -1.0, math.nan, math.inf, "10s")),
        *((name, value) for name in ("seed", "threads") for value in (-1, 1.5)),
    ],
)
def test_an_argument_out_of_range_is_refused(name: str, value: Any) -> None:
    target = {} if name == "time" else {"error": 0.1}
    with pytest.raises(ValueError, match=f"{name} must be"):
        et.quote(et.load(SCENE).with_(size=(8, 8)), **{**target, name: value})


def test_per_cent_are_not_taken_for_a_fraction(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(ValueError, match=r"error=2 is 200 %.*: did you mean 0\.02, which is 2 %\?"):
        et.quote(et.load(SCENE).with_(size=(8, 8)), error=2)
    assert main(["quote", str(SCENE), "--error", "2"]) == 2
    assert "'2' is 200 %; did you mean 2%?" in capsys.readouterr().err


def test_a_scene_without_light_is_surely_black() -> None:
    dark = {"type": "scene", "sensor": {"type": "perspective"}, "ball": {"type": "sphere"}}
    with pytest.raises(et.RenderError, match="surely black"):
        et.quote(et.load_dict(dark).with_(size=(8, 8)), error=0.1)


def test_a_single_pixel_cannot_be_quoted_nor_rendered_to_an_error_alone() -> None:
    pixel = et.load(SCENE).with_(size=(1, 1))
    with pytest.raises(et.RenderError, match="few pixels"):
        et.quote(pixel, error=0.1)
    for asked in (et.render, et.progressive):
        with pytest.raises(et.RenderError, match="a single pixel cannot be known"):
            asked(pixel, error=0.1)
    assert et.render(pixel, spp=16, error=0.1).stopped_by == "spp"


def test_a_scene_without_noise_says_so() -> None:
    film = {"type": "hdrfilm", "rfilter": {"type": "box"}}
    sky = {"type": "scene", "sensor": {"type": "perspective", "film": film}, "sky": {"type": "constant"}}
    with pytest.raises(et.RenderError, match="saw no noise"):
        et.quote(et.load_dict(sky).with_(size=(8, 8)), error=0.1)


def test_the_nearest_limit_is_quoted() -> None:
    quotes: list[et.Quote] = []
    et.render(et.load(SCENE).with_(size=(24, 24)), spp=40, error=1e-4, observer=et.Observer.of(quoted=quotes.append))
    assert quotes[0].spp.value == 40.0
    assert quotes[0].error.value > 1e-3


def test_the_command_prints_intervals_with_plain_brackets(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["quote", str(SCENE), "--error", "20%", "--size", "32x32", "--why", "-v"]) == 0
    printed = capsys.readouterr().out
    assert " % (" in printed
    assert "\\" not in printed
    assert "-" not in re.findall(r"which light +(.)", printed)


def test_a_doubt_stands_in_the_second_line() -> None:
    found, asked = et.quote(et.load(SCENE).with_(size=(32, 32)), error=0.3, why=False), Asked(None, 0.3)
    first, second, *_ = answer(replace(found, error=found.error.doubted("rare light")), asked)
    assert (first[:12], second) == ("Error surely", "in doubt: rare light")
    assert not any(line.startswith("in doubt") for line in answer(found, asked))


def test_light_that_the_camera_sees_falls_on_no_surface() -> None:
    """A lamp's edge makes noise that no surface has scattered: 58 % of it "fell on straight into the camera"."""
    found = et.quote(et.load(SCENE).with_(size=(32, 32)), error=0.3, why=False)

    def told(seen: float, off: float = 0.0, doubt: str = "") -> str:
        shares = (("seen", seen), ("lit", 0.8 - seen))
        part = {name: Interval(share, share - off, share + off) for name, share in shares}
        kinds = {"light": {}, "surface": {"none": part["seen"], "floor": part["lit"], "box": Interval(0.2, 0.2, 0.2)}}
        light = NoiseLight(part["seen"], part["lit"], *[Interval(0.2, 0.2, 0.2)] * 4, kinds, (32, 32), 8, 8)
        lines = answer(replace(found, light=replace(light, doubt=doubt)), Asked(None, 0.3))
        return next(line for line in lines if line.startswith("Which light makes it: "))

    edges = "light seen by the camera is noisy at the edges of lamps and sky, where only more samples help"
    assert told(0.58).endswith(
        f": seen by the camera 58 %, direct 22 %, indirect 20 %; {edges}; falling on floor 22 %, box 20 %"
    )
    assert told(0.1).endswith(": direct 70 %, indirect 20 %, seen by the camera 10 %; falling on floor 70 %, box 20 %")
    assert "seen by the camera 58 %" in told(0.58, 0.3), "a wide interval without a doubt"
    assert told(0.58, 0.2, "few paths").endswith("(in doubt, see -v)")
    assert told(0.58, 0.3, "few paths").endswith("it: a few bright samples make too much of it to tell (see -v)")


def test_a_wide_interval_is_told_with_the_way_to_a_closer_one() -> None:
    """Quotes for different limits have tests of different lengths, and so differ within their intervals."""
    found = et.quote(et.load(SCENE).with_(size=(32, 32)), error=0.3, why=False)

    def last(low: float, high: float, error: float | None = 0.3, seconds: float = 1.0) -> str:
        prices = {0.01: Interval(20.0, low, high)}
        return answer(replace(found, prices=prices, pilot_seconds=seconds), Asked(None, error))[-1]

    closer = "This quote took 1 s; --error 1% predicts more closely, by a longer test; -v tells more."
    assert last(10.0, 41.0) == last(10.0, 41.0, None) == closer
    plain = "This quote took 1 s; -v tells more."
    assert last(10.0, 40.0) == last(10.0, 41.0, 0.01) == plain
    assert last(10.0, 41.0, seconds=10.0) == plain.replace("1 s", "10 s")


def test_shares_of_light_sum_to_all_of_the_noise() -> None:
    found = et.quote(et.load(SCENE).with_(size=(32, 32)), error=0.3, why=True)
    light = found.light
    assert light is not None

    def told(direct: float, indirect: float, surfaces: Mapping[str, Interval] = NO_SHARES) -> str:
        shares = [Interval(share, share, share) for share in (direct, indirect, 1.0 - direct - indirect)]
        named = dict(zip(("direct", "indirect", "seen"), shares, strict=True))
        changed = replace(light, kinds={**light.kinds, "light": {}, "surface": surfaces}, doubt="", **named)
        (line,) = [line for line in answer(replace(found, light=changed), Asked(None, 0.3)) if line.startswith("Which")]
        return line.removeprefix("Which light makes it: ")

    assert told(0.93, 0.05) == "direct 93 %, indirect 5 %, the rest 2 %"
    assert told(0.39, 0.60) == "indirect 60 %, direct 39 %"  # as far as rounding goes
    assert told(0.97, 0.01) == "direct 97 %, the rest 3 %"
    assert told(1.2, -0.3) == "direct 100 %, seen by the camera 10 %"
    parts = {"medium": Interval(0.2, 0.1, 0.3), "shape 3: floor (/tmp/scene.toml:12)": Interval(0.8, 0.7, 0.9)}
    assert told(0.97, 0.01, parts) == "direct 97 %, the rest 3 %; falling on floor 80 %, a medium 20 %"


def test_the_record_of_a_render_has_its_quote_or_why_there_is_none(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def record(*limits: str) -> Any:
        assert main(["render", str(SCENE), "-o", str(tmp_path / "a.exr"), "--size", "24x24", "--json", *limits]) == 0
        return json.loads(capsys.readouterr().out)

    quoted, unquoted = record("--error", "40%"), record("--error", "40%", "--spp", "1")
    assert quoted["quote"]["spp"]["low"] <= quoted["spp"]
    assert "unquoted" not in quoted
    assert "ended before" in unquoted["unquoted"]
    assert "quote" not in unquoted


def test_the_command_prints_json(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["quote", str(SCENE), "--error", "20%", "--size", "32x32", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert {"seconds", "error", "spp", "memory", "law"} <= set(found)
    assert found["seconds"]["low"] < found["seconds"]["value"] < found["seconds"]["high"]


def test_the_command_says_of_which_paths_the_noise_is(capsys: pytest.CaptureFixture[str]) -> None:
    command = ["quote", str(SCENE), "--error", "30%", "--size", "16x16", "--no-why"]
    assert main(command) == 0
    whole = capsys.readouterr().out
    assert whole.startswith("Error surely below 30 % after ")
    assert "the scene asks" not in whole
    for option, words in (
        (["--max-depth", "2"], "the scene asks"),
        (["--strategy", "best,truncate=2"], "biased: best,truncate=2; the scene asks"),
    ):
        assert main([*command, *option]) == 0
        cut = capsys.readouterr().out
        assert cut.startswith("Noise of paths up to depth 2 surely below 30 % after ")
        assert cut.splitlines()[1].startswith(f"{words} for paths up to depth 30: ")


@pytest.mark.parametrize(
    ("asked", "first", "second"),
    [
        ([], "In 30 s: error ", "How long until"),
        (["--time", "2s"], "In 2 s: error ", "How long until"),
        (["--error", "20%"], "Error surely below 20 % after ", "How long until"),
        (["--time", "2s", "--error", "20%"], "In 2 s: error ", "Error surely below 20 % after "),
    ],
)
def test_the_command_answers_first_and_in_twelve_lines(
    capsys: pytest.CaptureFixture[str], asked: list[str], first: str, second: str
) -> None:
    assert main(["quote", str(SCENE), "--size", "16x16", *asked]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) <= 12
    assert lines[0].startswith(first)
    assert lines[1].startswith(second)
    rows = [line for line in lines if re.match(r" +\d+ %  ", line)]
    assert [line.split()[0] for line in rows] == ["10", "5", "2", "1"]
    units = re.compile(r"(under )?[\d.,]+ (ms|s|min|h|days)( \([\d.,]+ to [\d.,]+\))?  ")
    assert all(units.match(line[10:]) for line in rows)


def test_a_quote_for_few_samples_is_of_the_render_itself_and_says_so(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    output = str(tmp_path / "a.exr")
    for spp, same in ((4, True), (8, True), (64, False)):
        words = ["--size", "32x32", "--seed", "7", "--spp", str(spp)]
        assert main(["quote", str(SCENE), *words, "--no-why"]) == 0
        quoted, second, *_ = capsys.readouterr().out.splitlines()
        assert second.startswith("this quote has rendered these samples: ") == same
        assert main(["render", str(SCENE), "-o", output, *words, "--overwrite"]) == 0
        rendered = capsys.readouterr().out
        before, after = (
            float(text.rpartition("error ")[2].split()[0]) for text in (quoted, rendered.rpartition("Done")[2])
        )
        assert after == pytest.approx(before, rel=0.01 if spp == 8 else 0.25), "all of the pilot's samples, or some"


def test_a_quote_of_a_slow_scene_is_from_two_samples_a_pixel_and_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pilot, "USUAL_SECONDS", 1e-9)
    found = et.quote(et.load(SCENE).with_(size=(24, 24)), time=10.0)
    assert found.law.samples == 2
    assert "2 samples a pixel may be far off" in found.error.doubt


def test_ctrl_c_keeps_what_a_pilot_has_seen(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    ended = pilot.Pilot.pass_ended

    def interrupted(watched: pilot.Pilot) -> et.Quote | None:
        ended(watched)
        if watched.taken >= 4 * 16 * 16:
            raise KeyboardInterrupt
        return None

    monkeypatch.setattr(pilot.Pilot, "pass_ended", interrupted)
    assert main(["quote", str(SCENE), "--size", "16x16"]) == 130
    told = capsys.readouterr().out
    assert told.startswith("In 30 s: error ")
    assert "interrupted: the quote is from the 4 samples a pixel until then" in told


def test_a_render_to_an_error_quotes_it_first(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    output = str(tmp_path / "a.exr")
    assert main(["render", str(SCENE), "-o", output, "--error", "25%", "--size", "32x32"]) == 0
    printed = capsys.readouterr()
    assert printed.out.startswith("Expect error ")
    assert "\nReached 25 %: error " in printed.out


LENS = SCENE.parent / "experiments" / "lens.toml"


def test_a_quote_without_an_effect_holds_what_the_render_without_it_then_states() -> None:
    scene = et.load(LENS).with_(size=(48, 48))
    quote = et.quote(scene, error=0.2, without=["lens"], why=False)
    result = et.render(scene, error=0.2, without=["lens"])
    assert quote.bias == result.bias
    assert quote.origin.without == result.origin.without == ("lens",)
    assert quote.spp.low <= result.spp <= quote.spp.high
    assert quote.error.low <= result.error.value <= quote.error.high
    assert quote.as_dict()["without"] == ["lens"]
    assert quote.as_dict()["bias"] == result.record["bias"]


def test_prices_without_an_effect_are_of_the_noise_that_the_bias_leaves() -> None:
    scene = et.load(SCENE).with_(size=(32, 32))
    quote = et.quote(scene, spp=1024, without=["long_paths=6"], why=False)
    assert quote.bias is not None
    assert 0.03 < quote.bias.low < quote.bias.high < 0.1
    assert quote.prices.keys() & {0.1, 0.02, 0.01} <= {0.1}
    lines = answer(quote, Asked(None, None, 1024, ("long_paths=6", "lens")))
    assert re.fullmatch(r"biased: without long_paths=6, which makes [\d.]+ % \(.*\) of it; noise alone: .*", lines[1])
    assert lines[2] == "lens: the scene does not call for it"
    told = {line.split()[0]: line for line in lines if line.startswith("  ")}
    assert "not surely; noise alone: " in told["1"]
    assert "not surely" not in told["10"]


def test_the_command_quotes_without_an_effect_and_hands_on_the_render(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "a lens.toml").write_text(LENS.read_text())
    monkeypatch.chdir(tmp_path)
    words = ["--error", "30%", "--without", "lens", "-D", "focus=100"]
    assert main(["quote", "a lens.toml", "--size", "32x32", "--no-why", *words]) == 0
    *_, told = capsys.readouterr().out.splitlines()
    command = shlex.split(told.removeprefix("to render it: "))
    options = ["--error", "30%", "--size", "32x32", "-D", "focus=100", "--without", "lens", "--seed", "0"]
    assert command == ["equaltime", "render", "a lens.toml", "-o", "a lens.exr", *options]
    assert main([*command[1:], "--quiet"]) == 0


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--without", "lense"], "unknown effect 'lense'; did you mean 'lens'?"),
        (
            ["--without", "long_paths=3", "--error", "5%"],
            "an error of 5 % cannot be reached: the effects left out make",
        ),
    ],
)
def test_a_quote_without_an_effect_has_the_errors_of_the_render(
    words: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["quote", str(SCENE), "--size", "24x24", *words]) == 2
    assert said in capsys.readouterr().err
