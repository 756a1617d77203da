"""Renders on a cluster of this machine: their bits, their speed beside threads, and what faults do to them.

``bits`` compares the moments of a render in one process with those on 1 and 4 processes, and on 4 of which three are
killed. ``speed`` renders the same samples with two threads and with two processes, in turn; starting the processes is
not timed, but the scene goes to them in the time. ``faults`` injects faults into renders, kind by kind in turn: a
worker is killed, or stopped so that it answers no more (as behind a cut network), all workers are killed, the
scheduler is killed, or the client. A lost client or scheduler is followed by a new one that resumes.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from measuring import SCENES, arguments, parsed, ratio, rounds, text

import equaltime as et
from equaltime.errors import RenderError

sys.path.insert(0, str(SCENES.parent / "tests" / "unit" / "cluster"))  # the suite injects the same faults
from daemons import at_progress, free_port, same, scheduler, worker

BITS: tuple[tuple[str, dict[str, Any]], ...] = (
    ("cornell-box", {"spp": 64}),
    ("cornell-box", {"error": 0.05}),
    ("terrain", {"spp": 32}),
    ("terrain", {"error": 0.1, "strategy": "best,adaptive=none"}),
    ("windmill", {"spp": 48}),
    ("windmill", {"error": 0.05}),
)
QUICKLY = {"DASK_DISTRIBUTED__SCHEDULER__WORKER_TTL": "3s"}
"""Time after which a scheduler gives up a worker that does not answer."""


def main() -> None:
    parser = arguments(__doc__, repeats=6)
    parser.add_argument("--parts", nargs="*", default=[*PARTS], choices=PARTS)
    parser.add_argument("--size", type=int, default=256, help="pixels along each side [%(default)s]")
    parser.add_argument("--seconds", type=float, default=30.0, help="of a render that is timed [%(default)s]")
    parser.add_argument("--faults", type=int, default=30, help="[%(default)s]")
    options = parsed(parser, repeats=1, seconds=3, faults=5, size=96)
    for part in options.parts:
        PARTS[part](options)


def bits(options: Any) -> None:
    """Print for each scene and limit whether all ways give the same moments."""
    for name, limits in BITS:
        scene = et.load(name).with_(size=(options.size, options.size))
        alone, found = et.render(scene, **limits), []
        for where in ("local:1", "local:4"):
            found.append(f"{where} {_told(same(et.render(scene, **limits, cluster=where), alone))}")
        with et.open_cluster("local:4") as cluster:
            thrice = et.Observer.of(progress=_Killer(cluster, 3))
            there = et.render(scene, **limits, cluster=cluster, observer=thrice)
        found.append(f"local:4 with three kills {_told(same(there, alone))}")
        print(f"{name:12} {limits}: {', '.join(found)}", flush=True)


class _Killer:
    """Kills a worker of a cluster at each of its first calls that are half a second apart."""

    def __init__(self, cluster: Any, kills: int) -> None:
        self._cluster, self._left, self._next = cluster, kills, 0.0

    def __call__(self, _: object) -> None:
        if self._left and time.monotonic() > self._next:
            workers = self._cluster.client.run(os.getpid, on_error="ignore")
            if workers:
                os.kill(next(iter(workers.values())), signal.SIGKILL)
                self._left, self._next = self._left - 1, time.monotonic() + 0.5


def speed(options: Any) -> None:
    """Print the time of two threads over that of two processes, for the same samples."""
    scene = et.load("cornell-box").with_(size=(2 * options.size, 2 * options.size))
    pilot = et.render(scene, spp=8, threads=2)
    spp = max(16, round(8 * options.seconds / pilot.stats.seconds))
    with et.open_cluster("local:2") as cluster:
        ways: Mapping[str, dict[str, Any]] = {"threads": {"threads": 2}, "processes": {"cluster": cluster}}

        def measure(name: str, _: int) -> float:
            begin = time.perf_counter()
            et.render(scene, spp=spp, **ways[name])
            return time.perf_counter() - begin

        seconds = rounds(ways, measure, options.repeats)
    print(f"two threads take {min(seconds['threads']):.3g} s at least for {spp} samples a pixel, {scene.size}")
    print(f"their time over that of two processes: {text(ratio(seconds['threads'], seconds['processes']))}", flush=True)


def faults(options: Any) -> None:
    """Print for each kind of fault how many renders had it, and how many had the bits of an undisturbed one."""
    scene = et.load("cornell-box").with_(size=(options.size, options.size))
    begin = time.perf_counter()
    alone = et.render(scene, spp=_SAMPLES, threads=2)
    print(f"undisturbed: {time.perf_counter() - begin:.3g} s")
    found: dict[str, list[tuple[bool, float]]] = {kind: [] for kind in FAULTS}
    for number in range(options.faults):
        kind = list(FAULTS)[number % len(FAULTS)]
        begin = time.perf_counter()
        with tempfile.TemporaryDirectory(prefix="equaltime-") as folder:
            result = FAULTS[kind](scene, Path(folder) / "a.exr", 2 + number // len(FAULTS))
        found[kind].append((same(result, alone), time.perf_counter() - begin))
    for kind, runs in found.items():
        took = [seconds for _, seconds in runs]
        right = sum(right for right, _ in runs)
        print(f"{kind:28} {right} of {len(runs)} have the same bits, {min(took):.3g} to {max(took):.3g} s", flush=True)


_SAMPLES = 96


def _of_workers(stop: Callable[[list[subprocess.Popen[bytes]]], object]) -> Callable[..., et.Result]:
    """Return a function that renders with two workers, to which ``stop`` does something on the way."""

    def render(scene: et.Scene, _: Path, when: int) -> et.Result:
        port = free_port()
        with ExitStack() as running:
            running.enter_context(scheduler(port, **QUICKLY))
            workers = [running.enter_context(worker(port)) for _ in range(2)]

            def act() -> None:
                stop(workers)
                running.enter_context(worker(port))

            observer = running.enter_context(at_progress(when, act))
            return et.render(scene, spp=_SAMPLES, cluster=f"tcp://127.0.0.1:{port}", observer=observer)

    return render


def _without_scheduler(scene: et.Scene, output: Path, when: int) -> et.Result:
    port = free_port()
    address = f"tcp://127.0.0.1:{port}"
    with scheduler(port) as first, worker(port), at_progress(when, first.kill) as observer:
        try:
            et.render(scene, spp=_SAMPLES, cluster=address, checkpoint=output, observer=observer)
            raise AssertionError("the render did not notice that the scheduler was gone")
        except RenderError:
            pass
    with scheduler(port), worker(port):
        resume = output if output.exists() else None
        return et.render(scene, spp=_SAMPLES, cluster=address, checkpoint=output, resume=resume)


def _without_client(scene: et.Scene, output: Path, when: int) -> et.Result:
    width, height = scene.size
    words = ["cornell-box", "--size", f"{width}x{height}", "--spp", str(_SAMPLES), "-o", str(output), "--resume"]
    command = [sys.executable, "-m", "equaltime", "render", *words, "--quiet", "--cluster", "local:2"]
    units = output.with_name("a.exr.units")
    with subprocess.Popen(command, stderr=subprocess.DEVNULL, start_new_session=True) as first:
        while first.poll() is None and len(list(units.glob("*.npz"))) < when:
            time.sleep(0.01)
        os.killpg(first.pid, signal.SIGKILL)
    subprocess.run(command, check=True, stderr=subprocess.DEVNULL)
    return et.read(output)


FAULTS: Mapping[str, Callable[..., et.Result]] = {
    "a worker is killed": _of_workers(lambda workers: workers[0].kill()),
    "a worker answers no more": _of_workers(lambda workers: workers[0].send_signal(signal.SIGSTOP)),
    "all workers are killed": _of_workers(lambda workers: [each.kill() for each in workers]),
    "the scheduler is killed": _without_scheduler,
    "the client is killed": _without_client,
}
PARTS = {"bits": bits, "speed": speed, "faults": faults}


def _told(right: bool) -> str:
    return "same bits" if right else "OTHER BITS"


if __name__ == "__main__":
    main()
