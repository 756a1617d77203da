"""Worker process with Mitsuba 3: ``python -m equaltime.experiments.peers.mitsuba_worker``, for `MitsubaPeer`.

A request is a JSON line on stdin, and its answer a JSON line on stdout. Output of libraries goes to stderr. Images are
float32 .npy files. Clocks cover the integrator's ``render`` and the wait for its pixels, and exclude all other work.

- ``start``   variant, threads → seconds to import and to start up, version
- ``load``    key, file (scene as JSON), integrator, sampler → seconds; a loaded scene is kept under its key
- ``count``   key, spp → the samples per pixel that the sampler takes when asked for ``spp``
- ``render``  key, spp, seed, file (.npy), wavefront → spp, wall and CPU seconds, and wall seconds of warming up
"""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from equaltime.errors import PeerError
from equaltime.extras import install
from equaltime.machine import worker_threads
from equaltime.scene.export.plain import with_transforms
from equaltime.strict_json import json_text

__all__ = ["MitsubaWorker", "samples_per_pass", "serve"]

Answer = dict[str, Any]

NO_LLVM = (
    "the variant {} needs LLVM, which was not found: install Debian's package libllvm19 (apt install libllvm19), or "
    "set DRJIT_LIBLLVM_PATH to a libLLVM.so; the variant scalar_rgb does without"
)


