"""What fuzzing has found, and what it begins with: each file is read or refused, in little time and memory."""

from __future__ import annotations

import random
import time
from pathlib import Path
from typing import Final

import pytest

from .memory import TooMuchMemory, Watch
from .mutators import mutated
from .subjects import MEMORY, SECONDS, SUBJECTS, check, limit_of, suffix_of

CORPUS: Final = Path(__file__).parent / "corpus"
FILES: Final = sorted(path for path in CORPUS.rglob("*") if path.is_file())


def test_every_reader_has_a_corpus() -> None:
    assert {path.name for path in CORPUS.iterdir()} == set(SUBJECTS)


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(CORPUS)))
def test_a_file_is_read_or_refused(path: Path) -> None:
    begin = time.process_time()
    with Watch().within(path.stat().st_size):
        check(path.parent.name, path)
    assert time.process_time() - begin < SECONDS


@pytest.mark.parametrize("name", SUBJECTS)
def test_mutants_are_made_again_from_their_seed_and_are_read_or_refused(tmp_path: Path, name: str) -> None:
    path = tmp_path / f"input{suffix_of(name)}"
    changed = 0
    for content in (file.read_bytes() for file in sorted((CORPUS / name).iterdir())[:2]):
        for seed in range(8):
            mutant = mutated(name, content, random.Random(seed))
            assert mutated(name, content, random.Random(seed)) == mutant
            changed += mutant != content
            path.write_bytes(mutant)
            check(name, path)
    assert changed > 0


@pytest.mark.parametrize("name", SUBJECTS)
def test_of_every_corpus_a_file_is_read(name: str) -> None:
    """The twin: where all were refused, nothing would be tested."""
    assert any(check(name, path) for path in (CORPUS / name).iterdir())


def test_too_much_memory_is_seen() -> None:
    """The twin."""
    held = bytearray()
    with pytest.raises(TooMuchMemory), Watch().within(100):
        held += b"\1" * (limit_of(100) + (8 << 20))
    assert len(held) > MEMORY
