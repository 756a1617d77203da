"""Images that float32 cannot hold are refused; errors of very bright and very dark images are the same."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import equaltime as et
from equaltime.cli import main
from equaltime.experiments.run import reference
from equaltime.film.error import PixelStatistics, image_error
from equaltime.machine import memory_bytes
from equaltime.rendering.core_subject import CoreSubject
from equaltime.rendering.saved import SavedRender

BRIGHT = (
    '[sensor]\ntype = "perspective"\nfilm = { type = "hdrfilm", width = 4, height = 4 }\n'
    '[sky]\ntype = "constant"\nradiance = 3.5e38\n'
)


def _scene(radiance: float) -> et.Scene:
    emitter = {"type": "constant", "radiance": {"type": "rgb", "value": [radiance] * 3}}
    film = {"type": "hdrfilm", "width": 4, "height": 4}
    return et.load_dict({"type": "scene", "sensor": {"type": "perspective", "film": film}, "emitter": emitter})


@pytest.mark.parametrize("radiance", [3.5e38, 1e155, 1e200])
def test_an_image_that_float32_cannot_hold_is_an_error_with_its_pixel(radiance: float) -> None:
    with pytest.raises(et.RenderError, match=r"pixel 0,0 is .*, more than an image of float32 can hold"):
        et.render(_scene(radiance), spp=2, threads=1)


def test_a_render_that_float32_cannot_hold_is_kept_and_goes_on(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file, output = tmp_path / "bright.toml", tmp_path / "bright.exr"
    file.write_text(BRIGHT)
    command = ["render", str(file), "-o", str(output), "-q"]
    assert main([*command, "--spp", "2"]) == 1
    said = f"pixel 0,0 is 3.5e+38 (infinite in {output}, which has all samples), more than an image of float32 can hold"
    assert capsys.readouterr() == ("", f"error: {file}: {said}\n")
    kept = SavedRender.read(output)
    assert kept.moments["mean"].min() == pytest.approx(3.5e38, rel=1e-3)
    assert kept.record["samples"]["max"] == 2
    assert main([*command, "--spp", "4", "--resume"]) == 1
    assert SavedRender.read(output).record["samples"]["max"] == 4
    assert main([*command[:3], str(tmp_path / "other.exr"), "-q", "--spp", "2", "--seed", "1"]) == 1
    capsys.readouterr()
    assert main(["merge", str(output), str(tmp_path / "other.exr"), "-o", str(tmp_path / "both.exr")]) == 1
    assert f"{file}: pixel 0,0 is 3.5e+38, more" in capsys.readouterr().err
    with pytest.raises(et.ImageError, match=r"bright\.exr: pixel 0,0 is not finite: R is inf"):
        et.compare(output, output)


@pytest.mark.parametrize("more", [(), ("--json",)])
def test_a_render_that_float32_cannot_hold_ends_with_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], more: tuple[str, ...]
) -> None:
    file = tmp_path / "bright.toml"
    file.write_text(BRIGHT)
    assert main(["render", str(file), "-o", str(tmp_path / "bright.exr"), "--spp", "2", *more]) == 1
    told = capsys.readouterr()
    assert told.out == ""
    assert [line for line in told.err.splitlines() if line.startswith("error")] == told.err.splitlines()[-1:]


def test_a_checkpoint_that_float32_cannot_hold_is_kept_and_ends_the_render(tmp_path: Path) -> None:
    with pytest.raises(et.BrightImage) as caught:
        et.render(_scene(4e38), spp=2**20, time=60.0, threads=1, checkpoint=tmp_path / "c.exr", checkpoint_every=0.01)
    assert isinstance(caught.value.result, et.Result)
    assert caught.value.result.stopped_by == "unfinished"
    kept = SavedRender.read(tmp_path / "c.exr")
    np.testing.assert_array_equal(kept.moments, np.asarray(caught.value.result.moments))


def test_a_pilot_of_a_bright_room_is_refused_with_its_pixel() -> None:
    room = {
        "type": "cube",
        "flip_normals": True,
        "bsdf": {"type": "conductor", "specular_reflectance": 0.9},
        "emitter": {"type": "area", "radiance": 1e200},
    }
    film = {"type": "hdrfilm", "width": 4, "height": 4}
    parts = {"integrator": {"type": "path", "max_depth": 6}, "sensor": {"type": "perspective", "film": film}}
    with pytest.raises(et.BrightImage, match=r"a pilot of 4x4 pixels: pixel 0,0 is inf, more than an image"):
        et.render({"type": "scene", **parts, "room": room}, spp=2, threads=1, within=0.01)


@pytest.mark.parametrize("radiance", [3.5e38, 1e155, 1e200, 1e306])
@pytest.mark.filterwarnings("error")
def test_an_experiment_does_not_measure_what_float32_cannot_hold(radiance: float) -> None:
    scene = _scene(radiance)
    with pytest.raises(et.RenderError, match=r"^reference: pixel 0,0 is .*, more than an image of float32 can hold"):
        reference.render(scene, error=0.1, seconds=5.0)
    subject = CoreSubject("mis", et.Strategy.parse("mis"))
    subject.prepare(scene, 1)
    with pytest.raises(et.RenderError, match=r"mis: pixel 0,0 is .*, more than an image of float32 can hold"):
        list(subject.run(1, [2]))


@pytest.mark.parametrize("exponent", [-400, 400])
def test_the_error_does_not_depend_on_how_bright_the_image_is(exponent: int) -> None:
    random = np.random.default_rng(3)
    mean, samples = random.uniform(0.5, 1.5, (16, 16, 3)), np.full((16, 16), 8, np.int64)
    pixels = PixelStatistics(mean, 0.01 * mean, samples, 1.0)
    scale = 2.0**exponent
    scaled = replace(pixels, mean=mean * scale, variance=pixels.variance * scale * scale)
    found, plain = image_error(scaled), image_error(pixels)
    assert [found.value, found.low, found.high] == pytest.approx([plain.value, plain.low, plain.high], rel=1e-12)


@pytest.mark.parametrize("name", ["memory.max", "memory/memory.limit_in_bytes"])
def test_the_memory_of_a_container_counts(tmp_path: Path, name: str) -> None:
    machine = memory_bytes(tmp_path)
    file = tmp_path / name
    file.parent.mkdir(exist_ok=True)
    file.write_text("max\n")
    assert memory_bytes(tmp_path) == machine
    file.write_text("1000000\n")
    assert memory_bytes(tmp_path) == 1_000_000
