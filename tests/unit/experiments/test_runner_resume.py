"""Going on with an experiment: nothing is done twice or lost, and nothing is mixed that does not belong together."""

import json
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from equaltime.errors import ExperimentError, PeerError
from equaltime.experiments.analysis.summarise import summarise
from equaltime.experiments.model.experiment import Experiment
from equaltime.experiments.run import reference as references
from equaltime.experiments.run import runner, single_run
from equaltime.experiments.run.folder import ExperimentFolder
from equaltime.experiments.run.record import load
from equaltime.experiments.run.reference import KnownReference
from equaltime.experiments.run.runner import RunProgress, run
from equaltime.images.metrics import Reference
from equaltime.strategy import Strategy

CORNELL = Path(__file__).parents[3] / "scenes" / "cornell-box.toml"


def experiment(**changes: Any) -> Experiment:
    values: dict[str, Any] = {
        "scenes": [{"path": str(CORNELL), "size": [12, 8], "max_depth": 3, "name": "box"}],
        "strategies": ["bsdf", "best"],
        "spp": [2, 4],
        "repeats": 3,
        "reference": {"error": 0.5, "seconds": 0.2},
    }
    return Experiment.model_validate(values | changes)


@pytest.fixture(autouse=True)
def no_flip(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """FLIP takes longer than all the rest."""
    monkeypatch.setattr(single_run, "flip", lambda image, truth: 0.5)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return tmp_path / "out"


def keys(folder: Path) -> list[tuple[str, str, int]]:
    return list(dict.fromkeys(row.key for row in load(folder / "records.csv")))


def test_running_it_again_does_nothing(folder: Path) -> None:
    run(experiment(), folder)
    files = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    run(experiment(), folder)
    assert {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()} == files


def test_more_repeats_go_on_where_it_was(folder: Path) -> None:
    run(experiment(repeats=1), folder)
    before = (folder / "records.csv").read_bytes()
    run(experiment(repeats=2, title="now named", targets=[0.3], baseline="best"), folder)
    assert (folder / "records.csv").read_bytes().startswith(before)
    assert len(keys(folder)) == 4


def test_what_is_added_is_measured_besides_and_what_is_not_asked_for_stays(folder: Path) -> None:
    run(experiment(strategies=["bsdf", "best"]), folder)
    before = (folder / "records.csv").read_bytes()
    scenes = [*experiment().scenes, {"path": str(CORNELL), "size": [8, 8], "name": "small"}]
    run(experiment(strategies=["mis", "best"], scenes=scenes), folder)
    assert (folder / "records.csv").read_bytes().startswith(before)
    added = keys(folder)[6:]
    assert {key[:2] for key in added} == {("box", "mis"), ("small", "mis"), ("small", "best")}
    assert len(added) == 9
    run(experiment(strategies=["bsdf", "mis", "best"]), folder)
    assert len(keys(folder)) == 15, "all is there"


def test_a_name_never_means_another_thing_even_if_it_was_not_asked_for_in_between(folder: Path) -> None:
    run(experiment(repeats=1), folder)
    run(experiment(repeats=1, strategies=["bsdf"]), folder)
    with pytest.raises(ExperimentError, match=r'strategies\.best\.name is "best" there, and "mis" now'):
        run(experiment(strategies=["bsdf", {"label": "best", "strategy": "mis"}]), folder)


def test_a_strategy_that_was_added_later_says_so(folder: Path) -> None:
    run(experiment(strategies=["bsdf", "best"]), folder)
    later = experiment(strategies=["bsdf", "mis", "best"])
    run(later, folder)
    bsdf, mis, best = summarise(later, load(folder / "records.csv"), folder).scenes[0].strategies
    assert any("measured apart from bsdf" in note for note in mis.notes)
    assert not any("measured apart" in note for note in (*bsdf.notes, *best.notes))


@pytest.mark.parametrize(
    ("changes", "what"),
    [
        ({"spp": [2, 6]}, r"spp\[1\] is 4 there, and 6 now"),
        ({"strategies": ["bsdf", {"label": "best", "strategy": "mis"}]}, 'strategies.best.name is "best" there'),
        ({"scenes": [{"path": str(CORNELL), "size": [12, 8], "name": "box"}]}, "scenes.box.max_depth is 3 there"),
        ({"reference": {"error": 0.4, "seconds": 0.2}}, r"reference.error is 0\.5 there, and 0\.4 now"),
        ({"threads": 3}, "threads is . there, and 3 now"),
    ],
)  # fmt: skip
def test_another_experiment_does_not_get_into_the_same_folder(folder: Path, changes: dict[str, Any], what: str) -> None:
    run(experiment(repeats=1), folder)
    files = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    with pytest.raises(ExperimentError, match=f"has records of another experiment: {what}"):
        run(experiment(**changes), folder)
    assert {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()} == files


def with_program(folder: Path, text: str, repeats: int = 1, log: str = "") -> Experiment:
    """Return an experiment with a renderer that is a script, which stands beside the folder with this text."""
    (folder.parent / "mine.sh").write_text(f"#!/bin/sh\n{text}\ncp image.pfm $1\n")
    (folder.parent / "image.pfm").write_bytes(b"PF\n12 8\n-1.0\n" + np.ones((8, 12, 3), "<f4").tobytes())
    command = f"sh mine.sh {{out}}.pfm {{spp}} {{seed}} --log={log}"
    strategies = ["best", {"label": "mine", "peer": {"command": command}}]
    return experiment(strategies=strategies, baseline="best", repeats=repeats, folder=folder.parent)


def test_a_program_that_changed_after_its_runs_does_not_get_into_the_same_folder(folder: Path) -> None:
    run(with_program(folder, "true", log="log.txt"), folder)
    identity = json.loads((folder / "experiment.json").read_text())["identity"]["strategies"]
    assert identity["mine"]["files"].keys() == {"sh", "mine.sh"}
    assert "files" not in identity["best"]
    (folder.parent / "log.txt").write_text("the program wrote this")
    run(with_program(folder, "true", repeats=2, log="log.txt"), folder)
    before = (folder / "records.csv").read_bytes()
    (folder.parent / "log.txt").write_text("and this")
    what = r"mine\.sh, a file of the program of mine, has changed since its runs\n"
    with pytest.raises(ExperimentError, match=f"has records of another experiment: {what}"):
        run(with_program(folder, "false", repeats=3, log="log.txt"), folder)
    assert (folder / "records.csv").read_bytes() == before


def test_a_folder_of_an_earlier_version_takes_the_files_of_programs(folder: Path) -> None:
    run(with_program(folder, "true"), folder)
    stored = json.loads((folder / "experiment.json").read_text())
    files = stored["identity"]["strategies"]["mine"].pop("files")
    (folder / "experiment.json").write_text(json.dumps(stored))
    run(with_program(folder, "true", repeats=2), folder)
    assert json.loads((folder / "experiment.json").read_text())["identity"]["strategies"]["mine"]["files"] == files


def test_a_folder_without_a_finished_run_takes_another_experiment(folder: Path) -> None:
    with pytest.raises(PeerError, match="mine"):
        run(with_program(folder, "exit 3"), folder)
    (folder / "notes.txt").write_text("mine")
    references.write(
        ExperimentFolder(folder).reference("box"),
        KnownReference(Reference(np.ones((9, 9, 3)), np.zeros((9, 9, 3))), {}),
    )
    run(experiment(repeats=1, spp=[3, 9]), folder)
    assert {row.strategy for row in load(folder / "records.csv")} == {"bsdf", "best"}
    stored = json.loads((folder / "experiment.json").read_text())
    assert stored["identity"]["spp"] == stored["experiment"]["spp"] == [3, 9]
    assert "mine" not in stored["identity"]["strategies"]
    assert "agreements" not in ExperimentFolder(folder).read_provenance()
    assert (folder / "notes.txt").read_text() == "mine"


def test_a_run_that_did_not_end_does_not_hold_the_folder(folder: Path) -> None:
    """Rows of an unfinished run are no record: the next call removes them anyway."""
    run(experiment(repeats=1), folder)
    records = folder / "records.csv"
    records.write_text("".join(records.read_text().splitlines(keepends=True)[:2]))
    run(experiment(repeats=1, spp=[3, 9]), folder)
    assert {row.spp for row in load(records)} == {3, 9}


def test_all_words_of_a_strategy_are_kept_whatever_its_preset_becomes(folder: Path) -> None:
    run(experiment(repeats=1), folder)
    kept = ExperimentFolder(folder).read_provenance()["strategies"]
    assert kept["best"]["words"].startswith("technique=mis,heuristic=power,")
    assert {Strategy.parse(facts["words"]).name for facts in kept.values()} == {"bsdf", "best"}


@pytest.mark.parametrize("kind", ["machine", "build"])
def test_times_of_another_machine_or_build_are_not_mixed(
    folder: Path, kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    run(experiment(repeats=1), folder)
    monkeypatch.setattr(runner, f"{kind}_facts", lambda: {"other": True})
    with pytest.raises(ExperimentError, match=f"has times of another {kind}"):
        run(experiment(repeats=2), folder)
    assert len(keys(folder)) == 2


def test_a_folder_with_files_that_are_not_ours_is_left_alone(folder: Path) -> None:
    folder.mkdir()
    (folder / "notes.txt").write_text("mine")
    (folder / "report.html").write_text("mine too")
    with pytest.raises(ExperimentError, match=r"out: has report\.html, but not of an experiment"):
        run(experiment(), folder)
    (folder / "report.html").unlink()
    run(experiment(repeats=1), folder)
    assert (folder / "notes.txt").read_text() == "mine"


def test_a_folder_that_cannot_be_made_is_named(folder: Path) -> None:
    folder.write_text("a file")
    with pytest.raises(ExperimentError, match=r"out: "):
        run(experiment(), folder)


PROGRAM = """
import sys
from pathlib import Path
sys.path.insert(0, sys.argv[2])
from equaltime.experiments.run import single_run
single_run.flip = lambda image, truth: 0.5
from test_runner_resume import experiment
from equaltime.experiments.run.runner import RunProgress, run
run(experiment(repeats=int(sys.argv[3])), Path(sys.argv[1]), lambda p: print(p.phase, flush=True))
"""


def start(folder: Path, repeats: int) -> "subprocess.Popen[bytes]":
    here = str(Path(__file__).parent)
    return subprocess.Popen([sys.executable, "-c", PROGRAM, str(folder), here, str(repeats)], stdout=subprocess.PIPE)


def kill_and_finish(folder: Path, kills: int, repeats: int) -> None:
    """Kill the experiment at random moments, finish it, and compare with one that nobody disturbed."""
    begin = time.perf_counter()
    with start(folder.with_name("undisturbed"), repeats) as process:
        assert process.stdout is not None
        process.stdout.readline()
        ready = time.perf_counter() - begin
        process.stdout.read()
    length = time.perf_counter() - begin - ready
    finished = 0
    for moment in np.random.default_rng(3).uniform(-0.1 * ready, length, kills):
        with start(folder, repeats) as process:
            time.sleep(ready + moment)
            process.send_signal(signal.SIGKILL)
        done = [row for row in load(folder / "records.csv") if row.last]
        assert len(done) >= finished
        finished = len(done)
    run(experiment(repeats=repeats), folder)
    rows, expected = load(folder / "records.csv"), load(folder.with_name("undisturbed") / "records.csv")
    names = ("scene", "strategy", "repeat", "checkpoint", "spp", "seed", "estimate", "last", "image")
    assert [[getattr(row, name) for name in names] for row in rows] == [
        [getattr(row, name) for name in names] for row in expected
    ]
    assert json.loads((folder / "provenance.json").read_text())["references"].keys() == {"box"}
    assert not list(folder.rglob("*.part"))


def test_an_experiment_survives_kills(folder: Path) -> None:
    kill_and_finish(folder, kills=2, repeats=20)


@pytest.mark.slow
def test_an_experiment_survives_many_kills(folder: Path) -> None:
    kill_and_finish(folder, kills=40, repeats=300)


def test_an_experiment_that_is_running_keeps_its_identity(folder: Path) -> None:
    """Another process adds a strategy to it meanwhile."""
    begun, failures = ExperimentFolder(folder).experiment, list[str]()

    def meanwhile(told: RunProgress) -> None:
        identity = begun.read_bytes()
        with pytest.raises(ExperimentError) as caught:
            run(experiment(strategies=["bsdf", "best", "mis"]), folder)
        failures.append(str(caught.value))
        assert begun.read_bytes() == identity

    run(experiment(), folder, meanwhile)
    assert set(failures) == {
        f"{folder}: another process runs its experiment; wait until that ends, or use another folder"
    }
    run(experiment(strategies=["bsdf", "best", "mis"]), folder)


def test_the_provenance_is_written_by_the_process_that_has_the_lock(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    note, noted = ExperimentFolder.note, list[str]()

    def noted_under_lock(self: ExperimentFolder, section: str, *rest: Any) -> None:
        with pytest.raises(ExperimentError, match="another process"), self.locked():
            pass
        noted.append(section)
        note(self, section, *rest)

    monkeypatch.setattr(ExperimentFolder, "note", noted_under_lock)
    run(experiment(), folder)
    assert set(noted) == {"machines", "builds", "own_depths", "strategies", "references", "sessions"}


@pytest.mark.parametrize("step", ["note", "write"])
def test_how_a_reference_was_made_is_told_wherever_making_it_ended(
    folder: Path, step: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    note = ExperimentFolder.note

    def interrupted(*arguments: Any) -> None:
        if step == "note" and arguments[1] != "references":
            return note(*arguments)
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(*((ExperimentFolder, "note") if step == "note" else (references, "write")), interrupted)
        with pytest.raises(KeyboardInterrupt):
            run(experiment(repeats=1), folder)
    run(experiment(repeats=1), folder)
    assert json.loads((folder / "provenance.json").read_text())["references"].keys() == {"box"}


def test_a_process_that_was_killed_before_its_first_record_is_continued(folder: Path) -> None:
    with ExperimentFolder(folder).locked():
        pass
    run(experiment(), folder)
