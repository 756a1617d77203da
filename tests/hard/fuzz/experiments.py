"""A small experiment whose folder has one file of fuzz: it is refused, or left out and told of."""

from __future__ import annotations

import atexit
import shutil
import tempfile
from dataclasses import fields
from functools import cache
from pathlib import Path
from typing import Any, Final

import numpy as np

from equaltime.experiments.analysis.summarise import summarise
from equaltime.experiments.model.experiment import Experiment
from equaltime.experiments.report.pictures import load_pictures
from equaltime.experiments.run.folder import ExperimentFolder
from equaltime.experiments.run.record import Recorder, Row, load
from equaltime.experiments.run.reference import KnownReference, write
from equaltime.images.metrics import Reference

__all__ = ["SHAPE", "read_image_of", "read_provenance_of", "read_records_of", "read_reference_of", "rows"]

SHAPE: Final = (3, 4, 3)
_LABELS: Final = ("naive", "best")
_REPEATS: Final = 3
_SPP: Final = (2, 4)


def rows() -> tuple[Row, ...]:
    """Return what the records of the experiment say."""
    made = []
    for label in _LABELS:
        for repeat in range(_REPEATS):
            for checkpoint, spp in enumerate(_SPP):
                last = spp == _SPP[-1]
                image = f"images/box/{label}-r{repeat}.npy" if last else None
                values: dict[str, Any] = {field.name: 0 for field in fields(Row)} | {
                    **dict.fromkeys(("scene", "digest", "machine", "build", "started"), "box"),
                    **{"strategy": label, "name": label, "renderer": "core", "biased": False},
                    **dict.fromkeys(("doubt", "decided", "splitting")),
                    **{"width": SHAPE[1], "height": SHAPE[0], "crop": (0, 0, SHAPE[1], SHAPE[0]), "max_depth": 8},
                    **{"repeat": repeat, "seed": repeat, "checkpoint": checkpoint, "spp": spp, "wall_s": 0.1 * spp},
                    **{
                        "cpu_s": 0.1 * spp,
                        "threads": 1,
                        "relmse": 1.0 / spp,
                        "mse": 1.0 / spp,
                        "mare": 0.5,
                        "flip": None,
                    },
                    **{"last": last, "image": image},
                }
                made.append(Row(**values))
    return tuple(made)


@cache
def _folder() -> ExperimentFolder:
    """Return the folder as it should be."""
    folder = ExperimentFolder(Path(tempfile.mkdtemp(prefix="equaltime-fuzz-")))
    atexit.register(shutil.rmtree, folder.path, True)
    with Recorder(folder.records) as recorder:
        for row in rows():
            recorder.append(row)
            if row.image is not None:
                path = folder.path / row.image
                path.parent.mkdir(parents=True, exist_ok=True)
                np.save(path, np.full(SHAPE, 1.0 + 0.1 * row.repeat, np.float32))
    write(folder.reference("box"), KnownReference(Reference(np.ones(SHAPE), np.full(SHAPE, 1e-4)), {}))
    folder.note("references", "box", {"spp": 64})
    return folder


@cache
def _experiment() -> Experiment:
    scene = {"name": "box", "path": "box.toml"}
    return Experiment.model_validate({"scenes": [scene], "strategies": list(_LABELS), "targets": [0.1], "budget": 1.0})


def _read_with(path: Path, place: Path) -> object:
    """Conclude the experiment with a file in the place of its own."""
    kept = place.read_bytes()
    try:
        shutil.copyfile(path, place)
        found = summarise(_experiment(), load(_folder().records), _folder().path)
        return [load_pictures(scene) for scene in found.scenes]
    finally:
        place.write_bytes(kept)


def read_image_of(path: Path) -> object:
    """Read it as the image of a run."""
    return _read_with(path, _folder().image("box", "best", 1))


def read_records_of(path: Path) -> object:
    """Read it as the records, also as they are gone on with."""
    copied = _folder().path / "copied.csv"
    shutil.copyfile(path, copied)
    with Recorder(copied):
        pass
    return _read_with(path, _folder().records)


def read_reference_of(path: Path) -> object:
    """Read it as the reference."""
    return _read_with(path, _folder().reference("box"))


def read_provenance_of(path: Path) -> object:
    """Read it as what is known of machines and references."""
    return _read_with(path, _folder().provenance)
