"""A container's limits count as the machine's, and decide how many threads work by default."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

import equaltime as et
from equaltime import bench, machine
from equaltime import files as locks
from equaltime.experiments.model.experiment import Experiment
from equaltime.experiments.run.folder import ExperimentFolder
from equaltime.experiments.run.record import load
from equaltime.experiments.run.runner import run
from equaltime.machine import memory_bytes, processors
from equaltime.rendering import core as core_renderer

CORNELL = Path(__file__).parents[2] / "scenes" / "cornell-box.toml"
MANY = 64


@pytest.fixture
def groups(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder of cgroups on a machine of 64 processors, where this process is in one of each version."""
    own = tmp_path / "own"
    own.write_text("9:name=systemd:/\n4:memory:/pod/box\n1:cpuacct,cpu:/pod/box\n0::/pod/box\n")
    monkeypatch.setattr(machine, "_OWN", own)
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: set(range(MANY)))
    return tmp_path / "cgroup"


def write(file: Path, text: str) -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(f"{text}\n")


@pytest.mark.parametrize("place", ["", "pod", "pod/box"])
@pytest.mark.parametrize(
    ("limit", "count"),
    [("max 100000", MANY), ("200000 100000", 2), ("150000 100000", 2), ("1000 100000", 1), ("9900000 100000", MANY)],
)
def test_the_share_of_a_container_counts(groups: Path, place: str, limit: str, count: int) -> None:
    assert processors(groups) == MANY
    write(groups / place / "cpu.max", limit)
    assert processors(groups) == count


@pytest.mark.parametrize("place", ["cpu", "cpu/pod", "cpu/pod/box"])
@pytest.mark.parametrize(("quota", "count"), [(-1, MANY), (300_000, 3), (310_000, 4), (1_000, 1)])
def test_the_share_of_an_old_container_counts(groups: Path, place: str, quota: int, count: int) -> None:
    write(groups / place / "cpu.cfs_period_us", "100000")
    assert processors(groups) == MANY
    write(groups / place / "cpu.cfs_quota_us", str(quota))
    assert processors(groups) == count


def test_the_smallest_share_of_all_around_counts(groups: Path) -> None:
    write(groups / "cpu.max", "700000 100000")
    write(groups / "pod" / "cpu.max", "300000 100000")
    write(groups / "pod" / "box" / "cpu.max", "500000 100000")
    assert processors(groups) == 3


@pytest.mark.parametrize("place", ["memory.max", "pod/memory.max", "memory/pod/box/memory.limit_in_bytes"])
def test_the_memory_of_a_container_in_another_counts(groups: Path, place: str) -> None:
    write(groups / place, "4096")
    assert memory_bytes(groups) == 4096


def test_a_memory_limit_of_nothing_is_ignored(groups: Path) -> None:
    present = memory_bytes(groups)
    write(groups / "memory.max", "0")
    assert memory_bytes(groups) == present


def test_records_of_machines_have_the_memory_of_the_container(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(machine, "memory_bytes", lambda: 4096)
    assert machine.machine()["memory_bytes"] == 4096


def test_a_system_that_tells_no_processors_has_those_of_the_machine(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delattr(os, "sched_getaffinity")
    monkeypatch.setattr(machine, "_OWN", tmp_path / "nothing")
    monkeypatch.setattr(os, "cpu_count", lambda: 5)
    assert processors(tmp_path) == 5
    monkeypatch.setattr(os, "cpu_count", lambda: None)
    assert processors(tmp_path) == 1


def test_as_many_threads_work_by_default(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(machine, "processors", lambda: 3)
    scene = et.load(CORNELL).with_(size=(6, 6), max_depth=2)
    assert et.render(scene, spp=1).stats.threads == 3
    assert et.render(scene, spp=1, threads=2).stats.threads == 2
    (measured,) = bench.measure([scene], repeats=1, spp=1).scenes
    assert measured.threads == 3
    wish = {"error": 0.5, "seconds": 0.1}
    run(Experiment(scenes=[{"scene": scene}], strategies=["best"], spp=[1], repeats=1, reference=wish), tmp_path / "o")  # type: ignore[arg-type]  # read
    assert {row.threads for row in load(ExperimentFolder(tmp_path / "o").records)} == {3}


def test_a_film_that_a_container_does_not_hold_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(core_renderer, "memory_bytes", lambda: 1000)
    scene = et.load(CORNELL).with_(size=(6, 6))
    for measured in (lambda: et.render(scene, spp=1), lambda: bench.measure([scene])):
        with pytest.raises(et.SceneError, match=r"GB of memory needed, 1e-06 GB allowed by the machine or its"):
            measured()


def test_without_locks_the_reason_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(locks, "fcntl", None)
    with (
        pytest.raises(et.ExperimentError, match="this system has no locks on files"),
        ExperimentFolder(tmp_path).locked(),
    ):
        pass
