"""Runs of experiments by machines of a cluster: the bits of runs here, times of like machines only, nothing lost."""

from __future__ import annotations

import os
import signal
import warnings
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np
import pytest

import equaltime as et
from equaltime.cli import main
from equaltime.cluster import check_machines
from equaltime.cluster.dask_cluster import DaskCluster
from equaltime.cluster.likeness import likeness
from equaltime.cluster.machines import Machines, send_files
from equaltime.cluster.pool import Pool
from equaltime.cluster.scene_text import SceneText
from equaltime.cluster.tasks import Ended, Ground, Machine
from equaltime.errors import EqualtimeWarning, ExperimentError, RenderError
from equaltime.experiments.model.experiment import Experiment
from equaltime.experiments.run import runner
from equaltime.experiments.run.collection import run_all
from equaltime.experiments.run.folder import ExperimentFolder
from equaltime.experiments.run.record import Row, load
from equaltime.experiments.run.runner import RunProgress, run
from equaltime.experiments.run.single_run import RunOrder
from equaltime.experiments.run.spread_runs import finished_runs
from equaltime.experiments.run.stage import Stage, perform
from equaltime.images.metrics import Reference
from equaltime.strategy import Strategy

from .test_scene_text import OBJ, with_mesh

CORNELL = Path(__file__).parents[3] / "scenes" / "cornell-box.toml"
SCENE = et.load(CORNELL).with_(size=(12, 8), max_depth=3)
LONGEST = 60
"""Seconds after which a test fails instead of waiting."""

pytestmark = pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning", "ignore::ResourceWarning")


