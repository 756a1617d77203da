"""Every output says why an upper limit cannot be trusted: a table of outputs, on a caustic and on a plain scene."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

import equaltime as et
from equaltime.cli import main
from equaltime.rendering.core_subject import CoreSubject
from equaltime.rendering.render_file import read_picture
from equaltime.statistics.intervals import Interval

SCENES = Path(__file__).parents[2] / "scenes"
CAUSTIC, PLAIN = SCENES / "experiments" / "caustic.toml", SCENES / "cornell-box.toml"
WORDS = "small bright emitters reach the image by way of glass, where"
Said = Callable[[str], str]


def scene(path: Path) -> et.Scene:
    return et.load(path).with_(size=(16, 16))


def saved(path: Path, folder: Path, seed: int = 0) -> Path:
    file = folder / f"{seed}.exr"
    et.render(scene(path), spp=8, seed=seed).save(file)
    return file


def rendered(path: Path, folder: Path, printed: Said) -> str:
    assert main(["render", str(path), "-o", str(folder / "a.exr"), "--size", "16x16", "--spp", "8"]) == 0
    return printed("")


def rendered_json(path: Path, folder: Path, printed: Said) -> str:
    assert main(["render", str(path), "-o", str(folder / "a.exr"), "--size", "16x16", "--spp", "8", "--json"]) == 0
    return str(json.loads(printed(""))["error"].get("doubt", ""))


def quoted(path: Path, folder: Path, printed: Said) -> str:
    assert main(["quote", str(path), "--size", "16x16", "--error", "30%"]) == 0
    return printed("")


def quoted_of_a_render_that_is_taken_up(path: Path, folder: Path, printed: Said) -> str:
    found: list[et.Quote] = []
    et.render(scene(path), error=0.3, resume=saved(path, folder), observer=et.Observer.of(quoted=found.append))
    return found[0].error.doubt


def with_a_bias(path: Path, folder: Path, printed: Said) -> str:
    return et.render(scene(path), spp=8).error.with_bias(Interval(0.1, 0.05, 0.2)).doubt


def in_a_file(path: Path, folder: Path, printed: Said) -> str:
    return str(read_picture(saved(path, folder)).record["error"].get("doubt", ""))


def merged(path: Path, folder: Path, printed: Said) -> str:
    assert main(["merge", *(str(saved(path, folder, s)) for s in (0, 1)), "-o", str(folder / "both.exr")]) == 0
    return printed("")


def compared(path: Path, folder: Path, printed: Said) -> str:
    assert main(["compare", *(str(saved(path, folder, seed)) for seed in (0, 1))]) == 0
    return printed("")


def step_by_step(path: Path, folder: Path, printed: Said) -> str:
    return next(iter(et.progressive(scene(path), spp=8))).error.doubt


def recorded_by_cost(path: Path, folder: Path, printed: Said) -> str:
    subject = CoreSubject("best", et.Strategy())
    subject.prepare(scene(path), 1)
    return " ".join(point.estimate.doubt for point in subject.run(0, [4, 8]) if point.estimate is not None)


OUTPUTS = [
    rendered,
    rendered_json,
    quoted,
    quoted_of_a_render_that_is_taken_up,
    with_a_bias,
    in_a_file,
    merged,
    compared,
    step_by_step,
    recorded_by_cost,
]


@pytest.mark.parametrize(("path", "doubted"), [(CAUSTIC, True), (PLAIN, False)], ids=["caustic", "plain"])
@pytest.mark.parametrize("said", OUTPUTS, ids=lambda said: said.__name__)
def test_every_output_tells_a_doubt_and_none_makes_one_up(
    said: Callable[[Path, Path, Said], str],
    path: Path,
    doubted: bool,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    def printed(_: str) -> str:
        return " ".join(capsys.readouterr().out.split())

    assert (WORDS in said(path, tmp_path, printed)) == doubted


def test_the_doubt_of_a_bias_is_one_of_the_error() -> None:
    error = Interval(0.1, 0.09, 0.11)
    assert error.doubted("of the noise").with_bias(error.doubted("of the bias")).doubt == "of the noise; of the bias"
