"""Try mutants of all corpora for some time: python -m tests.hard.fuzz.campaign FOLDER SECONDS [SEED [NAME ...]].

A worker process reads one mutant after the other, and renders every fourth scene; this one watches it. Each input that
hangs, ends the worker, takes too much memory or raises what is no error of ours is kept in FOLDER. The counts by format
are printed every minute and at the end.
"""

from __future__ import annotations

import json
import os
import random
import resource
import select
import signal
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Final

from .memory import TooMuchMemory, Watch
from .mutators import mutated
from .subjects import SCENES, SECONDS, SUBJECTS, check, check_use, suffix_of

CORPUS: Final = Path(__file__).parent / "corpus"
ROOT: Final = Path(__file__).parents[3]
LONGEST: Final = 20.0
"""Seconds after which a worker is ended."""
MOST_SEED: Final = 64 << 10
"""Bytes of a shipped file that serves as a seed besides the corpus."""
MOST_ALIKE: Final = 2
"""Inputs that are kept of those that end alike, in one worker."""
MOST_SAID: Final = 3000
"""Letters of a traceback that are kept, from its end; a line fits into a pipe."""
ADDRESSES: Final = 6 << 30
"""Bytes of memory that a worker may ask for."""


def seeds(name: str) -> list[bytes]:
    """Return what mutants of a subject are made of: its corpus, and small shipped files of the kind."""
    folders = {
        "toml": "scenes",
        "xml": "scenes",
        "result": "tests/unit/data/format_1",
        "experiment": "scenes/experiments",
    }
    shipped = sorted((ROOT / folders.get(name, "tests/unit/data")).rglob(f"*{suffix_of(name)}"))
    files = [*sorted((CORPUS / name).iterdir()), *shipped]
    return [file.read_bytes() for file in files if file.stat().st_size <= MOST_SEED]


def work(names: list[str], seed: int, first: int, pipe: int, place: Path) -> None:
    """Go through the inputs from a number on, and say of each when it begins and how it ended."""
    resource.setrlimit(resource.RLIMIT_AS, (ADDRESSES, ADDRESSES))
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    warnings.simplefilter("error", RuntimeWarning)  # a user would read NumPy's words for them
    all_seeds = {name: seeds(name) for name in names}
    for name in names:  # what is imported late takes time and memory only once
        for content in all_seeds[name][:2]:
            _outcome(name, _written(place, name, content), True)
    watch, number = Watch(), first
    while True:
        chance = random.Random(f"{seed} {number}")
        name = names[number % len(names)]
        content = mutated(name, chance.choice(all_seeds[name]), chance)
        path = _written(place, name, content)
        _say(pipe, number, name, "begins")
        begin, outcome = time.process_time(), "?"
        try:
            with watch.within(len(content)):
                outcome = _outcome(name, path, name in SCENES and number // len(names) % 4 == 0)
        except TooMuchMemory as error:
            outcome = f"memory: {error}"
        if time.process_time() - begin > SECONDS:
            outcome = f"slow: {time.process_time() - begin:.1f} s; {outcome}"
        _say(pipe, number, name, outcome)
        number += 1


def _outcome(name: str, path: Path, whole: bool) -> str:
    try:
        read = check(name, path)
        return "rendered" if read and whole and check_use(name, path) else "read" if read else "refused"
    except MemoryError:
        return "memory: MemoryError"
    except Exception:
        return f"traceback: {traceback.format_exc()}"


def _written(place: Path, name: str, content: bytes) -> Path:
    path = place / f"input{suffix_of(name)}"
    path.write_bytes(content)
    return path


def _say(pipe: int, number: int, name: str, what: str) -> None:
    shown = what if len(what) <= MOST_SAID else f"{what[:20]} ... {what[-MOST_SAID:]}"
    os.write(pipe, json.dumps([number, name, shown]).encode() + b"\n")


def lines_of(pipe: int, until: float) -> Iterator[list[str] | None]:
    """Yield what a worker says, and None once if it says nothing for too long; end with its end, or at a time."""
    rest = b""
    while time.monotonic() < until:
        ready, _, _ = select.select([pipe], [], [], LONGEST)
        if not ready:
            yield None
            return
        data = os.read(pipe, 1 << 16)
        if not data:
            return
        *lines, rest = (rest + data).split(b"\n")
        yield from (json.loads(line) for line in lines)


def watch_one(names: list[str], seed: int, first: int, until: float, kept: Path, counts: Counter[str]) -> int:
    """Watch one worker until it ends or has to be ended; return the number of the input that comes next."""
    seen = Counter[str]()
    with tempfile.TemporaryDirectory(dir="/dev/shm") as folder:
        reading, writing = os.pipe()
        child = os.fork()
        if child == 0:
            os.close(reading)  # or a worker would never hear that nobody listens any more
            try:
                work(names, seed, first, writing, Path(folder))
            finally:
                os._exit(1)
        os.close(writing)
        number, name, open_since, told = first, names[0], False, time.monotonic()
        hung = False
        for line in lines_of(reading, until):
            if line is None:
                hung = True
                break
            number, name, what = int(line[0]), line[1], line[2]
            open_since = what == "begins"
            if open_since:
                continue
            kind = what.split(":")[0]
            counts[f"{name} {kind}"] += 1
            cause = f"{name} {kind} {what.rstrip().rpartition('File ')[2]}"
            seen[cause] += kind in ("traceback", "memory", "slow")
            if 0 < seen[cause] <= MOST_ALIKE:
                _keep(kept, Path(folder), seed, number, name, what, all_of=names)
            if time.monotonic() - told > 60.0:
                told = time.monotonic()
                print(dict(sorted(counts.items())), flush=True)
        finished = time.monotonic() >= until
        os.kill(child, signal.SIGKILL)
        _, status = os.waitpid(child, 0)
        os.close(reading)
        if open_since and not finished:
            what = f"hang: over {LONGEST:g} s" if hung else f"abort: status {status}"
            counts[f"{name} {what.split(':')[0]}"] += 1
            _keep(kept, Path(folder), seed, number, name, what, all_of=names)
        return number + 1


def _keep(kept: Path, folder: Path, seed: int, number: int, name: str, what: str, all_of: list[str]) -> None:
    """Make an input again, and write it with what it did."""
    chance = random.Random(f"{seed} {number}")
    assert all_of[number % len(all_of)] == name
    content = mutated(name, chance.choice(seeds(name)), chance)
    stem = f"{what.split(':')[0]}-{name}-{seed}-{number}"
    (kept / f"{stem}{suffix_of(name)}").write_bytes(content)
    (kept / f"{stem}.txt").write_text(what)


def main() -> None:
    folder, seconds, *rest = sys.argv[1:]
    kept = Path(folder)
    kept.mkdir(parents=True, exist_ok=True)
    seed = int(rest[0]) if rest else 0
    names = rest[1:] or list(SUBJECTS)
    until = time.monotonic() + float(seconds)
    counts: Counter[str] = Counter()
    number = 0
    while time.monotonic() < until:
        number = watch_one(names, seed, number, until, kept, counts)
    for line, count in sorted(counts.items()):
        print(f"{line}: {count}")
    print(f"all: {sum(counts.values())}")


if __name__ == "__main__":
    main()
