"""``equaltime info`` tells what a folder of ``equaltime cost`` holds, and what an experiment file would run."""

from __future__ import annotations

import io
import json
import re
import shlex
import shutil
from contextlib import redirect_stdout
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest

import equaltime as et
from equaltime.cli import main
from equaltime.cli.info_experiment import _elsewhere, _errors, _reached, _was_quick
from equaltime.examples import example_of
from equaltime.experiments.model.summary import StrategyResult
from equaltime.experiments.run.folder import ExperimentFolder
from equaltime.revision import revision
from equaltime.statistics.intervals import UNKNOWN, Interval

from ..experiments.fake_summary import summary

SCENES = Path(__file__).parents[3] / "scenes"
CORNELL = SCENES / "cornell-box.toml"
EXPERIMENT = f"""
title = "Boxes"
description = "Two ways to aim."
scenes = [{{ path = "{CORNELL}", name = "box", size = [8, 8], max_depth = 2, define = {{ light_scale = 0.5 }} }}]
strategies = ["bsdf", "best"]
budget = "20ms"
repeats = 2
threads = 1
reference = {{ error = 0.5, seconds = 0.2 }}
"""


def told(capsys: pytest.CaptureFixture[str], *words: str) -> list[str]:
    """Return the lines that ``equaltime info`` prints with these words."""
    capsys.readouterr()
    assert main(["info", *words]) == 0
    return capsys.readouterr().out.splitlines()


def line(lines: list[str], name: str) -> str:
    """Return what the only line that begins with ``name`` says."""
    (found,) = [text for text in lines if text.startswith(f"{name} ")]
    return found.removeprefix(name).strip()


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """Return the folder of a small experiment, and the verdict that ``cost`` printed."""
    folder = tmp_path_factory.mktemp("all") / "box"
    (file := folder.with_suffix(".toml")).write_text(EXPERIMENT)
    with pytest.MonkeyPatch.context() as patched, redirect_stdout(io.StringIO()) as printed:
        patched.setenv("XDG_CACHE_HOME", str(folder.parent / "cache"))
        assert main(["cost", str(file), "-o", str(folder)]) == 0
    return folder, printed.getvalue().splitlines()[0]


@pytest.fixture
def copy(measured: tuple[Path, str], tmp_path: Path) -> Path:
    """Return a copy of the folder, for changes."""
    return Path(shutil.copytree(measured[0], tmp_path / "box"))


def test_a_folder_answers_with_its_verdict_first(
    measured: tuple[Path, str], capsys: pytest.CaptureFixture[str]
) -> None:
    folder, verdict = measured
    lines = told(capsys, str(folder))
    assert lines[0] == verdict
    assert len(lines) <= 11
    assert line(lines, "experiment") == "Boxes"
    assert line(lines, "scenes") == "box, 8x8 pixels"
    assert line(lines, "strategies") == "2: bsdf, best; compared with bsdf; -v for more"
    assert line(lines, "error").startswith("after 20 ms: bsdf ")
    assert line(lines, "ran").startswith("all 4 runs, ")
    assert line(lines, "machine").endswith(", 1 thread")
    assert re.fullmatch(r"equaltime .*, Embree \d[\d.]*, which takes \w.*", line(lines, "build"))
    assert line(lines, "report") == f"equaltime open {folder}"
    more = told(capsys, str(folder), "-v")
    assert line(more, "commit") == revision()
    more = more[len(lines) + 1 :]
    description, rows, legend, defines, in_full, decided, commands = "\n".join(more).strip().split("\n\n")
    assert description == "Two ways to aim."
    assert defines == "box: light_scale = 0.5"
    assert [text.split()[0] for text in rows.splitlines()] == ["strategy", "bsdf", "best"]
    assert any(text.startswith("bsdf: ") for text in legend.splitlines())
    assert [text.split()[0] for text in in_full.splitlines()] == ["bsdf:", "best:"]
    assert decided.startswith("box: best decided by itself: roulette=throughput")
    assert decided.endswith("splitting was not tried: the picture is small, or the technique has no pilot")
    assert commands.startswith("equaltime ")
    assert not any(text.endswith("-v for more") for text in told(capsys, str(folder), "-v"))
    assert more[-5].startswith("best: technique=mis,heuristic=power,lights=tree,")
    assert more[-1] == f"equaltime cost {folder}.toml -o {folder}"


