"""Renders that are saved, taken up and merged."""

import json
import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import equaltime as et
from equaltime.images import image_files as images
from equaltime.rendering.passes import Progress
from equaltime.rendering.render_file import read_film, read_picture

SCENE = Path(__file__).parents[3] / "scenes" / "cornell-box.toml"


@pytest.fixture(scope="module")
def scene() -> et.Scene:
    return et.load(SCENE).with_(size=(24, 20), max_depth=4)


def moments_of(result: et.Result) -> Any:
    assert result.moments is not None
    return result.moments


def same_moments(a: et.Result, b: et.Result) -> bool:
    return moments_of(a).tobytes() == moments_of(b).tobytes()


@pytest.mark.parametrize("first", [2, 7, 16, 33])
def test_a_render_that_is_taken_up_has_the_bits_of_one_that_never_stopped(
    scene: et.Scene, tmp_path: Path, first: int
) -> None:
    et.render(scene, spp=first).save(tmp_path / "a.exr")
    whole = et.render(scene, spp=40)
    taken_up = et.render(scene, spp=40, resume=tmp_path / "a.exr")
    assert same_moments(taken_up, whole)
    assert taken_up.stats.paths == whole.stats.paths
    assert taken_up.stats.rays == whole.stats.rays
    np.testing.assert_array_equal(taken_up.image, whole.image)
    anew = [et.render(scene, spp=count).image.astype(float) * count for count in (first, 40 - first)]
    assert np.abs(sum(anew) / 40 - whole.image).max() > 1e-6, "the twin: the same numbers once more"


def test_the_runs_of_a_render_are_counted_as_its_seconds_are(scene: et.Scene, tmp_path: Path) -> None:
    files = [tmp_path / name for name in ("a.exr", "b.exr", "c.exr")]
    first = et.render(scene, spp=2)
    first.save(files[0])
    et.render(scene, spp=4, resume=files[0]).save(files[1])
    resumed = et.read(files[1]).stats
    assert "runs" not in first.record
    assert (resumed.runs, resumed.seconds > first.stats.seconds) == (2, True)
    et.render(scene, spp=4, seed=1).save(files[2])
    assert et.merge(files[1:]).record["runs"] == 3


def test_a_render_that_ctrl_c_cut_within_a_pass_is_taken_up(scene: et.Scene, tmp_path: Path) -> None:
    def interrupt(progress: Progress) -> None:
        if progress.samples >= 4:
            raise KeyboardInterrupt

    cut = et.render(scene, spp=100_000, observer=et.Observer.of(progress=interrupt))
    assert cut.stopped_by == "interrupt"
    cut.save(tmp_path / "a.exr")
    spp = int(cut.samples.max()) + 10
    assert same_moments(et.render(scene, spp=spp, resume=tmp_path / "a.exr"), et.render(scene, spp=spp))


def test_a_render_to_an_error_that_was_cut_stops_where_one_stops_that_never_was(
    scene: et.Scene, tmp_path: Path
) -> None:
    whole = et.render(scene, error=0.04)
    assert len(whole.looks) >= 3
    between = (whole.looks[1].samples + whole.looks[2].samples) // 4 * 2

    def interrupt(progress: Progress) -> None:
        if progress.samples >= between:
            raise KeyboardInterrupt

    cut = et.render(scene, error=0.04, observer=et.Observer.of(progress=interrupt))
    assert cut.stopped_by == "interrupt"
    cut.save(tmp_path / "a.exr")
    taken_up = et.render(scene, error=0.04, resume=tmp_path / "a.exr")
    assert same_moments(taken_up, whole)
    assert taken_up.looks == whole.looks
    taken_up.save(tmp_path / "a.exr")
    again = et.render(scene, error=0.04, resume=tmp_path / "a.exr")
    assert same_moments(again, whole), "nothing is left to do"
    assert again.stopped_by == "error"


def test_a_target_that_is_behind_renders_nothing_more(scene: et.Scene, tmp_path: Path) -> None:
    result = et.render(scene, spp=12)
    result.save(tmp_path / "a.exr")
    again = et.render(scene, spp=4, resume=tmp_path / "a.exr")
    assert same_moments(again, result)
    assert again.stopped_by == "spp"


def test_a_render_stops_at_its_error_and_the_same_counts_give_the_same_bits(scene: et.Scene) -> None:
    result = et.render(scene, error=0.3)
    assert result.stopped_by == "error"
    assert result.error.value < 0.3
    assert et.render(scene, error=0.3).spp == result.spp
    assert same_moments(et.render(scene, spp=int(result.spp)), result)


