"""Renders by processes of Dask on this machine: the bits of one process, whatever fails on the way."""

from __future__ import annotations

import asyncio
import logging
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import suppress
from multiprocessing import get_context
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import dask
import pytest
from distributed import Client, LocalCluster, Status

import equaltime as et
from equaltime.cli import main
from equaltime.cluster import dask_cluster, scene_text
from equaltime.cluster.dask_cluster import DaskCluster, DaskTeam
from equaltime.cluster.machines import send_files
from equaltime.cluster.scene_text import SceneText
from equaltime.errors import EqualtimeWarning, RenderError

from .daemons import at_progress, free_port, same, scheduler, worker
from .test_scene_text import with_mesh

SCENE = et.load("cornell-box").with_(size=(128, 112))
SAMPLES = 96
HUNG = "3s"
LONGEST = 60
"""Seconds after which a test fails instead of waiting."""

pytestmark = pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning", "ignore::ResourceWarning")


@pytest.fixture(scope="module")
def here() -> et.Result:
    return et.render(SCENE, spp=SAMPLES)


@pytest.fixture(scope="module")
def cluster() -> Iterator[DaskCluster]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(dask_cluster, "_HUNG", HUNG)
        with DaskCluster.here(2, None) as made:
            yield made


def processes(client: Client) -> list[int]:
    return [int(pid) for pid in client.run(os.getpid).values()]


@pytest.mark.parametrize("limits", [{"spp": SAMPLES}, {"error": 0.15}, {"spp": 20, "strategy": "mis,sampler=sobol"}])
def test_two_processes_give_the_bits_of_one(cluster: DaskCluster, limits: dict[str, Any]) -> None:
    there, alone = et.render(SCENE, **limits, cluster=cluster), et.render(SCENE, **limits)
    assert same(there, alone)
    assert (there.stats.rays, there.spp, there.error) == (alone.stats.rays, alone.spp, alone.error)
    assert not same(there, et.render(SCENE, **limits, seed=1)), "the twin"


def test_killed_processes_change_no_bit(cluster: DaskCluster, here: et.Result) -> None:
    def kill() -> None:
        os.kill(processes(cluster.client)[0], signal.SIGKILL)

    with at_progress(3, kill) as observer:
        assert same(et.render(SCENE, spp=SAMPLES, cluster=cluster, observer=observer), here)


def test_when_all_processes_are_killed_new_ones_go_on(cluster: DaskCluster, here: et.Result) -> None:
    def kill() -> None:
        for pid in processes(cluster.client):
            os.kill(pid, signal.SIGKILL)

    with at_progress(4, kill) as observer:
        assert same(et.render(SCENE, spp=SAMPLES, cluster=cluster, observer=observer), here)


def test_a_process_that_hangs_is_given_up(cluster: DaskCluster, here: et.Result) -> None:
    stopped = []

    def stop() -> None:
        stopped.append(processes(cluster.client)[0])
        os.kill(stopped[0], signal.SIGSTOP)

    try:
        with at_progress(3, stop) as observer:
            assert same(et.render(SCENE, spp=SAMPLES, cluster=cluster, observer=observer), here)
    finally:
        with suppress(ProcessLookupError):
            os.kill(stopped[0], signal.SIGKILL)


def test_a_client_that_is_killed_loses_no_finished_unit(tmp_path: Path, here: et.Result) -> None:
    words = ["render", "cornell-box", "--size", "128x112", "-o", str(tmp_path / "a.exr"), "--quiet"]
    command = [sys.executable, "-m", "equaltime", *words, "--spp", str(SAMPLES), "--cluster", "local:2"]
    units = tmp_path / "a.exr.units"
    with subprocess.Popen(command, stderr=subprocess.DEVNULL, start_new_session=True) as render:
        while render.poll() is None and len(list(units.glob("*.npz"))) < 3:
            time.sleep(0.02)
        os.killpg(render.pid, signal.SIGKILL)
    assert len(list(units.glob("*.npz"))) >= 3, "the render had ended"
    assert not (tmp_path / "a.exr").exists()
    subprocess.run([*command, "--resume"], check=True, stderr=subprocess.DEVNULL)
    assert same(et.read(tmp_path / "a.exr"), here)
    assert not units.exists()


def test_a_client_that_fails_to_close_is_no_error() -> None:
    """Distributed raised RuntimeError now and then where the scheduler had ended while the client closed."""

    class Client:
        closed = 0

        def close(self) -> None:
            self.closed += 1
            raise RuntimeError("Cannot change state of expiring Timeout")

    client: Any = Client()
    DaskCluster(client, None, 1).close()
    assert client.closed == 1


