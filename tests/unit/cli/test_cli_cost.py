"""``equaltime cost`` as a user meets it: what it takes, what it says, and what a signal leaves behind."""

import json
import math
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest

import equaltime as et
from equaltime import cost as measure_cost
from equaltime.cli import main
from equaltime.cli.progress import describe, time_left
from equaltime.errors import ExperimentError
from equaltime.experiments import report
from equaltime.experiments.analysis import summarise as analysis
from equaltime.experiments.model import reader as making
from equaltime.experiments.model.reader import make_experiment, split_strategies
from equaltime.experiments.model.summary import Curve, SceneResult, StrategyResult, Summary
from equaltime.experiments.run import single_run
from equaltime.experiments.run.record import load
from equaltime.experiments.run.runner import RunProgress
from equaltime.statistics.intervals import UNKNOWN, Interval

CORNELL = Path(__file__).parents[3] / "scenes" / "cornell-box.toml"
SMALL = ["--size", "8x8", "--repeats", "2", "--budget", "20ms", "--threads", "1"]


def stub(experiment: Any, rows: Any, folder: Path) -> Summary:
    """Summarise without looking: what the summary says is not tested here."""
    number = Interval(0.5, 0.25, 1.0)
    curve = Curve((2,), (number,), (number,), number, (number,))
    strategies = tuple(
        StrategyResult(
            label=entry.label,
            name=entry.label,
            renderer="core",
            biased=False,
            repeats=2,
            curve=curve,
            time_to={
                target: Interval(math.inf, 1.0, math.inf) if target > 0.05 else number for target in experiment.targets
            },
            ratio=dict.fromkeys(experiment.targets, number),
            efficiency=number,
            error_at_budget=number,
            fewer_samples=UNKNOWN,
            equality_p=None,
            bias=None,
            notes=(),
            image=Path("x.npy"),
        )
        for entry in experiment.strategies
    )
    scene = SceneResult("box", "", (8, 8), 2, 0.1, experiment.baseline, None, 0.02, strategies)
    return Summary(
        "title",
        "",
        (scene,),
        experiment.targets,
        {"rows": len(rows)},
        VERDICT,
    )


VERDICT = "On box, best is about 2 times faster than bsdf (1.5 to 3)."


