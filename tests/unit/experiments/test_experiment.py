"""Experiments: their words, their defaults, and what is said of one that makes no sense."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import equaltime as et
from equaltime.errors import ExperimentError, SceneError
from equaltime.experiments.model.experiment import Experiment, SceneEntry, StrategyEntry
from equaltime.experiments.model.reader import (
    default_experiment,
    is_experiment,
    make_experiment,
    quicker,
    read_experiment,
)
from equaltime.images import image_files as images
from equaltime.strategy import Strategy

SCENES = Path(__file__).parents[3] / "scenes"
CORNELL = SCENES / "cornell-box.toml"
MONTELIGHT = SCENES / "montelight" / "simple.toml"

EXPERIMENT = f"""
title = "Lights"
baseline = "plain"
budget = "1m30s"
repeats = 4
targets = [0.1, 0.01]
crops = [[0, 0, 16, 16]]
threads = 1

[[scenes]]
path = "{CORNELL}"
size = [64, 64]
max_depth = 5

[[scenes]]
name = "cropped"
path = "{CORNELL}"
crop = [16, 16, 32, 32]

[[strategies]]
label = "plain"
strategy = "bsdf,sampler=sobol"

[[strategies]]
strategy = "best"

[[strategies]]
label = "theirs"
peer = {{ renderer = "mitsuba", variant = "scalar_rgb" }}

[[strategies]]
label = "any"
peer.command = "renderer {{scene}} {{spp}} {{seed}} {{out}}"

