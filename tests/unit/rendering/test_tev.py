"""tev's protocol, spoken to a small server that reads it as tev does."""

from __future__ import annotations

import socket
import struct
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import equaltime as et
from equaltime.cli import main
from equaltime.rendering import tev

SCENE = Path(__file__).parents[3] / "scenes" / "cornell-box.toml"
MESSAGES: dict[int, str] = {4: "create", 6: "update"}


class FakeTev:
    """Keeps the images that it is sent, by name, and how often each was updated."""

    def __init__(self) -> None:
        self.images: dict[str, NDArray[np.float32]] = {}
        self.updates = 0
        self._listening = socket.create_server(("127.0.0.1", 0))
        self.address = f"127.0.0.1:{self._listening.getsockname()[1]}"
        self._thread = threading.Thread(target=self._serve)
        self._thread.start()

    def wait(self) -> None:
        self._thread.join(10.0)
        self._listening.close()

    def _serve(self) -> None:
        connection, _ = self._listening.accept()
        with connection, connection.makefile("rb") as stream:
            while head := stream.read(4):
                (length,) = struct.unpack("<I", head)
                self._take(stream.read(length - 4))

    def _take(self, body: bytes) -> None:
        kind, rest = MESSAGES[body[0]], body[2:]
        name, rest = text(rest)
        if kind == "create":
            (width, height, count), rest = numbers("<3i", rest)
            self.images[name] = np.full((height, width, count), np.nan, np.float32)
            assert names(rest, count) == (["R", "G", "B"], b"")
            return
        ((count,), rest) = numbers("<i", rest)
        channels, rest = names(rest, count)
        (x, y, width, height), rest = numbers("<4i", rest)
        offsets, rest = numbers(f"<{count}q", rest)
        strides, rest = numbers(f"<{count}q", rest)
        data = np.frombuffer(rest, "<f4")
        assert len(data) == max(o + (width * height - 1) * s + 1 for o, s in zip(offsets, strides, strict=True))
        for channel, offset, stride in zip(map("RGB".index, channels), offsets, strides, strict=True):
            plane = data[offset::stride][: width * height].reshape(height, width)
            self.images[name][y : y + height, x : x + width, channel] = plane
        self.updates += 1


def text(data: bytes) -> tuple[str, bytes]:
    words, _, rest = data.partition(b"\0")
    return words.decode(), rest


def names(data: bytes, count: int) -> tuple[list[str], bytes]:
    found = []
    for _ in range(count):
        name, data = text(data)
        found.append(name)
    return found, data


def numbers(form: str, data: bytes) -> tuple[tuple[int, ...], bytes]:
    size = struct.calcsize(form)
    return struct.unpack(form, data[:size]), data[size:]


@contextmanager
def fake_tev() -> Iterator[FakeTev]:
    server = FakeTev()
    yield server
    server.wait()


def test_an_image_arrives_whole_in_however_many_pieces(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tev, "_MOST_BYTES", 1000)
    image = np.random.default_rng(1).random((50, 31, 3)).astype(np.float32)
    with fake_tev() as server:
        viewer = tev.Viewer(server.address, "größe")
        viewer.show(np.zeros_like(image))
        viewer.show(image)
        viewer.close()
    assert viewer.problem is None
    np.testing.assert_array_equal(server.images["größe"], image)
    assert server.updates == 2 * 25


def test_a_render_shows_its_passes_and_ends_with_its_image() -> None:
    with fake_tev() as server:
        viewer = tev.Viewer(server.address)
        result = et.render(et.load(SCENE).with_(size=(20, 12)), spp=8, show=viewer)
        viewer.close()
    np.testing.assert_array_equal(server.images["equaltime"], result.image)
    assert server.updates >= 2


def test_nobody_there_is_one_message_and_the_render_is_kept(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        address = f"127.0.0.1:{taken.getsockname()[1]}"
    output = tmp_path / "a.exr"
    command = ["render", str(SCENE), "-o", str(output), "--spp", "8", "--size", "16x16", "--tev", address]
    assert main(command) == 0
    said = [line for line in capsys.readouterr().err.splitlines() if "tev" in line]
    assert said == [f"warning: tev at {address}: Connection refused; the render goes on"]
    assert output.exists()


def test_a_viewer_that_goes_away_is_let_go() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        viewer = tev.Viewer(f"127.0.0.1:{server.getsockname()[1]}")
        viewer.show(np.zeros((4, 4, 3)))
        connection, _ = server.accept()
        connection.close()
        for _ in range(100):
            viewer.show(np.zeros((64, 64, 3)))
        assert viewer.problem is not None
        assert "the render goes on" in viewer.problem
        assert not viewer.due


def test_a_viewer_that_reads_nothing_holds_up_no_pass(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tev, "_PATIENCE", 0.5)
    with socket.create_server(("127.0.0.1", 0)) as server:
        viewer = tev.Viewer(f"127.0.0.1:{server.getsockname()[1]}")
        large = np.zeros((2048, 2048, 3), np.float32)
        viewer.offer(large)
        assert not viewer.due, "the first is under way"
        assert viewer.problem is None
        viewer.show(large)
    assert viewer.problem is not None, "what was offered was waited for"


@pytest.mark.parametrize("address", [":14158", "localhost:tev", "localhost:70000", "", "localhost:"])
def test_what_is_no_address_is_refused(address: str) -> None:
    with pytest.raises(et.RenderError, match="expected HOST:PORT"):
        tev.Viewer(address)


@pytest.mark.parametrize("address", ["host..lan:14158", f"{'x' * 64}.lan"])
def test_a_name_that_is_no_host_is_told_and_the_render_goes_on(address: str) -> None:
    viewer = tev.Viewer(address)
    assert et.render(et.load(SCENE).with_(size=(8, 8)), spp=2, show=viewer).spp == 2
    assert viewer.problem is not None
    assert viewer.problem.endswith("the render goes on")


def test_a_name_that_is_no_text_can_be_shown() -> None:
    server = FakeTev()
    viewer = tev.Viewer(server.address, "\udcff.exr")
    viewer.show(np.ones((2, 2, 3)))
    viewer.close()
    server.wait()
    assert viewer.problem is None
    assert list(server.images) == ["?.exr"]
