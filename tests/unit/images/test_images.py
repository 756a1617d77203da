import errno
import os
import resource
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import OpenImageIO as oiio  # noqa: N813
import pytest
from numpy.typing import NDArray

from equaltime import files as disk
from equaltime.errors import ImageError
from equaltime.images import image_files as images
from equaltime.images import preview
from equaltime.images.image_files import Window
from equaltime.rendering.origin import Origin
from equaltime.rendering.render_file import RenderFile, read_picture
from equaltime.rendering.result import Result, Stats
from equaltime.statistics.intervals import Interval

HEIGHT, WIDTH = 5, 7


def numbers(*shape: int) -> NDArray[np.float32]:
    return np.random.default_rng(3).random(shape, np.float32)


@pytest.fixture
def result() -> Result:
    stats = Stats({"load": 0.1, "build": 0.2, "render": 2.0, "estimate": 0.01}, 35, 100, 60, "diffuse", 2, ("area",))
    window = Window(10, 20, 40, 30)
    origin = Origin("box.toml", "ab12", window, 8, "best", False, 2**63, 2, "core")
    image, errors = numbers(HEIGHT, WIDTH, 3), numbers(HEIGHT, WIDTH, 3)
    samples = np.full((HEIGHT, WIDTH), 4, np.int64)
    return Result(image, errors, samples, Interval(0.02, 0.01, 0.03), stats, "spp", origin)


def test_an_exr_holds_image_error_samples_and_record(result: Result, tmp_path: Path) -> None:
    result.save(tmp_path / "out.exr")
    picture = read_picture(tmp_path / "out.exr")
    np.testing.assert_array_equal(picture.image, result.image)
    np.testing.assert_allclose(picture.standard_error, result.standard_error, rtol=2.0**-6)
    np.testing.assert_array_equal(picture.samples, result.samples)
    assert picture.record == result.record
    assert picture.record["seed"] == 2**63


def test_the_channels_of_the_image_come_first(result: Result, tmp_path: Path) -> None:
    result.save(tmp_path / "out.exr")
    assert [*images.read(tmp_path / "out.exr").channels] == ["R", "G", "B"], "in the part that others read"
    names = [*read_picture(tmp_path / "out.exr").channels]
    assert names == ["R", "G", "B", "stderr.R", "stderr.G", "stderr.B", "samples"]


def test_a_crop_keeps_its_place_in_the_film(result: Result, tmp_path: Path) -> None:
    result.save(tmp_path / "out.exr")
    assert images.read(tmp_path / "out.exr").window == result.origin.window


def test_an_unknown_error_survives_the_file(result: Result, tmp_path: Path) -> None:
    unknown = replace(result, error=Interval(np.nan, 0.0, np.inf), standard_error=np.full_like(result.image, np.inf))
    unknown.save(tmp_path / "out.exr")
    picture = read_picture(tmp_path / "out.exr")
    assert picture.record["error"] == {"value": None, "low": 0.0, "high": None, "trusted": True}
    assert np.isinf(picture.standard_error).all()  # type: ignore[arg-type]


def test_saving_an_exr_puts_a_preview_beside_it(result: Result, tmp_path: Path) -> None:
    files = result.save(tmp_path / "out.exr")
    assert files == (tmp_path / "out.exr", tmp_path / "out.png")
    assert sorted(tmp_path.iterdir()) == sorted(files)


def test_saving_a_png_writes_the_preview_alone(result: Result, tmp_path: Path) -> None:
    assert result.save(tmp_path / "out.png") == (tmp_path / "out.png",)
    assert list(tmp_path.iterdir()) == [tmp_path / "out.png"]


def test_the_preview_follows_the_srgb_curve() -> None:
    linear = np.array([[[-1.0, 0.0, 0.002], [0.0031308, 0.18, 0.5], [1.0, 2.0, np.inf]]])
    assert preview.srgb_bytes(linear).tolist() == [[[0, 0, 7], [10, 118, 188], [255, 255, 255]]]


def test_the_preview_holds_the_encoded_pixels(result: Result, tmp_path: Path) -> None:
    preview.write(tmp_path / "out.png", result.image)
    stored = np.round(images.read(tmp_path / "out.png").image * 255).astype(np.uint8)
    np.testing.assert_array_equal(stored, preview.srgb_bytes(result.image))


def test_a_result_shows_itself_as_a_png(result: Result) -> None:
    assert result._repr_png_().startswith(b"\x89PNG")


def test_a_result_says_what_it_is(result: Result) -> None:
    assert repr(result) == "Result(7x5, 4 spp, error 2.0 % (1.0 to 3.0), stopped by spp)"


@contextmanager
def files_limited_to(size: int) -> Iterator[None]:
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


def test_a_full_disk_leaves_the_old_file_alone(tmp_path: Path) -> None:
    path = tmp_path / "out.exr"
    path.write_bytes(b"old")
    samples = np.ones((300, 300), np.int64)
    large = RenderFile(numbers(300, 300, 3), numbers(300, 300, 3), samples, {}, Window(0, 0, 300, 300))
    with files_limited_to(50_000), pytest.raises(ImageError, match=r"out\.exr: "):
        large.write(path)
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize(("name", "file_format"), [("out.exr", "openexr"), ("out.png", "png"), ("out.jpg", "jpeg")])
def test_a_full_disk_is_told_as_the_system_tells_it(tmp_path: Path, name: str, file_format: str) -> None:
    """libpng would leave half a picture without an error, and libjpeg would end the process."""
    path = tmp_path / name
    path.write_bytes(b"old")
    noise = np.random.default_rng(1).integers(0, 256, (300, 300, 3), np.uint8)
    layer = images.Layer(images.RGB, noise if file_format != "openexr" else noise.astype(np.float32), {})
    for limit in (20_000, 100_000):
        with files_limited_to(limit), pytest.raises(ImageError, match=rf"{name}: (cannot write: )?File too large"):
            images.write(path, file_format, [layer])
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]
    images.write(path, file_format, [layer])
    assert images.read(path).image.shape == (300, 300, 3)


