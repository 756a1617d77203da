"""The benchmark: what the core times, how repeats are taken in turn, and what the command prints."""

import json
import re
import signal
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pytest

import equaltime as et
from equaltime import _core
from equaltime.bench import Measurement, measure
from equaltime.cli import main
from equaltime.statistics.intervals import Interval

SCENE = """
[integrator]
type = "path"
max_depth = 4

[sensor]
type = "perspective"
fov = 60
film = { type = "hdrfilm", width = 24, height = 16, rfilter = { type = "box" } }

[room]
type = "cube"
to_world = [{ scale = 5 }, { translate = [0.3, 0.2, 0.1] }]
flip_normals = true
bsdf = { type = "diffuse", reflectance = 0.8 }

[ball]
type = "sphere"
center = [0, 0, 3]

[lamp]
type = "sphere"
center = [2, 3, 1]
radius = 0.5
emitter = { type = "area", radiance = 20 }
"""
PIXELS = 24 * 16


@pytest.fixture
def path(tmp_path: Path) -> Path:
    file = tmp_path / "room.toml"
    file.write_text(SCENE)
    return file


@pytest.fixture
def scene(path: Path) -> et.Scene:
    return et.load(path)


def limit(scene: et.Scene, max_depth: int = 4, **options: Any) -> dict[str, Any]:
    return _core.measure_limit(scene.core, _core.Settings(max_depth=max_depth), **{"samples": 2, "pairs": 1} | options)


def counts(result: Mapping[str, Any]) -> list[tuple[int, ...]]:
    return [tuple(pair[key] for key in ("paths", "rays", "shadow_rays", "found")) for pair in result["pairs"]]


# --- The core: renders and replays ---


def test_the_timed_render_is_that_of_the_renderer(scene: et.Scene) -> None:
    renderer = _core.Renderer(scene.core, _core.Settings(max_depth=4), seed=3, threads=1)
    renderer.advance(20)
    result = limit(scene, seed=3, samples=20, threads=1)
    assert (result["samples"], result["threads"], result["kernel"]) == (20, 1, renderer.kernel)
    (pair,) = result["pairs"]
    assert {key: renderer.counters[key] for key in ("paths", "rays", "shadow_rays")}.items() <= pair.items()
    assert pair["render_seconds"] > 0.0
    assert pair["replay_seconds"] > 0.0


def test_every_camera_ray_of_a_closed_room_finds_a_wall(scene: et.Scene) -> None:
    assert counts(limit(scene, max_depth=1)) == [(2 * PIXELS, 2 * PIXELS, 0, 2 * PIXELS)]


def test_what_the_replay_finds_is_what_the_path_tracer_met(scene: et.Scene) -> None:
    """Within a closed room every nearest-hit ray finds something; all that is left are shadow rays."""
    (_, rays, shadow_rays, found) = counts(limit(scene))[0]
    assert rays < found < rays + shadow_rays


@pytest.mark.parametrize("options", [{"threads": 3}, {"tile": 5}, {"memory_bytes": 1}, {"replay_first": True}])
def test_the_rays_do_not_depend_on_how_they_are_dealt_out(scene: et.Scene, options: dict[str, Any]) -> None:
    assert counts(limit(scene, pairs=3, **options)) == counts(limit(scene, pairs=3, threads=1))


def test_each_pair_has_samples_of_its_own(scene: et.Scene) -> None:
    assert len(set(counts(limit(scene, pairs=4)))) == 4


@pytest.mark.parametrize("option", ["samples", "pairs"])
def test_a_measurement_of_nothing_is_refused(scene: et.Scene, option: str) -> None:
    with pytest.raises(ValueError, match="at least 1"):
        limit(scene, **{option: 0})


# --- The round of repeats ---


class FakeClock:
    """Stands in for the core: a render takes 8 s on one thread and 4.4 s on two, its replay a quarter."""

    def __init__(self) -> None:
        self.calls: list[tuple[int, int, bool]] = []

    def __call__(
        self,
        scene: object,
        settings: object,
        *,
        seed: int = 0,
        threads: int,
        samples: int,
        pairs: int,
        replay_first: bool,
    ) -> dict[str, Any]:
        assert pairs == 1
        self.calls.append((threads, seed, replay_first))
        seconds = 8.0 if threads == 1 else 4.4
        pair = {
            "render_seconds": seconds,
            "replay_seconds": seconds / 4,
            "paths": 800,
            "rays": 2000,
            "shadow_rays": 400,
        }
        return {"samples": samples, "threads": threads, "kernel": "all", "pairs": [pair]}


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> FakeClock:
    fake = FakeClock()
    monkeypatch.setattr(_core, "measure_limit", fake)
    return fake


def test_repeats_go_round_there_and_back(scene: et.Scene, clock: FakeClock) -> None:
    measure([scene], threads=[1, 2], repeats=3, spp=4)
    assert clock.calls == [
        (1, 0, False), (2, 0, False),
        (2, 1, True), (1, 1, True),
        (1, 2, False), (2, 2, False),
    ]  # fmt: skip