@pytest.fixture
def quickly(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave out what takes seconds and has tests of its own."""
    monkeypatch.setattr(analysis, "summarise", stub, raising=False)
    monkeypatch.setattr(report, "write_report", lambda summary, folder, told: folder / "report.html")
    monkeypatch.setattr(single_run, "flip", lambda image, truth: 0.5)


@pytest.fixture(autouse=True)
def cache(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return tmp_path / "out"


@pytest.fixture
def experiment(tmp_path: Path) -> Path:
    path = tmp_path / "x.toml"
    path.write_text(
        f'scenes = [{{ path = "{CORNELL}", size = [8, 8], max_depth = 2 }}]\nstrategies = ["bsdf", "best"]\n'
        "spp = [2, 4]\nrepeats = 2\nreference = { error = 0.5, seconds = 0.2 }\n"
    )
    return path


@pytest.mark.usefixtures("quickly")
def test_an_experiment_begins_and_ends_with_the_verdict(
    experiment: Path, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["cost", str(experiment), "-o", str(folder)]) == 0
    captured = capsys.readouterr()
    assert captured.err == (
        "references of up to 200 ms each, then 4 runs of 4 samples a pixel; "
        "with 2 repeats there are no intervals: --repeats 3 is the least, 6 are better; "
        "the baseline of all ratios is bsdf\n"
    )
    lines = captured.out.splitlines()
    assert lines[0] == lines[-1] == VERDICT
    assert [line.split()[0] for line in lines[1:4]] == ["strategy", "bsdf", "best"]
    assert "time to 2" in lines[1]
    assert "10" not in lines[1]  # nothing is known of it
    assert lines[-2] == f"Curves and pictures: open {folder}/report.html"
    assert len(load(folder / "records.csv")) == 8


def test_the_name_of_an_example_is_no_reason_for_a_warning(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["cost", "experiments", "-o", "out", "--strategies", "best"]) == 2, "options that a folder refuses"
    told = capsys.readouterr().err
    assert told.startswith("experiments is the example ")
    assert "warning" not in told


@pytest.mark.usefixtures("quickly")
def test_the_command_line_is_kept_with_the_runs_that_it_made(experiment: Path, folder: Path) -> None:
    arguments = ["cost", str(experiment), "-o", str(folder), "--repeats", "1"]
    for count in ("1", "2", "2"):
        assert main([*arguments[:-1], count]) == 0
    sessions = json.loads((folder / "provenance.json").read_text())["sessions"]
    begin = f"equaltime cost {experiment} -o {folder} --repeats"
    assert [session["command"] for session in sessions.values()] == [f"{begin} 1", f"{begin} 2"]


@pytest.mark.usefixtures("quickly")
def test_json_has_the_summary_and_nothing_that_json_has_not(
    experiment: Path, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["cost", str(experiment), "-o", str(folder), "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["verdict"] == VERDICT
    result = data["scenes"][0]["strategies"][0]
    unreached = {"value": None, "low": 1.0, "high": None, "trusted": True, "never": True}
    assert result["time_to"]["0.1"] == unreached
    assert result["image"] == "x.npy"


@pytest.mark.usefixtures("quickly")
def test_options_beat_the_experiment(experiment: Path, folder: Path) -> None:
    options = ["--repeats", "1", "--size", "6x4", "--threads", "1", "--strategies", "best,mis,sampler=sobol"]
    assert main(["cost", str(experiment), "-o", str(folder), *options]) == 0
    rows = load(folder / "records.csv")
    assert {(row.width, row.height, row.repeat, row.threads) for row in rows} == {(6, 4, 0, 1)}
    assert {(row.strategy, row.name) for row in rows} == {("best", "best"), ("mis,sampler=sobol",) * 2}


@pytest.mark.usefixtures("quickly")
def test_targets_are_chosen_on_the_command_line(
    experiment: Path, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["cost", str(experiment), "-o", str(folder), "--repeats", "1", "--targets", "30%,0.2", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["targets"] == [0.3, 0.2]


@pytest.mark.usefixtures("quickly")
def test_a_scene_needs_no_experiment(folder: Path) -> None:
    options = ["--size", "8x8", "--repeats", "1", "--budget", "20ms", "--quick"]
    assert main(["cost", str(CORNELL), "-o", str(folder), *options, "--strategies", "bsdf,best"]) == 0
    rows = load(folder / "records.csv")
    assert {row.strategy for row in rows} == {"bsdf", "best"}
    assert all(row.wall_s < 5.0 for row in rows if row.last), "the budget of an experiment without one is 10 s"


def test_a_wrong_experiment_is_told_line_by_line(
    tmp_path: Path, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "x.toml"
    path.write_text('scenes = [{ pth = "a" }]\nstrategies = ["bset"]\n')
    assert main(["cost", str(path), "-o", str(folder)]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 3
    assert [line.partition(f"error: {path}:")[2].partition(":")[0] for line in lines] == ["1", "1", "2"]
    assert not folder.exists()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--budget", "soon"], "'soon' is no duration"),
        (["--size", "big"], "'big' is no size"),
        (["--repeats", "0"], "is no whole number from 1"),
        (["--targets", "20"], "'20' is 2000 %; did you mean 20%?"),
        (["--targets", "5%,"], "'' is no error; write a positive percentage, such as 2%"),
        (["--strategies", "bset"], "did you mean 'best'?"),
        (["--strategies", ""], "unknown strategy ''"),
        (["-D", "width"], "'width' is no definition"),
    ],
)
def test_wrong_options_are_refused(
    options: list[str], message: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["cost", str(CORNELL), "-o", str(folder), *options]) == 2
    assert message in capsys.readouterr().err
    assert not folder.exists()


@pytest.mark.usefixtures("quickly")
def test_a_folder_of_another_experiment_is_refused_and_left_alone(
    experiment: Path, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["cost", str(experiment), "-o", str(folder)]) == 0
    before = (folder / "records.csv").read_bytes()
    capsys.readouterr()
    assert main(["cost", str(experiment), "-o", str(folder), "--budget", "1s"]) == 2
    assert "has records of another experiment: budget is null there, and 1.0 now" in capsys.readouterr().err
    assert (folder / "records.csv").read_bytes() == before


def test_without_dask_a_cluster_is_refused_with_the_line_that_installs_it(
    experiment: Path, folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)  # as if it were not installed
    commands = (["cost", str(experiment), "-o", str(folder)], ["render", str(experiment)], ["quote", str(experiment)])
    for command in commands:
        assert main([*command, "--cluster", "tcp://127.0.0.1:9"]) == 2
        (told,) = capsys.readouterr().err.splitlines()
        assert "this needs the package distributed: pip install '.[cluster]' in a checkout of equaltime, or " in told
    assert not folder.exists(), "refused before anything is begun"
    assert main(["cost", "--help"]) == 0
    assert "pip install '.[cluster]'" in " ".join(
        capsys.readouterr().out.replace("\N{BOX DRAWINGS LIGHT VERTICAL}", " ").split()
    )


def test_without_dask_a_cluster_is_refused_in_python_before_the_scene_is_read(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    for place in ("local:1", "tcp://127.0.0.1:9"):
        with pytest.raises(et.EqualtimeError, match=r"^this needs the package distributed: pip install "):
            et.cost("no-such-scene.toml", folder, cluster=place)
    assert not folder.exists()


def test_packages_that_are_missing_are_named_before_anything_is_run(
    experiment: Path, folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(making, "find_spec", lambda name: None)
    assert main(["cost", str(experiment), "-o", str(folder)]) == 2
    assert (
        "flip_evaluator, matplotlib, jinja2: pip install '.[report]' in a checkout of equaltime, or "
        in capsys.readouterr().err
    )
    assert not folder.exists()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_what_is_done_when_a_signal_comes_is_kept(experiment: Path, folder: Path, number: signal.Signals) -> None:
    command = [sys.executable, "-m", "equaltime", "cost", str(experiment), "-o", str(folder), "--repeats", "9999"]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        deadline = time.monotonic() + 60.0
        while time.monotonic() < deadline and not any(row.last for row in load(folder / "records.csv")):
            time.sleep(0.05)
        process.send_signal(number)
        _, errors = process.communicate(timeout=30)
    assert process.returncode == 130
    runs = sum(row.last for row in load(folder / "records.csv"))
    words = "1 run is" if runs == 1 else f"{runs} runs are"
    _, said = errors.splitlines()  # the first tells how long it will take
    assert said == f"error: interrupted; {words} recorded in {folder}; the same command goes on from there"


def test_help_explains_experiments(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["cost", "--help"]) == 0
    text = capsys.readouterr().out
    for word in ("--quick", "--budget", "--strategies", "scenes = [", "peer", "baseline", "report.html"):
        assert word in text


def test_strategies_are_split_where_a_new_one_begins() -> None:
    assert split_strategies("naive,best") == ("naive", "best")
    assert split_strategies("bsdf, best,lights=uniform,sampler=sobol,mis") == (
        "bsdf", "best,lights=uniform,sampler=sobol", "mis")  # fmt: skip


def test_definitions_are_for_scenes_only(experiment: Path) -> None:
    made = make_experiment(CORNELL, define={"light_scale": "0.5"}, strategies=("best",))
    assert made.load_scenes()[0].digest != et.load(CORNELL).digest
    with pytest.raises(ExperimentError, match="definitions belong to scenes"):
        make_experiment(experiment, define={"light_scale": "0.5"})


@pytest.mark.parametrize(
    ("phase", "done", "words"),
    [
        ("setup", 0, "setting up best on box"),
        ("agreement", 0, "agreement of best with equaltime on box"),
        ("own reference", 0, "reference of box by best"),
        ("reference", 0, "reference of box"),
        ("run", 4, "run 5 of 25: best on box"),
        ("run", 25, "25 runs done"),
        ("report", 25, "writing the report of box"),
    ],
)
def test_the_progress_says_what_is_going_on(phase: Any, done: int, words: str) -> None:
    assert describe(RunProgress(phase, "box", "best", 0, done, 25, 0.2, None)) == words


def test_the_progress_of_a_cluster_counts_machines() -> None:
    said = describe(RunProgress("run", "box", "best", 0, 4, 25, 0.2, None, machines=2))
    assert said == "4 of 25 runs done on 2 machines; begins best on box"
    assert "on 1 machine;" in describe(RunProgress("run", "box", "best", 0, 4, 25, 0.2, None, machines=1))


def test_the_report_of_a_single_experiment_has_no_name_in_the_progress() -> None:
    assert describe(RunProgress("report", "", "", 0, 25, 25, 0.2, None)) == "writing the report"


def test_the_time_left_is_a_countdown() -> None:
    assert [time_left(seconds) for seconds in (6.2, 3750.0, -1.0)] == ["0:07 left", "1:02:30 left", "0:00 left"]


@pytest.mark.parametrize(("repeats", "told"), [(1, "no intervals: repeats=3 is"), (5, "no trusted times"), (6, "")])
def test_python_warns_of_too_few_repeats_as_the_command_does(
    repeats: int, told: str, experiment: Path, folder: Path, recwarn: pytest.WarningsRecorder
) -> None:
    et.cost(experiment, folder, size=(6, 6), repeats=repeats, strategies=["best"])
    found = [one for one in recwarn if one.category is et.EqualtimeWarning]
    assert [told in str(one.message) and one.filename == __file__ for one in found] == [True] * bool(told)


@pytest.mark.filterwarnings("ignore:with . repeat:equaltime.EqualtimeWarning")
def test_python_spells_the_same_words(experiment: Path, folder: Path) -> None:
    assert et.cost is measure_cost
    seen: list[RunProgress] = []
    summary = et.cost(experiment, folder, size=(6, 6), strategies=["best", "bsdf"], progress=seen.append)
    assert summary.verdict
    assert [(told.phase, told.fraction) for told in seen[-2:]] == [("report", 0.0), ("report", 1.0)]
    assert [result.label for result in summary.scenes[0].strategies] == ["best", "bsdf"]
    assert (folder / "report.html").stat().st_size > 1000
