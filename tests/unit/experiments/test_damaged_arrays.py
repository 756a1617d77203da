"""Damaged images in the folder of an experiment: an error that names the file; missing ones are left out."""

from __future__ import annotations

import io
import pickle
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from equaltime.errors import ImageError
from equaltime.experiments.analysis.strategy_runs import StrategyRuns, runs_of
from equaltime.experiments.run.folder import read_array
from equaltime.experiments.run.record import Row

SHAPE = (3, 4, 3)


def _saved(array: object) -> bytes:
    file = io.BytesIO()
    np.save(file, np.asarray(array))
    return file.getvalue()


def _zipped() -> bytes:
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr("a.npy", _saved(np.zeros(SHAPE)))
    return file.getvalue()


GOOD = _saved(np.ones(SHAPE, np.float32))
HEADER = GOOD[:10]
DAMAGED = {
    "empty": b"",
    "no array": b"no array",
    "cut": GOOD[:-1],
    "cut in its header": GOOD[:40],
    "a bracket that does not close": GOOD.replace(b"(3, 4, 3)", b"((3, 4,)"),
    "no literal": GOOD.replace(b"(3, 4, 3)", b"(3, 4, x)"),
    "more than any memory": GOOD.replace(b"(3, 4, 3), }    ", b"(9999999, 9999)}"),
    "no type": GOOD.replace(b"'<f4'", b"'<x4'"),
    "a type that goes on": GOOD.replace(b"'<f4'", b"'{{4'"),
    "letters beyond ASCII": GOOD.replace(b"'<f4'", b"'<\xff4'"),
    "a pickle": pickle.dumps([1, 2]),
    "objects": _saved(np.array([{}], dtype=object)),
    "an archive": _zipped(),
    "another shape": _saved(np.ones((3, 3))),
    "text": _saved(np.full(SHAPE, "a")),
    "not finite": _saved(np.full(SHAPE, np.nan)),
}


@pytest.mark.parametrize("content", DAMAGED.values(), ids=DAMAGED)
def test_a_damaged_array_is_an_error_that_names_it(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "best-r0.npy"
    path.write_bytes(content)
    with pytest.raises(ImageError, match=r"best-r0\.npy: is damaged: .*; put a copy of the file there, or remove it"):
        read_array(path, SHAPE)


def test_an_array_is_read(tmp_path: Path) -> None:
    """The twin."""
    (tmp_path / "best-r0.npy").write_bytes(GOOD)
    np.testing.assert_array_equal(read_array(tmp_path / "best-r0.npy", SHAPE), np.ones(SHAPE))


@pytest.fixture
def rows(tmp_path: Path, row: Callable[..., Row]) -> tuple[Row, ...]:
    return tuple(row(repeat=repeat, image=f"best-r{repeat}.npy") for repeat in range(3))


@pytest.fixture
def row() -> Callable[..., Row]:
    def make(**values: object) -> Row:
        common: dict[str, object] = dict.fromkeys(Row.__dataclass_fields__, 0)
        texts = ("scene", "digest", "strategy", "name", "renderer", "machine", "build", "started")
        window = {"crop": (0, 0, SHAPE[1], SHAPE[0]), "width": SHAPE[1], "height": SHAPE[0]}
        given = {**common, **dict.fromkeys(texts, "x"), **window, "spp": 2, "relmse": 1.0, "mse": 1.0, "last": True}
        return Row(**{**given, **values})  # type: ignore[arg-type]

    return make


def _images(rows: tuple[Row, ...], folder: Path) -> object:
    return StrategyRuns("best", rows, folder, *runs_of(rows)).images()


def test_a_run_whose_image_is_damaged_is_not_left_out_in_silence(tmp_path: Path, rows: tuple[Row, ...]) -> None:
    for number in range(3):
        (tmp_path / f"best-r{number}.npy").write_bytes(GOOD)
    assert np.shape(_images(rows, tmp_path)) == (3, *SHAPE)  # type: ignore[arg-type]
    (tmp_path / "best-r1.npy").write_bytes(DAMAGED["cut in its header"])
    with pytest.raises(ImageError, match=r"best-r1\.npy: is damaged"):
        _images(rows, tmp_path)
    (tmp_path / "best-r1.npy").unlink()
    assert _images(rows, tmp_path) is None


def test_an_image_that_was_never_finite_is_no_damage(tmp_path: Path, row: Callable[..., Row]) -> None:
    (tmp_path / "best-r0.npy").write_bytes(DAMAGED["not finite"])
    assert _images((row(image="best-r0.npy", mse=float("nan")),), tmp_path) is None