@pytest.mark.filterwarnings("ignore:the cluster has no worker")  # a slow machine tells that before
def test_a_scheduler_that_ends_leaves_what_is_finished(tmp_path: Path, here: et.Result) -> None:
    port, output = free_port(), tmp_path / "a.exr"
    address = f"tcp://127.0.0.1:{port}"

    def kill(_: object) -> None:
        if list((tmp_path / "a.exr.units").glob("*.npz")):
            first.kill()

    with (
        dask.config.set({"distributed.comm.timeouts.connect": "2s"}),
        scheduler(port) as first,
        worker(port),
        pytest.raises(
            RenderError, match=r"scheduler was lost; start it and its workers again, then repeat .* --resume"
        ),
    ):
        et.render(SCENE, spp=SAMPLES, cluster=address, checkpoint=output, observer=et.Observer.of(progress=kill))
    assert list((tmp_path / "a.exr.units").glob("*.npz"))
    with scheduler(port), worker(port):
        assert same(et.render(SCENE, spp=SAMPLES, cluster=address, checkpoint=output), here)
    assert not (tmp_path / "a.exr.units").exists()


def test_a_worker_with_other_instructions_is_refused(here: et.Result) -> None:
    port = free_port()
    address = f"tcp://127.0.0.1:{port}"
    with scheduler(port), worker(port, EQUALTIME_ISA="v2"):
        refused = pytest.warns(EqualtimeWarning, match="takes no part: .*instructions of Embree")
        with refused, pytest.raises(RenderError, match="no worker of the cluster can take part"):
            et.render(SCENE, spp=2, cluster=address)
        with worker(port), Client(address) as client:
            client.wait_for_workers(2)
            with pytest.warns(EqualtimeWarning, match="takes no part"):
                assert same(et.render(SCENE, spp=SAMPLES, cluster=address), here)


def test_a_worker_without_equaltime_takes_no_part(tmp_path: Path, here: et.Result) -> None:
    (tmp_path / "equaltime.py").write_text("raise ModuleNotFoundError(\"No module named 'equaltime'\")")
    port = free_port()
    address = f"tcp://127.0.0.1:{port}"
    refused = r"takes no part: equaltime is not installed there"
    with scheduler(port), worker(port, PYTHONPATH=str(tmp_path)), Client(address) as client:
        client.wait_for_workers(1, timeout=LONGEST)
        with (
            pytest.warns(EqualtimeWarning, match=refused),
            pytest.raises(RenderError, match="no worker of the cluster"),
        ):
            et.render(SCENE, spp=2, cluster=address)
        with worker(port):
            client.wait_for_workers(2, timeout=LONGEST)
            with pytest.warns(EqualtimeWarning, match=refused):
                assert same(et.render(SCENE, spp=SAMPLES, cluster=address), here)


