"""Identities of experiments: an experiment continues a folder's records only if both have the same identity."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from equaltime.errors import ExperimentError, Problem
from equaltime.experiments.model.experiment import Experiment
from equaltime.rendering.subject import Subject
from equaltime.scene import Scene

__all__ = ["film_seed", "identity_of", "run_seeds"]


def identity_of(
    experiment: Experiment, scenes: Sequence[Scene], subjects: Sequence[Subject], threads: int
) -> dict[str, Any]:
    """Return, as JSON data, every setting that affects a record.

    Titles, targets, crops, the baseline and the number of repeats are left out: they may change between calls.
    """
    wish = experiment.reference
    return {
        "scenes": {
            entry.name: {
                "digest": scene.digest,
                "size": list(scene.size),
                "crop": list(scene.model.sensor.film.crop),
                "max_depth": scene.max_depth,
            }
            for entry, scene in zip(experiment.scenes, scenes, strict=True)
        },
        "strategies": {subject.label: {"renderer": subject.renderer, "name": subject.name} for subject in subjects},
        "budget": experiment.budget,
        "spp": None if experiment.spp is None else list(experiment.spp),
        "reference": {
            "error": wish.error,
            "seconds": wish.seconds,
            "file": None if wish.file is None else _sha256(wish.file),
        },
        "threads": threads,
    }


def run_seeds(scene: str, strategy: str, repeats: int) -> tuple[int, ...]:
    """Return the seeds of a strategy's repeats on a scene: distinct 31-bit numbers, which every renderer accepts.

    Seeds are hashes of names, so that adding strategies or repeats does not change them. A repeat whose hash is already
    taken is hashed again.
    """
    seeds: dict[int, None] = {}
    for repeat in range(repeats):
        seed, again = _hashed(scene, strategy, str(repeat)), 0
        while seed in seeds:
            again += 1
            seed = _hashed(scene, strategy, str(repeat), str(again))
        seeds[seed] = None
    return tuple(seeds)


def film_seed(scene: str, strategy: str) -> int:
    """Return the seed of the run from which a strategy's film is made."""
    return _hashed(scene, strategy, "-1")


def _hashed(*words: str) -> int:
    """Return a 31-bit hash of words."""
    text = "\0".join(("equaltime cost", *words))
    return int.from_bytes(hashlib.sha256(text.encode()).digest()[:4], "big") >> 1


def _sha256(path: Path) -> str:
    try:
        return hashlib.sha256(path.read_bytes()).hexdigest()
    except OSError as error:
        text = f"{path}: cannot be read: {error.strerror or error}"
        raise ExperimentError((Problem("reference.file", text),)) from error
