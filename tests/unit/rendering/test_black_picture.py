"""A picture that is black everywhere is told of: a warning in Python, one line on the command line."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import equaltime as et
from equaltime.cli import main
from equaltime.experiments.peers.agreement import check
from equaltime.rendering.black_picture import unwarned
from equaltime.rendering.core_subject import Point, RendererKind

FILM = {"type": "hdrfilm", "width": 8, "height": 8}
SENSOR = {"type": "perspective", "film": FILM}
SKY = {"type": "constant"}


def described(**objects: object) -> et.Scene:
    return et.load_dict({"type": "scene", "sensor": SENSOR, **objects})


@pytest.mark.parametrize(
    ("objects", "words"),
    [
        (
            {"ball": {"type": "sphere", "radius": 3.0}, "sky": SKY},
            r"0 %: no sample has met any light; camera-enclosed: .*ball.*you can move the camera out",
        ),
        ({"floor": {"type": "rectangle"}}, r"no-light: .*you can add an emitter"),
        (
            {"lamp": {"type": "point", "position": [0.0, 0.0, -5.0]}},
            r"has met any light; look at where the camera is and what emits light",
        ),
    ],
)
def test_python_warns_of_a_black_picture(objects: dict[str, Any], words: str) -> None:
    with pytest.warns(et.EqualtimeWarning, match=rf"the picture is black everywhere.*{words}") as caught:
        result = et.render(described(**objects), spp=4)
    assert not result.image.any()
    assert [warning.filename for warning in caught] == [__file__]


def test_a_picture_with_light_and_one_that_wants_none_are_not_told_of() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert et.render(described(sky=SKY), spp=4).image.any()
        assert not et.render(described(integrator={"type": "depth"}), spp=4).image.any()


def test_a_thread_that_wants_no_warnings_does_not_silence_another() -> None:
    dark = described(floor={"type": "rectangle"})
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        with unwarned(), ThreadPoolExecutor(1) as pool:
            et.render(dark, spp=4)
            assert not caught
            pool.submit(et.render, dark, spp=4).result()
    assert [warning.category for warning in caught] == [et.EqualtimeWarning]


class _Dark:
    """A peer whose images are black."""

    label = name = "dark"
    renderer: RendererKind = "command"
    biased = False

    def prepare(self, scene: et.Scene, threads: int) -> float:
        self.size = scene.size
        return 0.0

    def run(self, seed: int, ladder: Iterable[int], seconds: float | None = None) -> Iterator[Point]:
        width, height = self.size
        for spp in ladder:
            yield Point(spp, 0.01, 0.01, np.zeros((height, width, 3), np.float32))


def test_peers_are_compared_on_a_black_picture_without_a_warning() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert check(_Dark(), described(floor={"type": "rectangle"}), threads=1, seeds=4).agrees


TOML = """
[sensor]
type = "perspective"
film = { type = "hdrfilm", width = 8, height = 8 }
"""
BALL = '[ball]\ntype = "sphere"\nradius = 3.0\n[sky]\ntype = "constant"\n'
DIM = '[dim]\ntype = "point"\nposition = [0, 0, -5]\nintensity = 1e-13\n'
BEHIND = '[lamp]\ntype = "point"\nposition = [0, 0, -5]\n'


@pytest.mark.parametrize(
    ("objects", "lines"),
    [
        (BALL, ["lint: "]),
        (BEHIND, ["warning: the picture is black everywhere"]),
        (BEHIND + DIM, ["lint: 1 warning (radiance-range)", "warning: the picture is black everywhere"]),
    ],
)
def test_the_command_line_tells_it_once(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], objects: str, lines: list[str]
) -> None:
    scene = tmp_path / "scene.toml"
    scene.write_text(TOML + objects)
    command = ["render", str(scene), "-o", str(tmp_path / "out.exr"), "--spp", "4"]
    assert main(command) == 0
    told = capsys.readouterr().err.splitlines()
    assert [line[: len(start)] for line, start in zip(told, lines, strict=True)] == lines
    assert main([*command, "-q"]) == 0
    assert capsys.readouterr().err == ""
