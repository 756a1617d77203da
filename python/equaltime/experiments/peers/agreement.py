"""Tests whether a peer means the same image as equaltime, before the two are compared in time.

Against equaltime's reference, the error of a peer that means another image would end at the difference. Such a peer is
measured against `own_reference`, and reports show the note.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from equaltime.experiments.peers.common import with_box_filter
from equaltime.experiments.peers.mitsuba import MitsubaPeer
from equaltime.experiments.run.reference import KnownReference
from equaltime.images.image_files import SOFTWARE
from equaltime.images.metrics import Reference
from equaltime.images.mitsuba_reference import CAVEAT
from equaltime.rendering.budget import Limits
from equaltime.rendering.job import Job
from equaltime.rendering.result import uninterrupted
from equaltime.rendering.session import Session
from equaltime.rendering.subject import Subject
from equaltime.scene import Scene
from equaltime.statistics.agreement import LEVEL, Agreement, BlockMeans, compare
from equaltime.strategy import Strategy

__all__ = ["LEVEL", "SEEDS", "Gate", "check", "own_reference", "resizable"]

SEEDS = 64
"""Independent renders of either side: what the test of agreement asks for."""
_SIDE, _BLOCK = 48, 4
_SPP, _OUR_SPP = 16, 32
_FIRST_SEED, _FIRST_REFERENCE_SEED = 2**30, 2**30 + 2**29
_FEWEST, _WANTED = 8, 32


@dataclass(frozen=True, eq=False)
class Gate:
    """The outcome of comparing a peer with equaltime on one scene."""

    agreement: Agreement
    ours: BlockMeans
    """Equaltime's side, which serves for every peer that is compared at this size."""
    level: float
    """The rate at which peers that agree fail."""
    size: tuple[int, int]
    """Width and height of the images that were compared."""
    seeds: int
    reference_note: str = ""
    """Caveat on a reference that the peer renders; an empty string if there is none."""

    @property
    def agrees(self) -> bool:
        """Whether the test does not reject equal expected images."""
        return bool(self.agreement.p > self.level)

    @property
    def note(self) -> str:
        """A sentence for reports; empty if the peer agrees."""
        if self.agrees:
            return ""
        width, height = self.size
        return (
            f"its image is not that of equaltime (p = {self.agreement.p:.1g}, level {self.level:.1g}; {self.seeds} "
            f"renders each of {width}x{height} pixels): it is measured against a reference of its own"
            + (f"; {self.reference_note}" if self.reference_note else "")
        )


def check(
    peer: Subject,
    scene: Scene,
    threads: int = 0,
    level: float = LEVEL,
    seeds: int = SEEDS,
    progress: Callable[[float], object] | None = None,
    ours: BlockMeans | None = None,
) -> Gate:
    """Render a small version of ``scene`` with both, box-filtered and with many seeds, and compare.

    A peer that cannot be told a size (``resizable`` is false) is compared at the scene's. The peer is left prepared for
    the small scene.

    Parameters
    ----------
    level
        The false-alarm rate. For many peers and scenes the one of all is kept by
        `equaltime.statistics.agreement.share`.
    progress
        Called with the share of the work that is done, 0 … 1.
    ours
        Equaltime's side, if it is known from the gate of another peer on the same scene, as resizable as this one.

    Raises
    ------
    PeerError
        If the peer cannot render the scene.
    """
    small = _small(scene) if resizable(peer) else with_box_filter(scene)
    peer.prepare(small, threads)
    renders = seeds if ours is not None else 2 * seeds

    def means(images: Iterator[NDArray[np.float32]], before: int) -> BlockMeans:
        return BlockMeans.of_seeds(told(images, before), _BLOCK)

    def told(images: Iterator[NDArray[np.float32]], before: int) -> Iterator[NDArray[np.float32]]:
        for number, image in enumerate(images, before + 1):
            if progress is not None:
                progress(number / renders)
            yield image

    theirs = means((_one(peer, _FIRST_SEED + seed, _SPP) for seed in range(seeds)), 0)
    if ours is None:
        ours = means((_our_image(small, seed, threads) for seed in range(seeds)), seeds)
    _, _, width, height = small.model.sensor.film.crop
    note = str(getattr(peer, "reference_note", ""))
    return Gate(compare(theirs, ours), ours, level, (width, height), seeds, note)


