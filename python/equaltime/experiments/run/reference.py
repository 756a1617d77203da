"""References: precise images against which errors are measured, rendered once and cached.

A reference is rendered by a fixed strategy with independent samples, so that the sample variance gives its error. A
reference consists of two independent halves, and no run uses their seeds. The cache is keyed by the content of the
scene, so that all experiments on a scene share one reference.
"""

from __future__ import annotations

import json
import math
import os
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from equaltime.errors import ExperimentError, ImageError, Problem
from equaltime.experiments.model.experiment import ReferenceWish
from equaltime.experiments.model.reader import with_roulette
from equaltime.experiments.run.folder import build_facts, replacing
from equaltime.film.error import pixel_statistics
from equaltime.film.moments import squared_deviations
from equaltime.images import image_files as images
from equaltime.images.float32 import beyond_float32
from equaltime.images.metrics import Reference
from equaltime.images.mitsuba_reference import CAVEAT, is_mitsuba
from equaltime.rendering.core import bad_sample, make_renderer
from equaltime.rendering.noisy_reference import Noise
from equaltime.rendering.saved import as_picture
from equaltime.scene import Scene
from equaltime.strategy import Strategy
from equaltime.strict_json import json_text

__all__ = ["REFERENCE_STRATEGY", "TOLERANCE", "KnownReference", "cache_folder", "obtain", "read", "render", "write"]

REFERENCE_STRATEGY = "mis,lights=power,sampler=independent"

Report = Callable[[float], object]

# Seeds of the halves; no run has them, because runs have seeds below 2^31.
_SEEDS = (2**63 + 1, 2**63 + 2)
_FIRST_SAMPLES = 8
# Fewest samples of a half: with fewer, an image that has not found any light yet would pass for exact.
_FEWEST_SAMPLES = 32
_FASTEST_GROWTH = 4.0
TOLERANCE = 1.02
"""Multiple of the wanted error up to which an error is accepted: another pass would cost more than it gains."""
_VERSION = 1


@dataclass(frozen=True, eq=False)
class KnownReference:
    """A reference (precise image against which errors are measured), and the facts of its origin."""

    reference: Reference
    facts: Mapping[str, Any]
    """Facts on the origin of the reference as JSON data: its ``error``, ``strategy``, ``seeds``, ``spp``, ``seconds``
    and so on, or the ``file`` that it was read from. ``caveat`` names a limit of the reference besides its noise."""

    @property
    def error(self) -> float:
        """Relative error of the reference by its own noise; 0.01 is 1 %."""
        return math.sqrt(max(self.reference.relmse, 0.0))


def cache_folder() -> Path:
    """Return the folder where references are kept for later experiments.

    It is ``equaltime/references`` in ``$XDG_CACHE_HOME``, or in ``~/.cache`` if that is unset.
    """
    base = os.environ.get("XDG_CACHE_HOME")
    return (Path(base) if base else Path.home() / ".cache") / "equaltime" / "references"


def obtain(
    scene: Scene, wish: ReferenceWish, cache: Path | None = None, threads: int = 0, report: Report | None = None
) -> KnownReference:
    """Return a reference of the scene: read from ``wish.file`` if given, else from the cache, else rendered.

    A cached reference is used if its error is at most ``wish.error``, or if its time limit was at least
    ``wish.seconds``.

    Parameters
    ----------
    cache
        Folder of the cache; by default `cache_folder`. A new reference is kept there if the folder is writable.
    report
        Called now and then with the completed share of the work, in [0, 1].

    Raises
    ------
    ExperimentError, ImageError
        If ``wish.file`` cannot be read or has another size.
    """
    if wish.file is not None:
        return _from_file(wish.file, scene)
    path = (cache or cache_folder()) / f"{scene.digest}.npz"
    kept = _kept(path, scene)
    if kept is not None and (kept.error <= wish.error or kept.facts["seconds_allowed"] >= wish.seconds):
        return kept
    known = render(scene, wish.error, wish.seconds, threads, report)
    try:
        write(path, known)
    except OSError:  # go on without a cache that cannot be written to
        return known
    return known


def render(
    scene: Scene, error: float, seconds: float, threads: int = 0, report: Report | None = None
) -> KnownReference:
    """Render and return a reference: the mean of two independent halves with equal sample counts.

    Rendering ends when the mean has at most 1.02 times the relative ``error``, or after about ``seconds``. ``report``
    is called now and then with the completed share of the work, in [0, 1].

    Raises
    ------
    NonFiniteSample, BrightImage
        If a sample is not finite, or float32 cannot hold the image.
    """
    strategy = with_roulette(Strategy.parse(REFERENCE_STRATEGY), scene)
    renderers = [make_renderer(scene, strategy, seed, threads) for seed in _SEEDS]
    samples, begin = _FIRST_SAMPLES, time.perf_counter()
    corner, where = scene.model.sensor.film.crop[:2], ": ".join(filter(None, (str(scene.source or ""), "reference")))

    share = 0.0

    def tell() -> bool:
        if report is not None:
            report(min(1.0, max(share, (time.perf_counter() - begin) / seconds)))
        return True

    while True:
        for renderer, seed in zip(renderers, _SEEDS, strict=True):
            renderer.advance(samples, None, tell)
            if renderer.nonfinite:
                raise bad_sample(scene, strategy, seed, renderer)
            if (beyond := beyond_float32(pixel_statistics(renderer.moments).mean, corner, where)) is not None:
                raise beyond
        reference = _join([renderer.moments for renderer in renderers])
        found, passed = math.sqrt(max(reference.relmse, 0.0)), time.perf_counter() - begin
        share = min(1.0, (error / found) ** 2) if found > 0.0 else 1.0
        more = _more(samples, found / error, passed / seconds)
        if more is None:
            break
        samples = more
    facts = {
        "software": images.SOFTWARE,
        "core": build_facts()["core_sha256"],
        "strategy": strategy.name,
        "seeds": list(_SEEDS),
        "spp": 2 * samples,
        "error": found,
        "error_wanted": error,
        "seconds": passed,
        "seconds_allowed": seconds,
    }
    return KnownReference(reference, facts)