@pytest.mark.parametrize(("name", "file_format"), [("out.png", "png"), ("out.jpg", "jpeg")])
def test_a_picture_of_pure_noise_is_not_larger_than_its_pixels(tmp_path: Path, name: str, file_format: str) -> None:
    """That much room is asked of the disk before a picture is written."""
    noise = np.random.default_rng(2).integers(0, 256, (200, 300, 3), np.uint8)
    attributes = {"compression": "jpeg:95", "jpeg:subsampling": "4:4:4"} if file_format == "jpeg" else {}
    images.write(tmp_path / name, file_format, [images.Layer(images.RGB, noise, attributes)])
    assert (tmp_path / name).stat().st_size < noise.nbytes + 4096


def test_a_disk_that_complains_only_when_it_is_asked_leaves_the_old_file_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "out.exr"
    path.write_bytes(b"old")

    def full(_: Path) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(disk, "to_disk", full)
    with pytest.raises(ImageError, match=r"out\.exr: No space left"):
        images.write_exr(path, numbers(4, 4, 3))
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]


def test_an_existing_file_is_replaced(result: Result, tmp_path: Path) -> None:
    path = tmp_path / "out.exr"
    path.write_bytes(b"old")
    result.save(path, overwrite=True)
    assert read_picture(path).record["seed"] == result.origin.seed


def test_a_link_stays_and_what_it_leads_to_is_replaced(result: Result, tmp_path: Path) -> None:
    (tmp_path / "far").mkdir()
    (tmp_path / "far" / "kept.exr").write_bytes(b"old")
    (tmp_path / "out.exr").symlink_to("far/kept.exr")
    (tmp_path / "out.png").symlink_to("far/new.png")
    result.save(tmp_path / "out.exr", overwrite=True)
    assert (tmp_path / "out.exr").is_symlink()
    assert (tmp_path / "out.png").is_symlink()
    assert read_picture(tmp_path / "far" / "kept.exr").record["seed"] == result.origin.seed
    assert sorted(file.name for file in (tmp_path / "far").iterdir()) == ["kept.exr", "new.png"]


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("lost.exr", "the folder .*nowhere does not exist"),
        ("out.jpg", r"extension '\.jpg'; expected \.exr, \.png"),
        ("out", "no extension"),
        ("nowhere/out.exr", "the folder .*nowhere does not exist"),
        ("folder.exr", "is a folder"),
    ],
)
def test_a_path_that_cannot_be_written_is_found_beforehand(tmp_path: Path, name: str, message: str) -> None:
    (tmp_path / "folder.exr").mkdir()
    (tmp_path / "lost.exr").symlink_to("nowhere/out.exr")
    with pytest.raises(ImageError, match=message):
        images.check_writable(tmp_path / name, (".exr", ".png"))


def test_a_folder_without_write_permission_is_found_beforehand(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "access", lambda path, mode: False)  # root may write anywhere
    with pytest.raises(ImageError, match="cannot be written to"):
        images.check_writable(tmp_path / "out.exr", (".exr",))


def test_a_missing_file_is_said_to_be_missing(tmp_path: Path) -> None:
    with pytest.raises(ImageError, match=r"none\.exr: no such file"):
        images.read(tmp_path / "none.exr")


@pytest.mark.parametrize("content", [b"", b"no image", b"v/1\x01\x02\x00\x00\x00"])
def test_a_damaged_file_is_an_image_error(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "bad.exr"
    path.write_bytes(content)
    with pytest.raises(ImageError, match=r"bad\.exr: "):
        images.read(path)


def test_a_truncated_file_is_an_image_error(result: Result, tmp_path: Path) -> None:
    """The twin of files that are written aside and renamed: what a death while writing in place would leave."""
    path = tmp_path / "out.exr"
    result.save(path)
    path.write_bytes(path.read_bytes()[:-200])
    with pytest.raises(ImageError, match=r"out\.exr: "):
        read_picture(path)


def test_the_file_of_another_renderer_has_no_error_and_no_record(tmp_path: Path) -> None:
    path = tmp_path / "other.exr"
    images.write(path, "openexr", [images.Layer(("R", "G", "B"), numbers(4, 6, 3), {})])
    picture = images.read(path)
    assert picture.image.shape == (4, 6, 3)
    assert picture.standard_error is None
    assert picture.samples is None
    assert picture.record == {}


def test_a_file_without_colour_says_what_it_has(tmp_path: Path) -> None:
    path = tmp_path / "depth.exr"
    images.write(path, "openexr", [images.Layer(("Z",), numbers(4, 6, 1), {})])
    with pytest.raises(ImageError, match="no channel R, G, B; it has Z"):
        _ = images.read(path).image


def test_the_exr_is_compressed_and_names_its_software(result: Result, tmp_path: Path) -> None:
    result.save(tmp_path / "out.exr")
    source = oiio.ImageInput.open(str(tmp_path / "out.exr"))
    assert source is not None
    assert source.spec().getattribute("compression") == "zip"
    assert source.spec().getattribute("Software") == images.SOFTWARE
    source.close()
