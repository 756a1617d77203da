"""Records: what is written comes back, and a kill at any moment costs at most the run that was going on."""

import csv
import math
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from equaltime.errors import ExperimentError
from equaltime.experiments.run.record import COLUMNS, Recorder, Row, check_seeds, complete, load

ROW = Row(
    scene="cornell box, red",
    digest="ab" * 32,
    width=64,
    height=48,
    crop=(0, 8, 64, 40),
    max_depth=-1,
    strategy='the "best"',
    name="best,sampler=independent",
    renderer="core",
    biased=False,
    repeat=0,
    seed=2**31 - 1,
    checkpoint=0,
    spp=2,
    wall_s=0.1,
    cpu_s=1 / 3,
    setup_s=1e-300,
    threads=2,
    paths=10**12,
    rays=None,
    shadow_rays=None,
    relmse=-1e-9,
    mse=math.inf,
    mare=0.25,
    flip=None,
    reference_relmse=2.5e-5,
    estimate=None,
    estimate_low=None,
    estimate_high=None,
    last=False,
    image=None,
    machine="m1",
    build="b1",
    started="2026-01-01T00:00:00Z",
)


def run(repeat: int, checkpoints: int = 3) -> Iterator[Row]:
    for checkpoint in range(checkpoints):
        last = checkpoint == checkpoints - 1
        image = "images/é.npy" if last else None
        yield replace(ROW, repeat=repeat, checkpoint=checkpoint, spp=2 + 2 * checkpoint, last=last, image=image)


def write(path: Path, *runs: Iterator[Row]) -> tuple[Row, ...]:
    with Recorder(path) as recorder:
        for rows in runs:
            for row in rows:
                recorder.append(row)
        return recorder.rows


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "records.csv"


def test_what_is_written_comes_back(path: Path) -> None:
    rows = write(path, run(0), run(1))
    assert rows == (*run(0), *run(1))
    assert load(path) == rows
    assert path.read_text().splitlines()[0] == ",".join(COLUMNS)


def test_numbers_of_numpy_are_written_as_numbers(path: Path) -> None:
    row = replace(ROW, wall_s=np.float64(0.1), spp=int(np.int64(4)), last=True)
    assert write(path, iter([row])) == load(path)


def test_no_file_holds_no_rows(path: Path) -> None:
    assert load(path) == ()
    path.touch()
    assert load(path) == ()


def test_a_second_opening_goes_on_where_the_first_ended(path: Path) -> None:
    write(path, run(0))
    before = path.read_bytes()
    assert write(path, run(1)) == (*run(0), *run(1))
    assert path.read_bytes().startswith(before)


def test_a_torn_last_line_is_left_out_and_cut_before_the_next_is_written(path: Path) -> None:
    write(path, run(0), run(1))
    whole = path.read_bytes()
    line = whole.rfind(b"\n", 0, -1) + 1
    for size in range(line, len(whole)):
        path.write_bytes(whole[:size])
        assert load(path) == (*run(0), *tuple(run(1))[:-1])
        assert write(path, run(1)) == (*run(0), *run(1))
        assert path.read_bytes() == whole


def test_a_torn_first_line_is_written_again(path: Path) -> None:
    write(path, run(0))
    whole = path.read_bytes()
    for size in range(whole.index(b"\n") + 1):
        path.write_bytes(whole[:size])
        assert load(path) == ()
        assert write(path, run(0)) == tuple(run(0))
        assert path.read_bytes() == whole


def test_a_run_that_had_not_ended_is_cut_off(path: Path) -> None:
    write(path, run(0), iter(tuple(run(1))[:2]))
    assert len(load(path)) == 5
    assert complete(load(path)) == tuple(run(0))
    with Recorder(path) as recorder:
        assert recorder.rows == tuple(run(0))
    assert load(path) == tuple(run(0))


def without(columns: tuple[str, ...], path: Path) -> None:
    """Make the file what an earlier version wrote."""
    table = [row[:] for row in csv.reader(path.read_text(encoding="utf-8").splitlines())]
    kept = [number for number, name in enumerate(table[0]) if name not in columns]
    with path.open("w", newline="", encoding="utf-8") as file:
        csv.writer(file, lineterminator="\n").writerows([row[number] for number in kept] for row in table)


def test_what_a_render_doubts_is_recorded(path: Path) -> None:
    rows = [replace(row, doubt="heavy tail: one pixel, and others") for row in run(0)]
    write(path, iter(rows))
    assert list(load(path)) == rows


@pytest.mark.parametrize("columns", [("doubt", "decided", "splitting"), ("decided", "splitting")])
def test_records_of_earlier_versions_are_read_and_gone_on_with(path: Path, columns: tuple[str, ...]) -> None:
    write(path, run(0))
    without(columns, path)
    assert load(path) == tuple(run(0))
    write(
        path,
        (
            replace(row, **{name: 0.5 if name == "splitting" else "no room for it" for name in columns})
            for row in run(1)
        ),
    )
    assert load(path) == (*run(0), *run(1))