def test_a_stricter_error_goes_on_from_there(scene: et.Scene, tmp_path: Path) -> None:
    first = et.render(scene, error=0.4)
    first.save(tmp_path / "a.exr")
    second = et.render(scene, error=0.25, resume=tmp_path / "a.exr")
    assert second.spp > first.spp
    assert second.looks[: len(first.looks)] == first.looks
    assert second.stats.seconds > 0.0


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"seed": 1}, "it has seed 0, not 1$"),
        ({"strategy": "bsdf"}, "it has strategy best, not bsdf$"),
    ],
)
def test_another_render_is_not_taken_up(scene: et.Scene, tmp_path: Path, change: dict[str, Any], words: str) -> None:
    et.render(scene, spp=4).save(tmp_path / "a.exr")
    with pytest.raises(et.ImageError, match=words):
        et.render(scene, spp=8, resume=tmp_path / "a.exr", **change)


def test_another_scene_or_crop_is_not_taken_up(scene: et.Scene, tmp_path: Path) -> None:
    et.render(scene, spp=4).save(tmp_path / "a.exr")
    with pytest.raises(et.ImageError, match=r"cannot be resumed: it has no -D light_scale=0\.5$"):
        et.render(et.load(SCENE, light_scale="0.5").with_(size=(24, 20), max_depth=4), spp=8, resume=tmp_path / "a.exr")
    with pytest.raises(et.ImageError, match=r"it has crop 0,0,24,20, not 0,0,12,20$"):
        et.render(scene.with_(crop=(0, 0, 12, 20)), spp=8, resume=tmp_path / "a.exr")


def test_files_without_moments_are_refused_by_name(scene: et.Scene, tmp_path: Path) -> None:
    path = tmp_path / "a.exr"
    result = et.render(scene, spp=4)
    result.save(path, small=True)
    with pytest.raises(et.ImageError, match="holds no moments, only an image, as --small saves it"):
        et.render(scene, spp=8, resume=path)
    images.write_exr(path, result.image)
    with pytest.raises(et.ImageError, match="not rendered by equaltime"):
        et.render(scene, spp=8, resume=path)


def test_merging_gives_the_mean_of_all_samples_and_its_error(scene: et.Scene, tmp_path: Path) -> None:
    parts = [et.render(scene, spp=spp, seed=seed) for seed, spp in enumerate((8, 24, 16))]
    paths = [tmp_path / f"{i}.exr" for i in range(3)]
    for part, path in zip(parts, paths, strict=True):
        part.save(path)
    merged = et.merge(paths)
    expected = sum(part.image.astype(np.float64) * part.spp for part in parts) / 48
    np.testing.assert_allclose(merged.image, expected, rtol=3e-7, atol=1e-12)
    assert merged.spp == 48
    assert merged.stats.rays == sum(part.stats.rays for part in parts)
    assert merged.error.value < min(part.error.value for part in parts)
    assert [source["seed"] for source in merged.origin.sources] == [0, 1, 2]


def test_the_order_of_merging_matters_by_an_ulp_at_most(scene: et.Scene, tmp_path: Path) -> None:
    paths = [tmp_path / f"{i}.exr" for i in range(3)]
    for seed, path in enumerate(paths):
        et.render(scene, spp=6, seed=seed).save(path)
    once = et.merge(paths)
    et.merge(paths[1:]).save(tmp_path / "pair.exr")
    twice = et.merge([tmp_path / "pair.exr", paths[0]])
    np.testing.assert_array_max_ulp(once.image, twice.image, maxulp=1)


def test_merging_refuses_the_same_samples_and_other_images(scene: et.Scene, tmp_path: Path) -> None:
    a, b, c, d = (tmp_path / f"{name}.exr" for name in "abcd")
    et.render(scene, spp=4).save(a)
    et.render(scene, spp=4, seed=1, strategy="light").save(b)
    et.render(scene.with_(max_depth=3), spp=4, seed=1).save(c)
    et.render(scene, spp=4, seed=1).save(d)
    with pytest.raises(et.ImageError, match="both have the samples of seed 0"):
        et.merge([a, a])
    with pytest.raises(et.ImageError, match="strategy"):
        et.merge([a, b])
    with pytest.raises(et.ImageError, match=r"it has max depth 3, not 4\. Parts of one render differ only in"):
        et.merge([a, c])
    et.merge([a, d]).save(b)
    with pytest.raises(et.ImageError, match="seed 1"):
        et.merge([b, d])
    with pytest.raises(et.ImageError, match="it was merged"):
        et.render(scene, spp=8, resume=b)


