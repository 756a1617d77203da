"""`et.compare` and ``equaltime compare``: files with and without standard errors, and files that cannot be compared."""

from __future__ import annotations

import json
import math
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import equaltime as et
from equaltime.cli import main
from equaltime.cli.messages import MOST_LINES
from equaltime.film.error import pixel_statistics, standard_error
from equaltime.film.moments import DTYPE
from equaltime.film.parts_of_merge import MergedFilm
from equaltime.images import image_files as images
from equaltime.images.image_files import Window
from equaltime.rendering.noisy_reference import Noise
from equaltime.rendering.render_file import RenderFile, read_film, read_picture

Array = NDArray[np.float64]
SCENE = Path(__file__).resolve().parents[3] / "scenes/cornell-box.toml"
HEIGHT, WIDTH = 64, 48
TRUTH = np.random.default_rng(1).uniform(0.2, 2.0, (HEIGHT, WIDTH, 3))
SIGMA = {"a.exr": 0.05, "b.exr": 0.1, "ref.exr": 0.005}


def write(path: Path, image: Array, sigma: float | None = None, record: dict[str, Any] | None = None) -> Path:
    """Write an EXR like equaltime's, or a plain one of R, G, B if no standard error is given."""
    height, width = image.shape[:2]
    if sigma is None:
        images.write(path, "openexr", [images.Layer(("R", "G", "B"), image.astype(np.float32), {})])
    else:
        errors = np.full(image.shape, sigma)
        RenderFile(image, errors, np.full((height, width), 4), record or {}, Window(0, 0, width, height)).write(path)
    return path


def noisy(sigma: float, seed: int) -> Array:
    return TRUTH + sigma * np.random.default_rng(seed).standard_normal(TRUTH.shape)


@pytest.fixture
def files(tmp_path: Path) -> tuple[Path, Path, Path]:
    """Write A, B with twice the noise of A in a quarter of the time, and a reference."""
    records = [{"seed": i, "digest": "d", "seconds": s, "error": None} for i, s in enumerate((4.0, 1.0, 100.0))]
    a, b, reference = (
        write(tmp_path / name, noisy(sigma, seed), sigma, record)
        for (name, sigma), seed, record in zip(SIGMA.items(), (10, 11, 12), records, strict=True)
    )
    return a, b, reference


def test_two_images_against_a_reference(files: tuple[Path, Path, Path]) -> None:
    found = et.compare(*files)
    assert found.size == (WIDTH, HEIGHT)
    assert found.against == files[2]
    assert [image.path for image in found.images] == list(files[:2])
    assert set(found.images[0].metrics) == {"error", "relmse", "mse", "mare", "flip"}
    for image, sigma in zip(found.images, SIGMA.values(), strict=False):
        mse = image.metrics["mse"]
        assert mse.value == pytest.approx(sigma**2, rel=0.05)
        assert mse.low < mse.value < mse.high
    assert found.notes == ()


def test_the_ratio_of_errors_has_an_interval(files: tuple[Path, Path, Path]) -> None:
    found = et.compare(*files)
    assert found.ratio is not None
    assert found.ratio.low < 0.5 < found.ratio.high
    assert found.ratio.high - found.ratio.low < 0.1


def test_efficiency_is_told_where_times_are(files: tuple[Path, Path, Path]) -> None:
    """Half the error in four times the time is the same efficiency."""
    found = et.compare(*files)
    assert found.efficiency is not None
    assert found.efficiency.low < 1.0 < found.efficiency.high


def test_without_a_reference_the_second_image_stands_for_it(files: tuple[Path, Path, Path]) -> None:
    found = et.compare(files[0], files[2])
    assert found.against == files[2]
    assert [image.path for image in found.images] == [files[0]]
    assert found.ratio is None
    assert found.images[0].metrics["mse"].value == pytest.approx(0.05**2, rel=0.05)


def test_equal_expectations_are_not_called_biased(files: tuple[Path, Path, Path]) -> None:
    assert all(image.bias_p is not None and image.bias_p > 0.01 for image in et.compare(*files).images)


