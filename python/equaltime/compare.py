"""Compare images of any renderer: with each other, or both with a reference.

Whatever file OpenImageIO reads will do. Files that carry the standard errors of their pixels (``stderr.R/G/B``, as
equaltime's do) say more: a reference's noise is subtracted and its doubt becomes an interval, and two images can be
tested for equal expectations.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from equaltime import images
from equaltime.cost.agreement import BlockMeans
from equaltime.cost.agreement import compare as compare_blocks
from equaltime.cost.metrics import Measured, Reference, contributions, measure
from equaltime.cost.mitsuba_reference import CAVEAT, is_mitsuba
from equaltime.cost.statistics import Interval
from equaltime.error_estimate import Estimate
from equaltime.errors import ImageError
from equaltime.images import Picture
from equaltime.stated import different_problems

__all__ = ["Compared", "Comparison", "compare"]

Floats = NDArray[np.float64]
File = str | os.PathLike[str]

_BLOCK = 8
_FEWEST_BLOCKS = 16
# Of a block's variance: a standard error is pooled over 7x7 pixels, and a block holds little more than that.
_DEGREES = 49.0
_DISPLAY = {".png", ".jpg", ".jpeg", ".bmp", ".tga", ".gif", ".webp"}


@dataclass(frozen=True)
class Compared:
    """One image and how far it is from what it was compared with."""

    path: Path
    metrics: Mapping[str, Measured]
    """By name, see `equaltime.cost.metrics`: of this very image, with the noise of the other subtracted if known."""
    bias_p: float | None
    """P-value of equal expectations; None if that cannot be tested. Small: one of the two is biased."""
    own: Estimate | None
    """What the render itself said its error was."""
    seconds: float | None
    """What it took to render, if the file says so."""


@dataclass(frozen=True)
class Comparison:
    """What `compare` found."""

    size: tuple[int, int]
    """Width and height."""
    against: Path
    """The file that stands for the truth: the reference, or B if there is none."""
    images: tuple[Compared, ...]
    """A and B; A alone if there is no reference."""
    ratio: Interval | None
    """A's error over B's, if there is a reference: below 1 A is nearer."""
    efficiency: Interval | None
    """A's efficiency, 1 / (error² x seconds), over B's, if there is a reference and both files say their times."""
    notes: tuple[str, ...]
    """What must be known to read the numbers."""

    def as_dict(self) -> dict[str, Any]:
        """Return everything as JSON data: what is unknown or not finite is None."""
        return {
            "size": list(self.size),
            "against": str(self.against),
            "images": [
                {
                    "path": str(image.path),
                    "metrics": {name: _plain(asdict(measured)) for name, measured in image.metrics.items()},
                    "bias_p": image.bias_p,
                    "own_estimate": None if image.own is None else image.own.as_dict(),
                    "seconds": image.seconds,
                }
                for image in self.images
            ],
            "ratio": None if self.ratio is None else _plain(asdict(self.ratio)),
            "efficiency": None if self.efficiency is None else _plain(asdict(self.efficiency)),
            "notes": list(self.notes),
        }


def compare(a: File, b: File, reference: File | None = None) -> Comparison:
    """Measure image A against image B, or both against a reference.

    Parameters
    ----------
    a, b, reference
        Image files of the same size with channels R, G and B, in linear light.

    Raises
    ------
    ImageError
        If a file cannot be read, lacks a channel, has a pixel that is not finite, or is of another size.
    EqualtimeError
        If the packages of ``equaltime[report]`` are missing.
    """
    files = [_File.read(path) for path in (a, b, reference) if path is not None]
    _check_sizes(files)
    truth = files[-1]
    subjects = files[:-1]
    compared = tuple(_compared(file, truth) for file in subjects)
    ratio = _ratio(subjects[0], subjects[1], truth) if reference is not None else None
    efficiency = None if ratio is None else _efficiency(ratio, compared)
    height, width = truth.image.shape[:2]
    return Comparison((width, height), truth.path, compared, ratio, efficiency, tuple(_notes(files)))


@dataclass(frozen=True, eq=False)
class _File:
    path: Path
    image: Floats
    variance: Floats | None
    picture: Picture

    @classmethod
    def read(cls, path: File) -> _File:
        picture = images.read(path)
        try:
            image = picture.image.astype(np.float64)
            errors = picture.standard_error
        except ImageError as error:
            raise ImageError(f"{path}: {error}") from None
        if not np.isfinite(image).all():
            y, x, channel = (int(i[0]) for i in np.nonzero(~np.isfinite(image)))
            value = image[y, x, channel]
            raise ImageError(f"{path}: pixel {x},{y} is not finite: {'RGB'[channel]} is {value}")
        known = errors is not None and bool(np.isfinite(errors).all() and (errors >= 0.0).all())
        variance = np.square(errors.astype(np.float64)) if errors is not None and known else None
        return cls(Path(path), image, variance, picture)

    @property
    def reference(self) -> Reference:
        variance = np.zeros_like(self.image) if self.variance is None else self.variance
        return Reference(self.image, variance)

    def said(self, key: str) -> Any:
        """Return what the file's record says."""
        return self.picture.record.get(key)