def test_a_report_has_rates_ratio_and_scaling(scene: et.Scene, clock: FakeClock) -> None:
    shares: list[float] = []
    report = measure([scene, scene], threads=[1, 2], repeats=2, spp=4, strategy="mis", progress=shares.append)
    assert [row.threads for row in report.scenes] == [1, 2, 1, 2]
    one, two = report.scenes[2:]
    assert one.paths_per_s == Interval(100.0, 100.0, 100.0).doubted("only 2 repeats, and 6 are the least for a median")
    assert one.rays_per_s.value == pytest.approx(300.0)
    assert two.limit_ratio.value == 0.25
    assert one.scaling.value == 1.0
    assert two.scaling.value == pytest.approx(8.0 / 4.4)
    assert (one.samples, one.repeats, one.rays_per_path, one.strategy, one.size) == (4, 2, 3.0, "mis", (24, 16))
    assert shares == sorted(shares)
    assert shares[-1] == 1.0


def test_the_number_of_samples_is_chosen_by_time(scene: et.Scene) -> None:
    (row,) = measure([scene], repeats=1, threads=[1]).scenes
    assert row.samples > 16


@pytest.mark.parametrize(
    "arguments", [{"threads": []}, {"threads": [-1]}, {"repeats": 0}, {"spp": 0}, {"scenes": []}], ids=str
)
def test_arguments_out_of_range_are_refused(scene: et.Scene, arguments: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match="at least"):
        measure(**{"scenes": [scene]} | arguments)


def test_a_film_beyond_all_memory_is_refused(scene: et.Scene) -> None:
    with pytest.raises(et.SceneError, match="memory"):
        measure([scene.with_(size=(10**6, 10**6))])


# --- The command ---


def run_json(arguments: Sequence[str], capsys: pytest.CaptureFixture[str]) -> dict[str, Any]:
    assert main(["bench", *arguments, "--json"]) == 0
    captured = capsys.readouterr()
    assert captured.err == ""
    record = json.loads(captured.out)
    assert isinstance(record, dict)
    return record


def test_the_record_has_what_scripts_rely_on(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    options = ["--threads", "1,2", "--repeats", "2", "--spp", "2", "--size", "8x6", "--max-depth", "3"]
    record = run_json([str(path), *options, "--strategy", "bsdf"], capsys)
    assert record.keys() == {"scenes", "machine", "build"}
    assert [row["threads"] for row in record["scenes"]] == [1, 2]
    row = record["scenes"][0]
    assert row.keys() == Measurement.__dataclass_fields__.keys() | {"intervals"}
    assert (row["name"], row["size"], row["max_depth"], row["strategy"]) == (str(path), [8, 6], 3, "bsdf")
    assert row["intervals"].keys() == {"paths_per_s", "rays_per_s", "limit_ratio", "scaling"}
    for name, (low, high) in row["intervals"].items():
        assert 0.0 < low <= row[name] <= high
    assert record["machine"]["processors"] >= 1
    assert "embree" in record["build"]


def test_the_table_names_scenes_and_says_what_it_stands_on(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    command = ["bench", str(path), "--repeats", "1", "--spp", "2", "--threads"]
    assert main([*command, "1"]) == 0
    answer, measured = capsys.readouterr().out.splitlines()
    assert re.match(r"room\.toml: [\d.]+ million rays a second \(.*\) on 1 thread, [\d.]+ % \(", answer)
    assert answer.endswith(") of the speed of Embree alone.")
    assert measured.startswith("Medians of 1 repeat with their ranges, at load ")
    assert main([*command, "1,2"]) == 0
    out = capsys.readouterr().out
    assert all(word in out for word in ("threads", "M rays/s", "limit ratio", "scaling"))
    assert main([*command, "1", "-v"]) == 0
    out = capsys.readouterr().out
    assert all(word in out for word in ("M paths/s", "limit ratio: time of Embree", "Embree 3."))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--threads", "one"], "'one' is no list of numbers of threads"),
        (["--threads", "1,,2"], "is no list of numbers of threads"),
        (["--repeats", "0"], "--repeats"),
        (["--spp", "0"], "--spp"),
        (["--size", "12"], "'12' is no size"),
        (["--strategy", "bets"], "did you mean 'best'?"),
        (["-D", "unknown=1"], "unknown"),
        (["nowhere.toml"], "nowhere.toml"),
        (["--size", "1000000000x1000000000"], "memory"),
    ],
)
def test_bad_input_is_one_clear_message(
    path: Path, capsys: pytest.CaptureFixture[str], options: list[str], message: str
) -> None:
    assert main(["bench", str(path), *options]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert len(captured.err.splitlines()) == 1
    assert captured.err.startswith("error: ")
    assert message in captured.err


def test_without_a_scene_there_is_nothing_to_measure(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench"]) == 2
    assert "SCENE" in capsys.readouterr().err


def test_ctrl_c_ends_it_at_once(path: Path) -> None:
    code = "import sys; from equaltime.cli import main; print('begun', file=sys.stderr, flush=True); sys.exit(main())"
    command = [sys.executable, "-c", code, "bench", str(path), "--spp", "100000", "--size", "128x128"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr is not None
        assert process.stderr.readline() == "begun\n"
        time.sleep(1.0)
        process.send_signal(signal.SIGINT)
        sent = time.monotonic()
        printed, complaints = process.communicate(timeout=20.0)
    assert time.monotonic() - sent < 2.0
    assert process.returncode == 130
    assert printed == ""
    assert "Traceback" not in complaints
