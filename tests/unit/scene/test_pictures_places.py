"""The places of a picture's texels: its orientation, its display window, its parts."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import OpenEXR
import OpenImageIO as oiio  # noqa: N813
import pytest
from numpy.typing import NDArray
from PIL import Image

import equaltime as et

from .picture_files import FILE_ORIENTATIONS, colors, hdr, numbers, scene, texels, written

RADIANCE = {
    **{"-Y {h} +X {w}": 1, "-Y {h} -X {w}": 2, "+Y {h} -X {w}": 3, "+Y {h} +X {w}": 4},
    **{"+X {w} -Y {h}": 5, "-X {w} -Y {h}": 6, "-X {w} +Y {h}": 7, "+X {w} +Y {h}": 8},
}


def planes(pixels: NDArray[np.float32]) -> dict[str, NDArray[np.float32]]:
    return {name: np.ascontiguousarray(pixels[..., i]) for i, name in enumerate("RGB")}


def standing(height: int, width: int, axes: str) -> tuple[list[tuple[int, int]], tuple[int, int]]:
    """Return the pixels (row, column) of a picture in the order of a Radiance file, and its rows and their length.

    This follows the words of the format: the first axis runs from row to row, the second within a row; y grows upwards.
    """
    ways = {"-Y": range(height), "+Y": range(height)[::-1], "+X": range(width), "-X": range(width)[::-1]}
    first, second = axes.split()[0], axes.split()[2]
    order = [(a, b) if first[1] == "Y" else (b, a) for a in ways[first] for b in ways[second]]
    return order, (len(ways[first]), len(ways[second]))


@pytest.mark.parametrize("axes", RADIANCE)
@pytest.mark.parametrize("use", ["texture", "sky"])
def test_all_eight_orientations_of_radiance_show_one_picture(tmp_path: Path, axes: str, use: str) -> None:
    seen = np.random.default_rng(1).integers(128, 256, (4, 6, 4), np.uint8)
    seen[..., 3] = 128
    order, shape = standing(4, 6, axes)
    stored = np.array([seen[place] for place in order]).reshape(*shape, 4)
    path = hdr(tmp_path / "a.hdr", stored, axes)
    expected = numbers(hdr(tmp_path / "b.hdr", seen))
    if use == "texture":
        assert (numbers(path) == expected).all()
    else:
        loaded = scene(path, "sky")
        assert (loaded.assets.image(loaded.model.emitters[0]) == expected).all()  # type: ignore[arg-type]
    assert texels(path).told == ()


@pytest.mark.parametrize("number", FILE_ORIENTATIONS)
@pytest.mark.parametrize("kind", ["png", "tif", "jpg", "exr"])
def test_orientations_of_exif_and_tiff_are_turned_upright(tmp_path: Path, kind: str, number: int) -> None:
    seen = np.zeros((32, 48, 3), np.uint8)
    seen[:16, :16], seen[16:, :16] = (200, 40, 40), (40, 200, 40)
    stored = np.ascontiguousarray(FILE_ORIENTATIONS[number](seen))
    stored = stored.astype(np.float32) if kind == "exr" else stored
    found = numbers(written(tmp_path / f"a.{kind}", stored, Orientation=number))
    plain = numbers(written(tmp_path / f"b.{kind}", seen.astype(stored.dtype)))
    assert found.shape == plain.shape
    assert np.abs(found - plain).max() <= (0.08 if kind == "jpg" else 0.0)  # whose blocks lie otherwise


@pytest.mark.parametrize("kind", ["png", "webp"])
def test_orientations_in_exif_beside_the_pixels_are_turned_upright(tmp_path: Path, kind: str) -> None:
    seen = np.random.default_rng(1).integers(0, 256, (4, 6, 3), np.uint8)
    exif = Image.Exif()
    exif[0x0112] = 6
    stored = Image.fromarray(np.ascontiguousarray(FILE_ORIENTATIONS[6](seen)))
    stored.save(tmp_path / f"a.{kind}", exif=exif, lossless=True)
    assert (texels(tmp_path / f"a.{kind}").texels == seen).all()


def test_an_orientation_that_is_none_changes_nothing(tmp_path: Path) -> None:
    path = written(tmp_path / "a.exr", colors(), Orientation=11)
    assert (numbers(path) == colors()).all()


# -- windows ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("use", ["texture", "sky"])
def test_a_display_window_spans_the_surface_and_is_black_where_there_are_no_pixels(tmp_path: Path, use: str) -> None:
    expected = np.zeros((8, 12, 3), np.float32)
    expected[1:5, 2:8] = colors()
    path = written(tmp_path / "a.exr", colors(), data=(2, 1), display=(12, 8))
    found = scene(path, use)
    if use == "sky":
        assert (found.assets.image(found.model.emitters[0]) == expected).all()  # type: ignore[arg-type]
    assert (numbers(path) == expected).all()


def test_what_lies_outside_the_display_window_is_cut_off(tmp_path: Path) -> None:
    whole = colors(8, 12)
    path = written(tmp_path / "a.exr", whole, data=(-3, -2), display=(6, 4))
    assert (numbers(path) == whole[2:6, 3:9]).all()


def test_data_beside_the_display_window_leave_it_black(tmp_path: Path) -> None:
    assert not numbers(written(tmp_path / "a.exr", colors(), data=(20, 20), display=(6, 4))).any()


def test_a_display_window_may_begin_anywhere(tmp_path: Path) -> None:
    channels = planes(colors())
    windows = {
        "dataWindow": (np.array([102, 201], np.int32), np.array([107, 204], np.int32)),
        "displayWindow": (np.array([100, 200], np.int32), np.array([107, 207], np.int32)),
    }
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage, **windows}
    OpenEXR.File(header, channels).write(str(tmp_path / "a.exr"))
    expected = np.zeros((8, 8, 3), np.float32)
    expected[1:5, 2:8] = colors()
    assert (numbers(tmp_path / "a.exr") == expected).all()


def test_a_display_window_that_no_memory_holds_is_refused(tmp_path: Path) -> None:
    path = written(tmp_path / "a.exr", colors(), display=(1 << 20, 1 << 20))
    with pytest.raises(et.SceneError, match=r"a display window of 1048576x1048576 pixels around 6x4"):
        scene(path)


def test_an_offset_on_a_page_is_told_and_moves_nothing(tmp_path: Path) -> None:
    pixels = np.arange(72, dtype=np.uint8).reshape(4, 6, 3)
    path = tmp_path / "a.tif"
    Image.fromarray(pixels).save(path, tiffinfo={286: 3.0, 287: 2.0, 282: 1.0, 283: 1.0})
    assert (texels(path).texels == pixels).all()
    assert texels(path).told == ("its offset on a page is not used",)


# -- parts ------------------------------------------------------------------------------------------------------------


def test_the_first_frame_of_an_animation_is_used_and_the_others_are_told(tmp_path: Path) -> None:
    frames = [Image.new("RGB", (6, 4), color) for color in ((255, 0, 0), (0, 255, 0), (0, 0, 255))]
    frames[0].save(tmp_path / "a.gif", save_all=True, append_images=frames[1:])
    found = texels(tmp_path / "a.gif")
    assert (found.texels == (255, 0, 0)).all()
    assert found.told == ("the first of 3 images in the file is used",)


def test_the_first_part_of_an_exr_file_is_used_and_the_others_are_told(tmp_path: Path) -> None:
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    parts = [
        OpenEXR.Part({**header, "name": name}, planes(colors(seed=seed))) for seed, name in ((1, "left"), (2, "right"))
    ]
    OpenEXR.File(parts).write(str(tmp_path / "a.exr"))
    assert (numbers(tmp_path / "a.exr") == colors(seed=1)).all()
    assert texels(tmp_path / "a.exr").told == ("the first of 2 images in the file is used",)


def test_smaller_copies_are_told_and_tiles_are_read(tmp_path: Path) -> None:
    plain = written(tmp_path / "plain.exr", colors(64, 64))
    assert oiio.ImageBufAlgo.make_texture(oiio.MakeTxTexture, str(plain), str(tmp_path / "a.exr"))
    found = texels(tmp_path / "a.exr")
    assert found.linear == pytest.approx(colors(64, 64), abs=1e-3)
    assert found.told == ("6 smaller copies of it are not used",)


def test_pixels_that_are_not_square_are_told(tmp_path: Path) -> None:
    path = written(tmp_path / "a.exr", colors(), PixelAspectRatio=2.0)
    assert (numbers(path) == colors()).all()
    assert texels(path).told == ("pixels of aspect 2 are taken for squares: a picture spans u and v in [0, 1]",)