def test_two_percent_too_much_light_is_found(files: tuple[Path, Path, Path], tmp_path: Path) -> None:
    bright = write(tmp_path / "bright.exr", 1.02 * noisy(0.05, 20), 0.05)
    (image,) = et.compare(bright, files[2]).images
    assert image.bias_p is not None
    assert image.bias_p < 1e-6


def test_the_bias_that_is_told_would_be_found(files: tuple[Path, Path, Path], tmp_path: Path) -> None:
    least = et.compare(files[0], files[2]).images[0].least_bias
    assert least is not None
    assert 0.001 < least < 0.02
    bright = write(tmp_path / "bright.exr", (1.0 + 1.5 * least) * noisy(0.05, 20), 0.05)
    (image,) = et.compare(bright, files[2]).images
    assert image.bias_p is not None
    assert image.bias_p < 0.001


def test_files_in_the_wrong_order_are_warned_of_in_the_second_line(
    files: tuple[Path, Path, Path], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(files[0].parent)
    write(Path("plain.exr"), noisy(0.05, 20))
    assert main(["compare", "ref.exr", "plain.exr"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[1].startswith(
        "warning: plain.exr carries no standard errors: its noise is part of the error. If ref.exr"
    )
    assert len(lines) <= MOST_LINES
    assert not any(line.startswith("note: ") for line in lines)
    assert "give it second" in str(et.compare("ref.exr", "plain.exr"))
    assert et.compare("plain.exr", "ref.exr").order == ""


def test_equal_seeds_are_not_tested_for_bias(tmp_path: Path) -> None:
    record = {"seed": 1, "digest": "d"}
    a, b = (write(tmp_path / f"{seed}.exr", noisy(0.05, seed), 0.05, record) for seed in (3, 4))
    found = et.compare(a, b)
    assert found.images[0].bias_p is None
    assert any("a seed in common" in note for note in found.notes)


def test_of_a_file_that_is_given_twice_the_first_line_says_so(
    files: tuple[Path, Path, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    a, b, reference = files
    told = f"identical: {a} was given twice; give two files"
    assert main(["compare", str(a), str(a)]) == 0
    said = capsys.readouterr().out
    assert said.splitlines()[0] == told
    assert "seed in common" not in said
    copy = a.with_name("copy.exr")
    copy.write_bytes(a.read_bytes())
    assert et.compare(a, copy, reference).same.startswith(f"identical: {a} and {copy} have the same pixels")
    assert main(["compare", str(a), str(copy)]) == 0
    assert capsys.readouterr().out.startswith("identical: ")
    assert et.compare(a, b, reference).same == ""


def test_samples_that_both_have_are_not_subtracted_twice(tmp_path: Path) -> None:
    first, rest = noisy(0.08, 3) - TRUTH, noisy(0.08 / math.sqrt(3.0), 4) - TRUTH
    shared = [{"seed": 0, "digest": digest} for digest in ("a", "b")]  # what was left out makes it another scene
    a = write(tmp_path / "a.exr", TRUTH + first, 0.08, shared[0])
    both = write(tmp_path / "both.exr", TRUTH + 0.25 * first + 0.75 * rest, 0.04, shared[1])
    found = et.compare(a, write(tmp_path / "b.exr", TRUTH, 0.0, {"seed": 5}), both)
    of_a, of_b = found.images
    assert of_a.metrics["mse"].value == pytest.approx(0.08**2 - 0.04**2, rel=0.05)  # of these two images
    assert not of_a.metrics["mse"].trusted
    assert of_a.bias_p is None
    assert of_b.metrics["mse"].trusted
    assert found.ratio is not None
    assert "a.exr has a seed in common with the reference" in found.ratio.note
    other = write(tmp_path / "other.exr", TRUTH + 0.5 * first, 0.04, {"seed": 0, "digest": "c"})
    ratio = et.compare(a, other, both).ratio
    assert ratio is not None
    assert "both have a seed in common with the reference" in ratio.note


def test_a_merged_file_is_not_independent_of_its_parts(tmp_path: Path) -> None:
    parts = [{"seed": seed} for seed in (1, 2)]
    both = write(tmp_path / "both.exr", noisy(0.05, 3), 0.05, {"seed": 1, "digest": "d", "sources": parts})
    for seed, independent in ((1, False), (2, False), (3, True)):
        part = write(tmp_path / "part.exr", noisy(0.05, 3 + seed), 0.05, {"seed": seed, "digest": "d"})
        found = et.compare(part, both)
        assert (found.images[0].bias_p is not None) == independent
        assert (found.notes == ()) == independent


def test_images_of_paths_of_different_lengths_are_images_of_two_problems(tmp_path: Path) -> None:
    record = {"seed": 1, "digest": "d", "scene": "box.toml", "max_depth": 2, "scene_max_depth": -1}
    cut = write(tmp_path / "cut.exr", noisy(0.05, 3), 0.05, record)
    whole = write(tmp_path / "whole.exr", TRUTH, 0.01, {**record, "seed": 2, "digest": "e", "max_depth": -1})
    (note,) = et.compare(cut, whole).notes
    assert note.startswith(
        f"images of two problems: {cut} shows paths up to depth 2, {whole} shows paths of any length. "
    )
    same = write(tmp_path / "same.exr", TRUTH, 0.01, {**record, "seed": 2})
    assert et.compare(cut, same).notes == (
        "the images show paths up to depth 2; the scene asks for paths of any length",
    )


def test_plain_files_of_other_renderers_have_errors_without_intervals(tmp_path: Path) -> None:
    a, reference = write(tmp_path / "a.exr", noisy(0.05, 3)), write(tmp_path / "r.exr", TRUTH)
    found = et.compare(a, reference)
    (image,) = found.images
    assert image.metrics["mse"].value == pytest.approx(0.05**2, rel=0.05)
    assert not image.metrics["mse"].trusted
    assert image.bias_p is None
    assert any("no standard errors" in note for note in found.notes)


def test_an_unknown_standard_error_is_none(tmp_path: Path) -> None:
    a, reference = write(tmp_path / "a.exr", noisy(0.05, 3)), write(tmp_path / "r.exr", TRUTH, math.inf)
    assert not et.compare(a, reference).images[0].metrics["mse"].trusted


def test_a_render_compares_with_its_own_preview_under_protest(tmp_path: Path) -> None:
    a = write(tmp_path / "a.exr", TRUTH)
    images.write(tmp_path / "a.png", "png", [images.Layer(("R", "G", "B"), (100 * TRUTH).astype(np.uint8), {})])
    found = et.compare(a, tmp_path / "a.png")
    assert found.unlike.startswith("values for displays in a.png, radiance in a.exr: most of the difference may")
    assert found.unlike in str(found)
    alike = et.compare(tmp_path / "a.png", tmp_path / "a.png")
    assert not alike.unlike
    assert any("made for displays" in note for note in alike.notes)


def test_different_sizes_are_named(files: tuple[Path, Path, Path], tmp_path: Path) -> None:
    small = write(tmp_path / "small.exr", TRUTH[:32])
    with pytest.raises(et.ImageError, match=r"a\.exr is 48x64, .*small\.exr is 48x32"):
        et.compare(files[0], small)


def test_a_missing_channel_is_named_with_its_file(files: tuple[Path, Path, Path], tmp_path: Path) -> None:
    images.write(tmp_path / "depth.exr", "openexr", [images.Layer(("Z",), TRUTH[..., :1].astype(np.float32), {})])
    with pytest.raises(et.ImageError, match=r"depth\.exr: the image has no channel R, G, B; it has Z"):
        et.compare(files[0], tmp_path / "depth.exr")


def test_a_pixel_that_is_not_finite_is_named(files: tuple[Path, Path, Path], tmp_path: Path) -> None:
    image = TRUTH.copy()
    image[5, 7, 1] = np.nan
    with pytest.raises(et.ImageError, match=r"bad\.exr: pixel 7,5 is not finite: G is nan"):
        et.compare(write(tmp_path / "bad.exr", image), files[2])


def test_a_tiny_image_is_compared_without_trust(tmp_path: Path) -> None:
    tiny = [write(tmp_path / f"{i}.exr", TRUTH[:2, :2] * (1.0 + 0.1 * i), 0.01) for i in range(3)]
    found = et.compare(*tiny)
    assert found.ratio is not None
    assert not found.ratio.trusted
    assert found.images[0].bias_p is None


def test_a_single_pixel_is_compared_without_a_number_that_there_is_not(tmp_path: Path) -> None:
    record = {"seconds": 1.0}
    pixels = [write(tmp_path / f"{i}.exr", TRUTH[:1, :1] * (1.0 + 0.1 * i), 0.01, record) for i in (1, 2, 0)]
    found = et.compare(*pixels)
    assert not found.images[0].metrics["error"].known
    assert (found.ratio, found.efficiency) == (None, None)


def test_against_a_reference_that_says_it_has_no_noise_the_ratio_is_exact(tmp_path: Path) -> None:
    paths = [write(tmp_path / f"{i}.exr", TRUTH * (1.0 + 0.1 * i), 0.0) for i in (1, 2, 0)]
    found = et.compare(*paths)
    assert found.ratio is not None
    assert found.ratio.trusted
    assert found.ratio.low == found.ratio.value == found.ratio.high == pytest.approx(0.5, rel=1e-6)


def test_against_a_reference_without_errors_the_ratio_has_no_interval(files: tuple[Path, Path, Path]) -> None:
    plain = write(files[2].with_name("plain.exr"), noisy(0.05, 30))
    found = et.compare(*files[:2], plain)
    assert found.ratio is not None
    assert found.ratio.note == "noise of the reference pulls it towards 1"
    assert math.isnan(found.ratio.low)
    assert found.as_dict()["ratio"]["low"] is None
    assert 0.6 < found.ratio.value < 0.7  # of 0.5, with a noise of 0.05 left in both


def test_a_reference_that_is_noisier_than_the_images_puts_their_ratio_in_doubt(
    files: tuple[Path, Path, Path], tmp_path: Path
) -> None:
    found = et.compare(*files[:2], write(tmp_path / "rough.exr", noisy(0.1, 31), 0.1, {"seed": 31}))
    assert found.ratio is not None
    assert "noise of rough.exr may make" in found.ratio.note


LAMP = np.full((32, 32, 3), 0.05)
LAMP[10:13, 10:13] = 20.0


def rendered(path: Path, seed: int, samples: int, moments: bool = True, record: dict[str, Any] | None = None) -> Path:
    """Write a render of a lamp in a dark room, with noise of rare events, as equaltime does."""
    rng = np.random.default_rng(seed)
    found = np.zeros((2, 32, 32), DTYPE)
    found["count"] = samples // 2
    for replicate in found:
        replicate["mean"] = LAMP * rng.gamma(0.25 * samples, 4.0 / samples, (32, 32, 1))
    pixels = pixel_statistics(found)
    said = {"seed": seed, "error": None} | (record or {})
    kept = found if moments else None
    shown = (pixels.mean, standard_error(pixels), pixels.samples, said, Window(0, 0, 32, 32))
    RenderFile(*shown, moments=kept).write(path)
    return path


@pytest.mark.parametrize("moments", [True, False], ids=["moments", "standard errors alone"])
def test_the_noise_of_a_lamp_is_not_subtracted_from_the_dark_pixels_beside_it(tmp_path: Path, moments: bool) -> None:
    a, b = (rendered(tmp_path / f"{i}.exr", i, 64, moments) for i in (1, 2))
    (image,) = et.compare(a, b).images
    square = np.square(images.read(a).image - LAMP) / (np.square(LAMP) + (0.1 * LAMP.mean()) ** 2)
    error = image.metrics["error"]
    assert error.low < math.sqrt(square.mean()) < error.high
    assert error.high < 1.5 * error.value


def test_moments_of_another_image_are_not_the_noise_of_this_one(tmp_path: Path) -> None:
    path = rendered(tmp_path / "a.exr", 1, 64)
    picture, moments = read_picture(path), read_film(path).moments
    assert moments is not None
    changed = {name: 2.0 * plane for name, plane in picture.channels.items()}  # as a denoiser, or anyone, would
    own, other = (Noise.of_render(one, read_film(path)) for one in (picture, replace(picture, channels=changed)))
    assert own is not None
    assert other is not None
    assert (own.pooled, other.pooled) == (False, True)
    np.testing.assert_array_equal(own.variance, pixel_statistics(moments).variance)


def test_the_noise_of_a_merged_file_comes_from_all_its_parts(tmp_path: Path) -> None:
    scene = et.load(SCENE).with_(size=(16, 16))
    paths = [tmp_path / f"{seed}.exr" for seed in range(3)]
    for seed, path in enumerate(paths):
        et.render(scene, spp=3, seed=seed).save(path)
    merged = et.merge(paths)
    merged.save(tmp_path / "all.exr")
    noise = Noise.of_render(read_picture(tmp_path / "all.exr"), read_film(tmp_path / "all.exr"))
    assert noise is not None
    assert not noise.pooled
    moments, parts, _ = read_film(tmp_path / "all.exr")
    assert moments is not None
    assert parts is not None
    np.testing.assert_array_equal(noise.variance, MergedFilm(moments, parts).statistics().variance)
    assert not np.array_equal(noise.variance, pixel_statistics(moments).variance)


def test_where_the_reference_is_too_noisy_an_upper_limit_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    rendered(tmp_path / "a.exr", 1, 4096)
    rendered(tmp_path / "b.exr", 2, 2)
    (image,) = et.compare("a.exr", "b.exr").images
    error = image.metrics["error"]
    assert (error.known, error.low) == (False, 0.0)
    assert error.high > 1.0 / 64.0
    assert main(["compare", "a.exr", "b.exr"]) == 0
    out = capsys.readouterr().out
    assert "unknown, at most" in out
    assert "Render b.exr with more samples" in out
    assert main(["compare", "a.exr", "b.exr", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["images"][0]["metrics"]["error"]["value"] is None


def test_the_own_estimate_keeps_its_doubt(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    said = {"value": 0.1, "low": 0.05, "high": None, "doubt": "heavy tail"}
    a, b = (rendered(tmp_path / f"{i}.exr", i, 64, record={"error": said}) for i in (1, 2))
    (image,) = et.compare(a, b).images
    assert image.own == et.Interval(0.1, 0.05, math.inf).doubted("heavy tail")
    assert main(["compare", str(a), str(b)]) == 0
    assert "is in doubt: heavy tail" in capsys.readouterr().out


def test_a_doubt_of_the_reference_is_one_of_all_that_is_measured_against_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    said = {"value": 0.1, "low": 0.05, "high": None, "doubt": "small lamps behind glass"}
    for seed, name in enumerate(("a.exr", "b.exr")):
        rendered(tmp_path / name, seed, 64)
    rendered(tmp_path / "ref.exr", 2, 1024, record={"error": said})
    found = et.compare("a.exr", "b.exr", "ref.exr")
    assert [image.doubt for image in found.images] == ["small lamps behind glass"] * 2
    assert found.ratio is not None
    assert found.ratio.note == "the error that ref.exr states is in doubt"
    assert main(["compare", "a.exr", "b.exr", "ref.exr"]) == 0
    out = capsys.readouterr().out
    assert out.count("yes, see the note") == 2
    assert "ref.exr states is in doubt, and so are all errors measured against it: small lamps behind glass" in out
    assert et.compare("ref.exr", "a.exr").images[0].doubt == ""


def test_a_doubt_that_two_images_have_is_told_once(tmp_path: Path) -> None:
    said = {"value": 0.1, "low": 0.05, "high": None}
    a, b, other = (
        rendered(tmp_path / f"{seed}.exr", seed, 64, record={"error": {**said, "doubt": doubt}})
        for seed, doubt in enumerate(("1,610 samples miss light", "64 samples miss light", "heavy tail"))
    )
    first, second = et.compare(a, b).notes[:2]
    assert first == f"the error that {a} states is in doubt: 1,610 samples miss light"
    assert second.endswith("in doubt, and so are all errors measured against it, for the same reason")
    assert et.compare(a, other).notes[1].endswith(": heavy tail")


def test_without_the_package_of_flip_all_other_metrics_are_told(
    files: tuple[Path, Path, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "flip_evaluator", None)  # as if it were not installed
    found = et.compare(*files)
    assert set(found.images[0].metrics) == {"error", "relmse", "mse", "mare"}
    assert any("flip is left out" in note for note in found.notes)


def test_the_command_prints_every_metric(
    files: tuple[Path, Path, Path], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(files[0].parent)  # names that need no second line in the table
    names = [file.name for file in files]
    assert main(["compare", *names]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert re.match(r"a\.exr has 0\.49\d* times \(0\.4\d* to 0\.\d+\) the error of b\.exr\.$", lines[0])
    assert lines[1].startswith("Bias found: ") or re.match(
        r"No bias found: p = \S+ for a\.exr, p = \S+ for b\.exr; only p below 0\.001 counts as bias\. "
        r"A bias of [\d.]+ % in all pixels would mostly be found\.$",
        lines[1],
    )
    assert lines[-1].endswith("relmse, mse, mare, efficiency")
    assert len(lines) <= MOST_LINES
    assert not any("relmse  " in line for line in lines)
    assert main(["compare", *names, "-v"]) == 0
    out = capsys.readouterr().out
    for word in (
        "error",
        "relmse",
        "mse",
        "mare",
        "FLIP",
        "a.exr",
        "b.exr",
        "p of equal means",
        "at 67 pixels per degree",
        "mare: mean of |A - R| / (|R| + 0.1 m)",
        "efficiency: 1 / (error\N{SUPERSCRIPT TWO} x render time)",
        "p of equal means: the least p of three tests over the whole image",
        "Intervals hold for these images alone",
    ):
        assert word in out


def test_the_command_promises_an_efficiency_only_with_a_reference(
    files: tuple[Path, Path, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    names = [str(file) for file in files[:2]]
    assert main(["compare", *names]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].endswith(" b.exr is taken as the truth; its noise is subtracted.")
    assert lines[-1].endswith("relmse, mse, mare")
    assert main(["compare", *map(str, files)]) == 0
    assert "taken as the truth" not in capsys.readouterr().out, "the third file is the reference"
    assert main(["compare", *names, "-v"]) == 0
    assert "efficiency" not in capsys.readouterr().out


def test_intervals_are_printed_with_plain_brackets(
    files: tuple[Path, Path, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["compare", *map(str, files)]) == 0
    printed = capsys.readouterr().out
    assert " (" in printed
    assert "[" not in printed
    assert "\\" not in printed


def test_the_command_gives_json(files: tuple[Path, Path, Path], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["compare", *map(str, files), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found == et.compare(*files).as_dict()
    assert found["images"][0]["metrics"]["mse"]["value"] == pytest.approx(0.05**2, rel=0.05)
    assert found["ratio"]["low"] < 0.5 < found["ratio"]["high"]


def test_of_a_missing_file_one_line_is_said(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "equaltime", "compare", "none.exr", "none.exr"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=60, check=False)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.splitlines() == ["error: none.exr: no such file"]


def test_the_command_refuses_bad_input_with_code_2(
    files: tuple[Path, Path, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["compare", str(files[0]), str(tmp_path / "none.exr")]) == 2
    assert "none.exr: no such file" in capsys.readouterr().err
    assert main(["compare", str(files[0])]) == 2
    assert "error:" in capsys.readouterr().err