def test_two_repeats_of_one_seed_are_told(path: Path) -> None:
    rows = [replace(row, seed=5 + row.repeat % 2) for repeat in range(3) for row in run(repeat)]
    check_seeds(rows[:6], path)
    with pytest.raises(ExperimentError, match='repeats 0 and 2 of the "best" on cornell box, red have one seed'):
        check_seeds(rows, path)


def test_a_checkpoint_cannot_be_recorded_twice(path: Path) -> None:
    write(path, run(0))
    with Recorder(path) as recorder, pytest.raises(ValueError, match="recorded already"):
        recorder.append(ROW)
    assert load(path) == tuple(run(0))


def test_a_line_break_cannot_get_into_a_record(path: Path) -> None:
    with Recorder(path) as recorder:
        for text in ("two\nlines", "two\rlines"):
            with pytest.raises(ValueError, match="line break"):
                recorder.append(replace(ROW, name=text))
    assert load(path) == ()


def test_only_one_process_writes_at_a_time(path: Path) -> None:
    with Recorder(path), pytest.raises(ExperimentError, match=r"records\.csv: another process is writing to it"):
        Recorder(path)
    Recorder(path).close()


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("scene,digest", "scene,digests", r"records\.csv:1: the columns are not those of equaltime's records"),
        (",core,0,0,", ",core,true,0,", r"records\.csv:2: no record: biased: expected 0 or 1, found 'true'"),
        (",core,0,0,", ",core,2,0,", r"records\.csv:2: no record: biased: expected 0 or 1, found '2'"),
        (",0 8 64 40,", ",0 8 64,", r"records\.csv:2: no record: crop: expected 4 whole numbers, found '0 8 64'"),
        (",core,", ",", r"records\.csv:2: no record: it has 36 cells, not 37"),
        ('"the ""best"""', '"the ""best" "x', r"records\.csv:2: no record"),
        (",64,48,", ",64,0,", r"records\.csv:2: no record: height: must be at least 1, found '0'"),
        (
            ",64,48,",
            ",60,48,",
            r"records\.csv:2: no record: crop must lie in the image of 60x48, found \(0, 8, 64, 40\)",
        ),
        (",2,0.1,", ",2,inf,", r"records\.csv:2: no record: wall_s: expected a finite number, found 'inf'"),
        (",2,0.1,", ",2,nan,", r"records\.csv:2: no record: wall_s: expected a finite number, found 'nan'"),
        (",2,0.1,", ",0,0.1,", r"records\.csv:2: no record: spp: must be at least 1, found '0'"),
        (",64,48,", ",,48,", r"records\.csv:2: no record: width: expected a whole number, found ''"),
        (",0,2147483647,1,4", ",0,2147483647,0,2", r"records\.csv:3: the same checkpoint of the same run as line 2"),
    ],
)
def test_what_is_no_record_is_refused_with_its_line(path: Path, old: str, new: str, message: str) -> None:
    write(path, run(0))
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))
    for use in (load, Recorder):
        with pytest.raises(ExperimentError, match=message):
            use(path)


def test_every_damaged_line_is_told(path: Path) -> None:
    write(path, run(0))
    path.write_text(path.read_text().replace(",core,", ",core,core,"))
    with pytest.raises(ExperimentError) as caught:
        load(path)
    assert len(caught.value.problems) == 3


WRITER = """
import sys
from pathlib import Path
sys.path.insert(0, sys.argv[2])
from test_records import run
from equaltime.experiments.run.record import Recorder
with Recorder(Path(sys.argv[1])) as recorder:
    print("ready", flush=True)
    for repeat in range(len({row.repeat for row in recorder.rows}), 100000):
        for row in run(repeat):
            recorder.append(row)
"""


def kill_writers(path: Path, times: int) -> None:
    moments = np.random.default_rng(1).uniform(0.0, 0.03, times)
    for moment in moments:
        before = complete(load(path))
        command = [sys.executable, "-c", WRITER, str(path), str(Path(__file__).parent)]
        with subprocess.Popen(command, stdout=subprocess.PIPE) as process:
            assert process.stdout is not None
            process.stdout.readline()
            time.sleep(moment)
            process.send_signal(signal.SIGKILL)
        rows = complete(load(path))
        assert rows[: len(before)] == before
        assert rows == tuple(row for repeat in range(len(rows) // 3) for row in run(repeat))


def test_records_survive_kills(path: Path) -> None:
    kill_writers(path, 3)
    assert load(path)


@pytest.mark.slow
def test_records_survive_a_hundred_kills(path: Path) -> None:
    kill_writers(path, 100)
    assert load(path)