def test_a_worker_that_cannot_try_the_scene_says_why(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(scene_text, "_PARENTS", [])
    broken: Any = None
    joining = dask_cluster._Joining("name", SceneText.of(SCENE), broken, "", 1)
    there: Any = SimpleNamespace(resources={}, local_directory=str(tmp_path))

    async def set_resources(**offered: int) -> None:
        there.resources |= offered

    there.set_resources = set_resources
    asyncio.run(joining.setup(there))
    assert joining.why == "AttributeError: 'NoneType' object has no attribute 'recipe'"
    assert there.resources == {"name": 0}


def test_a_worker_that_ends_tells_the_scheduler_nothing() -> None:
    told: list[dict[str, int]] = []

    async def set_resources(**offered: int) -> None:
        told.append(offered)

    joining = dask_cluster._Joining("name", SceneText.of(SCENE), dask_cluster.probe_unit(SCENE), "", 1)
    for status in (Status.closing, Status.closing_gracefully, Status.running):
        there: Any = SimpleNamespace(status=status, set_resources=set_resources)
        asyncio.run(joining.teardown(there))
    assert told == [{"name": 0}]


def test_a_worker_that_joins_within_a_pass_gets_units(here: et.Result) -> None:
    with LocalCluster(n_workers=1, threads_per_worker=1, processes=False, dashboard_address="127.0.0.1:0") as local:
        with DaskCluster.of(local, None) as made:
            team = made.team(SCENE)
            assert team.size == 1
            local.scale(2)
            last = time.monotonic() + LONGEST
            while team.size == 1 and time.monotonic() < last:
                team.check()
                time.sleep(0.1)
            assert team.size == 2
        assert same(et.render(SCENE, spp=SAMPLES, cluster=local), here)


def test_a_worker_that_left_since_the_scheduler_told_of_it_is_no_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    gone = "tcp://127.0.0.1:1"
    with (
        dask.config.set({"distributed.comm.timeouts.connect": "100ms"}),
        LocalCluster(n_workers=1, threads_per_worker=1, processes=False, dashboard_address="127.0.0.1:0") as local,
        DaskCluster.of(local, None) as made,
    ):
        team = made.team(SCENE)
        told = {**dask_cluster.workers_of(made.client), gone: {"resources": {team._name: 1}}}
        monkeypatch.setattr(dask_cluster, "workers_of", lambda client: told)
        monkeypatch.setattr(dask_cluster, "_CHECK_EVERY", 0.0)
        team.check()
        assert team.size == 1
        errors = send_files(made.client, SceneText.of(with_mesh(tmp_path)).files, [*told])
        assert errors.keys() == {gone}


def test_workers_get_copies_of_files_in_their_own_folders(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A worker is there at the begin, and one joins within the pass; both ask for copies, though they see the files."""
    for name in ("_COPIES", "_PARENTS"):
        monkeypatch.setattr(scene_text, name, [])
    monkeypatch.setattr(dask_cluster, "lacks", lambda files: not scene_text._at(scene_text._copies(), files))
    with (
        LocalCluster(
            n_workers=1,
            threads_per_worker=1,
            processes=False,
            dashboard_address="127.0.0.1:0",
            local_directory=tmp_path,
        ) as local,
        DaskCluster.of(local, None) as made,
    ):
        team = made.team(with_mesh(tmp_path))
        for size in (1, 2):
            local.scale(size)
            last = time.monotonic() + LONGEST
            while team.size < size and time.monotonic() < last:
                team.check()
                time.sleep(0.1)
            assert team.size == size
            assert len(list(tmp_path.glob("dask-scratch-space/worker-*/equaltime-*/**/a b.obj"))) == size
            scene_text._COPIES.clear()  # the next worker has none, like another process


def test_a_scheduler_without_workers_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(dask_cluster, "_PATIENT", 0.0)
    monkeypatch.setattr(dask_cluster, "_CHECK_EVERY", 0.0)
    with LocalCluster(n_workers=0, processes=False, dashboard_address="127.0.0.1:0") as local, Client(local) as client:
        impatient = DaskTeam(SCENE, None, client, 1, patience=0.0)
        with pytest.raises(RenderError, match=r"for 0 s; start workers, then repeat the render$"):
            impatient.check()
        with DaskCluster.of(local, None) as queue:
            team = queue.team(SCENE)
            with pytest.warns(EqualtimeWarning, match=r"no worker; the render waits for one$"):
                assert not team.check()
            assert not team.check(), "no second warning, which would be an error"


@pytest.mark.parametrize("threads", [1, 3])
def test_workers_within_this_process_give_the_same_bits(here: et.Result, threads: int) -> None:
    with (
        LocalCluster(
            n_workers=2, threads_per_worker=threads, processes=False, dashboard_address="127.0.0.1:0"
        ) as local,
        Client(local) as client,
    ):
        assert same(et.render(SCENE, spp=SAMPLES, cluster=client), here)
        assert client.status == "running"
    with pytest.raises(ValueError, match="the Client of Dask is closed; expected one that is connected"):
        et.render(SCENE, spp=1, cluster=client)


def test_dask_logs_nothing_of_a_connection_that_equaltime_made(cluster: DaskCluster) -> None:
    address = cluster.client.scheduler.address
    logger, handler = logging.getLogger("distributed"), logging.StreamHandler()
    logger.addHandler(handler)
    try:
        with DaskCluster.at(address, None):
            assert handler.level == logging.CRITICAL
        assert handler.level == logging.NOTSET
    finally:
        logger.removeHandler(handler)


def test_an_executor_of_processes_gives_the_same_bits(here: et.Result) -> None:
    with ProcessPoolExecutor(2, get_context("spawn")) as pool:
        assert same(et.render(SCENE, spp=SAMPLES, cluster=pool), here)


def test_a_place_that_is_none_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(dask_cluster, "CONNECT_SECONDS", 0.5)
    with pytest.raises(ValueError, match="local:N"):
        et.render(SCENE, spp=1, cluster="local:0")
    with pytest.raises(RenderError, match="no scheduler"):
        et.render(SCENE, spp=1, cluster=f"tcp://127.0.0.1:{free_port()}")


@pytest.mark.parametrize("words", [("render", "-o", "box.png", "--spp", "1"), ("quote",)])
def test_the_command_line_says_that_it_waits_for_a_scheduler(
    words: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(dask_cluster, "CONNECT_SECONDS", 0.5)
    monkeypatch.chdir(tmp_path)
    command, *options = words
    address = f"tcp://127.0.0.1:{free_port()}"
    assert main([command, "cornell-box", *options, "--cluster", address]) == 1
    lines = capsys.readouterr().err.splitlines()
    assert f"connecting to {address}, which may take up to 20 s" in lines
    assert lines[-1].startswith("error: no scheduler of Dask answers")
