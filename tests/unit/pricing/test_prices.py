"""The price list of effects: what is told of each, of which part of the picture, and how it is printed."""

import json
import shlex
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

import equaltime as et
from equaltime.cli import main
from equaltime.cli.effects_table import print_effects
from equaltime.cli.messages import MOST_LINES, softer_sun
from equaltime.images import image_files as images
from equaltime.pricing import Price, PriceList
from equaltime.quoting.light_parts import KINDS_OF_PARTS
from equaltime.quoting.pairs import Renders, Versus
from equaltime.scene.effects.kinds import KINDS, Reason
from equaltime.statistics.intervals import Interval

from ..scene.test_effects import CHECKED, ROOT, scene

RENDER = "equaltime render b.toml -o b.exr"
OFF = "it is then off by at most"
NONE = "Leave all effects in: for a picture off by at most 10 %, none surely saves 5 % of the time to the same error."


def test_the_price_list_tells_what_is_called_for_and_what_is_free(capsys: pytest.CaptureFixture[str]) -> None:
    box = str(ROOT / "scenes" / "cornell-box.toml")
    assert main(["effects", box, "--quick", "--size", "16x16", "--threads", "1", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    (paths,) = found["effects"]
    assert paths["name"] == "long_paths"
    assert paths["time"]["value"] < 1.0
    assert paths["change"]["low"] > 0.2
    assert set(found["free"]) == KINDS.keys() - {"long_paths"}
    for shares in found["shares"].values():
        assert sum(share["value"] for share in shares.values()) == pytest.approx(1.0)


def test_a_folder_that_cannot_be_written_is_told_before_anything_is_measured(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setattr(import_module("equaltime.cli.effects"), "measure_effects", lambda *_: pytest.fail("measured"))
    box = str(ROOT / "scenes" / "cornell-box.toml")
    assert main(["effects", box, "-o", str(tmp_path / "file")]) == 2
    assert "file: File exists" in capsys.readouterr().err


def test_what_appears_where_all_was_black_is_a_change_of_unknown_size() -> None:
    dark = Renders(np.zeros((4, 2, 2, 3)), 1, np.ones(4), 0)
    found = Versus.of(dark, Renders(np.ones((4, 2, 2, 3)), 1, np.ones(4), 0)).change
    assert np.isnan(found.value), "unknown"
    assert (found.high, found.trusted) == (np.inf, False)
    assert Versus.of(dark, dark).change.high == 0.0


def test_the_prices_are_those_of_the_crop_window() -> None:
    cut = scene(CHECKED).with_(crop=(3, 2, 7, 4))
    (texture,) = (price for price in et.effects(cut, quick=True).prices if price.kind.name == "textures")
    assert texture.difference is not None
    assert texture.difference.shape == (4, 7, 3)


def test_rare_light_leaves_shares_of_the_noise_in_doubt_and_even_noise_does_not(
    capsys: pytest.CaptureFixture[str],
) -> None:
    """The box at 8 samples has edges of its lamp; a lamp that is alone in a grey room has no rare light."""
    box = str(ROOT / "scenes" / "cornell-box.toml")
    assert main(["effects", box, "--quick", "--size", "16x16", "--max-depth", "3", "-v"]) == 0
    assert "shares of the noise are in doubt: heavy tail" in capsys.readouterr().out
    assert main(["effects", box, "--quick", "--size", "16x16", "--max-depth", "3"]) == 0
    assert "(shares of the noise are in doubt, see -v)" in capsys.readouterr().out
    lamp = {"type": "constant", "radiance": 1.0}
    ball = {"type": "sphere", "center": [0.0, 0.0, 6.0], "radius": 4.0}
    film = {"type": "hdrfilm", "width": 16, "height": 16}
    even = et.load_dict({"type": "scene", "camera": {"type": "perspective", "film": film}, "sky": lamp, "ball": ball})
    assert et.effects(even, quick=True).doubt == ""


def test_the_price_list_is_printed_and_pictures_show_what_changes(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    box = str(ROOT / "scenes" / "cornell-box.toml")
    assert main(["effects", box, "--quick", "--size", "8x8", "--threads", "1", "-o", str(tmp_path / "out")]) == 0
    short = capsys.readouterr().out.splitlines()
    assert short[0].startswith("What makes cornell-box.toml slow: first of all long_paths (light that was ")
    assert short[1].startswith(
        (
            "For a picture off by at most 10 %, you save most without long_paths=",
            NONE,
        )
    )
    assert len(short) <= MOST_LINES
    assert main(["effects", box, "--quick", "--size", "8x8", "--threads", "1", "-v"]) == 0
    text = capsys.readouterr().out
    assert f"long_paths: light that was scattered more than once, for {box}:" in text
    assert "free, since the scene does not use them: analytic_shapes, " in text
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == [
        "without-long_paths.exr",
        "without-long_paths.png",
    ]
    assert images.read(tmp_path / "out" / "without-long_paths.exr").image.max() < 1e-6
    assert "the scene asks for" not in text


def test_a_share_that_is_not_above_zero_is_none_and_large_memory_is_in_mb(capsys: pytest.CaptureFixture[str]) -> None:
    reasons = (Reason("", "the scene as a whole"),)
    prices = (
        Price(
            KINDS["textures"],
            reasons,
            "their means",
            time=Interval(-0.04, -0.2, 0.12),
            variance=Interval(0.34, 0.3, 0.38),
            change=Interval(0.01, 0.009, 0.011),
            memory=25_207_000,
        ),
        Price(KINDS["principled"], reasons, None, variance=Interval(0.9, 0.8, 1.0)),
    )
    lengths = {"1": Interval(0.2, 0.1, 0.3), "2 and more": Interval(0.8, 0.7, 0.9)}
    surfaces = {"diffuse": Interval(0.7, 0.6, 0.8), "none": Interval(0.3, 0.2, 0.4)}
    shares = {
        "length": lengths,
        "way": {},
        "bsdf": surfaces,
        "surface": {"shape 3: floor (/tmp/a/b.toml:9)": Interval(0.7, 0.6, 0.8), "medium": Interval(0.3, 0.2, 0.4)},
        "light": {"light 0: sun (/tmp/a/b.toml:3)": Interval(0.6, 0.5, 0.7)},
    }
    found = PriceList(prices, ("lens", "media"), shares, {}, {}, (8, 8), 8, 6, "best", 0, -1, -1)
    print_effects(found, "b.toml", RENDER, verbose=False)
    lines = capsys.readouterr().out.splitlines()
    first, then = lines[0].split(". ")
    assert first.startswith("What makes b.toml slow: first of all principled")
    assert first.endswith(", 90 % ±10 of the noise; it cannot be left out")
    assert then == "Of what can be, first textures, 34 % ±4 of the noise."
    said = (
        "For a picture off by at most 10 %, you save most without textures: 34 % ±4 of the noise; it is then off by at"
    )
    assert lines[1] == f"{said} most 1.1 %: {RENDER} --without textures"
    assert lines[3].split() == ["textures", *["none", "measurable", "34", "%", "±4", "25", "MB", "1", "%", "±0.1"]]
    assert lines[4] == "none measurable: the lower end of the 95 % interval is 0 or less."
    assert "Always there: principled (90 % ±10 of the noise)." in lines
    assert "Noise: seen by the camera 20 % ±10; falling on floor (b.toml:9) 70 % ±10, a medium 30 % ±10." in lines
    assert lines[-1] == (
        "Measured at 8x8; shares differ at other sizes (--size). 2 other effects cost nothing here. -v shows reasons, "
        "places and all shares."
    )
    print_effects(found, "b.toml", RENDER, verbose=True)
    told = capsys.readouterr().out
    assert told.count("none measurable: the lower end of") == 1
    assert "(2: direct light): 1: 20 % ±10; 2 and more: 80 % ±10" in told
    assert (
        "by the BSDF that the light of a source falls on: diffuse 70 % ±10; straight into the camera 30 % ±10" in told
    )


@pytest.mark.parametrize(
    ("costs", "answer"),
    [
        ((0.2, 0.1), "What makes b.toml slow: first of all textures, 20 % ±2 of the noise."),
        ((None, 0.1), "it cannot be left out. Nothing that can be has a measurable cost."),
        ((None, None), "no effect has a measurable cost (the lower end of every 95 % interval is 0 or less)."),
    ],
)
def test_the_answer_names_the_costliest_effect_and_whether_it_can_be_left_out(
    costs: tuple[float | None, float | None], answer: str, capsys: pytest.CaptureFixture[str]
) -> None:
    reasons = (Reason("", "the scene as a whole"),)
    removable, fixed = (None if cost is None else Interval(cost, 0.9 * cost, 1.1 * cost) for cost in costs)
    prices = (
        Price(KINDS["textures"], reasons, "their means", variance=removable),
        Price(KINDS["principled"], reasons, None, variance=fixed),
    )
    shares: dict[str, dict[str, Interval]] = {kind: {} for kind in KINDS_OF_PARTS}
    print_effects(
        PriceList(prices, (), shares, {}, {}, (8, 8), 8, 6, "best", 0, -1, -1), "b.toml", RENDER, verbose=False
    )
    assert capsys.readouterr().out.splitlines()[0].endswith(answer)


@pytest.mark.parametrize(("share", "told"), [(0.8, True), (0.3, False)])
def test_much_noise_of_point_lights_has_a_hint(share: float, told: bool, capsys: pytest.CaptureFixture[str]) -> None:
    reasons = (Reason("", "the scene as a whole"),)
    price = Price(KINDS["point_lights"], reasons, None, variance=Interval(share, share - 0.1, share + 0.1))
    shares: dict[str, dict[str, Interval]] = {kind: {} for kind in KINDS_OF_PARTS}
    print_effects(
        PriceList((price,), (), shares, {}, {}, (8, 8), 8, 6, "best", 0, -1, -1), "b.toml", RENDER, verbose=False
    )
    assert ("A larger, softer light" in capsys.readouterr().out.splitlines()[0]) == told


@pytest.mark.parametrize(("share", "lit"), [(0.97, 0.79), (0.97, 0.3), (0.9, 0.79)])
def test_where_all_light_meets_the_costliest_effect_the_answer_names_the_light(
    share: float, lit: float, capsys: pytest.CaptureFixture[str]
) -> None:
    """Every material of a glTF file is a principled BSDF, which no option leaves out."""
    about = Interval(share, share - 0.01, share + 0.01)
    price = Price(KINDS["principled"], (Reason("", "the scene as a whole"),), None, variance=about)
    shares: dict[str, dict[str, Interval]] = {kind: {} for kind in KINDS_OF_PARTS}
    sun, rest = (Interval(part, part - 0.02, part + 0.02) for part in (lit, 1.0 - lit))
    shares["light"] = {"light 1: sun (/tmp/a.glb)": sun, "environment": Interval(0.21, 0.19, 0.23)}
    shares["surface"] = {"shape 2: table (/tmp/a.glb)": sun, "shape 3: ball (/tmp/a.glb)": rest}
    found = PriceList((price,), (), shares, {}, {}, (8, 8), 8, 6, "best", 0, -1, -1)
    print_effects(found, "a.glb", RENDER, verbose=False)
    first = capsys.readouterr().out.splitlines()[0]
    principled = f"principled (the principled model), {100 * share:.3g} % ±1 of the noise"
    if share == 0.9:
        assert first.startswith(f"What makes a.glb slow: first of all {principled}; it cannot be left out. ")
    elif lit == 0.79:
        light = "the light of sun, 79 % ±2 of the noise; and light that falls on table, 79 % ±2 of the noise"
        assert first.startswith(f"What makes a.glb slow: first of all {light}. {principled}, cannot be left out. ")
    else:
        light = "light that falls on ball, 70 % ±2 of the noise"
        assert first.startswith(f"What makes a.glb slow: first of all {light}. {principled}, cannot be left out. ")


def test_the_hint_names_the_option_that_makes_the_sun_of_this_scene_larger(
    capsys: pytest.CaptureFixture[str],
) -> None:
    model = ROOT / "scenes" / "render" / "windmill.glb"
    price = Price(KINDS["point_lights"], (), None, variance=Interval(0.8, 0.7, 0.9))
    shares: dict[str, dict[str, Interval]] = {kind: {} for kind in KINDS_OF_PARTS}
    found = PriceList((price,), (), shares, {}, {}, (8, 8), 8, 6, "best", 0, -1, -1)
    assert softer_sun(et.load(ROOT / "scenes" / "cornell-box.toml")) == ""
    print_effects(found, "windmill.glb", RENDER, verbose=False, softens=softer_sun(et.load(model)))
    hint = "A larger, softer light in place of a point or a sun (-D sun_angle=15) makes less noise"
    assert hint in capsys.readouterr().out.splitlines()[0]


def proposed(capsys: pytest.CaptureFixture[str], cut: Price | None, *prices: Price) -> str:
    """Return the second line of the output for these prices."""
    shares: dict[str, dict[str, Interval]] = {kind: {} for kind in KINDS_OF_PARTS}
    print_effects(
        PriceList(prices, (), shares, {}, {}, (8, 8), 8, 6, "best", 0, -1, -1, cut), "b.toml", RENDER, verbose=False
    )
    return capsys.readouterr().out.splitlines()[1]


def priced(name: str, share: float, change: float, time: float = 0.0) -> Price:
    """Return the price of an effect with these shares, 10 % more or less."""
    about = [Interval(value, 0.9 * value, 1.1 * value) for value in (time, share, change)]
    return Price(KINDS[name], (Reason("", "the scene as a whole"),), "its stand-in", *about)


def test_the_effect_that_saves_most_is_proposed_whatever_it_is(capsys: pytest.CaptureFixture[str]) -> None:
    cut = Price(KINDS["long_paths"], (), "truncate=4", Interval(0.2, 0.18, 0.22), None, Interval(0.01, 0.009, 0.011))
    textures, lens, motion = priced("textures", 0.1, 0.01), priced("lens", 0.5, 0.05), priced("motion", 0.9, 0.5)
    media = priced("media", 0.4, 0.01, time=0.4)
    paths = proposed(capsys, cut, textures)
    assert paths.endswith(f"without long_paths=4: 20 % ±2 of the time; {OFF} 1.1 %: {RENDER} --without long_paths=4")
    assert f"without lens: 50 % ±5 of the noise; {OFF} 5.5 %: " in proposed(capsys, cut, textures, lens, motion)
    assert "without media: 40 % ±4 of the noise and 40 % ±4 of the time; " in proposed(capsys, cut, lens, media)


def test_a_step_that_may_save_less_than_a_twentieth_is_not_proposed(capsys: pytest.CaptureFixture[str]) -> None:
    little = Interval(0.01, 0.003, 0.018)
    unsure = Interval(0.08, 0.04, 0.12)
    for share in (little, unsure):
        step = Price(KINDS["textures"], (), "their means", None, share, Interval(0.01, 0.009, 0.011))
        assert proposed(capsys, None, step) == NONE
    both = Price(KINDS["textures"], (), "their means", unsure, unsure, Interval(0.01, 0.009, 0.011))
    assert "you save most without textures: " in proposed(capsys, None, both)


def test_a_choice_among_two_lights_is_not_called_many(capsys: pytest.CaptureFixture[str]) -> None:
    choice = Price(KINDS["many_lights"], (), None)
    shares: dict[str, dict[str, Interval]] = {kind: {} for kind in KINDS_OF_PARTS}
    found = PriceList((choice,), (), shares, {}, {}, (8, 8), 8, 6, "best", 0, -1, -1)
    print_effects(found, "b.toml", RENDER, verbose=False)
    assert "Always there: a choice among lights." in capsys.readouterr().out.splitlines()


def test_where_no_effect_saves_anything_one_sentence_says_so(capsys: pytest.CaptureFixture[str]) -> None:
    idle = Price(KINDS["textures"], (), "their means", *[Interval(0.1, -0.1, 0.3)] * 2, Interval(0.01, 0.009, 0.011))
    unknown = Price(KINDS["lens"], (), "a pinhole", variance=Interval(0.5, 0.4, 0.6))
    assert proposed(capsys, None, idle, unknown, priced("motion", 0.5, 0.2)) == NONE


def test_the_proposed_command_has_the_options_and_can_be_pasted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "a box.toml").write_text((ROOT / "scenes" / "cornell-box.toml").read_text())
    monkeypatch.chdir(tmp_path)
    options = ["--size", "12x12", "--strategy", "mis"]
    cut = Price(KINDS["long_paths"], (), "truncate=8", Interval(0.3, 0.2, 0.4), None, Interval(0.01, 0.009, 0.011))
    shares: dict[str, dict[str, Interval]] = {kind: {} for kind in KINDS_OF_PARTS}
    found = PriceList((), (), shares, {}, {}, (12, 12), 8, 6, "mis", 0, -1, -1, cut)
    monkeypatch.setattr(import_module("equaltime.cli.effects"), "measure_effects", lambda *_, **__: found)
    assert main(["effects", "a box.toml", "--quick", *options]) == 0
    command = shlex.split(capsys.readouterr().out.splitlines()[1].rpartition("%: ")[2])
    assert command[:-1] == ["equaltime", "render", "a box.toml", "-o", "a box.exr", *options, "--without"]
    assert main([*command[1:], "--spp", "4", "--quiet"]) == 0


def test_a_cut_that_changes_little_is_priced() -> None:
    found = et.effects(et.load(ROOT / "scenes" / "cornell-box.toml").with_(size=(16, 16)), quick=True)
    assert found.cut is not None
    depth = int(str(found.cut.instead).removeprefix("truncate="))
    assert found.cut.change == found.truncated[depth]
    assert found.cut.change.high <= 0.02
    (paths,) = (price for price in found.prices if price.kind.name == "long_paths")
    assert found.cut.time is not None
    assert found.cut.variance is not None
    assert paths.variance is not None
    assert found.cut.variance.value < paths.variance.value, "the light of longer paths only"


@pytest.mark.parametrize("cut", [["--max-depth", "3"], ["--strategy", "best,truncate=3"]])
def test_the_price_list_says_of_which_paths_it_is(capsys: pytest.CaptureFixture[str], cut: list[str]) -> None:
    box = str(ROOT / "scenes" / "cornell-box.toml")
    command = ["effects", box, "--quick", "--size", "6x6", "--threads", "1", *cut]
    assert main(command) == 0
    said = "All numbers are for paths up to depth 3; the scene asks for paths up to depth 30."
    assert said in capsys.readouterr().out.splitlines()
    assert main([*command, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["max_depth"], found["scene_max_depth"]) == (3, 30)
