"""Fuzz a reader, guided by coverage: python -m tests.hard.fuzz.fuzz_readers NAME FOLDER [libFuzzer options].

NAME is one of `subjects.SUBJECTS`; FOLDER keeps what was found worth keeping, and begins with tests/hard/fuzz/corpus.
An input that is neither read nor refused, or takes too much memory or time, ends the run and is kept. Needs the extra
``fuzz`` (atheris).
"""

from __future__ import annotations

import shutil
import sys
import tempfile
from pathlib import Path

import atheris

with atheris.instrument_imports(include=["equaltime", "pygltflib"], enable_loader_override=False):
    from tests.hard.fuzz.memory import Watch
    from tests.hard.fuzz.subjects import SECONDS, SUBJECTS, check, suffix_of

CORPUS = Path(__file__).parent / "corpus"


def main() -> None:
    name, folder, *options = sys.argv[1:]
    if name not in SUBJECTS:
        sys.exit(f"NAME is one of {', '.join(SUBJECTS)}, not {name}")
    kept = Path(folder)
    kept.mkdir(parents=True, exist_ok=True)
    for seed in (CORPUS / name).iterdir():
        shutil.copy(seed, kept)
    with tempfile.TemporaryDirectory(dir="/dev/shm") as place:
        path = Path(place) / f"input{suffix_of(name)}"
        watch = Watch()

        def one(content: bytes) -> None:
            path.write_bytes(content)
            with watch.within(len(content)):
                check(name, path)

        common = [f"-timeout={SECONDS}", f"-artifact_prefix={kept.parent}/{name}-", "-max_len=16384"]
        atheris.Setup([sys.argv[0], *common, *options, str(kept)], one)
        atheris.Fuzz()


if __name__ == "__main__":
    main()
