"""The runner: what is run in which order, what is kept, and that nothing is lost or done twice."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import equaltime as et
from equaltime.errors import ExperimentError, NonFiniteSample, PeerError, RenderError
from equaltime.experiments.analysis.summarise import summarise
from equaltime.experiments.model.experiment import Experiment
from equaltime.experiments.model.plan import PeerTimes
from equaltime.experiments.model.reader import film_seed, make_experiment, run_seeds
from equaltime.experiments.run import runner, single_run
from equaltime.experiments.run.folder import ExperimentFolder
from equaltime.experiments.run.record import counts_of, load
from equaltime.experiments.run.reference import REFERENCE_STRATEGY
from equaltime.experiments.run.runner import RunProgress, run
from equaltime.film.error import pixel_statistics
from equaltime.film.unseen import stated_error
from equaltime.rendering.core import make_renderer
from equaltime.rendering.core_subject import CoreSubject, Point, RendererKind
from equaltime.scene import Scene
from equaltime.scene import load as load_scene
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


def test_the_summary_knows_the_depth_that_the_scene_s_file_asks_for(folder: Path) -> None:
    scenes = [{"path": str(CORNELL), "size": [6, 6], "name": "own"}]
    scenes.append({"path": str(CORNELL), "size": [6, 6], "name": "cut", "max_depth": 2})  # type: ignore[dict-item]
    wanted = experiment(scenes=scenes, repeats=1)
    run(wanted, folder)
    found = summarise(wanted, load(folder / "records.csv"), folder)
    assert [(scene.max_depth, scene.scene_max_depth) for scene in found.scenes] == [(30, 30), (2, 30)]
    assert [scene.other_depth for scene in found.scenes] == [
        "",
        "paths up to depth 2; the scene asks for paths up to depth 30",
    ]
    assert "own_depths" not in found.provenance


def test_every_strategy_takes_its_turn_on_every_scene_in_every_repeat(folder: Path) -> None:
    scenes = [{"path": str(CORNELL), "size": [n, n], "max_depth": 2, "name": f"{n}"} for n in (6, 8)]
    run(experiment(scenes=scenes, repeats=2), folder)
    first = [("6", "bsdf"), ("6", "best"), ("8", "bsdf"), ("8", "best")]
    second = [("6", "best"), ("6", "bsdf"), ("8", "best"), ("8", "bsdf")]  # the other way round
    assert keys(folder) == [(*key, repeat) for repeat, turns in enumerate((first, second)) for key in turns]


def test_a_record_says_what_was_done(folder: Path) -> None:
    run(experiment(threads=1), folder)
    rows = load(folder / "records.csv")
    row = rows[1]
    assert (row.scene, row.strategy, row.name, row.renderer, row.biased) == ("box", "bsdf", "bsdf", "core", False)
    assert (row.width, row.height, row.crop, row.max_depth) == (12, 8, (0, 0, 12, 8), 3)
    assert (row.repeat, row.checkpoint, row.spp, row.last, row.threads) == (0, 1, 4, True, 1)
    assert row.paths == 12 * 8 * 4
    assert row.seed == run_seeds("box", "bsdf", 1)[0]
    assert row.relmse is not None
    assert row.reference_relmse is not None
    assert row.estimate is not None
    assert rows[0].wall_s < row.wall_s
    assert 0.0 < row.cpu_s < 10.0 * row.wall_s + 0.1
    assert row.setup_s > 0.0
    assert len({row.seed for row in rows}) == 6
    assert [(row.last, row.flip) for row in rows[:2]] == [(False, None), (True, None)]


def test_a_record_says_what_a_strategy_decided_by_itself(folder: Path) -> None:
    run(experiment(spp=[2, 16], repeats=1), folder)
    decided = [(row.strategy, row.spp, row.decided) for row in load(folder / "records.csv")]
    assert decided[:2] == [("bsdf", 2, None), ("bsdf", 16, None)]
    assert decided[2] == ("best", 2, "roulette=throughput")
    assert decided[3][2] in ("roulette=throughput,adaptive=none", "roulette=throughput,adaptive=error")


def test_counts_of_earlier_runs_give_the_same_images(folder: Path, tmp_path: Path) -> None:
    """The twin takes its counts from the clock again, here a clock that is faster."""
    scene = {"path": str(CORNELL), "size": [12, 8], "name": "box"}
    wanted = experiment(spp=None, budget="20ms", scenes=[scene], repeats=2)
    run(wanted, folder)
    counts = counts_of(folder / "records.csv")
    assert counts.keys() == {"box"}
    assert counts["box"].keys() == {"bsdf", "best"}
    repeated = make_experiment(wanted, budget="60ms", counts=counts)
    run(repeated, tmp_path / "again")
    run(make_experiment(wanted, budget="60ms"), tmp_path / "twin")
    rows, again, twin = (load(path / "records.csv") for path in (folder, tmp_path / "again", tmp_path / "twin"))
    assert [(row.key, row.spp, row.relmse) for row in rows] == [(row.key, row.spp, row.relmse) for row in again]
    assert counts_of(tmp_path / "twin" / "records.csv") != counts
    assert len(twin) > len(rows)
    for path in sorted((folder / "images").glob("box/*.npy")):
        assert path.read_bytes() == (tmp_path / "again" / path.relative_to(folder)).read_bytes()


def test_counts_of_another_experiment_are_refused() -> None:
    with pytest.raises(ExperimentError, match="has no run of this one, only mis on box"):
        make_experiment(experiment(spp=None), counts={"box": {"mis": (2, 4)}})
    with pytest.raises(ExperimentError, match="spp: gives the counts of all runs already"):
        make_experiment(experiment(), counts={"box": {"best": (2, 4)}})


def test_counts_without_a_finished_run_are_refused(folder: Path) -> None:
    with pytest.raises(ExperimentError, match=r"out/records\.csv: has no finished run"):
        counts_of(folder / "records.csv")


def test_the_image_of_a_run_is_that_of_its_last_checkpoint(folder: Path) -> None:
    run(experiment(repeats=1), folder)
    for row in load(folder / "records.csv"):
        if row.image is not None:
            image = np.load(folder / row.image)
            subject = CoreSubject("x", Strategy.parse(row.name))
            subject.prepare(experiment().load_scenes()[0], 1)
            *_, last = subject.run(row.seed, (row.spp,))
            assert image.dtype == np.float32
            np.testing.assert_array_equal(image, last.image)


def lamp_in_sight() -> dict[str, object]:
    """Return a lamp that fills a ten-thousandth of a pixel, over a floor that it lights."""
    look = {"origin": [0.0, 1.0, 4.0], "target": [0.0, 0.6, 0.0], "up": [0, 1, 0]}
    film = {"type": "hdrfilm", "width": 16, "height": 16, "rfilter": {"type": "box"}}
    lying = [{"rotate": {"axis": [1, 0, 0], "angle": -90}}, {"scale": 4}]
    lamp = {"type": "sphere", "center": [0.1, 1.1, 0.0], "radius": 0.002}
    return {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 3},
        "sensor": {"type": "perspective", "fov": 40, "to_world": [{"look_at": look}], "film": film},
        "floor": {"type": "rectangle", "to_world": lying, "bsdf": {"type": "diffuse", "reflectance": 0.5}},
        "lamp": {**lamp, "emitter": {"type": "area", "radiance": 1e5}},
    }


def test_a_record_states_the_error_that_a_render_states() -> None:
    scene = et.load_dict(lamp_in_sight())
    subject = CoreSubject("x", Strategy())
    subject.prepare(scene, 1)
    for seed, spp in ((1, 8), (2, 24)):
        *_, point = subject.run(seed, (2, spp))
        rendered = et.render(scene, spp=spp, seed=seed, threads=1)
        assert rendered.moments is not None
        seen = stated_error(pixel_statistics(rendered.moments))
        assert point.estimate == rendered.error
        assert rendered.error.high > 1.5 * seen.high, "what is hidden makes much of the limit"


def test_the_provenance_names_machine_build_references_and_sessions(folder: Path) -> None:
    run(experiment(repeats=1), folder)
    provenance = ExperimentFolder(folder).read_provenance()
    row = load(folder / "records.csv")[0]
    assert provenance["machines"][row.machine]["processors"] >= 1
    assert len(provenance["builds"][row.build]["core_sha256"]) == 64
    assert Strategy.parse(provenance["references"]["box"]["strategy"]) == Strategy.parse(REFERENCE_STRATEGY)
    (session,) = provenance["sessions"].values()
    assert 0.0 < session["rendering_s"] < session["elapsed_s"]
    assert (folder / "references" / "box.npz").exists()


@dataclass
class Clockwork:
    """Renders so many samples a second by its own clock, and stops the world when told."""

    label: str
    rate: float = 100.0
    fails: bool = False
    name: str = "clockwork"
    renderer: RendererKind = "core"
    biased: bool = False
    asked: list[tuple[int, ...]] = field(default_factory=list)
    closed: bool = False
    samples: NDArray[np.int64] | None = None
    variance: NDArray[np.float32] | None = None
    rounded: Callable[[Iterable[int]], Iterable[int]] | None = None

    def prepare(self, scene: Scene, threads: int) -> float:
        return 0.25

    def run(self, seed: int, ladder: Iterable[int], seconds: float | None) -> Iterator[Point]:
        if self.fails:
            raise NonFiniteSample((1, 2), 3, seed, None)
        taken = []
        for spp in ladder if self.rounded is None else self.rounded(ladder):
            taken.append(spp)
            image = np.full((8, 12, 3), 0.1, np.float32)
            yield Point(spp, spp / self.rate, spp / self.rate, image, samples=self.samples, variance=self.variance)
        self.asked.append(tuple(taken))

    def close(self) -> None:
        self.closed = True


@pytest.fixture
def clockworks(monkeypatch: pytest.MonkeyPatch) -> list[Clockwork]:
    made = [Clockwork("bsdf"), Clockwork("best", rate=33.0)]
    monkeypatch.setattr(runner, "make_subjects", lambda experiment: made)
    return made


def test_all_repeats_have_the_counts_that_the_first_reached(folder: Path, clockworks: list[Clockwork]) -> None:
    run(experiment(budget=1.0, spp=None), folder)
    fast, slow = clockworks
    assert fast.asked == [(2, 4, 6, 8, 12, 16, 24, 32, 48, 64, 104)] * 3
    assert slow.asked == [(2, 4, 6, 8, 12, 16, 24, 34)] * 3
    assert all(subject.closed for subject in clockworks)


def test_sample_counts_that_differ_are_kept_for_the_report(folder: Path, clockworks: list[Clockwork]) -> None:
    clockworks[1].samples = np.arange(96).reshape(8, 12)
    run(experiment(), folder)
    even, uneven = summarise(experiment(), load(folder / "records.csv"), folder).scenes[0].strategies
    assert even.samples is None
    assert uneven.samples is not None
    np.testing.assert_array_equal(np.load(uneven.samples), clockworks[1].samples)


def test_variances_are_kept_for_the_report_where_a_renderer_tells_them(
    folder: Path, clockworks: list[Clockwork]
) -> None:
    clockworks[1].variance = np.arange(96, dtype=np.float32).reshape(8, 12)
    run(experiment(), folder)
    silent, telling = summarise(experiment(), load(folder / "records.csv"), folder).scenes[0].strategies
    assert silent.variances == ()
    assert len(telling.variances) == telling.repeats
    np.testing.assert_array_equal(np.load(telling.variances[0]), clockworks[1].variance)


def test_the_core_tells_the_variance_of_a_sample() -> None:
    scene = load_scene(CORNELL).with_(size=(8, 8))
    subject = CoreSubject("mis", Strategy.parse("mis"))
    subject.prepare(scene, 1)
    few, many = subject.run(1, (2, 64))
    assert few.variance is not None
    assert many.variance is not None
    assert np.isinf(few.variance).all(), "two samples are one in each replicate"
    assert many.variance.shape == (8, 8)
    assert np.isfinite(many.variance).all()
    assert many.variance.dtype == np.float32


def test_the_core_tells_how_many_samples_each_pixel_had() -> None:
    scene = load_scene(CORNELL).with_(size=(24, 24))
    counts = {}
    for name in ("best", "best,adaptive=history"):
        subject = CoreSubject(name, Strategy.parse(name))
        subject.prepare(scene, 2)
        *_, last = subject.run(1, (8, 64))
        counts[name] = last.samples
    assert counts["best"] is None
    uneven = counts["best,adaptive=history"]
    assert uneven is not None
    assert uneven.min() < 64 < uneven.max()


def test_flip_is_measured_at_the_end_of_runs_that_are_long_enough(folder: Path, clockworks: list[Clockwork]) -> None:
    clockworks[0].rate, clockworks[1].rate = 2.0, 0.5  # 4 samples take 2 and 8 seconds
    run(experiment(repeats=2), folder)
    found = {(row.strategy, row.repeat, row.checkpoint): row.flip for row in load(folder / "records.csv")}
    expected = {("bsdf", 0, 1), ("best", 0, 1), ("best", 1, 1)}
    assert {key for key, value in found.items() if value is not None} == expected


def test_progress_tells_what_is_going_on_and_what_is_left(folder: Path, clockworks: list[Clockwork]) -> None:
    seen: list[RunProgress] = []
    run(experiment(repeats=2), folder, seen.append)
    runs = [progress for progress in seen if progress.phase == "run"]
    assert [progress.phase for progress in seen[:2]] == ["setup", "setup"]
    assert any(progress.phase == "reference" for progress in seen)
    assert [(progress.strategy, progress.repeat, progress.done) for progress in runs] == [
        ("bsdf", 0, 0), ("best", 0, 1), ("best", 1, 2), ("bsdf", 1, 3)]  # fmt: skip
    assert {progress.total for progress in seen} == {4}
    assert all(progress.time_left is not None for progress in runs)


def test_peers_are_measured_and_announced_before_their_tests(
    folder: Path, clockworks: list[Clockwork], monkeypatch: pytest.MonkeyPatch
) -> None:
    seen: list[object] = []

    def gates(peers: Any, *arguments: Any) -> None:
        for report in arguments[-2:]:
            report(peers[0], 0.5)

    def measured(peers: Any, *_: Any) -> PeerTimes:
        return PeerTimes(3.0 * len(peers), 0.25)

    def told(progress: RunProgress) -> None:
        left = progress.time_left
        seen.append((progress.phase, progress.strategy, left is not None and 40.0 < left < 60.0))

    monkeypatch.setattr(runner, "measured_times", measured)
    monkeypatch.setattr(runner, "pass_gates", gates)
    theirs = {"label": "best", "peer": {"command": "render {spp} {seed} {out}"}}
    wanted = experiment(strategies=["bsdf", theirs], budget=3.0, spp=None)
    run(wanted, folder, told, begins=lambda *found: seen.append(found))
    assert seen[2:5] == [
        (wanted, PeerTimes(3.0, 0.25), 1),
        ("agreement", "best", True),
        ("own reference", "best", True),
    ]
    assert ("run", "bsdf", True) in seen


def test_a_reference_that_cannot_be_read_leaves_no_folder_behind(folder: Path, tmp_path: Path) -> None:
    with pytest.raises(ExperimentError, match=r"reference\.file: .*cannot be read"):
        run(experiment(reference={"file": tmp_path / "missing.exr"}), folder)
    assert not folder.exists()


@pytest.mark.parametrize("position", range(6))
def test_a_failure_or_ctrl_c_loses_nothing_that_was_finished(
    folder: Path, clockworks: list[Clockwork], position: int
) -> None:
    def stop(progress: RunProgress) -> None:
        if progress.phase == "run" and progress.done == position:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run(experiment(), folder, stop)
    assert len(keys(folder)) == position
    run(experiment(), folder)
    assert len(keys(folder)) == 6
    assert sum(len(subject.asked) for subject in clockworks) == 6


def test_a_sample_that_is_no_number_ends_the_experiment(folder: Path, clockworks: list[Clockwork]) -> None:
    clockworks[1].fails = True
    with pytest.raises(NonFiniteSample):
        run(experiment(), folder)
    assert keys(folder) == [("box", "bsdf", 0)]


def test_a_subject_without_an_image_is_an_error(
    folder: Path, clockworks: list[Clockwork], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Clockwork, "run", lambda *arguments: iter(()))
    with pytest.raises(RenderError, match="bsdf: gave no image"):
        run(experiment(), folder)


@pytest.mark.parametrize("name", ["prepare", "run"])
def test_a_failure_of_another_renderer_names_the_scene(
    folder: Path, clockworks: list[Clockwork], monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    def fail(*arguments: object) -> None:
        raise PeerError("bsdf: its process ended")

    monkeypatch.setattr(Clockwork, name, fail)
    with pytest.raises(PeerError, match=r"^box: bsdf: its process ended"):
        run(experiment(), folder)


def test_own_subjects_come_from_python_files(folder: Path, tmp_path: Path) -> None:
    path = tmp_path / "own.py"
    path.write_text(
        "from equaltime.rendering.core_subject import CoreSubject\nfrom equaltime.strategy import Strategy\n"
        "def make(label):\n    return CoreSubject(label, Strategy(technique='light'))\n"
    )
    run(experiment(strategies=[{"label": "own", "python": f"{path}:make"}], repeats=1), folder)
    assert load(folder / "records.csv")[0].name == "best,technique=light"
    for place, message in ((f"{path}:mak", "has no 'mak'"), (f"{path}", "expected FILE.py:NAME"),
                           (f"{path}x:make", "no such Python file")):  # fmt: skip
        with pytest.raises(ExperimentError, match=rf"strategies\[0\]\.python: .*{message}"):
            run(experiment(strategies=[{"label": "own", "python": place}]), tmp_path / "other")


def test_seeds_of_runs_have_31_bits_and_are_all_different() -> None:
    seeds = [seed for scene in "ab" for label in "cd" for seed in run_seeds(scene, label, 500)]
    assert len(set(seeds)) == len(seeds)
    assert max(seeds) < 2**31
    assert min(seeds) >= 0
    assert film_seed("a", "c") not in seeds


def test_repeats_whose_hashes_are_the_same_have_seeds_of_their_own() -> None:
    """The hashes of repeats 12745 and 17535 are the same for these names."""
    seeds = run_seeds("s", "best", 20_000)
    assert len(set(seeds)) == len(seeds)
    assert run_seeds("s", "best", 17_535) == seeds[:17_535], "more repeats change none"
    assert seeds[0] == 1342983669, "folders of earlier versions can be taken up"


def test_a_renderer_must_take_the_same_counts_in_every_repeat(folder: Path, clockworks: list[Clockwork]) -> None:
    def stop(progress: RunProgress) -> None:
        if progress.phase == "run" and progress.repeat == 1:
            clockworks[0].rounded = lambda ladder: (spp + 3 for spp in ladder)

    message = "box: bsdf: repeat 1 has 5 samples a pixel, and the first repeat had 2, 4; repeats are compared at equal"
    with pytest.raises(ExperimentError, match=message):
        run(experiment(), folder, stop)
    clockworks[0].rounded = lambda ladder: list(ladder)[:1]
    with pytest.raises(ExperimentError, match="repeat 1 has 2 samples a pixel, and the first repeat had 2, 4"):
        run(experiment(), folder)
    clockworks[0].rounded = None
    run(experiment(), folder)
    assert len(keys(folder)) == 6, "what was refused can be done again"


def test_a_strategy_s_own_pilot_runs_within_the_time_that_is_measured() -> None:
    """The clock of a run covers `advance` alone, so the pilot must run there. Its rays count, its samples do not."""
    scene = load_scene(CORNELL).with_(size=(256, 256), max_depth=3)
    renderer = make_renderer(scene, Strategy.parse("best"), 0, 2)
    assert (renderer.decision, renderer.counters["rays"]) == (None, 0)
    renderer.advance(2)
    assert renderer.decision is not None
    assert renderer.decision["splitting"] is not None, "measured by a pilot"
    assert (renderer.moments["count"].sum(axis=0) == 2).all()