@pytest.fixture(autouse=True)
def time_limit(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[None]:
    def over(number: int, frame: FrameType | None) -> None:
        raise TimeoutError(f"the test has taken {LONGEST} s")

    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    before = signal.signal(signal.SIGALRM, over)
    signal.alarm(LONGEST)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


@pytest.fixture(scope="module")
def cluster() -> Iterator[DaskCluster]:
    with DaskCluster.here(1, None) as made:
        yield made


def experiment(**changes: Any) -> Experiment:
    scenes = [{"path": str(CORNELL), "size": [n, 8], "max_depth": 3, "name": name} for name, n in (("a", 12), ("b", 9))]
    values: dict[str, Any] = {
        "scenes": scenes,
        "strategies": ["bsdf", "best"],
        "spp": [2, 4],
        "repeats": 2,
        "reference": {"error": 0.5, "seconds": 0.2},
    }
    return Experiment.model_validate(values | changes)


def rows(folder: Path) -> tuple[Row, ...]:
    return load(folder / "records.csv")


def untimed(folder: Path) -> list[Row]:
    """Return all rows of a folder in a fixed order, without what the clock tells."""
    still = {"wall_s": 0.0, "cpu_s": 0.0, "setup_s": 0.0, "started": "", "flip": None}
    return sorted((replace(row, **still) for row in rows(folder)), key=lambda row: (row.key, row.checkpoint))


def test_runs_elsewhere_have_the_bits_of_runs_here(cluster: DaskCluster, tmp_path: Path) -> None:
    there, here = tmp_path / "there", tmp_path / "here"
    told: list[RunProgress] = []
    run(experiment(), there, told.append, cluster=cluster)
    run(experiment(), here)
    assert untimed(there) == untimed(here)
    images = sorted(path.relative_to(here) for path in here.glob("images/*/*.npy"))
    assert len(images) == 16  # with variances
    assert all(np.array_equal(np.load(there / path), np.load(here / path)) for path in images)
    assert [row.repeat for row in rows(there) if row.last] == [0] * 4 + [1] * 4, "first repeats come first"
    ((address, facts),) = ExperimentFolder(there).read_provenance()["workers"].items()
    assert address.startswith("tcp://127.0.0.1:")
    assert facts["host"] == likeness().host
    assert sorted(map(tuple, facts["ran"])) == sorted({row.key for row in rows(there)})
    assert "workers" not in ExperimentFolder(here).read_provenance()
    assert {progress.machines for progress in told if progress.phase == "run"} == {1}


def test_a_folder_begun_by_a_cluster_goes_on_without(cluster: DaskCluster, tmp_path: Path) -> None:
    wanted = experiment(spp=None, budget=0.05)
    run(wanted, tmp_path, cluster=cluster)
    before = rows(tmp_path)
    run(wanted.replace(repeats=3), tmp_path)
    assert rows(tmp_path)[: len(before)] == before
    for key in {row.key[:2] for row in before}:
        counts = [[row.spp for row in rows(tmp_path) if row.key == (*key, repeat)] for repeat in range(3)]
        assert counts[0] == counts[1] == counts[2] != []
    facts = ExperimentFolder(tmp_path).read_provenance()
    assert sum(len(worker["ran"]) for worker in facts["workers"].values()) == 8
    assert [session["runs"] for session in facts["sessions"].values()] == [8, 4]


def test_a_run_of_a_machine_that_is_killed_goes_to_another(cluster: DaskCluster, tmp_path: Path) -> None:
    killed: list[int] = []

    def progress(told: RunProgress) -> None:
        if told.phase == "run" and told.done == 1 and not killed:
            killed.extend(cluster.client.run(os.getpid).values())
            os.kill(killed[0], signal.SIGKILL)

    wanted = experiment(scenes=experiment().scenes[:1], spp=(2, 8192), repeats=1)
    run(wanted, tmp_path, progress, cluster=cluster)
    assert len(killed) == 1
    assert [row.strategy for row in rows(tmp_path) if row.last] == ["bsdf", "best"]
    workers = ExperimentFolder(tmp_path).read_provenance()["workers"]
    assert [len(worker["ran"]) for worker in workers.values()] == [1, 1], "the second worker is a new one"


def test_the_error_of_a_run_elsewhere_is_raised_here(cluster: DaskCluster) -> None:
    found, mis = cluster.machines(), Strategy.parse("mis")
    ground = Ground(SceneText.of(SCENE), Reference.of_images(np.ones((2, 8, 12, 3))), Stage)
    order = RunOrder(("box", "mis", 1), 7, (2, 4), (2, 6), 1, "m", "b")
    found.give("run", found.free[0], ground, perform, order, mis)
    assert found.free == ()
    with pytest.raises(ExperimentError, match="repeat 1 has 2, 4 samples a pixel"):
        next(end for _ in range(LONGEST) for end in found.ended())


def ended(found: Machines, scene: SceneText, size: tuple[int, int]) -> Ended:
    """Return the end of a run of a scene on the first free machine."""
    ground = Ground(scene, Reference.of_images(np.ones((2, size[1], size[0], 3))), Stage)
    order = RunOrder(("mesh", "mis", 0), 7, (2, 4), None, 1, "m", "b")
    found.give("run", found.free[0], ground, perform, order, Strategy.parse("mis"))
    return next(end for _ in range(LONGEST) for end in found.ended())


def test_a_worker_without_the_files_of_a_scene_reads_copies(cluster: DaskCluster, tmp_path: Path) -> None:
    found, text = cluster.machines(), SceneText.of(with_mesh(tmp_path).with_(size=(6, 5)))
    send_files(cluster.client, text.files, [found.free[0].address])
    (tmp_path / "a b.obj").unlink()
    assert [row.spp for row in ended(found, text, (6, 5)).result.rows] == [2, 4]


def test_a_worker_with_other_files_is_refused_and_its_run_comes_back(cluster: DaskCluster, tmp_path: Path) -> None:
    found, text = cluster.machines(), SceneText.of(with_mesh(tmp_path).with_(size=(5, 6)))
    (tmp_path / "a b.obj").write_text(OBJ.replace("v 1 0 0", "v 2 0 0"))
    with pytest.warns(EqualtimeWarning, match="takes no part: the files of the scene have other contents"):
        end = ended(found, text, (5, 6))
    assert (end.name, end.result, end.lost) == ("run", None, False)
    assert found.present == ()
    with pytest.raises(RenderError, match=r"no worker of the cluster can take runs; .* other contents"):
        found.look()


def test_each_experiment_of_a_folder_goes_to_the_cluster(cluster: DaskCluster, tmp_path: Path) -> None:
    scene = f'scenes = [{{ path = "{CORNELL}", name = "box", size = [8, 8], max_depth = 2 }}]'
    rest = "spp = [2, 4]\nrepeats = 1\nreference = { error = 0.5, seconds = 0.2 }\n"
    theirs = '{ label = "theirs", peer = { command = "render {spp} {seed} {out}" } }'
    (tmp_path / "x1.toml").write_text(f'{scene}\nstrategies = ["mis", "best"]\n{rest}')
    (tmp_path / "x2.toml").write_text(f'{scene}\nstrategies = ["best", {theirs}]\n{rest}')
    first, second = run_all(tmp_path, tmp_path / "out", cluster=cluster)
    assert (first.state, second.state) == ("done", "failed")
    assert "theirs: other renderers and estimators" in second.problem
    assert len(ExperimentFolder(tmp_path / "out" / "x1").read_provenance()["workers"]) == 1


def test_an_unlike_worker_takes_no_part(
    cluster: DaskCluster, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("equaltime.cluster.likeness.machine_facts", lambda: {"cpu": "another one"})
    why = r"times of unlike machines cannot be compared \(cpu is .* there, and another one here; "
    refused = pytest.warns(EqualtimeWarning, match=f"takes no part: {why}")
    with refused, pytest.raises(RenderError, match=f"no worker of the cluster can take runs; tcp://.*{why}"):
        run(experiment(), tmp_path, cluster=cluster)
    assert rows(tmp_path) == ()
    place = cluster.client.scheduler.address
    with warnings.catch_warnings():
        warnings.simplefilter("default")
        assert main(["cost", str(CORNELL), "-o", str(tmp_path / "a"), "--cluster", place, "--quick"]) == 1
    told = capsys.readouterr().err.splitlines()
    assert [line.split(":")[0] for line in told] == ["warning", "error"]
    assert "takes no part: times of unlike machines" in told[0]


def test_machines_are_alike_if_their_memory_differs_a_little() -> None:
    mine = likeness()
    memory = mine.facts["memory_bytes"]
    more, twice = (replace(mine, facts={**mine.facts, "memory_bytes": k * memory // 100}) for k in (101, 200))
    assert mine.differences(more) == ""
    assert mine.differences(twice) == f"memory_bytes is {2 * memory} there, and {memory} here"
    core = replace(mine, facts={**mine.facts, "core_sha256": "0" * 64})
    assert mine.differences(core).startswith(f"core_sha256 is {'0' * 40} there, and ")


def test_of_two_workers_on_one_machine_one_takes_runs() -> None:
    with DaskCluster.here(2, None) as two:
        two.client.wait_for_workers(2, timeout=LONGEST)
        with pytest.warns(EqualtimeWarning, match=f"another worker of {likeness().host} does"):
            found = two.machines()
        assert len(found.present) == 1
        (first,) = found.present
        os.kill(two.client.run(os.getpid, workers=[first.address])[first.address], signal.SIGKILL)
        while found.present in ((), (first,)):
            with suppress(EqualtimeWarning):
                found.look()
        assert len(found.present) == 1


def test_places_where_runs_would_disturb_each_other_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(ValueError, match="local:2: processes of one machine would disturb each other's times"):
        et.cost(SCENE, tmp_path / "a", cluster="local:2")
    with ProcessPoolExecutor(1) as pool:
        for where in (pool, Pool(pool)):
            with pytest.raises(ValueError, match="does not tell on which machines its processes are"):
                et.cost(SCENE, tmp_path / "a", cluster=where)
    assert not (tmp_path / "a").exists()
    assert main(["cost", str(CORNELL), "-o", str(tmp_path / "a"), "--cluster", "local:4"]) == 2
    assert "'--cluster': local:4: processes of one machine" in capsys.readouterr().err
    assert check_machines("local:1") == "local:1"
    assert check_machines(None) is None


def test_other_renderers_and_estimators_run_here_alone(tmp_path: Path) -> None:
    theirs = {"label": "theirs", "peer": {"command": "render {spp} {seed} {out}"}}
    with pytest.raises(ExperimentError, match="strategies: theirs, own: other renderers and estimators"):
        run(
            experiment(strategies=["best", theirs, {"label": "own", "python": "a.py:Own"}]), tmp_path, cluster="local:1"
        )
    assert not list(tmp_path.glob("*.csv"))


class _Table(Machines):
    """Machines that exist on paper: each run takes the seconds that its strategy takes on its machine."""

    def __init__(self, count: int) -> None:
        self._all = tuple(Machine(f"tcp://{n}", str(n)) for n in range(count))
        self._at: dict[str, tuple[Any, Machine]] = {}
        self.log: list[tuple[str, Any]] = []
        self.losing = 0

    @property
    def present(self) -> tuple[Machine, ...]:
        return self._all

    @property
    def free(self) -> tuple[Machine, ...]:
        return tuple(machine for machine in self._all if machine.address not in self._at)

    def look(self) -> None:
        pass

    def give(self, name: Any, machine: Machine, *_: Any) -> None:
        assert machine in self.free, "one run at a time"
        self._at[machine.address] = name, machine
        self.log.append((machine.host, name))

    def ended(self) -> Iterator[Ended]:
        at, self._at = self._at, {}
        for name, machine in at.values():
            lost = self.losing > 0
            self.losing -= lost
            yield Ended(name, machine, None if lost else "run", lost)


def spread(table: _Table, repeats: int) -> list[Any]:
    """Return the runs of two strategies in the order in which they end; counts come from the first repeat."""
    keys = [("s", label, repeat) for repeat in range(repeats) for label in ("x", "y")]
    done: list[Any] = []

    def order(key: Any) -> Any:
        return "order" if key[2] == 0 or (*key[:2], 0) in done else None

    strategies = dict.fromkeys("xy", Strategy.parse("mis"))
    for key, _, _ in finished_runs(table, keys, order, {"s": None}, strategies, lambda *told: None):  # type: ignore[dict-item]
        done.append(key)
    return done


def test_first_repeats_go_first_and_strategies_change_machines() -> None:
    table = _Table(2)
    assert len(spread(table, 5)) == 10
    assert [name[2] for _, name in table.log] == sorted(name[2] for _, name in table.log)
    for host in "01":
        runs = [name[1] for where, name in table.log if where == host]
        assert abs(runs.count("x") - runs.count("y")) <= 1
    waits = _Table(3)
    spread(waits, 2)
    assert [host for host, name in waits.log if name[2] == 0] == ["0", "1"], "the third waits for the counts"


def test_a_lost_run_is_given_again_but_not_without_end() -> None:
    table = _Table(1)
    table.losing = 4
    assert spread(table, 1) == [("s", "x", 0), ("s", "y", 0)]
    assert [name[1] for _, name in table.log] == ["x"] * 5 + ["y"]
    table = _Table(1)
    table.losing = 5
    with pytest.raises(RenderError, match="repeat 0 of x on s ended several machines in turn"):
        spread(table, 1)


def test_a_complete_experiment_asks_for_no_cluster(
    cluster: DaskCluster, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    wanted = experiment(scenes=experiment().scenes[:1], repeats=1)
    run(wanted, tmp_path)
    monkeypatch.setattr(runner, "finished_runs", None)
    run(wanted, tmp_path, cluster="tcp://127.0.0.1:1")  # nobody listens there
