"""The layout of saved renders: what is in a file, that no bit of it changes unseen, and who can open it."""

from __future__ import annotations

import json
import os
import random
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio  # noqa: N813
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

import equaltime as et
from equaltime.film.moments import (
    DTYPE,
    PARTS,
    channel_names,
    packed,
    packed_moments,
    unpacked,
    unpacked_moments,
)
from equaltime.images import image_files as images
from equaltime.rendering import render_file
from equaltime.rendering.render_file import FORMAT, RenderFile, read_film, read_picture

SCENES = Path(__file__).parents[3] / "scenes"
BEFORE = Path(__file__).parents[1] / "data" / "format_1"
BEST_BEFORE = "best,roulette=throughput,sampler=sobol,adaptive=none"
"""What ``best`` was when these files were written."""


@pytest.fixture(scope="module")
def scene() -> et.Scene:
    return et.load(BEFORE / "scene.toml")


@pytest.fixture(scope="module")
def result(scene: et.Scene) -> et.Result:
    return et.render(scene, spp=6, threads=1)


@pytest.fixture
def saved(result: et.Result, tmp_path: Path) -> Path:
    result.save(tmp_path / "a.exr")
    return tmp_path / "a.exr"


def bits(rng: np.random.Generator, dtype: np.dtype[Any], *shape: int) -> NDArray[Any]:
    """Return numbers of any bits."""
    return rng.integers(0, 256, (*shape, dtype.itemsize), dtype=np.uint8).view(dtype)[..., 0]