def _check_sizes(files: Iterable[_File]) -> None:
    sizes = {file.path: "x".join(str(n) for n in file.image.shape[1::-1]) for file in files}
    if len(set(sizes.values())) > 1:
        listed = ", ".join(f"{path} is {size}" for path, size in sizes.items())
        raise ImageError(f"images of different sizes cannot be compared: {listed}")


def _compared(file: _File, truth: _File) -> Compared:
    said, seconds = file.said("error"), file.said("seconds")
    own = None
    if isinstance(said, dict) and said.get("value") is not None:
        low, high = said.get("low"), said.get("high")
        own = Estimate(said["value"], 0.0 if low is None else low, math.inf if high is None else high)
    known = float(seconds) if isinstance(seconds, int | float) and seconds > 0 else None
    return Compared(file.path, measure(file.image, _held_against(file, truth)), _bias_p(file, truth), own, known)


def _held_against(file: _File, truth: _File) -> Reference:
    """Return the truth for a file; its noise is none to be subtracted where the file may have the same."""
    return replace(truth, variance=None).reference if _same_seed(file, truth) else truth.reference


def _bias_p(first: _File, second: _File) -> float | None:
    """Test equal expectations by the block means, if both files know their errors and are independent.

    Block means of a single pair of renders are near to normal, not normal: where few samples carry the light, p-values
    of 0.001 come about more often than that. Renders with many seeds are what `equaltime.cost.agreement` is made for.
    """
    height, width = first.image.shape[:2]
    blocks = (height // _BLOCK) * (width // _BLOCK)
    if first.variance is None or second.variance is None or blocks < _FEWEST_BLOCKS or _same_seed(first, second):
        return None
    images = (first.image, first.variance), (second.image, second.variance)
    return compare_blocks(*(BlockMeans.of_pixels(*image, _BLOCK, _DEGREES) for image in images)).p


def _same_seed(first: _File, second: _File) -> bool:
    """Tell whether both have a seed in common, and so numbers; a merged file has those of all its parts.

    Of another scene too: what is left out of one, or a path's length, leaves the numbers of all else as they are.
    """
    return bool(_seeds(first) & _seeds(second))


def _seeds(file: _File) -> set[int]:
    sources = file.said("sources")
    parts = [part.get("seed") for part in sources if isinstance(part, dict)] if isinstance(sources, list) else []
    return {seed for seed in parts or [file.said("seed")] if isinstance(seed, int)}


def _ratio(first: _File, second: _File, truth: _File) -> Interval | None:
    """Return the ratio of errors with the interval that the scatter of blocks gives it, formed on the logarithm.

    Blocks are independent; what the picture makes of both errors alike cancels in the difference of their shares.
    """
    parts = [_block_sums(contributions(file.image, _held_against(file, truth))) for file in (first, second)]
    means = [float(part.mean()) for part in parts]
    if min(means) <= 0.0:
        return None
    log_ratio = math.log(means[0] / means[1])
    scatter = float(np.std(parts[0] / means[0] - parts[1] / means[1], ddof=1)) if parts[0].size > 1 else math.inf
    half = 1.96 * scatter / math.sqrt(parts[0].size)
    logs = (log_ratio, log_ratio - half, log_ratio + half)
    value, low, high = (math.exp(0.5 * min(x, 1400.0)) for x in logs)
    found = Interval(value, low, high)
    if any(_same_seed(file, truth) for file in (first, second)):
        return found.doubted("one has a seed in common with the reference")
    return found if parts[0].size >= _FEWEST_BLOCKS else found.doubted("too few pixels")


def _block_sums(parts: Floats) -> Floats:
    """Return means over blocks, or the pixels themselves where an image has few of them."""
    block = _BLOCK if min(parts.shape) >= 4 * _BLOCK else 1
    rows, columns = (n // block for n in parts.shape)
    cut = parts[: rows * block, : columns * block]
    means: Floats = cut.reshape(rows, block, columns, block).mean(axis=(1, 3)).ravel()
    return means


def _efficiency(ratio: Interval, compared: tuple[Compared, ...]) -> Interval | None:
    first, second = (image.seconds for image in compared)
    if first is None or second is None:
        return None

    def gain(error: float) -> float:
        square = error * error
        return second / first / square if square > 0.0 else math.inf

    return ratio.map(gain)


def _notes(files: list[_File]) -> Iterable[str]:
    truth = files[-1]
    if truth.variance is None:
        yield f"{truth.path} carries no standard errors: its noise is part of the errors, and they have no intervals"
    if is_mitsuba(truth.picture.software):
        yield f"{truth.path} is by Mitsuba: {CAVEAT}"
    for file in files:
        if file.path.suffix.lower() in _DISPLAY:
            yield f"{file.path} is made for displays: its values are taken as they are, and may not be linear"
        if file is not truth and _same_seed(file, truth):
            yield (
                f"{file.path} and {truth.path} have a seed in common: they are not independent. "
                "No noise is subtracted, and bias is not tested; render one with another --seed"
            )
    if len({(file.picture.window.x, file.picture.window.y) for file in files}) > 1:
        yield "the files lie at different places in the film"
    yield from different_problems([(file.path, file.picture.record) for file in files])


def _plain(numbers: Mapping[str, Any]) -> dict[str, Any]:
    return {key: None if isinstance(n, float) and not math.isfinite(n) else n for key, n in numbers.items()}
