"""Mitsuba 3 as a renderer that takes part in an experiment."""

from __future__ import annotations

import contextlib
import dataclasses
import hashlib
import sys
import tempfile
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from equaltime.errors import PeerError
from equaltime.experiments.peers.common import checked_image, render_seed
from equaltime.experiments.peers.process import DEFAULT_LIMIT, SETUP_LIMIT, Worker
from equaltime.images.mitsuba_reference import CAVEAT, UNFIT_SAMPLERS, fit_sampler
from equaltime.rendering.core_subject import Point, RendererKind
from equaltime.scene import Scene
from equaltime.scene.export.plain import mitsuba_dict
from equaltime.strict_json import json_text

__all__ = ["MOST_IN_FLIGHT", "MitsubaPeer"]

MOST_IN_FLIGHT = 2**26
"""Largest number of samples in one pass of Mitsuba, which limits its memory. More samples take several passes of one
sequence."""
_TO_WARM_UP = 4


@dataclass
class MitsubaPeer:
    """Mitsuba 3 as a renderer that takes part in an experiment, in a separate process.

    Mitsuba gets the same scene as a Mitsuba dictionary, with a box filter and the scene's ``max_depth`` and
    ``rr_depth``. A checkpoint is the image and the time at a sample count. Mitsuba cannot continue an image: each
    checkpoint is a separate render with its own seed.

    A sampler may round the sample count. A checkpoint gives the count actually taken, and a count that rounds to the
    previous count is skipped. Importing, loading and compiling are set-up. A render that compiles kernels is repeated,
    and `compiling` adds up the seconds of such first renders.

    `equaltime.images.mitsuba_reference` describes the limits of a reference by Mitsuba. For one seed the image depends
    on Mitsuba's order of the lights, which differs from load to load.
    """

    label: str
    variant: str = "llvm_ad_rgb"
    integrator: str = "path"
    sampler: str = "independent"
    rr_depth: int | None = None
    """Depth from which Russian roulette may end a path; by default the scene's, which defaults to 5."""
    python: str = sys.executable
    """Python interpreter in which Mitsuba and equaltime are installed."""
    limit: float = DEFAULT_LIMIT
    """Longest time of one render, in seconds; a process that takes longer is ended.

    Starting, loading, and the first render, which compiles, each have at least `SETUP_LIMIT` seconds.
    """
    renderer: RendererKind = field(default="mitsuba", init=False)
    biased: bool = field(default=False, init=False)
    version: str = field(default="", init=False)
    """Version of Mitsuba; empty before it is started."""
    compiling: float = field(default=0.0, init=False)
    """Seconds spent, in all runs so far, on renders that were repeated because they compiled kernels."""
    _worker: Worker | None = field(default=None, init=False, repr=False)
    _threads: int = field(default=0, init=False, repr=False)
    _scene: Scene | None = field(default=None, init=False, repr=False)
    _key: str = field(default="", init=False, repr=False)
    _setup: dict[str, float] = field(default_factory=dict, init=False, repr=False)

    @property
    def name(self) -> str:
        """Name of this renderer in results: variant, integrator, sampler and, if given, roulette depth."""
        roulette = "" if self.rr_depth is None else f",rr_depth={self.rr_depth}"
        return f"mitsuba,variant={self.variant},integrator={self.integrator},sampler={self.sampler}{roulette}"

    @property
    def reference_note(self) -> str:
        """Sentence for reports on the known limits of a reference that Mitsuba renders, and on its sampler."""
        if self.sampler not in UNFIT_SAMPLERS:
            return CAVEAT
        another = f"with the sampler {fit_sampler(self.sampler)}, because {self.sampler} is no reference"
        return f"that one is rendered {another}: {UNFIT_SAMPLERS[self.sampler]}; {CAVEAT}"

    def for_reference(self) -> MitsubaPeer:
        """Return the renderer for references: this one, or a copy with another sampler if its sampler is biased."""
        fit = fit_sampler(self.sampler)
        return self if fit == self.sampler else dataclasses.replace(self, sampler=fit)

    def prepare(self, scene: Scene, threads: int) -> float:
        """Start Mitsuba if necessary, load ``scene`` and compile; return the seconds that this takes.

        For a scene that is loaded already, returns the seconds that its first loading took.

        Raises PeerError if Mitsuba or LLVM is missing, or Mitsuba cannot use the scene, integrator or sampler.
        """
        starting = self._start(threads)
        try:
            plain, integrator = mitsuba_dict(scene.model, scene.assets), self._integrator(scene)
        except ValueError as error:
            raise PeerError(f"{self.label}: {error}") from error
        plain["sensor"]["film"]["rfilter"] = {"type": "box"}
        text = json_text([plain, integrator])
        self._scene, self._key = scene, hashlib.sha256(text.encode()).hexdigest()
        if self._key not in self._setup:
            with tempfile.TemporaryDirectory() as folder:
                file = Path(folder) / "scene.json"
                file.write_text(json_text(plain))
                asked = {"integrator": integrator, "sampler": self.sampler}
                loaded = self._ask("load", SETUP_LIMIT, key=self._key, file=str(file), **asked)
            _, compiled = self._render(0, _TO_WARM_UP, SETUP_LIMIT)
            self._setup[self._key] = starting + loaded["seconds"] + compiled
        return self._setup[self._key]

    def run(self, seed: int, ladder: Iterable[int], seconds: float | None = None) -> Iterator[Point]:
        """Render an image for each sample count per pixel in ``ladder``, and yield each image with its time and count.

        The first render that takes ``seconds`` or longer is the last.
        """
        done = 0
        for asked in ladder:
            spp = self._ask("count", key=self._key, spp=asked)["spp"]
            if spp <= done:
                continue
            done = spp
            checkpoint, compiling = self._render(seed, spp)
            self.compiling += compiling
            yield checkpoint
            if seconds is not None and checkpoint.wall_s >= seconds:
                return

    def close(self) -> None:
        """End Mitsuba's process, if it runs."""
        if self._worker is not None:
            self._worker.close()
        self._worker = None
        self._setup.clear()

    def _start(self, threads: int) -> float:
        """Start a process with ``threads`` threads; return the seconds of its import, 0 if it was running already."""
        if self._worker is not None and self._worker.running and threads == self._threads:
            return 0.0
        self.close()
        command = [self.python, "-m", "equaltime.experiments.peers.mitsuba_worker"]
        self._worker = Worker(command, f"{self.label} (Mitsuba)", self.limit)
        self._threads = threads
        started = self._ask("start", SETUP_LIMIT, variant=self.variant, threads=threads)
        self.version = started["version"]
        return float(started["seconds"])

    def _integrator(self, scene: Scene) -> dict[str, object]:
        hidden: dict[str, object] = {"hide_emitters": scene.model.integrator.hides_emitters}
        if self.integrator == "direct":
            if scene.max_depth != 2:
                raise PeerError(f"{self.label}: the integrator 'direct' needs max_depth 2, found {scene.max_depth}")
            return {"type": "direct"} | hidden
        rr_depth = self.rr_depth or getattr(scene.model.integrator, "rr_depth", 5)
        return {"type": self.integrator, "max_depth": scene.max_depth, "rr_depth": rr_depth} | hidden

    def _render(self, seed: int, spp: int, at_least: float = 0.0) -> tuple[Point, float]:
        """Return one render, and the seconds of a preceding render that compiled kernels (0 if there was none)."""
        assert self._scene is not None, "prepare comes first"
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "image.npy"
            numbers = {"spp": spp, "seed": render_seed(seed, spp), "wavefront": MOST_IN_FLIGHT}
            answer = self._ask("render", at_least, key=self._key, file=str(file), **numbers)
            image = checked_image(np.load(file), self._scene, self.label)
        taken = int(answer["spp"])
        paths = taken * image.shape[0] * image.shape[1]
        checkpoint = Point(taken, float(answer["wall_s"]), float(answer["cpu_s"]), image, paths=paths)
        return checkpoint, float(answer["warming_s"])

    def _ask(self, do: str, at_least: float = 0.0, **question: object) -> dict[str, Any]:
        """Ask the process, with a time limit of at least ``at_least`` seconds; end the process if asking fails."""
        assert self._worker is not None, "prepare comes first"
        with contextlib.ExitStack() as stack:
            stack.callback(self.close)
            answer = self._worker.ask(do, at_least, **question)
            stack.pop_all()
        return answer
