"""Tests of peers (other renderers) before timing: whether a peer and equaltime have the same expected image.

If the expected images differ, the peer's error against equaltime's reference never falls below the difference. The
noise of such a peer is measured against its `own_reference`. Summaries leave out the errors that the difference would
spoil (`equaltime.experiments.analysis.disagreement`).
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from equaltime.experiments.model.experiment import ReferenceWish
from equaltime.experiments.model.plan import PeerTimes
from equaltime.experiments.peers.common import with_box_filter
from equaltime.experiments.peers.mitsuba import MitsubaPeer
from equaltime.experiments.run import reference as references
from equaltime.experiments.run.folder import ExperimentFolder
from equaltime.experiments.run.reference import KnownReference
from equaltime.images.image_files import SOFTWARE
from equaltime.images.metrics import Reference
from equaltime.images.mitsuba_reference import CAVEAT
from equaltime.rendering.budget import Limits
from equaltime.rendering.core_subject import Subject
from equaltime.rendering.job import Job
from equaltime.rendering.result import uninterrupted
from equaltime.rendering.session import Session
from equaltime.scene import Scene
from equaltime.statistics.agreement import LEVEL, Agreement, BlockMeans, compare, share
from equaltime.statistics.in_words import probability
from equaltime.strategy import Strategy

__all__ = ["LEVEL", "SEEDS", "Gate", "check", "measured_times", "own_reference", "pass_gates", "resizable", "untested"]

SEEDS = 64
"""Number of renders with independent seeds that each renderer makes for the test of equal expected images."""
_SIDE, _BLOCK = 48, 4
_SPP, _OUR_SPP = 16, 32
_FIRST_SEED, _FIRST_REFERENCE_SEED = 2**30, 2**30 + 2**29
_FEWEST, _WANTED = 8, 32


@dataclass(frozen=True, eq=False)
class Gate:
    """Outcome of the test whether a peer (another renderer) and equaltime have the same expected image of one scene."""

    agreement: Agreement
    ours: BlockMeans
    """Means of equaltime's renders over blocks of pixels, which the tests of further renderers at this size can reuse.
    """
    level: float
    """False-alarm rate of the test."""
    size: tuple[int, int]
    """Width and height of the compared images, in pixels."""
    seeds: int
    reference_note: str = ""
    """Known limit of a reference that the other renderer makes, as a sentence; empty if there is none."""

    @property
    def agrees(self) -> bool:
        """Whether the test finds no difference between the expected images: its p-value is above ``level``."""
        return bool(self.agreement.p > self.level)

    @property
    def note(self) -> str:
        """Sentence for reports: how the other renderer's images differ, and which reference is used.

        It is empty if the expected images agree.
        """
        if self.agrees:
            return ""
        width, height = self.size
        return (
            f"its image is not that of equaltime ({probability(self.agreement.p)}, level {self.level:.1g}; "
            f"{self.seeds} renders each of {width}x{height} pixels): its noise is measured against a reference of its "
            "own" + (f"; {self.reference_note}" if self.reference_note else "")
        )


def pass_gates(
    peers: Sequence[Subject],
    name: str,
    scene: Scene,
    wish: ReferenceWish,
    folder: ExperimentFolder,
    threads: int,
    gates: int,
    report: Callable[[Subject, float], object] = lambda peer, share: None,
    report_reference: Callable[[Subject, float], object] = lambda peer, share: None,
) -> None:
    """Test, before runs, whether each peer (another renderer) has the same expected image as equaltime of a scene.

    For each peer that differs, a reference rendered by the peer is written to ``folder``. The outcomes go to the
    provenance file, under ``agreements``, scene and label. Peers with a recorded outcome are skipped.

    Parameters
    ----------
    peers
        The other renderers, prepared for the scene.
    name
        Name of the scene.
    wish
        Wanted error and longest time of a reference that a peer renders.
    gates
        Number of such tests on all scenes of the experiment; all tests share one false-alarm rate.
    report, report_reference
        Called with a peer and the completed share, in [0, 1], of its test or of its own reference.
    """
    known: Mapping[str, Any] = folder.read_provenance().get("agreements", {}).get(name, {})
    ours: dict[bool, BlockMeans] = {}
    for peer in untested(peers, name, folder):
        told = partial(report, peer)
        gate = check(peer, scene, threads, share(LEVEL, gates), progress=told, ours=ours.get(resizable(peer)))
        ours[resizable(peer)] = gate.ours
        if not gate.agrees:
            told = partial(report_reference, peer)
            own = own_reference(peer, scene, wish.error, wish.seconds, threads, progress=told)
            references.write(folder.reference(name, peer.label), own)
        facts = {"agrees": gate.agrees, "p": gate.agreement.p, "level": gate.level, "seeds": gate.seeds}
        known = {**known, peer.label: {**facts, "note": gate.note, "size": list(gate.size)}}
        folder.note("agreements", name, known)


def untested(peers: Sequence[Subject], name: str, folder: ExperimentFolder) -> list[Subject]:
    """Return the peers (other renderers) whose expected image of the scene ``name`` is not yet tested in ``folder``."""
    known = folder.read_provenance().get("agreements", {}).get(name, {})
    return [peer for peer in peers if peer.label not in known]


def measured_times(
    peers: Sequence[Subject], name: str, scene: Scene, folder: ExperimentFolder, threads: int
) -> PeerTimes:
    """Return the times of peers (other renderers) on one scene, to predict the time of an experiment.

    Each peer and equaltime render once, at the size of the tests for equal expected images. Prepare the peers again
    before they render ``scene``.
    """
    ahead, tests, renders = untested(peers, name, folder), 0.0, 0.0
    ours: set[bool] = set()
    for peer in peers:
        small = _compared(peer, scene)
        peer.prepare(small, threads)
        begin = time.perf_counter()
        _one(peer, _FIRST_SEED, _SPP)
        took = time.perf_counter() - begin
        renders += took
        if peer not in ahead:
            continue
        tests += SEEDS * took
        if resizable(peer) not in ours:  # equaltime's renders of one size serve for all peers
            ours.add(resizable(peer))
            begin = time.perf_counter()
            _our_image(small, 0, threads)
            tests += SEEDS * (time.perf_counter() - begin)
    return PeerTimes(tests, renders)


def check(
    peer: Subject,
    scene: Scene,
    threads: int = 0,
    level: float = LEVEL,
    seeds: int = SEEDS,
    progress: Callable[[float], object] | None = None,
    ours: BlockMeans | None = None,
) -> Gate:
    """Test whether a peer (another renderer) and equaltime have the same expected image of a scene.

    Both renderers render a small, box-filtered version of ``scene`` with many seeds. If the peer has a fixed image
    size, both render at the scene's size. Prepare the peer again before it renders ``scene``.

    Parameters
    ----------
    level
        False-alarm rate of the test. `equaltime.statistics.agreement.share` splits a common rate over several tests.
    seeds
        Number of independent renders by each renderer.
    progress
        Called with the completed share of the work, in [0, 1].
    ours
        Means of equaltime's renders over blocks of pixels, if known from the test of another peer on the same scene at
        the same size.

    Raises
    ------
    PeerError
        If the peer cannot render the scene.
    """
    small = _compared(peer, scene)
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
    """Tell whether a peer (another renderer) can render images of any size, rather than of one fixed size."""
    return bool(getattr(peer, "resizable", True))


def own_reference(
    peer: Subject,
    scene: Scene,
    error: float,
    seconds: float,
    threads: int = 0,
    first_seed: int = _FIRST_REFERENCE_SEED,
    progress: Callable[[float], object] = lambda share: None,
) -> KnownReference:
    """Return a reference rendered by the peer (another renderer): the mean of independent renders.

    The spread of the renders gives the noise of the mean. Rendering ends at the relative ``error`` or after
    ``seconds``, but not before eight renders. Their seeds begin at ``first_seed``. The two halves of the reference are
    the odd and the even renders. If the peer's sampler is biased, a copy of the peer with an unbiased sampler renders.
    ``progress`` is called with the completed share of the work, in [0, 1].
    """
    with _fit(peer) as renderer:
        return _own_reference(renderer, scene, error, seconds, threads, first_seed, progress)


@contextmanager
def _fit(peer: Subject) -> Iterator[Subject]:
    """Yield the subject that renders references for a peer; close it at the end unless it is the peer."""
    other = peer.for_reference() if isinstance(peer, MitsubaPeer) else peer
    try:
        yield other
    finally:
        if isinstance(other, MitsubaPeer) and other is not peer:
            other.close()


def _own_reference(
    peer: Subject,
    scene: Scene,
    error: float,
    seconds: float,
    threads: int,
    first_seed: int,
    progress: Callable[[float], object],
) -> KnownReference:
    peer.prepare(scene, threads)
    spp = _spp_of_parts(peer, seconds, first_seed)
    sums: list[NDArray[np.float64] | float] = [0.0, 0.0]
    squares: NDArray[np.float64] | float = 0.0
    begin, count, origin = time.perf_counter(), 0, None
    progress(0.0)
    while True:
        image = _one(peer, first_seed + 1 + count, spp).astype(np.float64)
        origin = image if origin is None else origin  # subtracted to keep small differences in the squares
        sums[count % 2] += image - origin
        squares += np.square(image - origin)
        count += 1
        passed = time.perf_counter() - begin
        progress(min(1.0, passed / seconds))
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
    """Return a power of four (no sampler rounds it) for which about 32 renders fill the time."""
    (checkpoint,) = peer.run(seed, (_SPP,), None)
    affordable = checkpoint.spp * seconds / _WANTED / max(checkpoint.wall_s, 1e-3)
    return int(4 ** min(max(math.floor(math.log(max(affordable, 1.0), 4)), 1), 8))


def _compared(peer: Subject, scene: Scene) -> Scene:
    """Return the scene as a test renders it: small if the peer can render any size, and with a box filter."""
    return _small(scene) if resizable(peer) else with_box_filter(scene)


def _small(scene: Scene) -> Scene:
    """Return the scene with its whole film scaled to a longest side of at most 48 pixels, and a box filter."""
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
