"""A folder of experiments: each is run into a folder of its own, and one page shows what became of them."""

from __future__ import annotations

import json
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from equaltime.cli import main
from equaltime.errors import ExperimentError
from equaltime.experiments.analysis.beside import beside
from equaltime.experiments.model.experiment import TheirNumber, Theirs
from equaltime.experiments.report.index import Card, write_index
from equaltime.experiments.run import collection, single_run
from equaltime.experiments.run.collection import Changes, experiments_in, run_all
from equaltime.experiments.run.folder import ExperimentFolder
from equaltime.experiments.run.record import load

from .fake_summary import summary
from .test_report import Page

CORNELL = Path(__file__).parents[3] / "scenes" / "cornell-box.toml"
EXPERIMENT = f"""
title = "T-{{name}}"
scenes = [{{{{ path = "{CORNELL}", size = [8, 8], max_depth = 2 }}}}]
strategies = ["bsdf", "best"]
spp = [2, 4]
repeats = 2
threads = 1
reference = {{{{ error = 0.5, seconds = 0.2 }}}}
"""
THEIRS = Theirs(
    source="They",
    claim="It is faster.",
    numbers=(TheirNumber(what="speed-up", says="20 times", ours="speed-up", strategy="best"),),
)


@pytest.fixture(autouse=True)
def quickly(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr(single_run, "flip", lambda image, truth: 0.5)
    monkeypatch.setattr(collection.conclude.__globals__["report"], "write_report", lambda summary, folder, told: folder)


@pytest.fixture
def source(tmp_path: Path) -> Path:
    folder = tmp_path / "experiments"
    folder.mkdir()
    for name in ("x10-b", "x2-a", "own"):
        (folder / f"{name}.toml").write_text(EXPERIMENT.format(name=name))
    (folder / "scene.toml").write_text(CORNELL.read_text())
    return folder


def test_experiments_come_in_the_order_of_their_numbers_and_scenes_are_none(source: Path) -> None:
    assert [path.stem for path in experiments_in(source)] == ["x2-a", "x10-b", "own"]


def test_a_folder_without_experiments_is_told(tmp_path: Path) -> None:
    with pytest.raises(ExperimentError, match="has no experiment"):
        run_all(tmp_path, tmp_path / "out")


def test_each_experiment_gets_its_folder_and_a_second_time_nothing_is_run(source: Path, tmp_path: Path) -> None:
    out, told, scenes = tmp_path / "out", list[str](), set[str]()
    first = run_all(
        source, out, Changes(), lambda at: scenes.add(at.scene), lambda card: told.append(card.name), "equaltime cost x"
    )
    assert scenes == {f"{name} / cornell-box" for name in told} | {*told}  # the report has no scene
    assert told == ["x2-a", "x10-b", "own"]
    assert [card.state for card in first] == ["done"] * 3
    before = (out / "own" / "records.csv").read_bytes()
    assert len(load(out / "own" / "records.csv")) == 8
    run_all(source, out)
    assert (out / "own" / "records.csv").read_bytes() == before
    provenance = json.loads((out / "own" / "provenance.json").read_text())
    assert [session["command"] for session in provenance["sessions"].values()] == ["equaltime cost x"]


def test_changes_hold_for_all_and_counted_samples_stay_counted(source: Path) -> None:
    experiment = Changes(repeats=3, budget=1.0, targets=(0.3,)).of(collection.read_experiment(source / "own.toml"))
    assert (experiment.repeats, experiment.spp, experiment.budget) == (3, (2, 4), None)
    assert experiment.targets == (0.3,)


def test_every_wrong_file_is_told_before_anything_is_run(source: Path, tmp_path: Path) -> None:
    for name in ("own", "x2-a"):
        (source / f"{name}.toml").write_text('scenes = [{ path = "nothing" }]\nstrategies = ["bset"]\n')
    with pytest.raises(ExperimentError) as caught:
        run_all(source, tmp_path / "out")
    assert [problem.place.split(":")[0][-9:] for problem in caught.value.problems] == [
        *["x2-a.toml"] * 2,
        *["/own.toml"] * 2,
    ]
    assert not (tmp_path / "out").exists()


def test_a_file_that_cannot_be_read_is_told(source: Path, tmp_path: Path) -> None:
    (source / "x3-broken.toml").write_text("scenes = [")
    with pytest.raises(ExperimentError, match=r"x3-broken\.toml:1: not well-formed TOML"):
        run_all(source, tmp_path / "out")


def test_reports_of_an_earlier_run_stay_on_the_page(
    source: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "out" / "own").mkdir(parents=True)
    (tmp_path / "out" / "own" / "report.html").touch()
    monkeypatch.setattr(collection, "_run", lambda *_: pytest.fail("stopped"))
    with pytest.raises(pytest.fail.Exception):
        run_all(source, tmp_path / "out")
    page = Page((tmp_path / "out" / "index.html").read_text("utf-8"))
    assert [link["href"] for link in page.all("a") if "report" in link["href"]] == ["own/report.html"]


def test_an_experiment_that_fails_does_not_keep_the_others_from_running(
    source: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = (source / "x2-a.toml").read_text().replace('"bsdf"', '{ label = "bsdf", python = "none.py:x" }')
    (source / "x2-a.toml").write_text(text)
    out = tmp_path / "out"
    assert main(["cost", str(source), "-o", str(out)]) == 1
    captured = capsys.readouterr()
    assert "x2-a: " in captured.err
    assert captured.out.splitlines()[-1] == f"All of them: open {out}/index.html"
    page = Page((out / "index.html").read_text("utf-8"))
    assert "Failed: " in page.visible
    assert {link["href"] for link in page.all("a")} >= {"x10-b/report.html", "own/report.html"}
    assert "x2-a/report.html" not in {link["href"] for link in page.all("a")}


def test_the_traceback_of_an_unexpected_error_is_kept_until_the_next_try(
    source: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def fails(*_: object) -> None:
        raise KeyError("\ud800")

    out = tmp_path / "out"
    with monkeypatch.context() as patched:
        patched.setattr(single_run, "measure", fails)
        assert main(["cost", str(source), "-o", str(out)]) == 1
    kept = out / "own" / "failure.txt"
    assert f"error: own: KeyError: '\\ud800' (traceback in {kept})" in capsys.readouterr().err
    text = kept.read_text("utf-8")
    assert text.startswith("Traceback")
    assert "in fails" in text
    assert text.endswith("KeyError: '\\ud800'\n")
    assert run_all(source, out)[0].state == "done"
    assert not kept.exists()


@pytest.mark.parametrize("foreign", [False, True])
def test_the_traceback_of_another_process_or_folder_is_left_alone(source: Path, tmp_path: Path, foreign: bool) -> None:
    own = ExperimentFolder(tmp_path / "out" / "own")
    own.path.mkdir(parents=True)
    own.failure.write_text("theirs")
    if foreign:
        own.records.touch()
    for other in source.glob("x*.toml"):
        other.unlink()
    with ExitStack() as stack:
        if not foreign:
            stack.enter_context(own.locked())
        assert [card.state for card in run_all(source, tmp_path / "out")] == ["failed"]
    assert own.failure.read_text() == "theirs"


def test_a_peer_that_is_not_installed_leaves_its_experiment_out(
    source: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    text = (source / "own.toml").read_text().replace('"bsdf"', '{ label = "bsdf", peer = "mitsuba" }')
    (source / "own.toml").write_text(text)
    monkeypatch.setattr(collection, "find_spec", lambda name: None)
    assert main(["cost", str(source), "-o", str(tmp_path / "out")]) == 0
    assert "own: left out: it needs Mitsuba 3: pip install '.[peers]'" in capsys.readouterr().out


def test_what_belongs_to_one_experiment_is_refused_for_a_folder(
    source: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for options in (["--strategies", "best"], ["-D", "a=1"], ["--counts", str(source)]):
        assert main(["cost", str(source), "-o", str(tmp_path / "out"), *options]) == 2
        assert "not for a folder" in capsys.readouterr().err


def test_the_folder_of_one_experiment_is_left_alone(source: Path, tmp_path: Path) -> None:
    (tmp_path / "one").mkdir()
    (tmp_path / "one" / "experiment.json").write_text("{}")
    with pytest.raises(ExperimentError, match="is the folder of one experiment"):
        run_all(source, tmp_path / "one")


def cards(folder: Path) -> tuple[Card, ...]:
    value = summary(folder, scenes=2)
    value = replace(value, theirs=THEIRS, beside=beside(THEIRS, value))
    return (
        Card("x1-a", "X1: <one>", "done", value),
        Card("x2-b", "X2: two", "failed", problem="a scene & more"),
        Card("x3-c", "X3: three"),
    )


def test_the_page_shows_their_figures_ours_a_curve_and_the_way_to_the_report(tmp_path: Path) -> None:
    text = write_index(cards(tmp_path), tmp_path, quick=True, command="equaltime cost here -o there").read_text("utf-8")
    page = Page(text)
    for part in (
        "X1: <one>",
        "It is faster.",
        "20 times",
        "64",
        "1 % error in 100 s",
        "Failed: a scene & more",
        "--quick",
    ):
        assert part in page.visible
    assert "Not run yet." in page.visible
    assert "equaltime cost here -o there" in page.visible
    assert [link["href"] for link in page.all("a") if str(link["href"]).endswith("html")] == ["x1-a/report.html"] * 2
    charts: list[Any] = [svg for svg in page.all("svg") if svg.get("aria-label")]
    assert len(charts) == 1


def test_the_page_fetches_nothing(tmp_path: Path) -> None:
    page = Page(write_index(cards(tmp_path), tmp_path).read_text("utf-8"))
    for tag, attributes in page.elements:
        for name in ("src", "srcset", "data", "action"):
            target = attributes.get(name)
            assert target is None or target.startswith("data:"), (tag, name, target)
    assert "first look" not in page.visible