def resizable(peer: Subject) -> bool:
    """Tell whether a peer can be told the size of its image."""
    return bool(getattr(peer, "resizable", True))


def own_reference(
    peer: Subject, scene: Scene, error: float, seconds: float, threads: int = 0, first_seed: int = _FIRST_REFERENCE_SEED
) -> KnownReference:
    """Render a reference with the peer itself: the mean of independent renders, its noise known from their spread.

    It ends when its own relative error is ``error``, or the ``seconds`` of rendering are used up, with eight renders at
    least. The halves are the odd and the even renders. If the peer's sampler is biased, another peer renders, in which
    the sampler alone is different.
    """
    with _fit(peer) as renderer:
        return _own_reference(renderer, scene, error, seconds, threads, first_seed)


@contextmanager
def _fit(peer: Subject) -> Iterator[Subject]:
    """Yield the subject that renders references for a peer; one that is not the peer is closed at the end."""
    other = peer.for_reference() if isinstance(peer, MitsubaPeer) else peer
    try:
        yield other
    finally:
        if isinstance(other, MitsubaPeer) and other is not peer:
            other.close()


def _own_reference(
    peer: Subject, scene: Scene, error: float, seconds: float, threads: int, first_seed: int
) -> KnownReference:
    peer.prepare(scene, threads)
    spp = _spp_of_parts(peer, seconds, first_seed)
    sums: list[NDArray[np.float64] | float] = [0.0, 0.0]
    squares: NDArray[np.float64] | float = 0.0
    begin, count, origin = time.perf_counter(), 0, None
    while True:
        image = _one(peer, first_seed + 1 + count, spp).astype(np.float64)
        origin = image if origin is None else origin  # so that the squares keep small differences
        sums[count % 2] += image - origin
        squares += np.square(image - origin)
        count += 1
        passed = time.perf_counter() - begin
        if count % 2 == 0 and count >= _FEWEST:
            reference = _joined(origin, sums, squares, count)
            found = math.sqrt(max(reference.relmse, 0.0))
            if found <= error or passed >= seconds:
                break
    facts = {
        "software": SOFTWARE,
        "strategy": peer.name,
        "spp": count * spp,
        "renders": count,
        "error": found,
        "error_wanted": error,
        "seconds": passed,
        "seconds_allowed": seconds,
    } | ({"caveat": CAVEAT} if peer.renderer == "mitsuba" else {})
    return KnownReference(reference, facts)


def _joined(
    origin: NDArray[np.float64],
    sums: list[NDArray[np.float64] | float],
    squares: NDArray[np.float64] | float,
    count: int,
) -> Reference:
    first, second = (origin + part / (count // 2) for part in sums)
    mean = 0.5 * (first + second)
    deviations = np.maximum(squares - count * np.square(mean - origin), 0.0)
    return Reference(mean, deviations / (count - 1.0) / count, (first, second))


def _spp_of_parts(peer: Subject, seconds: float, seed: int) -> int:
    """Return a power of four, which no sampler rounds, for which some thirty renders use up the time."""
    (checkpoint,) = peer.run(seed, (_SPP,), None)
    affordable = checkpoint.spp * seconds / _WANTED / max(checkpoint.wall_s, 1e-3)
    return int(4 ** min(max(math.floor(math.log(max(affordable, 1.0), 4)), 1), 8))


def _small(scene: Scene) -> Scene:
    """Return the whole film of the scene in the same shape, with a longest side of 48 pixels, and a box filter."""
    width, height = scene.size
    scale = min(1.0, _SIDE / max(width, height))
    size = (max(round(width * scale), _BLOCK), max(round(height * scale), _BLOCK))
    return with_box_filter(scene.with_(size=size))


def _our_image(scene: Scene, seed: int, threads: int) -> NDArray[np.float32]:
    job = Job(scene=scene, strategy=Strategy(), limits=Limits(_OUR_SPP), seed=seed, threads=threads)
    return uninterrupted(Session(job).run()).image


def _one(peer: Subject, seed: int, spp: int) -> NDArray[np.float32]:
    (checkpoint,) = peer.run(seed, (spp,), None)
    return checkpoint.image