def test_all_details_tell_which_worker_of_a_cluster_took_which_runs(
    copy: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    ExperimentFolder(copy).note_worker("tcp://10.0.0.1:9", "node1", ("box", "best", 0))
    ExperimentFolder(copy).note_worker("tcp://10.0.0.1:9", "node1", ("box", "bsdf", 1))
    assert "tcp://10.0.0.1:9 on node1: box, best, 0; box, bsdf, 1" in told(capsys, str(copy), "-v")


def test_files_that_changed_since_the_runs_are_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The experiment's file, its scene and a strategy's file, each by itself."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.chdir(tmp_path)
    scene, own = Path(shutil.copy(CORNELL, tmp_path / "box.toml")), tmp_path / "own.toml"
    own.write_text('preset = "mis"\n')
    changed = EXPERIMENT.replace(str(CORNELL), "box.toml").replace('"best"', '"own.toml"')
    (file := tmp_path / "x.toml").write_text(changed)
    assert main(["cost", "x.toml", "-o", "out", "--repeats", "1"]) == 0
    assert not any(text.startswith("changed") for text in told(capsys, "out"))
    file.write_text(f"{file.read_text()}# changed\n")
    after = (
        "since the last command; `repeat` takes the experiment as it was, with scenes and programs as they are now. "
        "The last command may now give another experiment: equaltime cost x.toml -o out-again --repeats 1"
    )
    assert line(told(capsys, "out"), "repeat") == "equaltime cost out/experiment.json -o out-again"
    assert line(told(capsys, "out"), "changed") == f"x.toml has changed {after}"
    scene.unlink()
    own.unlink()
    assert line(told(capsys, "out"), "changed") == f"box.toml is gone, own.toml is gone, x.toml has changed {after}"
    monkeypatch.chdir("/")
    assert line(told(capsys, str(tmp_path / "out")), "changed").startswith(f"{scene} is gone, {own} is gone, ")
    changes = json.loads("\n".join(told(capsys, str(tmp_path / "out"), "--json")))["changes"]
    assert [one["state"] for one in changes] == ["gone", "gone", "changed"]
    assert changes[0]["path"] == str(scene)


def test_an_experiment_whose_file_has_changed_is_had_from_its_record(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The refusal names commands to copy, and they work: from another directory, and with options of the old call."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.chdir(tmp_path)
    shutil.copy(CORNELL, tmp_path / "box.toml")
    (file := tmp_path / "x.toml").write_text(EXPERIMENT.replace(str(CORNELL), "box.toml"))
    assert main(["cost", "x.toml", "-o", "out", "--repeats", "1"]) == 0
    file.write_text(file.read_text().replace("20ms", "30ms"))
    assert main(["cost", "x.toml", "-o", "out"]) == 2
    refusal = capsys.readouterr().err
    again = "equaltime cost out/experiment.json -o out"
    assert "has records of another experiment: budget is 0.02 there, and 0.03 now\n" in refusal
    assert "`equaltime info out`" in refusal
    assert f"`{again}`" in refusal
    record = told(capsys, "out/experiment.json")
    assert line(record, "repeats") == "1 of each strategy on each scene"
    assert line(record, "run") == "equaltime cost out/experiment.json -o out-again"
    assert line(record, "--quick").startswith("about ")
    assert line(told(capsys, "out"), "repeat") == "equaltime cost out/experiment.json -o out-again"
    monkeypatch.chdir("out")
    assert line(told(capsys, "experiment.json"), "run").endswith(f" -o {tmp_path / 'out-again'}")
    monkeypatch.chdir(tmp_path)
    assert main(["cost", "out", "-o", "again"]) == 2
    assert "; out/experiment.json is the experiment that was run there" in capsys.readouterr().err
    identity = json.loads((tmp_path / "out" / "experiment.json").read_text())["identity"]
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    assert main(["cost", "../out/experiment.json", "-o", "../out", "--repeats", "2"]) == 0
    assert json.loads((tmp_path / "out" / "experiment.json").read_text())["identity"] == identity
    lines = told(capsys, "../out")
    assert line(lines, "ran").startswith("all 4 runs, ")
    assert not any(text.startswith("changed") for text in lines)


def test_the_record_of_a_scene_file_with_defines_is_an_experiment(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    scene = SCENES / "hard" / "ball-in-sky.toml"
    options = ["--size", "8x8", "--budget", "20ms", "--repeats", "1", "--strategies", "bsdf,best"]
    assert main(["cost", str(scene), "-o", str(tmp_path / "a"), "-D", "fov=3", *options]) == 0
    assert main(["cost", str(tmp_path / "a" / "experiment.json"), "-o", str(tmp_path / "b")]) == 0
    first, second = (json.loads((tmp_path / name / "experiment.json").read_text()) for name in "ab")
    assert first["identity"] == second["identity"]
    assert second["experiment"]["scenes"][0]["define"] == {"fov": "3"}


def test_the_record_of_a_quick_experiment_offers_no_quick_one(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    (file := tmp_path / "x.toml").write_text(EXPERIMENT)
    assert main(["cost", str(file), "-o", str(tmp_path / "out"), "--quick"]) == 0
    assert not any(text.startswith("--quick") for text in told(capsys, str(tmp_path / "out" / "experiment.json")))


@pytest.mark.filterwarnings("ignore:with . repeat:equaltime.EqualtimeWarning")
def test_the_record_of_a_scene_made_in_python_is_refused_with_the_reason(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    scene = et.load(SCENES / "hard" / "ball-in-sky.toml").with_(size=(8, 8))
    et.cost(scene, tmp_path / "a", budget="20ms", repeats=1, strategies=("bsdf", "best"))
    assert main(["cost", str(tmp_path / "a" / "experiment.json"), "-o", str(tmp_path / "b")]) == 2
    assert "was made in Python, so that no file holds it; call et.cost with it" in capsys.readouterr().err


def test_the_command_works_from_another_directory(
    measured: tuple[Path, str], capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    here, plain = Path.cwd(), line(told(capsys, str(measured[0])), "repeat")
    assert plain.startswith("equaltime cost ")
    monkeypatch.chdir("/")
    assert line(told(capsys, str(measured[0])), "repeat") == f"cd {shlex.quote(str(here))} && {plain}"


def test_a_damaged_table_of_files_is_an_error_with_its_place(copy: Path, capsys: pytest.CaptureFixture[str]) -> None:
    stored = json.loads((copy / "experiment.json").read_text())
    (copy / "experiment.json").write_text(json.dumps(stored | {"files": {"/x": 5}}))
    assert main(["info", str(copy)]) == 2
    assert "experiment.json: files: is damaged" in capsys.readouterr().err


def test_the_command_that_repeats_an_experiment_writes_another_folder(
    measured: tuple[Path, str], tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """In the same folder it would repeat nothing."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    _, *command = shlex.split(line(told(capsys, str(measured[0])), "repeat"))
    again = Path(command[command.index("-o") + 1])
    assert again == measured[0].with_name("box-again")
    command[command.index("-o") + 1] = str(tmp_path / "again")
    assert main(command) == 0
    found, made = (json.loads((path / "experiment.json").read_text()) for path in (measured[0], tmp_path / "again"))
    assert found["identity"] == made["identity"]


@pytest.mark.parametrize("option", ["-o b/", "--output=b", "-ob", "--output b"])
def test_every_way_to_name_the_folder_is_understood(option: str) -> None:
    assert _elsewhere(f"equaltime cost a.toml {option} --quick").split()[-2].endswith("b-again")


def test_an_experiment_that_was_stopped_is_told_and_goes_on(copy: Path, capsys: pytest.CaptureFixture[str]) -> None:
    records = copy / "records.csv"
    rows = records.read_text().splitlines(keepends=True)
    records.write_text("".join(rows[:-1]))
    lines = told(capsys, str(copy))
    assert line(lines, "ran").startswith("3 of 4 runs, not complete, ")
    assert line(lines, "go on").startswith("equaltime cost ")
    assert line(lines, "go on").endswith("/box"), "the same folder"
    records.write_text(rows[0])
    (copy / "provenance.json").unlink()
    lines = told(capsys, str(copy))
    assert lines[0] == f"{copy}: no run of this experiment is finished"
    assert line(lines, "ran") == "0 of 4 runs, not complete"
    assert line(lines, "go on") == "with the call that made it: the folder does not record a command"
    (data,) = [json.loads("\n".join(told(capsys, str(copy), "--json")))]
    assert (data["verdict"], data["complete"], data["runs"], data["planned_runs"]) == (lines[0], False, 0, 4)


def test_errors_after_a_time_tell_that_runs_ended_at_another_one(tmp_path: Path) -> None:
    found = summary(tmp_path)
    apart = "; some runs ended earlier or later"
    assert not _errors(found).endswith(apart)
    (scene,) = found.scenes
    early = tuple(replace(one, run_seconds=(1.0, 1.1, 1.9)) for one in scene.strategies)
    assert _errors(replace(found, scenes=(replace(scene, strategies=early),))).endswith(apart)


def test_no_scene_vanishes_from_the_errors_of_several() -> None:
    known, bound = Interval(0.163, 0.16, 0.19), Interval(0.3, 0.224, 0.9).bounded("low", "heavy tail")

    def reached(*errors: Interval) -> str:
        return _reached([cast(StrategyResult, SimpleNamespace(error_at_budget=error)) for error in errors])

    assert reached(known, bound) == "16.3 % and at least 22.4 %", "a measured error is no limit"
    assert reached(bound, known, replace(bound, low=0.25)) == "16.3 % and at least 22.4 % to 25 %"
    assert reached(known, UNKNOWN, UNKNOWN) == "16.3 % (not trusted on 2 of them)"
    assert reached(bound, UNKNOWN, UNKNOWN, UNKNOWN) == "at least 22.4 % (not trusted on 3 of them)"
    assert reached(known, Interval(0.2, 0.19, 0.21)) == "16.3 % to 20 %"
    assert reached(UNKNOWN, UNKNOWN) == "not trusted"
    assert reached(replace(known, reach=1.2)).endswith(") extrapolated")
    assert not reached(replace(bound, reach=1.2)).endswith("extrapolated")


@pytest.mark.filterwarnings("ignore:with . repeat:equaltime.EqualtimeWarning")
def test_an_experiment_of_a_dict_tells_the_call_that_repeats_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    ball = {"type": "sphere", "center": [0.0, 0.0, 5.0]}
    scene = {"type": "scene", "sensor": {"type": "perspective"}, "sky": {"type": "constant"}, "ball": ball}
    options: dict[str, Any] = {"quick": True, "size": (8, 8), "budget": "20ms", "repeats": 2, "threads": 1}
    options["strategies"] = ("bsdf", "best")
    et.cost(scene, tmp_path / "box", **options)
    call = ", ".join(f"{name}={value!r}" for name, value in options.items())
    needs = "the same scene or dict, which no file holds, and another folder"
    repeat = line(told(capsys, str(tmp_path / "box")), "repeat")
    assert repeat == f"in Python, with {needs}: et.cost(scene, folder, {call})"
    assert _was_quick(tmp_path / "box")
    assert "object at 0x" not in (tmp_path / "box" / "experiment.json").read_text()


def test_strategies_and_repeats_that_were_added_later_are_told(
    copy: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(copy.parent / "cache"))
    (file := copy.with_suffix(".toml")).write_text(EXPERIMENT)
    assert main(["cost", str(file), "-o", str(copy), "--repeats", "3", "--strategies", "bsdf,best,light"]) == 0
    lines = told(capsys, str(copy))
    assert line(lines, "strategies") == "3: bsdf, best, light; compared with bsdf; -v for more"
    assert line(lines, "ran").startswith("all 9 runs, ")
    assert line(lines, "repeat").endswith("--strategies bsdf,best,light (and 1 command before; see -v)")


def test_a_folder_tells_the_experiment_that_was_run_last(
    copy: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The file has another title, description and targets, and no longer asks for bsdf: its records remain."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(copy.parent / "cache"))
    assert not any(text.startswith("earlier") for text in told(capsys, str(copy)))
    later = EXPERIMENT.replace('"Boxes"', '"Lamps"\ntargets = [0.3]').replace("Two ways to aim.", "New words.")
    (file := copy.with_suffix(".toml")).write_text(later.replace('["bsdf", "best"]', '["light", "best"]'))
    assert main(["cost", str(file), "-o", str(copy)]) == 0
    lines = told(capsys, str(copy))
    assert line(lines, "experiment") == "Lamps"
    assert line(lines, "strategies") == "2: light, best; compared with light; -v for more"
    assert line(lines, "earlier") == "records of strategy bsdf remain that the last command did not ask for"
    assert line(lines, "ran").startswith("all 4 runs, ")
    data = json.loads("\n".join(told(capsys, str(copy), "--json")))
    assert (data["title"], data["description"], data["targets"]) == ("Lamps", "New words.", [0.3])
    assert data["earlier"] == ["strategy bsdf"]
    assert {strategy["label"] for strategy in data["scenes"][0]["strategies"]} == {"best", "light"}


def test_json_has_the_summary_and_what_has_run(measured: tuple[Path, str], capsys: pytest.CaptureFixture[str]) -> None:
    folder, verdict = measured
    data = json.loads("\n".join(told(capsys, str(folder), "--json")))
    assert (data["verdict"], data["complete"], data["runs"], data["planned_runs"]) == (verdict, True, 4, 4)
    assert [strategy["label"] for strategy in data["scenes"][0]["strategies"]] == ["bsdf", "best"]
    assert len(data["commands"]) == 1
    assert (data["description"], data["defines"]) == ("Two ways to aim.", {"box": {"light_scale": 0.5}})


def test_a_folder_of_experiments_tells_the_verdict_of_each(
    measured: tuple[Path, str], capsys: pytest.CaptureFixture[str]
) -> None:
    folder, verdict = measured
    lines = told(capsys, str(folder.parent))
    assert lines[0] == f"box: {verdict}"
    assert lines[-1] == f"More of one: equaltime info {folder}; all of them: equaltime open {folder.parent}"
    data = json.loads("\n".join(told(capsys, str(folder.parent), "--json")))
    assert [each["verdict"] for each in data["experiments"]] == [verdict]


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (None, "box: holds no experiment; `equaltime cost SCENE -o DIR` makes such a folder"),
        ("{", "experiment.json: cannot be read: "),
        ({"identity": {"scenes": {}}}, "experiment.json: identity: is damaged"),
        ({"titel": "x"}, "experiment.json: experiment.titel: unknown key 'titel'; did you mean 'title'?"),
        (3, "experiment.json: experiment: expected a table, found 3"),
        ({"strategies": [1], "baseline": "x"}, "experiment.baseline: no strategy has the label 'x'"),
    ],
)
def test_a_folder_without_a_whole_experiment_is_refused_in_one_line(
    content: object, words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder := tmp_path / "box").mkdir()
    identity = {"scenes": {"a": {}}, "strategies": {"b": {}}}
    if content is not None:
        whole = (
            content
            if isinstance(content, dict) and "identity" in content
            else {"identity": identity, "experiment": content}
        )
        (folder / "experiment.json").write_text(content if isinstance(content, str) else json.dumps(whole))
    assert main(["info", str(folder)]) == 2
    error = capsys.readouterr().err
    assert words in error
    assert len(error.splitlines()) == 1


def test_definitions_are_not_for_folders(measured: tuple[Path, str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["info", str(measured[0]), "-D", "a=1"]) == 2
    assert "--define and --substitute are for scenes" in capsys.readouterr().err


def test_an_experiment_file_tells_what_it_would_run_and_for_how_long(capsys: pytest.CaptureFixture[str]) -> None:
    path = SCENES / "experiments" / "x3-light.toml"
    lines = told(capsys, str(path))
    assert lines[0] == f"{path}: about 37.5 min: references of up to 60 s each, then 224 runs of 8 s"
    assert len(lines) <= 11
    assert line(lines, "scenes").startswith("7: area 1, area 1/4, ")
    assert line(lines, "scenes").endswith(" and 1 more, 128x128 pixels")
    assert (
        line(lines, "strategies")
        == "4: no light sampling, light, mis, best; compared with no light sampling; -v for more"
    )
    assert line(lines, "repeats") == "8 of each strategy on each scene"
    assert line(lines, "times") == "to errors of 20 %, 10 %, 5 %, 2 %"
    assert line(lines, "--quick").startswith("about 52 s: ")
    assert line(lines, "run") == f"equaltime cost {path} -o x3-light"
    assert not any("-v for more" in each for each in told(capsys, str(path), "-v"))
    assert "bsdf,roulette=albedo" in "\n".join(told(capsys, str(path), "-v"))
    by_name = [each.replace(str(example_of(Path("x3-light"))), str(path)) for each in told(capsys, "x3-light")]
    assert by_name == lines, "examples have names"
    data = json.loads("\n".join(told(capsys, str(path), "--json")))
    assert (data["runs"], data["repeats"], data["quick"]["runs"]) == (224, 8, 54)
    assert data["strategies"][0] == {"label": "no light sampling", "name": "bsdf,roulette=albedo"}


def test_details_of_an_experiment_file_have_its_description_and_its_defines(
    capsys: pytest.CaptureFixture[str],
) -> None:
    path = SCENES / "experiments" / "mis-grid.toml"
    lines = told(capsys, str(path), "-v")
    assert "roughness 0.01, radius 0.5: alpha = 0.01, radius = 0.5, radiance = 30.3964" in lines
    data = json.loads("\n".join(told(capsys, str(path), "--json")))
    assert data["scenes"][1]["define"] == {"alpha": 0.01, "radius": 0.5, "radiance": 30.3964}
    assert lines[lines.index("") + 1] == data["description"].strip().splitlines()[0]


def test_an_experiment_file_with_sample_counts_promises_no_time(capsys: pytest.CaptureFixture[str]) -> None:
    path = SCENES / "experiments" / "x1-naive.toml"
    assert " runs of 512 samples a pixel" in told(capsys, str(path))[0]
    assert json.loads("\n".join(told(capsys, str(path), "--json")))["seconds"] is None


def test_an_experiment_file_is_read_as_cost_reads_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "x.toml"
    path.write_text('scenes = [{ path = "none.toml" }]\nstrategies = ["bset"]\n')
    assert main(["info", str(path)]) == 2
    assert f"{path}:2: strategies[0].strategy: " in capsys.readouterr().err
    path.write_text('scenes = [{ path = "none.toml" }]\nstrategies = ["best"]\n')
    assert main(["info", str(path)]) == 2
    assert "none.toml: cannot be read" in capsys.readouterr().err
    assert main(["info", str(path), "-D", "a=1"]) == 2
    assert "definitions belong to scenes" in capsys.readouterr().err
