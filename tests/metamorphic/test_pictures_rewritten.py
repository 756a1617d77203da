"""Pictures that are rewritten without a change of meaning load to the same bits, and known changes follow.

Each example writes one picture in another way: format, orientation with its flag, data window, channels, compression,
type. Old faults, put back, must be caught.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

import equaltime as et
from equaltime.scene import pictures
from equaltime.scene.pictures import read_picture

from ..unit.scene.picture_files import FILE_ORIENTATIONS, hdr, scene, written
from .picture_rewrites import Rewrite, bordered, bytes_, floats, radiance

EVERYDAY, MANY = 200, 10_000
SEARCH = (Phase.generate,)
"""Phases for faults: an example that fails is wanted, but not the smallest one."""
Pixels = NDArray[np.float32]


def check_floats(pixels: Pixels, rewrite: Rewrite) -> None:
    with TemporaryDirectory() as folder:
        path = rewrite.write(Path(folder), pixels)
        for raw in (False, True):
            found = read_picture(path, raw)
            assert np.array_equal(found.linear, pixels)
            assert found.told == ()


def check_bytes(pixels: Pixels, rewrite: Rewrite) -> None:
    with TemporaryDirectory() as folder:
        path = rewrite.write(Path(folder), pixels)
        for raw in (False, True):
            found = read_picture(path, raw)
            assert np.array_equal(found.texels, pixels * 256)
            assert found.texels.dtype == np.uint8
            assert (found.srgb, found.told) == (not raw, ())


def check_radiance(pixels: Pixels, rewrite: Rewrite) -> None:
    with TemporaryDirectory() as folder:
        fours = np.dstack([pixels * 256, np.full((*pixels.shape[:2], 1), 128)])
        plain = read_picture(hdr(Path(folder) / "plain.hdr", fours))
        found = read_picture(rewrite.write(Path(folder), pixels))
        assert np.array_equal(found.linear, plain.linear)
        assert found.told == ()


KINDS: dict[str, tuple[Callable[[Pixels, Rewrite], None], st.SearchStrategy[Rewrite]]] = {
    "floats": (check_floats, floats()),
    "bytes": (check_bytes, bytes_()),
    "radiance": (check_radiance, radiance()),
}


def examine(kind: str, examples: int, phases: Sequence[Phase] = tuple(Phase)) -> None:
    """Look at so many examples of a kind; raises AssertionError for the first that loads to something else."""
    check, rewrites = KINDS[kind]

    @settings(max_examples=examples, deadline=None, database=None, phases=phases)
    @given(pixels=bordered(), rewrite=rewrites)
    def every_example(pixels: Pixels, rewrite: Rewrite) -> None:
        check(pixels, rewrite)

    every_example()


@pytest.mark.parametrize("kind", KINDS)
def test_a_picture_written_in_another_way_loads_to_the_same_bits(kind: str) -> None:
    examine(kind, EVERYDAY)


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_a_picture_written_in_ten_thousand_ways_loads_to_the_same_bits(kind: str) -> None:
    examine(kind, MANY)


# -- known changes ----------------------------------------------------------------------------------------------------


@settings(max_examples=EVERYDAY, deadline=None, database=None)
@given(pixels=bordered(), turn=st.integers(1, 8), x=st.integers(-3, 3), y=st.integers(-3, 3))
def test_known_changes_follow(pixels: Pixels, turn: int, x: int, y: int) -> None:
    """A flag alone turns the picture, an offset of the data window moves it, swapped names swap its colours."""
    height, width, _ = pixels.shape
    with TemporaryDirectory() as folder:
        path = Path(folder) / "a.exr"
        turned = read_picture(written(path, pixels, Orientation=turn)).linear
        assert np.array_equal(FILE_ORIENTATIONS[turn](turned), pixels)
        moved = read_picture(written(path, pixels, data=(x, y), display=(width, height))).linear
        wide = np.pad(pixels, ((3, 3), (3, 3), (0, 0)))
        assert np.array_equal(moved, wide[3 - y : 3 - y + height, 3 - x : 3 - x + width])
        assert np.array_equal(read_picture(written(path, pixels, "B G R")).linear, pixels[..., ::-1])


@pytest.mark.parametrize("use", ["texture", "sky"])
def test_rewritten_pictures_render_to_the_same_bits(tmp_path: Path, use: str) -> None:
    pixels = np.pad(
        np.random.default_rng(5).integers(1, 256, (6, 8, 3)).astype(np.float32) / 256, ((1, 1), (2, 2), (0, 0))
    )
    plain = written(tmp_path / "plain.exr", pixels)
    other = written(tmp_path / "other.exr", FILE_ORIENTATIONS[6](pixels).astype(np.float16), tile=16, Orientation=6)
    cropped = written(tmp_path / "cropped.exr", pixels[1:7, 2:10], data=(2, 1), display=(12, 8))
    images = [et.render(scene(path, use).with_(size=(16, 16)), spp=4).image for path in (plain, other, cropped)]
    assert images[0].any()
    assert all(np.array_equal(image, images[0]) for image in images)


# -- power ------------------------------------------------------------------------------------------------------------


def shown_without_window(pixels: NDArray[Any], window: object) -> NDArray[Any]:
    return np.ascontiguousarray(pixels)


FAULTS: dict[str, tuple[str, str, Any]] = {
    "orientations are not looked at": ("floats", "upright", lambda pixels, orientation: pixels),
    "those of bytes are not": ("bytes", "upright", lambda pixels, orientation: pixels),
    "those of Radiance are not": ("radiance", "upright", lambda pixels, orientation: pixels),
    "the data window is stretched": ("floats", "_shown", shown_without_window),
    "the first three channels are the colour": ("floats", "choose", lambda names: FIRST_THREE),
}
FIRST_THREE = pictures.Choice("colour", (0, 1, 2), None, True)


@pytest.mark.parametrize("name", FAULTS)
def test_old_faults_are_caught(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    kind, where, fault = FAULTS[name]
    monkeypatch.setattr(pictures, where, fault)
    with pytest.raises(AssertionError):
        examine(kind, EVERYDAY, SEARCH)
