"""The renderers that run the hard cases: equaltime's core, and Mitsuba 3 for comparison.

Mitsuba's images must have the same means, but not the same bits.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from time import perf_counter
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from equaltime.errors import EqualtimeError, PeerError
from equaltime.experiments.peers.mitsuba import MitsubaPeer
from equaltime.hardcases.cases import CASES, Case, load_case
from equaltime.hardcases.judge import Outcome, broken, judge_bits, judge_same, judge_value, limit_of
from equaltime.hardcases.units import in_units
from equaltime.rendering.budget import Limits
from equaltime.rendering.job import Job
from equaltime.rendering.result import uninterrupted
from equaltime.rendering.session import Session
from equaltime.scene import Scene
from equaltime.strategy import Strategy

__all__ = ["MitsubaSubject", "OurSubject", "PeerName"]

Image = NDArray[np.float32]
PeerName = Literal["mitsuba"]
_FIRST_SEED = 1


class OurSubject:
    """Equaltime's core as a renderer of hard cases, whose images are compared with known ones.

    A case names the strategy that renders it.
    """

    def __init__(self, threads: int = 0) -> None:
        self._threads = threads

    def outcome(self, case: Case) -> Outcome:
        """Render a case, and return how its image compares with the known image.

        An error while rendering gives a failed outcome.
        """
        return _timed(case, self._judged)

    def _judged(self, case: Case) -> Outcome:
        scene = load_case(case)
        if case.expected is None:
            return judge_bits(self._image(scene, case, 0), self._changed(scene, case))
        images = [self._image(scene, case, seed) for seed in range(case.seeds)]
        return judge_value(images, case.expected, limit_of(len(CASES)))

    def _image(self, scene: Scene, case: Case, seed: int, threads: int | None = None) -> Image:
        threads = self._threads if threads is None else threads
        job = Job(
            scene=scene,
            strategy=Strategy.of(case.strategy),
            limits=Limits(case.spp),
            seed=_FIRST_SEED + seed,
            threads=threads,
        )
        return uninterrupted(Session(job).run()).image

    def _changed(self, scene: Scene, case: Case) -> Image:
        """Render the changed scene, and undo the change of brightness: the image must be the same."""
        if case.threads:
            return self._image(scene, case, 0, case.threads)
        if case.crop is not None:
            return self._pasted(scene, case)
        other = in_units(scene, 2.0**case.length, 2.0**case.light)
        return np.ldexp(self._image(other, case, 0), -case.light)

    def _pasted(self, scene: Scene, case: Case) -> Image:
        """Return the whole image, with the crop window replaced by a separate render."""
        assert case.crop is not None
        x, y, width, height = case.crop
        whole = self._image(scene, case, 0).copy()
        whole[y : y + height, x : x + width] = self._image(scene.with_(crop=case.crop), case, 0)
        return whole


class MitsubaSubject:
    """Mitsuba 3 as a renderer of hard cases, in its scalar variant, which needs no compilation per scene.

    Mitsuba's images are compared with the known images, as equaltime's are. A reference rendered by Mitsuba would be no
    better than 0.2 %: see `equaltime.images.mitsuba_reference`.
    """

    def __init__(self, threads: int = 0) -> None:
        self._peer = MitsubaPeer("selftest", variant="scalar_rgb")
        self._threads = threads

    def start(self) -> str:
        """Start Mitsuba and return its name and version; raises PeerError if Mitsuba is not installed."""
        self._peer.prepare(load_case(CASES[0]), self._threads)
        return f"Mitsuba {self._peer.version}"

    def close(self) -> None:
        """End Mitsuba's process."""
        self._peer.close()

    def outcome(self, case: Case) -> Outcome:
        """Render a case, and return how its image compares with the known image.

        An error while rendering gives a failed outcome.
        """
        return _timed(case, self._judged)

    def _judged(self, case: Case) -> Outcome:
        scene, limit = load_case(case), limit_of(len(CASES))
        images = self._images(scene, case)
        if case.expected is not None:
            return judge_value(images, case.expected, limit)
        other = self._images(in_units(scene, 2.0**case.length, 2.0**case.light), case)
        return judge_same(images, [np.ldexp(image, -case.light) for image in other], limit)

    def _images(self, scene: Scene, case: Case) -> list[Image]:
        self._peer.prepare(scene, self._threads)
        return [
            next(self._peer.run(_FIRST_SEED + seed, (case.peer_spp or case.spp,))).image for seed in range(case.seeds)
        ]


def _timed(case: Case, judged: Callable[[Case], Outcome]) -> Outcome:
    begin = perf_counter()
    try:
        outcome = judged(case)
    except (EqualtimeError, PeerError) as error:
        outcome = broken(case.expected, str(error).splitlines()[0])
    return dataclasses.replace(outcome, seconds=perf_counter() - begin)
