"""Wherever an image by Mitsuba is the reference, the output says what it is worth; unfit samplers never make one."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import equaltime as et
from equaltime.cli.cost_table import print_summary
from equaltime.experiments.model.experiment import Experiment, ReferenceWish
from equaltime.experiments.peers.agreement import Gate, own_reference
from equaltime.experiments.peers.mitsuba import MitsubaPeer
from equaltime.experiments.report.words import facts
from equaltime.experiments.run.reference import obtain
from equaltime.images import image_files as images
from equaltime.images.mitsuba_reference import CAVEAT, UNFIT_SAMPLERS
from equaltime.rendering.core_subject import Point
from equaltime.statistics.agreement import BlockMeans

from ..experiments.fake_summary import scene_result, summary

SHAPE = (32, 32, 3)
SCENE = et.load(Path(__file__).parents[3] / "scenes" / "cornell-box.toml").with_(size=SHAPE[:2], max_depth=2)
WRITERS = {"Mitsuba version 3.9.1": True, "equaltime 0.1.0": False, "": False}


def picture(path: Path, writer: str, seed: int = 0) -> Path:
    """Write an image as Mitsuba does, which names itself in the attribute generatedBy."""
    pixels = np.random.default_rng(seed).uniform(0.4, 0.6, SHAPE).astype(np.float32)
    images.write(path, "openexr", [images.Layer(("R", "G", "B"), pixels, {"generatedBy": writer} if writer else {})])
    return path


@pytest.mark.parametrize("writer", WRITERS)
def test_compare_says_what_a_reference_by_mitsuba_is_worth(writer: str, tmp_path: Path) -> None:
    first, second, last = (picture(tmp_path / f"{i}.exr", "", i) for i in range(3))
    picture(last, writer, 2)
    assert any(CAVEAT in note for note in et.compare(first, second, last).notes) == WRITERS[writer]
    assert any(CAVEAT in note for note in et.compare(first, last).notes) == WRITERS[writer]
    assert not any(CAVEAT in note for note in et.compare(last, first).notes)


@pytest.mark.parametrize("writer", WRITERS)
def test_a_reference_file_by_mitsuba_has_a_caveat(writer: str, tmp_path: Path) -> None:
    known = obtain(SCENE, ReferenceWish(file=picture(tmp_path / "r.exr", writer)))
    assert known.facts.get("caveat", "") == (CAVEAT if WRITERS[writer] else "")


def test_page_and_command_line_repeat_the_caveat(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    exact = replace(scene_result(tmp_path), reference_error=0.0)
    assert "exact truth" in facts(exact)
    limited = replace(exact, reference_caveat=CAVEAT)
    assert CAVEAT in facts(limited)
    assert "exact truth" not in facts(limited)
    whole = summary(tmp_path)
    print_summary(replace(whole, scenes=(limited,)), tmp_path)
    assert CAVEAT in capsys.readouterr().out
    print_summary(replace(whole, scenes=(exact,)), tmp_path)
    assert CAVEAT not in capsys.readouterr().out


@pytest.mark.filterwarnings("ignore:with . repeat:equaltime.EqualtimeWarning")
@pytest.mark.parametrize("writer", WRITERS)
def test_a_summary_has_the_caveat_of_the_file_that_an_experiment_names(writer: str, tmp_path: Path) -> None:
    experiment = Experiment.model_validate(
        {
            "scenes": [{"name": "box", "scene": SCENE}],
            "strategies": [{"strategy": "best"}],
            "spp": (1, 2),
            "repeats": 1,
            "reference": {"file": picture(tmp_path / "r.exr", writer)},
        }
    )
    found = et.cost(experiment, tmp_path / "out")
    assert found.scenes[0].reference_caveat == (CAVEAT if WRITERS[writer] else "")


def gate(note: str, p: float) -> Gate:
    verdict: Any = type("Verdict", (), {"p": p})
    ours = BlockMeans(np.ones((2, 2, 3)), np.ones((2, 2, 3)), 63.0)
    return Gate(verdict, ours, 1e-3, (48, 48), 64, note)


@pytest.mark.parametrize("sampler", ["independent", "multijitter", *UNFIT_SAMPLERS])
def test_a_peer_that_does_not_agree_is_told_what_its_own_reference_is_worth(sampler: str) -> None:
    note = MitsubaPeer("theirs", sampler=sampler).reference_note
    assert CAVEAT in gate(note, 1e-6).note
    assert (f"{sampler} is no reference" in gate(note, 1e-6).note) == (sampler in UNFIT_SAMPLERS)
    assert gate(note, 0.5).note == ""


@pytest.mark.parametrize("sampler", ["independent", "multijitter", *UNFIT_SAMPLERS])
def test_an_unfit_sampler_never_makes_a_reference(sampler: str, monkeypatch: pytest.MonkeyPatch) -> None:
    rendered: set[str] = set()
    closed: list[str] = []

    def run(self: MitsubaPeer, seed: int, ladder: Iterable[int], seconds: float | None = None) -> Iterator[Point]:
        rendered.add(self.sampler)
        for spp in ladder:
            yield Point(spp, 1.0, 1.0, np.random.default_rng(seed).uniform(0.4, 0.6, SHAPE).astype(np.float32))

    monkeypatch.setattr(MitsubaPeer, "prepare", lambda *_: 0.0)
    monkeypatch.setattr(MitsubaPeer, "run", run)
    monkeypatch.setattr(MitsubaPeer, "close", lambda self: closed.append(self.sampler))
    known = own_reference(MitsubaPeer("theirs", "scalar_rgb", sampler=sampler), SCENE, 0.5, 1.0)
    fit = "independent" if sampler in UNFIT_SAMPLERS else sampler
    assert rendered == {fit}
    assert closed == ([] if fit == sampler else [fit])
    assert f"sampler={fit}" in known.facts["strategy"]
    assert known.facts["caveat"] == CAVEAT