[reference]
error = 0.01
seconds = "20s"
"""


@pytest.fixture
def file(tmp_path: Path) -> Callable[[str], Path]:
    def write(text: str) -> Path:
        path = tmp_path / "x.toml"
        path.write_text(text)
        return path

    return write


def problems_of(make: Callable[[], object]) -> list[str]:
    with pytest.raises(ExperimentError) as caught:
        make()
    return [str(problem) for problem in caught.value.problems]


def made(**changes: Any) -> Experiment:
    values = {"scenes": [{"path": str(CORNELL)}], "strategies": ["bsdf", "best"]} | changes
    return Experiment.model_validate(values)


def test_a_file_says_what_is_compared_on_what(file: Callable[[str], Path]) -> None:
    experiment = read_experiment(file(EXPERIMENT))
    assert [entry.label for entry in experiment.strategies] == ["plain", "best", "theirs", "any"]
    assert experiment.strategies[0].strategy == Strategy.parse("bsdf,sampler=sobol")
    assert (experiment.budget, experiment.spp, experiment.repeats, experiment.threads) == (90.0, None, 4, 1)
    assert (experiment.reference.error, experiment.reference.seconds) == (0.01, 20.0)
    assert [entry.name for entry in experiment.scenes] == ["cornell-box", "cropped"]
    first, second = experiment.load_scenes()
    assert (first.size, first.max_depth) == ((64, 64), 5)
    assert second.model.sensor.film.crop == (16, 16, 32, 32)


def test_what_is_not_said_has_sensible_values() -> None:
    experiment = made()
    assert (experiment.budget, experiment.repeats, experiment.baseline) == (10.0, 8, "bsdf")
    assert experiment.targets == (0.10, 0.05, 0.02, 0.01)
    assert made(strategies=["best", {"label": "naive", "strategy": "bsdf"}]).baseline == "naive"
    assert made(strategies=["best", "mis"]).baseline == "mis"
    assert made(strategies=["best"]).baseline == "best"


def test_names_of_files_are_looked_for_beside_the_experiment(file: Callable[[str], Path]) -> None:
    path = file(
        'scenes = [{ path = "s.toml" }]\nstrategies = ["my.toml", { label = "x", strategy = "my.toml" }, '
        '{ label = "own", python = "own.py:make" }]\nreference = { file = "r.exr" }'
    )
    (path.parent / "my.toml").write_text('technique = "bsdf"')
    experiment = read_experiment(path)
    assert experiment.scenes[0].path == path.parent / "s.toml"
    assert [entry.label for entry in experiment.strategies] == ["my", "x", "own"]
    assert experiment.strategies[1].strategy == Strategy(technique="bsdf")
    assert experiment.strategies[2].python == f"{path.parent}/own.py:make"
    assert experiment.reference.file == path.parent / "r.exr"


def test_every_problem_is_told_with_file_line_and_keys_in_order_of_lines(file: Callable[[str], Path]) -> None:
    path = file(
        'titel = "a"\nbaseline = "bset"\nrepeats = 0\n'
        '[[scenes]]\npath = "a.toml"\nsize = [0, 3]\n[[scenes]]\npth = "b.toml"\n'
        '[[strategies]]\nlabel = "best"\nstrategy = "bset"\n[[strategies]]\npeer = "mitsbua"\n[reference]\neror = 1'
    )
    assert problems_of(lambda: read_experiment(path)) == [
        f"{path}:1: titel: unknown key 'titel'; did you mean 'title'?",
        f"{path}:2: baseline: no strategy has the label 'bset'; did you mean 'best'?",
        f"{path}:3: repeats: must be at least 1, found 0",
        f"{path}:5: scenes[0].path: there is no such file: {path.parent / 'a.toml'}",
        f"{path}:6: scenes[0].size[0]: must be at least 1, found 0",
        f"{path}:7: scenes[1]: a scene has either 'path', a scene file, or 'scene', the scene as a table",
        f"{path}:8: scenes[1].pth: unknown key 'pth'; did you mean 'path'?",
        f"{path}:11: strategies[0].strategy: strategy 'bset': unknown strategy 'bset'; did you mean 'best'?",
        f"{path}:13: strategies[1].peer.renderer: expected 'mitsuba', found 'mitsbua'",
        f"{path}:15: reference.eror: unknown key 'eror'; did you mean 'error'?",
    ]


@pytest.mark.parametrize(
    ("changes", "problem"),
    [
        ({"scenes": []}, "scenes: must not be empty"),
        ({"scenes": 3}, "scenes: expected a list, found 3"),
        ({"strategies": None}, "strategies: expected a list, found None"),
        ({"budget": "ten"}, "budget: 'ten' is no duration; write 10s, 500ms, 2.5m or 1h30m"),
        ({"budget": 0}, "budget: must be more than 0, found 0"),
        ({"budget": 1, "spp": [2]}, "spp: give either 'budget' or 'spp'"),
        ({"spp": [2, 8, 4]}, "spp: the sample counts must rise, found [2, 8, 4]"),
        ({"spp": []}, "spp: must not be empty"),
        ({"repeats": "8"}, "repeats: expected a whole number, found '8'"),
        ({"repeats": True}, "repeats: expected a whole number, found True"),
        ({"targets": [0.1, 0.0]}, "targets[1]: must be more than 0, found 0.0"),
        ({"targets": [0.1, 5]}, "targets[1]: 5 is 500 %, and an error to be reached is below 100 %: did you mean 0.05, "
         "which is 5 %?"),
        ({"targets": ["5"]}, "targets[0]: '5' is no error; write 5%, or 0.05 without quotes"),
        ({"targets": ["-5%"]}, "targets[0]: '-5%' is no error; write 5%, or 0.05 without quotes"),
        ({"targets": ["0%"]}, "targets[0]: must be more than 0, found 0.0"),
        ({"reference": {"error": "small"}}, "reference.error: 'small' is no error; write 5%, or 0.05 without quotes"),
        ({"reference": {"error": 1}}, "reference.error: 1 is 100 %, and an error to be reached is below 100 %: did you "
         "mean 0.01, which is 1 %?"),
        ({"title": 3}, "title: expected a text, found 3"),
        ({"crops": [[0, 0, 4]]}, "crops[0]: has too few entries: [0, 0, 4]"),
        ({"strategies": ["best", "best"]}, "strategies[1].label: 'best' is strategies[0] already; "
         "give each a 'label' of its own"),
        ({"strategies": ["best", {"label": "BEST ", "strategy": "mis"}]}, "strategies[1].label: 'BEST ' is too much "
         "like strategies[0], 'best': they are names of files too"),
        ({"strategies": [{"label": "a\nb", "strategy": "mis"}]}, "strategies[0].label: must be one line of text, "
         "found U+000A in 'a\\nb'"),
        ({"strategies": [{"label": "x"}]}, "strategies[0]: give one of 'strategy', 'peer' and 'python'"),
        ({"strategies": [{"peer": {"command": "render {spp} {seed}"}}]}, "strategies[0].peer.command: the command "
         "does not use {out}"),
        ({"strategies": [{"peer": {"command": "r {spp} {seed} {out}", "sampler": "x"}}]}, "strategies[0].peer.sampler: "
         "not for a command"),
        ({"strategies": [{"peer": {}, "label": "x"}]}, "strategies[0].peer: a peer has either 'renderer' or 'command'"),
        ({"scenes": [{"scene": {}, "define": {"a": 1}}]}, "scenes[0].define: only the variables of a file can be "
         "defined"),
        ({"scenes": [{"path": "a/x.xml"}, {"path": "b/x.xml"}]}, "scenes[1].name: 'x' is scenes[0] already; "
         "give each a 'name' of its own"),
        ({"scenes": [{"path": "a"}, {"path": "b"}], "reference": {"file": "r.exr"}}, "reference.file: one file cannot "
         "be the reference of several scenes"),
    ],
)  # fmt: skip
def test_what_makes_no_sense_is_refused_with_the_reason(changes: dict[str, Any], problem: str) -> None:
    assert problems_of(lambda: made(**changes)) == [problem]


def test_errors_may_be_texts_in_per_cent_wherever_a_file_has_one() -> None:
    number = {"what": "time", "ours": "time", "strategy": "best", "target": "5 %"}
    theirs = {"source": "a page", "claim": "it is fast", "numbers": [number]}
    found = made(strategies=["best"], targets=["5%", "1.1 %", 0.01], reference={"error": "0.5%"}, theirs=theirs)
    assert found.targets == (0.05, 0.011, 0.01)
    assert found.reference.error == 0.005
    assert found.theirs is not None
    assert found.theirs.numbers[0].target == 0.05


def test_a_scene_may_be_the_name_of_its_file_and_a_target_may_stand_alone(file: Callable[[str], Path]) -> None:
    path = file('scenes = ["s.toml", { path = "t.toml", name = "u" }]\nstrategies = ["mis"]\ntargets = "5%"')
    experiment = read_experiment(path)
    assert [entry.path for entry in experiment.scenes] == [path.parent / "s.toml", path.parent / "t.toml"]
    assert [entry.name for entry in experiment.scenes] == ["s", "u"]
    assert experiment.targets == (0.05,)
    assert made(scenes=[CORNELL], targets=0.02) == made(targets=[0.02])


def test_a_missing_file_among_the_names_of_scenes_has_its_line(file: Callable[[str], Path]) -> None:
    path = file('scenes = [\n  "a.toml",\n  "b.toml",\n]\nstrategies = ["bset"]\n')
    assert problems_of(lambda: read_experiment(path))[:2] == [
        f"{path}:2: scenes[0]: there is no such file: {path.parent / 'a.toml'}",
        f"{path}:3: scenes[1]: there is no such file: {path.parent / 'b.toml'}",
    ]


def test_other_targets_take_the_place_of_the_experiments() -> None:
    numbers = [
        {"what": "time", "ours": "time", "strategy": "best", "target": 0.05},
        {"what": "speed", "ours": "speed-up", "strategy": "best"},
    ]
    experiment = made(theirs={"source": "a page", "claim": "it is fast", "numbers": numbers})
    found = make_experiment(experiment, targets=["20%", 0.02])
    assert found.targets == (0.2, 0.02)
    assert found.theirs is not None
    assert [number.what for number in found.theirs.numbers] == ["speed"]  # the other one's target is gone
    assert make_experiment(CORNELL, targets="30%").targets == (0.3,)
    assert problems_of(lambda: make_experiment(CORNELL, targets=["x"])) == [
        "targets[0]: 'x' is no error; write 5%, or 0.05 without quotes"
    ]


def test_entries_of_a_list_have_lines_of_their_own(file: Callable[[str], Path]) -> None:
    path = file(
        'scenes = [\n  # two\n  { path = "a.toml" },\n  { path = "b.toml", sise = 3 },\n]\nstrategies = ["bset"]\n'
    )
    assert set(problems_of(lambda: read_experiment(path))) == {
        f"{path}:3: scenes[0].path: there is no such file: {path.parent / 'a.toml'}",
        f"{path}:4: scenes[1].path: there is no such file: {path.parent / 'b.toml'}",
        f"{path}:4: scenes[1].sise: unknown key 'sise'; did you mean 'size'?",
        f"{path}:6: strategies[0].strategy: strategy 'bset': unknown strategy 'bset'; did you mean 'best'?",
    }


def test_a_file_that_is_no_toml_is_refused_by_name(file: Callable[[str], Path], tmp_path: Path) -> None:
    path = file("scenes = [")
    assert problems_of(lambda: read_experiment(path))[0].startswith(f"{path}:1: not well-formed TOML: ")
    missing = tmp_path / "missing.toml"
    assert problems_of(lambda: read_experiment(missing)) == [f"{missing}: cannot be read: No such file or directory"]


def test_problems_of_all_scenes_are_told_together(tmp_path: Path) -> None:
    broken = tmp_path / "broken.toml"
    broken.write_text('[ball]\ntype = "spher"')
    entries = [{"path": str(broken)}, {"path": "missing.toml"}, {"path": str(CORNELL), "crop": [999, 0, 8, 8]}]
    problems = problems_of(made(scenes=entries).load_scenes)
    named = list(dict.fromkeys(text.split(":")[0] for text in problems))
    assert named == [str(broken), "missing.toml", str(CORNELL)]


def test_experiments_are_told_from_scenes(file: Callable[[str], Path], tmp_path: Path) -> None:
    assert is_experiment(file(EXPERIMENT))
    assert is_experiment(file('scenes = ["a.toml"]'))
    assert not is_experiment(CORNELL)
    assert not is_experiment(file("[[scenes"))
    assert not is_experiment(tmp_path / "missing.toml")
    assert not is_experiment(SCENES / "mitsuba" / "cornell-box" / "scene_v3.xml")


def test_the_default_compares_the_presets_up_to_best() -> None:
    experiment = default_experiment(SceneEntry(path=CORNELL))
    labels = [entry.label for entry in experiment.strategies]
    assert labels[-1] == "best"
    assert {"bsdf", "light", "mis"} <= set(labels)
    assert experiment.scenes[0].name == "cornell-box"
    assert all(entry.strategy == Strategy.parse(entry.label) for entry in experiment.strategies)


def test_paths_without_an_end_get_a_roulette_by_default() -> None:
    experiment = default_experiment(SceneEntry(path=MONTELIGHT), ("bsdf", "best", "mis,roulette=none"))
    roulettes = [entry.strategy.roulette for entry in experiment.strategies if entry.strategy]
    assert roulettes == ["throughput", "automatic", "none"]


def test_a_misspelt_strategy_of_a_default_experiment_is_named() -> None:
    with pytest.raises(ExperimentError, match="did you mean 'best'"):
        default_experiment(SceneEntry(path=CORNELL), ("bset",))
    with pytest.raises(SceneError):
        default_experiment(SceneEntry(path=CORNELL.with_name("missing.toml")))


def test_a_loaded_scene_will_do_as_well() -> None:
    scene = et.load(CORNELL).with_(size=(20, 10))
    experiment = default_experiment(SceneEntry(scene=scene))
    assert experiment.load_scenes()[0].size == (20, 10)
    assert experiment.scenes[0].name == "cornell-box"


def test_a_quick_experiment_keeps_its_crops_scaled_with_each_film() -> None:
    scenes = [{"path": str(CORNELL), "name": name, "size": [side, side]} for name, side in (("a", 384), ("b", 64))]
    own = {**scenes[0], "name": "c", "crops": [[8, 8, 64, 128]]}
    quick = quicker(made(scenes=[*scenes, own], crops=[[200, 40, 80, 40], [0, 0, 12, 12]]))
    assert [entry.crops for entry in quick.scenes] == [((50, 10, 20, 10), (0, 0, 3, 3)), None, ((2, 2, 16, 32),)]
    assert quick.crops == ((200, 40, 80, 40), (0, 0, 12, 12)), "those of b, whose film stays"
    assert [entry.crops for entry in make_experiment(quick, size=(8, 8)).scenes] == [None] * 3


def test_a_quick_experiment_is_small_and_keeps_what_is_compared() -> None:
    experiment = made(scenes=[{"path": str(SCENES / "veach-mis.toml")}], repeats=20)
    quick = quicker(experiment)
    assert quick.load_scenes()[0].size == (96, 54)
    assert quick.strategies == experiment.strategies
    assert quick.budget is not None
    assert quick.budget * quick.repeats * len(quick.strategies) <= 20.0
    assert quick.reference.seconds <= 15.0
    assert quick.reference.error == 0.01
    assert quicker(made(reference={"error": "0.3%"})).reference.error == 0.003, "which the file asks for"
    assert quicker(made(spp=[2, 4], repeats=1)).spp == (2, 4)


def test_a_first_look_may_keep_less_and_run_longer() -> None:
    scenes = [{"path": str(CORNELL), "name": name} for name in ("a", "b", "c")]
    wish = {"scenes": ["a", "c"], "strategies": ["best", "bsdf"], "size": 200, "repeats": 3, "seconds": "24s"}
    quick = quicker(made(scenes=scenes, strategies=["naive", "bsdf", "best"], quick={**wish, "reference": "5s"}))
    assert [scene.name for scene in quick.scenes] == ["a", "c"]
    assert [entry.label for entry in quick.strategies] == ["bsdf", "best"]
    assert quick.baseline == "bsdf"
    assert quick.load_scenes()[0].size == (200, 200)
    assert (quick.repeats, quick.budget, quick.reference.seconds) == (3, 2, 2.5)


def test_a_first_look_keeps_smaller_sample_counts() -> None:
    assert quicker(made(spp=[2, 4, 8, 16], quick={"spp": 8})).spp == (2, 4, 8)
    assert quicker(made(spp=[16, 32], quick={"spp": 8})).spp == (16,)


def test_a_first_look_cannot_keep_what_is_not_there() -> None:
    wish = {"strategies": ["bset"], "scenes": ["room"]}
    assert problems_of(lambda: made(strategies=["mis", "best"], quick=wish)) == [
        "quick.scenes[0]: the experiment has no 'room'; expected 'cornell-box'",
        "quick.strategies[0]: the experiment has no 'bset'; did you mean 'best'?",
    ]


def test_choosing_strategies_leaves_the_others_out_of_the_first_look() -> None:
    experiment = made(strategies=["naive", "mis", "best"], quick={"strategies": ["naive", "best"]})
    assert experiment.replace(strategies=("mis", "best")).quick.strategies == ("best",)


def test_the_reference_of_a_scene_is_not_called_like_that_of_a_strategy_on_another() -> None:
    scenes = [{"path": str(CORNELL), "name": name} for name in ("room", "room--best")]
    assert problems_of(lambda: made(scenes=scenes, strategies=["best", "mis"])) == [
        "scenes[1].name: 'room--best' is already the name of the reference of 'best' on 'room'"
    ]


def test_a_quick_experiment_shows_the_part_that_is_cropped() -> None:
    scene = {"path": str(SCENES / "cornell-box.toml"), "size": [400, 400], "crop": [200, 100, 192, 96]}
    film = quicker(made(scenes=[scene])).load_scenes()[0].model.sensor.film
    assert (film.width, film.height, film.crop) == (200, 200, (100, 50, 96, 48))


def test_a_quick_experiment_keeps_the_size_of_a_reference_that_is_a_file(tmp_path: Path) -> None:
    file = tmp_path / "reference.exr"
    images.write_exr(file, np.ones((4, 4, 3)))
    scene = {"path": str(SCENES / "veach-mis.toml")}
    experiment = made(scenes=[scene], reference={"file": str(file)})
    assert quicker(experiment).load_scenes()[0].size == experiment.load_scenes()[0].size


def test_changing_an_experiment_checks_it_anew() -> None:
    experiment = made(budget=5.0)
    assert experiment.replace(spp=(2, 4)).budget is None
    assert experiment.replace(strategies=(StrategyEntry(label="a", strategy=Strategy()),)).baseline == "a"
    assert problems_of(lambda: experiment.replace(repeats=0)) == ["repeats: must be at least 1, found 0"]