def _more(samples: int, error: float, passed: float) -> int | None:
    """Return the next sample count, or None to stop; error and time are relative to the wanted ones."""
    if passed >= 1.0 or (error <= TOLERANCE and samples >= _FEWEST_SAMPLES):
        return None
    by_error = max(samples * error**2, float(_FEWEST_SAMPLES))
    by_time = 0.98 * samples / passed if passed > 0.0 else math.inf
    more = int(min(by_error, by_time, _FASTEST_GROWTH * samples)) // 2 * 2
    return more if more > TOLERANCE * samples else None


def _join(halves: list[NDArray[Any]]) -> Reference:
    """Return mean, halves, and the variance of the mean from all samples, which are independent.

    Let n, M, S be the count, mean and sum of squared deviations of each part. The whole has
    ``S = Σ S_r + Σ n_r (M_r - M)²`` (Chan et al. 1979), and its mean the variance ``S / (N - 1) / N``.
    """
    means = []
    for moments in halves:
        counts = moments["count"][..., None].astype(np.float64)
        means.append((counts * moments["mean"]).sum(axis=0) / counts.sum(axis=0))
    mean = 0.5 * (means[0] + means[1])
    total, deviations = np.zeros((*mean.shape[:2], 1)), np.zeros_like(mean)
    for moments in halves:
        for part in moments:
            counts = part["count"][..., None].astype(np.float64)
            total += counts
            deviations += squared_deviations(part) + counts * np.square(part["mean"] - mean)
    return Reference(mean, deviations / (total - 1.0) / total, (means[0], means[1]))


def write(path: Path, known: KnownReference) -> None:
    """Write a reference to an ``.npz`` file, atomically, for later experiments; raises OSError if that fails."""
    reference = known.reference
    arrays: dict[str, Any] = {"mean": reference.mean, "variance": reference.variance}
    if reference.halves is not None:
        arrays |= {"half_0": reference.halves[0], "half_1": reference.halves[1]}
    facts = json_text({"version": _VERSION, **known.facts})
    with replacing(path) as file:
        np.savez(file, facts=np.array(facts), **arrays)


def read(path: Path) -> KnownReference:
    """Read a reference from an ``.npz`` file that `write` made.

    Raises ExperimentError if the file is damaged or is no reference.
    """
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as arrays:
            facts = json.loads(str(arrays["facts"]))
            halves = (arrays["half_0"], arrays["half_1"]) if "half_0" in arrays else None
            reference = Reference(arrays["mean"], arrays["variance"], halves)
            _check(reference, facts)
    except Exception as error:  # zip, zlib, NumPy and JSON raise different errors for a damaged file
        raise ExperimentError((Problem(str(path), f"cannot be read as a reference: {error}"),)) from error
    return KnownReference(reference, facts)


def _check(reference: Reference, facts: object) -> None:
    """Raise ValueError unless all images have one size and finite numbers, and facts is a table."""
    shape = reference.mean.shape
    for image in (reference.mean, reference.variance, *(reference.halves or ())):
        if image.shape != shape or image.dtype != np.float64 or not np.isfinite(image).all():
            raise ValueError("expected images of one size with finite numbers")
    if len(shape) != 3 or shape[2] != 3 or not isinstance(facts, dict):
        raise ValueError("expected images with three channels, and facts")


def _kept(path: Path, scene: Scene) -> KnownReference | None:
    """Return the cached reference; None if it is missing, damaged, from another version or of another size."""
    if not path.exists():
        return None
    try:
        known = read(path)
    except ExperimentError:
        return None
    made = {"version": _VERSION, "software": images.SOFTWARE, "core": build_facts()["core_sha256"]}
    current = all(known.facts.get(key) == value for key, value in made.items())
    return known if current and known.reference.mean.shape == _shape(scene) else None


def _from_file(path: Path, scene: Scene) -> KnownReference:
    known = read(path) if path.suffix.lower() == ".npz" else _pictured(path)
    wrong = np.argwhere(~np.isfinite(known.reference.mean))
    if wrong.size:
        y, x = wrong[0][:2]
        raise ExperimentError((Problem("reference.file", f"{path}: pixel {x},{y} is not finite"),))
    found, expected = known.reference.mean.shape, _shape(scene)
    if found != expected:
        sizes = (f"{shape[1]}x{shape[0]}" for shape in (found, expected))
        raise ExperimentError((Problem("reference.file", "{} is {}, but the image is {}".format(path, *sizes)),))
    return KnownReference(known.reference, {**known.facts, "file": str(path), "error": known.error})


def _pictured(path: Path) -> KnownReference:
    """Return the image of a file as a reference, with the file's standard errors as noise if it has them.

    An image by Mitsuba gets a caveat.
    """
    try:
        picture, film = as_picture(path)
    except ImageError as error:
        raise ExperimentError((Problem("reference.file", str(error)),)) from error
    try:
        noise, mean = Noise.of_render(picture, film), picture.image.astype(np.float64)
    except ImageError as error:
        raise ExperimentError((Problem("reference.file", f"{path}: {error}"),)) from error
    reference = Reference(mean, np.zeros_like(mean) if noise is None else noise.variance)
    return KnownReference(reference, {"caveat": CAVEAT} if is_mitsuba(picture.software) else {})


def _shape(scene: Scene) -> tuple[int, int, int]:
    _, _, width, height = scene.model.sensor.film.crop
    return height, width, 3