def test_merging_refuses_what_lacks_a_sample(scene: et.Scene, tmp_path: Path) -> None:
    files = [tmp_path / f"{seed}.exr" for seed in range(2)]
    for seed, file in enumerate(files):
        replace(et.render(scene, spp=4, seed=seed), stopped_by="spp" if seed == 0 else "nonfinite").save(file)
    with pytest.raises(et.ImageError, match=r"1\.exr: cannot be merged: it ended at a sample that was not a number"):
        et.merge(files)


def command(output: Path, *options: str) -> list[str]:
    return [sys.executable, "-m", "equaltime", "render", str(SCENE), "-o", str(output), "--size", "64x64", *options]


def kill(output: Path, pause: float) -> None:
    """Render, or go on, and be killed so long after something was saved."""
    before = output.stat().st_mtime_ns if output.exists() else 0
    endless = command(output, "--spp", "1000000", "--checkpoint", "50ms", "--resume", "-q")
    process = subprocess.Popen(endless, stderr=subprocess.DEVNULL)
    deadline = time.monotonic() + 60
    while time.monotonic() < deadline and not (output.exists() and output.stat().st_mtime_ns > before):
        time.sleep(0.01)
    time.sleep(pause)
    os.kill(process.pid, signal.SIGKILL)
    process.wait()


def test_what_a_render_saved_that_is_killed_again_and_again_is_taken_up_with_the_same_bits(tmp_path: Path) -> None:
    """Case C6; tests/bench/kill_resume.py kills fifty times."""
    output = tmp_path / "a.exr"
    done = []
    for pause in (0.2, 0.0, 0.07):
        kill(output, pause)
        done.append(int(read_picture(output).record["paths"]))
    assert done == sorted(set(done))
    saved = read_picture(output).record
    assert saved["stopped_by"] == "unfinished"
    spp = int(saved["samples"]["max"]) + 2
    subprocess.run(command(output, "--spp", str(spp), "--resume", "-q"), check=True)
    whole = et.render(et.load(SCENE).with_(size=(64, 64)), spp=spp)
    read = read_film(output).moments
    assert read is not None
    assert read.tobytes() == moments_of(whole).tobytes()


def test_a_render_that_is_killed_within_its_first_pass_keeps_what_was_saved_of_it(tmp_path: Path) -> None:
    output = tmp_path / "a.exr"
    size = ("--size", "480x360")
    process = subprocess.Popen(command(output, "--spp", "1000000", "--checkpoint", "10ms", "-q", *size))
    deadline = time.monotonic() + 60
    while time.monotonic() < deadline and not output.exists():
        time.sleep(0.001)
    process.kill()
    process.wait()
    samples = read_picture(output).record["samples"]
    assert (samples["min"], samples["max"]) == (0, 2)
    subprocess.run(command(output, "--spp", "2", "--resume", "-q", *size), check=True)
    read = read_film(output).moments
    assert read is not None
    assert read.tobytes() == moments_of(et.render(et.load(SCENE).with_(size=(480, 360)), spp=2)).tobytes()


def test_resume_begins_anew_where_there_is_no_file(tmp_path: Path) -> None:
    output = tmp_path / "a.exr"
    done = subprocess.run(command(output, "--spp", "4", "--resume", "--json"), check=True, capture_output=True)
    assert json.loads(done.stdout)["spp"] == 4


def test_a_checkpoint_that_cannot_be_written_does_not_end_the_render(scene: et.Scene, tmp_path: Path) -> None:
    told: list[str] = []
    nowhere = tmp_path / "no such folder" / "a.exr"
    result = et.render(
        scene, spp=8, checkpoint=nowhere, checkpoint_every=1e-9, observer=et.Observer.of(unsaved=told.append)
    )
    assert (result.spp, result.stopped_by) == (8, "spp")
    assert len(told) == 1, "of several that failed in a row"
    assert str(nowhere) in told[0]


def test_the_number_of_nets_is_no_difference_of_its_own(tmp_path: Path) -> None:
    """It follows from the size: a film of 2^16 pixels has one net in a pixel, a smaller one has two."""
    scene = et.load(SCENE)
    et.render(scene.with_(size=(256, 256), max_depth=2), spp=2).save(tmp_path / "a.exr")
    with pytest.raises(et.ImageError, match=r"cannot be resumed: it has size 256x256, not 200x200$"):
        et.render(scene.with_(size=(200, 200), max_depth=2), spp=4, resume=tmp_path / "a.exr")
