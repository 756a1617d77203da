"""Films of how an image converges: pictures from one run of a strategy, at moments chosen for viewing.

The points of an error curve are spaced geometrically: late in a run, much time would pass without a new picture.
Pictures therefore come from a separate run, and are closer together at the beginning, where the image changes most.
This run lasts as long as the budget, and its times are not recorded.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from equaltime.experiments.model.experiment import Experiment
from equaltime.experiments.model.reader import film_seed
from equaltime.experiments.run.folder import ExperimentFolder, read_arrays, replacing
from equaltime.experiments.run.record import Key, Row
from equaltime.images.metrics import Reference, measure
from equaltime.images.preview import reduced
from equaltime.rendering.core_subject import Subject
from equaltime.scene import Scene

__all__ = ["Film", "Studio", "moments", "read_film"]

FRAMES = 48
"""Largest number of pictures in a film of a converging image; picture k is due when (k / FRAMES)² of the time has
passed."""
_LONGEST = 256
_MOST = 60000.0


@dataclass(frozen=True, eq=False)
class Film:
    """Film (animation) of one run that shows how its image converges: K frames in order of rendering time."""

    frames: NDArray[np.float16]
    """(K, H, W, 3): linear RGB; large images are averaged over blocks of pixels."""
    spp: NDArray[np.int64]
    """(K,): samples per pixel in each frame."""
    seconds: NDArray[np.float64]
    """(K,): rendering time of each frame, in seconds since the first sample."""
    error: NDArray[np.float64]
    """(K,): measured relative error; NaN if the reference's noise exceeds it."""


@dataclass(frozen=True, eq=False)
class Studio:
    """Renderer of an experiment's films, which show how images converge; used after the runs."""

    experiment: Experiment
    scenes: Sequence[Scene]
    folder: ExperimentFolder
    rows: Sequence[Row]
    """Records, which give the speed of each strategy."""
    references: Sequence[Reference]
    """References of the scenes, in order."""
    threads: int

    def wants(self, key: Key) -> bool:
        """Tell whether to render a film now: the run ``key`` is recorded, but the film of its strategy is missing."""
        return self._ended(key) is not None and not self.folder.film(*key[:2]).exists()

    def shoot(self, key: Key, number: int, subject: Subject) -> None:
        """Render the film of the scene and strategy in ``key``, and write the film to the folder.

        ``key`` holds scene name, strategy label and repeat. ``number`` is the scene's index, and ``subject`` the
        renderer.
        """
        ended = self._ended(key)
        assert ended is not None, "ask first what is wanted"
        seconds = self.experiment.budget or ended.wall_s
        counts = moments(seconds * ended.spp / max(ended.wall_s, 1e-9))
        subject.prepare(self.scenes[number], self.threads)
        film = _film(subject, film_seed(*key[:2]), counts, seconds, self.references[number])
        with replacing(self.folder.film(*key[:2])) as file:
            np.savez_compressed(file, frames=film.frames, spp=film.spp, seconds=film.seconds, error=film.error)

    def _ended(self, key: Key) -> Row | None:
        return next((row for row in self.rows if row.key == key and row.last), None)


def moments(samples: float) -> tuple[int, ...]:
    """Return the samples per pixel at each frame of a film, the animation that shows an image converge.

    The counts ascend. The last one is near ``samples``, the count per pixel that a run of the strategy reaches. Counts
    are even, so that the two halves of a pixel's samples are of equal size.
    """
    wanted = (2 * round(0.5 * samples * (k / FRAMES) ** 2) for k in range(1, FRAMES + 1))
    return tuple(sorted({max(2, count) for count in wanted}))


def read_film(path: Path) -> Film:
    """Read the film of a converging image from its ``.npz`` file; raises `ImageError` if the file cannot be read."""
    return Film(*read_arrays(path, ("frames", "spp", "seconds", "error")))


def _film(subject: Subject, seed: int, counts: Sequence[int], seconds: float, known: Reference) -> Film:
    frames, spp, times, errors = [], [], [], []
    for checkpoint in subject.run(seed, counts, seconds):
        frames.append(_small(checkpoint.image))
        spp.append(checkpoint.spp)
        times.append(checkpoint.wall_s)
        relmse = measure(checkpoint.image, known, ("relmse",))["relmse"].value
        errors.append(np.sqrt(relmse) if relmse > 0.0 else np.nan)
    return Film(np.array(frames, np.float16), np.array(spp), np.array(times), np.array(errors))


def _small(image: NDArray[np.float32]) -> NDArray[np.float16]:
    """Return an image reduced to at most 256 pixels a side and clipped to the range of float16."""
    return np.clip(reduced(image, _LONGEST), -_MOST, _MOST).astype(np.float16)
