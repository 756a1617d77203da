"""Too little memory, too few threads, no room on a disk: one error that says so, with its file."""

from __future__ import annotations

import errno
from collections.abc import Callable
from pathlib import Path
from typing import IO, Any

import numpy as np
import OpenImageIO as oiio  # noqa: N813
import pytest

import equaltime as et
from equaltime import cli
from equaltime import files as disk
from equaltime.experiments.run.record import Recorder
from equaltime.images import image_files as images
from equaltime.scene import scene as scenes

HEAD = '[sensor]\ntype = "perspective"\nfilm = { type = "hdrfilm", width = 2, height = 2 }\n'


def raising(error: BaseException) -> Callable[..., Any]:
    def act(*_: object, **__: object) -> None:
        raise error

    return act


@pytest.mark.parametrize("said", ["Embree cannot create a device", "Embree failed while building the scene, error 1"])
def test_a_scene_that_embree_cannot_build(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], said: str
) -> None:
    file = tmp_path / "scene.toml"
    file.write_text(HEAD + '[sky]\ntype = "constant"\n')
    monkeypatch.setattr(scenes, "compile_scene", raising(RuntimeError(said)))
    assert cli.main(["render", str(file), "-o", str(tmp_path / "out.exr")]) == 1
    expected = f"error: {file}: not enough memory or threads to build the scene ({said})\n"
    assert capsys.readouterr() == ("", expected)


def test_another_error_of_the_core_keeps_its_traceback(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = et.load_dict({"type": "scene", "sensor": {"type": "perspective"}})
    monkeypatch.setattr(scenes, "compile_scene", raising(RuntimeError("a bug")))
    with pytest.raises(RuntimeError, match="a bug"):
        _ = scene.core


def test_a_library_that_does_not_fit_into_memory(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    said = "libscipy_openblas.so: failed to map segment from shared object"
    monkeypatch.setattr(cli, "app", raising(ImportError(said)))
    assert cli.main(["info", "scene.toml"]) == 1
    assert capsys.readouterr().err == f"error: not enough memory: {said}\n"
    monkeypatch.setattr(cli, "app", raising(ImportError("no such module")))
    with pytest.raises(ImportError, match="no such module"):
        cli.main(["info", "scene.toml"])


def test_an_image_library_that_fails_once_is_asked_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    create, calls = oiio.ImageOutput.create, []

    class Late:
        @staticmethod
        def create(kind: str) -> Any:
            calls.append(kind)
            return create(kind) if len(calls) > 1 else None

    monkeypatch.setattr(oiio, "ImageOutput", Late)
    images.write_exr(tmp_path / "a.exr", np.zeros((2, 2, 3)))
    assert len(calls) == 2
    monkeypatch.setattr(Late, "create", staticmethod(lambda kind: None))
    with pytest.raises(et.ImageError, match=r"b\.exr: cannot write: OpenImageIO does not start; memory"):
        images.write_exr(tmp_path / "b.exr", np.zeros((2, 2, 3)))


class Full:
    """A file on a disk without room."""

    def __init__(self, file: IO[bytes]) -> None:
        self.file = file

    def write(self, data: bytes) -> int:
        raise OSError(errno.ENOSPC, "No space left on device")


@pytest.mark.parametrize(
    ("write", "said"),
    [
        (lambda file: Full(file).write(b"x"), "No space left on device"),
        (raising(OSError("12 requested and 0 written")), "12 requested and 0 written"),
    ],
)
def test_a_write_that_fails_names_the_file(tmp_path: Path, write: Callable[[IO[bytes]], object], said: str) -> None:
    path = tmp_path / "a.npy"
    with pytest.raises(OSError, match=said) as caught, disk.replacing(path) as fresh, fresh.open("wb") as file:
        write(file)
    assert caught.value.filename == str(path)
    assert list(tmp_path.iterdir()) == []


def test_records_that_do_not_fit_name_their_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "records.csv"
    monkeypatch.setattr("os.write", raising(OSError(errno.ENOSPC, "No space left on device")))
    with pytest.raises(OSError, match="No space left") as caught, Recorder(path):
        pass
    assert caught.value.filename == str(path)