def samples_per_pass(spp: int, pixels: int, wavefront: int) -> int:
    """Return the samples per pixel of each pass, if ``spp`` samples per pixel are taken in equal passes.

    The result is the largest divisor of ``spp`` for which a pass takes at most ``wavefront`` samples, over all pixels.
    If even one sample per pixel is too many, the result is 1.
    """
    fitting = max(wavefront // pixels, 1)
    return next(spp // passes for passes in range(-(-spp // fitting), spp + 1) if spp % passes == 0)


class Loaded:
    """A scene loaded in Mitsuba, with its integrator, so that several renders need not load it again."""

    def __init__(self, mitsuba: Any, scene: Any, integrator: Answer) -> None:
        self._mitsuba, self.scene, self._integrator, self.seconds = mitsuba, scene, integrator, 0.0
        self.warm: set[int] = set()
        """Sample counts whose kernels are compiled."""
        self.pixels = int(np.prod(scene.sensors()[0].film().crop_size()))

    def count(self, spp: int) -> int:
        """Return the samples per pixel that the sampler takes when asked for ``spp``."""
        sampler = self.scene.sensors()[0].sampler()
        sampler.set_sample_count(spp)
        return int(sampler.sample_count())

    def integrator(self, spp: int, wavefront: int) -> Any:
        """Return an integrator for ``spp`` samples per pixel, in passes of at most ``wavefront`` samples."""
        part = samples_per_pass(spp, self.pixels, wavefront)
        return self._mitsuba.load_dict(self._integrator | ({} if part == spp else {"samples_per_pass": part}))


class MitsubaWorker:
    """Mitsuba in this process, for another process that sends requests: each method answers one kind of request."""

    def start(self, variant: str, threads: int) -> Answer:
        """Import Mitsuba, choose its variant and start ``threads`` threads; return seconds and version.

        Raises PeerError if Mitsuba, the variant or LLVM is missing.
        """
        begin = perf_counter()
        try:
            import drjit
            import mitsuba
        except ModuleNotFoundError as error:
            raise PeerError(f"this needs the package {error.name}: {install('peers')}") from error
        if variant not in mitsuba.variants():
            raise PeerError(f"it has no variant '{variant}'; there are {', '.join(mitsuba.variants())}")
        try:
            mitsuba.set_variant(variant)
        except ImportError as error:
            raise PeerError(NO_LLVM.format(variant) if "LLVM" in str(error) else str(error)) from error
        mitsuba.set_log_level(mitsuba.LogLevel.Error)
        self._threads = worker_threads(threads)
        drjit.set_thread_count(self._threads)
        self._mitsuba, self._drjit, self._compiles = mitsuba, drjit, not variant.startswith("scalar")
        if self._compiles:
            drjit.set_flag(drjit.JitFlag.KernelHistory, True)
        self._scenes: dict[str, Loaded] = {}
        return {"seconds": perf_counter() - begin, "version": mitsuba.__version__}

    def load(self, key: str, file: str, integrator: Answer, sampler: str) -> Answer:
        """Load a scene from ``file`` unless ``key`` is known; return the seconds that loading took the first time.

        ``integrator`` is a dictionary as Mitsuba reads it, and ``sampler`` the name of Mitsuba's sampler. Loading uses
        at least two threads: on one thread, Mitsuba 3.9 hangs while reading an EXR file.
        """
        if key not in self._scenes:
            begin = perf_counter()
            plain = json.loads(Path(file).read_text())
            plain["sensor"]["sampler"] = {"type": sampler}
            self._drjit.set_thread_count(max(self._threads, 2))
            try:
                scene = self._mitsuba.load_dict(with_transforms(plain, self._mitsuba.ScalarTransform4f))
            finally:
                self._drjit.set_thread_count(self._threads)
            loaded = Loaded(self._mitsuba, scene, integrator)
            loaded.integrator(1, 1)  # made here, so that an unknown integrator is reported at once
            self._scenes[key] = loaded
            loaded.seconds = perf_counter() - begin
        return {"seconds": self._scenes[key].seconds}

    def count(self, key: str, spp: int) -> Answer:
        """Return the samples per pixel that the sampler of the scene ``key`` takes when asked for ``spp``.

        Some samplers round the count.
        """
        return {"spp": self._scenes[key].count(spp)}

    def render(self, key: str, spp: int, seed: int, file: str, wavefront: int) -> Answer:
        """Render the scene ``key`` to ``file``; return sample count, seconds of rendering and seconds of warming up.

        ``spp`` is the number of samples per pixel asked for. A pass takes at most ``wavefront`` samples over all
        pixels. If the render compiled kernels, the time of this render counts as warming up, and the image is rendered
        again.
        """
        loaded = self._scenes[key]
        count = loaded.count(spp)
        integrator = loaded.integrator(count, wavefront)

        def once() -> tuple[NDArray[np.float32], float, float]:
            wall, cpu = perf_counter(), process_time()
            image = integrator.render(loaded.scene, sensor=0, seed=seed, spp=count, develop=True, evaluate=True)
            pixels = np.array(image, dtype=np.float32)  # waits until all pixels are computed
            return pixels, perf_counter() - wall, process_time() - cpu

        warming = 0.0
        pixels, wall, cpu = once()
        if count not in loaded.warm and self._compiled():
            warming = wall
            pixels, wall, cpu = once()
        loaded.warm.add(count)
        np.save(file, pixels)
        return {"spp": count, "wall_s": wall, "cpu_s": cpu, "warming_s": warming}

    def _compiled(self) -> bool:
        """Tell whether a kernel was compiled or read from the disk since the last call."""
        if not self._compiles:
            return False
        history = self._drjit.kernel_history((self._drjit.KernelType.JIT,))
        return any(not kernel["cache_hit"] or kernel["cache_disk"] for kernel in history)


def serve(worker: MitsubaWorker) -> None:
    """Answer requests from standard input with ``worker`` until the input ends: one JSON line each."""
    answers = os.fdopen(os.dup(sys.stdout.fileno()), "w")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
    for line in sys.stdin:
        question = json.loads(line)
        try:
            answer = getattr(worker, question.pop("do"))(**question)
        except PeerError as error:
            answer = {"error": str(error)}
        except Exception as error:  # any error in Mitsuba is reported with its type
            answer = {"error": f"{type(error).__name__}: {error}"}
        answers.write(json_text(answer) + "\n")
        answers.flush()


if __name__ == "__main__":
    serve(MitsubaWorker())