@given(st.integers(1, 3), st.integers(1, 130), st.integers(1, 9), st.integers(0, 2**32))
@settings(max_examples=40, deadline=None)
def test_numbers_of_any_bits_survive_packing(layers: int, height: int, width: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    moments, image = bits(rng, DTYPE, layers, height, width), bits(rng, np.dtype("<f4"), height, width, 3)
    words = packed_moments(moments, image)
    assert words.shape == (height, -(-width // 4), len(channel_names(DTYPE, layers)))
    assert unpacked_moments(words, image).tobytes() == moments.tobytes()
    sums = bits(rng, PARTS, layers, height, width)
    assert unpacked(packed(sums), width, PARTS).tobytes() == sums.tobytes()


def test_moments_that_follow_from_the_image_are_stored_as_zeros(scene: et.Scene) -> None:
    one = et.render(scene, spp=1, threads=1)
    names = channel_names(DTYPE, 2)
    words = packed_moments(one.moments, one.image)  # type: ignore[arg-type]
    told = [name for i, name in enumerate(names) if words[..., i].any()]
    assert told == ["r0.count.0"]


def test_a_file_holds_the_parts_that_its_layout_names(saved: Path) -> None:
    found = {}
    source = oiio.ImageInput.open(str(saved))
    number = 0
    while source.seek_subimage(number, 0):
        spec = source.spec()
        found[spec.getattribute("oiio:subimagename")] = ({*spec.channelnames}, str(spec.format))
        number += 1
    source.close()
    assert [*found] == ["beauty", "stderr", "samples", "moments", "lamps"]
    assert found["beauty"] == ({"R", "G", "B"}, "float")
    assert found["samples"] == ({"samples"}, "uint")
    assert found["lamps"] == ({"R", "G", "B", "share"}, "float")
    assert found["moments"] == ({*channel_names(DTYPE, 2)}, "uint")


def test_the_layout_describes_every_part_and_every_key_of_a_record(result: et.Result, scene: et.Scene) -> None:
    page = render_file.__doc__
    assert page is not None
    merged = replace(result, parts=np.zeros((6, 8), PARTS), bias=result.error, position=(6, 0, 0))
    keys = {*merged.record, "without", "focus"}
    assert [key for key in keys if f"{key}" not in page] == []
    assert [
        part
        for part in ("beauty", "stderr", "samples", "moments", "parts", "unseen", "lamps", "aovs")
        if f"\n{part} " not in page
    ] == []


def test_what_is_saved_is_read_to_the_bit(saved: Path, result: et.Result) -> None:
    read = RenderFile.read(saved)
    assert result.moments is not None
    assert read.moments is not None
    assert read.moments.tobytes() == result.moments.tobytes()
    assert read.image.tobytes() == result.image.tobytes()
    assert json.loads(json.dumps({key: read.record[key] for key in result.record})) == json.loads(
        json.dumps(result.record)
    )
    np.testing.assert_array_equal(read.missed["lamps"], result.missed["lamps"])
    np.testing.assert_array_equal(read.samples, result.samples)
    np.testing.assert_allclose(read.standard_error, result.standard_error, rtol=2.0**-6)


def test_a_small_file_is_looked_at_but_not_gone_on_with(result: et.Result, tmp_path: Path) -> None:
    path = tmp_path / "a.exr"
    result.save(path, small=True)
    picture = read_picture(path)
    np.testing.assert_allclose(picture.image, result.image, rtol=2.0**-11)
    np.testing.assert_array_equal(picture.samples, result.samples)
    assert picture.record["error"] == result.record["error"]
    assert read_film(path) == (None, None, None)
    with pytest.raises(et.ImageError, match="as --small saves it"):
        et.merge([path, path])


@pytest.mark.parametrize("light", [2.0**-40, 1.0, 2.0**30])
def test_a_small_file_holds_images_of_any_brightness(result: et.Result, tmp_path: Path, light: float) -> None:
    image = (result.image * np.float32(light)).astype(np.float32)
    replace(result, image=image, moments=None).save(tmp_path / "a.exr", small=True)
    np.testing.assert_allclose(read_picture(tmp_path / "a.exr").image, image, rtol=2.0**-11)
    with np.errstate(over="ignore"):
        halves = image.astype(np.float16).astype(np.float32)
    assert np.abs(halves / image - 1.0).max() > 0.01 or light == 1.0, "the twin: halves alone"


@pytest.mark.parametrize("flags", [{}, {"small": True}])
def test_a_changed_bit_is_refused_or_changes_nothing(
    result: et.Result, scene: et.Scene, tmp_path: Path, flags: dict[str, bool]
) -> None:
    """Case: 400 single bits of the file, anywhere. Whatever is still read is what was saved."""
    path = tmp_path / "a.exr"
    result.save(path, **flags)
    good, rng, refused = path.read_bytes(), random.Random(1), 0
    picture = read_picture(path)
    for _ in range(400):
        damaged = bytearray(good)
        damaged[rng.randrange(len(good))] ^= 1 << rng.randrange(8)
        path.write_bytes(damaged)
        try:
            read, film = read_picture(path), read_film(path)
        except et.ImageError:
            refused += 1
            continue
        if not read.record:  # as another program's, of which nothing is trusted but the picture
            continue
        assert read.record == picture.record
        for name, plane in picture.channels.items():
            assert read.channels[name].tobytes() == plane.tobytes(), name
        if film[0] is not None:
            assert result.moments is not None
            assert film[0].tobytes() == result.moments.tobytes()
    assert refused > 200


def test_each_part_and_the_record_are_guarded(result: et.Result, saved: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The digests are those of what was saved: a file whose numbers were changed afterwards is refused."""
    honest = render_file._digest
    for wrong in ("record", "beauty", "stderr", "samples", "moments", "lamps"):
        calls = iter(("record", "beauty", "stderr", "samples", "moments", "lamps"))
        monkeypatch.setattr(
            render_file, "_digest", lambda numbers, calls=calls, wrong=wrong: honest(numbers) * (next(calls) != wrong)
        )
        result.save(saved)
        monkeypatch.undo()
        with pytest.raises(et.ImageError, match=f"is damaged: '{wrong}' is not what was saved"):
            RenderFile.read(saved)


def test_a_part_that_is_missing_is_missed(saved: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = images.write

    def without_lamps(path: Path, kind: str, parts: list[images.Layer], window: images.Window | None = None) -> None:
        whole(path, kind, [part for part in parts if part.attributes["oiio:subimagename"] != "lamps"], window)

    file = RenderFile.read(saved)
    monkeypatch.setattr(images, "write", without_lamps)
    file.write(saved)
    with pytest.raises(et.ImageError, match="is damaged: it lacks the part 'lamps'"):
        RenderFile.read(saved)


def test_moments_that_are_not_finite_are_refused(result: et.Result, tmp_path: Path) -> None:
    assert result.moments is not None
    for field, value in (("mean", np.inf), ("deviation", 0x7FF80000)):
        moments = result.moments.copy()
        moments[field][1, 2, 3] = value
        replace(result, moments=moments).save(tmp_path / "a.exr")
        with pytest.raises(et.ImageError, match=r"a\.exr: pixel 3,2 has moments that are not finite$"):
            et.merge([tmp_path / "a.exr", tmp_path / "a.exr"])


def test_a_file_of_a_later_version_is_refused_with_a_sentence(
    scene: et.Scene, result: et.Result, saved: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as patch:
        patch.setattr(render_file, "FORMAT", FORMAT + 1)
        patch.setattr("equaltime.rendering.result.FORMAT", FORMAT + 1)
        result.save(saved)
    words = rf"a\.exr: was saved by a later version of equaltime, in format {FORMAT + 1}; this version reads formats up"
    for use in (
        lambda: et.render(scene, spp=8, resume=saved),
        lambda: et.merge([saved, saved]),
        lambda: et.compare(saved, saved),
    ):
        with pytest.raises(et.ImageError, match=words):
            use()


def test_a_file_of_format_1_is_refused_where_its_sobol_numbers_are_of_another_version(
    scene: et.Scene, tmp_path: Path
) -> None:
    before = RenderFile.read(BEFORE / "seed0.exr")
    assert before.record["strategy"] == BEST_BEFORE
    result = et.render(scene, spp=6, threads=1, strategy=BEST_BEFORE)
    assert before.record["format"] == 1
    assert (before.record["numbers"], result.record["numbers"]) == (1, 2)
    file = RenderFile(**{**vars(before), "record": {**before.record, "build": result.record["build"]}})
    file.write(tmp_path / "a.exr")  # another machine's build is another matter
    with pytest.raises(et.ImageError, match=r"cannot be resumed: it has random numbers of version 1, not 2$"):
        et.render(scene, spp=10, strategy=BEST_BEFORE, resume=tmp_path / "a.exr")


def test_a_file_of_format_1_is_taken_up_with_its_own_samples(scene: et.Scene, tmp_path: Path) -> None:
    """Its Sobol' numbers are of the earlier version: called today's, today's samples from the seventh on join them."""
    before = RenderFile.read(BEFORE / "seed0.exr")
    assert before.moments is not None
    counts = before.moments["count"][..., None]
    mean = (counts * before.moments["mean"]).sum(axis=0) / counts.sum(axis=0)
    np.testing.assert_allclose(mean, before.image, rtol=1e-6)
    ours = [et.render(scene, spp=spp, threads=1, strategy=BEST_BEFORE) for spp in (6, 10)]
    record = {**before.record, "build": ours[0].record["build"], "numbers": 2}
    RenderFile(**{**vars(before), "record": record}).write(tmp_path / "a.exr")
    taken_up = et.render(scene, spp=10, strategy=BEST_BEFORE, resume=tmp_path / "a.exr")
    later = 10.0 * ours[1].image.astype(np.float64) - 6.0 * ours[0].image
    np.testing.assert_allclose(taken_up.image, (6.0 * mean + later) / 10.0, rtol=1e-5, atol=1e-6)


def test_files_of_format_1_are_merged_and_compared() -> None:
    now, then = et.merge([BEFORE / "seed0.exr", BEFORE / "seed1.exr"]), RenderFile.read(BEFORE / "merged.exr")
    assert then.parts is not None
    assert now.parts is not None
    np.testing.assert_array_equal(now.image, then.image)
    np.testing.assert_array_equal(now.parts["parts"], then.parts["parts"])
    np.testing.assert_allclose(now.parts["between"], then.parts["between"], rtol=1e-12)
    relmse = et.compare(BEFORE / "seed0.exr", BEFORE / "seed1.exr").images[0].metrics["relmse"]
    assert relmse.high == pytest.approx(0.042068937, rel=1e-6)  # as both files say, whatever renders today


def test_openexr_s_own_reader_opens_it(saved: Path, result: et.Result) -> None:
    openexr = pytest.importorskip("OpenEXR")
    with openexr.File(str(saved), separate_channels=True) as file:
        first = file.parts[0]
        assert first.header["name"] == "beauty"
        np.testing.assert_allclose(first.header["chromaticities"], images._REC709, rtol=1e-6)
        for i, channel in enumerate("RGB"):
            np.testing.assert_array_equal(first.channels[channel].pixels, result.image[..., i])


@pytest.mark.parametrize("small", [False, True])
def test_opencv_opens_it(result: et.Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, small: bool) -> None:
    monkeypatch.setitem(os.environ, "OPENCV_IO_ENABLE_OPENEXR", "1")
    cv2 = pytest.importorskip("cv2")
    result.save(tmp_path / "a.exr", small)
    found = cv2.imread(str(tmp_path / "a.exr"), cv2.IMREAD_UNCHANGED)
    np.testing.assert_array_equal(found[..., ::-1], read_picture(tmp_path / "a.exr").image)


def test_a_file_is_lean(scene: et.Scene, tmp_path: Path) -> None:
    """The table by sample counts is that of tests/bench/file_sizes.py; here only that it does not grow again."""
    cornell = et.load(SCENES / "cornell-box.toml").with_(size=(96, 96))
    for spp, most in ((1, 20.0), (64, 67.0)):  # 40 and 140 MB of 1920 x 1080
        result = et.render(cornell, spp=spp, strategy="best,adaptive=none")
        result.save(tmp_path / "a.exr")
        assert (tmp_path / "a.exr").stat().st_size < most * 96 * 96
        result.save(tmp_path / "a.exr", small=True)
        assert (tmp_path / "a.exr").stat().st_size < 9.0 * 96 * 96
