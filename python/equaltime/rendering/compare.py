"""Comparison of two images of any renderer: with each other, or of both with a reference.

Any file that OpenImageIO reads can be compared. Files that carry the standard errors of their pixels (``stderr.R/G/B``,
as equaltime's do) allow more: the noise of the reference is subtracted, and its uncertainty becomes an interval
(`equaltime.rendering.noisy_reference`). Two such images can also be tested for equal expected images.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from equaltime.errors import ImageError
from equaltime.extras import install
from equaltime.images.flip import available
from equaltime.images.image_files import Picture, extension
from equaltime.images.metrics import METRICS, Reference, contributions, measure
from equaltime.images.mitsuba_reference import CAVEAT, is_mitsuba
from equaltime.rendering.noisy_reference import FEWEST_BLOCKS, Difference, Noise, block_means, log_ratio
from equaltime.rendering.saved import Render, as_picture, name_of
from equaltime.rendering.stated import different_problems
from equaltime.statistics.agreement import Agreement, compare_pair
from equaltime.statistics.intervals import Interval, exp, signed_root
from equaltime.strict_json import fields_to_json, to_json
from equaltime.words import Shown, figure, percent, without_numbers

__all__ = ["Compared", "Comparison", "compare"]

Floats = NDArray[np.float64]

_BLOCK = 8
"""Side of the blocks whose means are tested for equal expectations, in pixels."""
_DEGREES = 49.0
"""Degrees of freedom of a block's variance: standard errors are pooled over 7x7 pixels, and a block has 64."""
_NOISY = 0.25
"""Largest share of the reference's noise in squared differences at which a ratio of errors is not in doubt."""
_DISPLAY = {".png", ".jpg", ".jpeg", ".bmp", ".tga", ".gif", ".webp"}


@dataclass(frozen=True)
class Compared:
    """Result of `compare` for one image: its distances from the image that it was compared with."""

    path: Path
    """File of the image."""
    metrics: Mapping[str, Interval] = field(hash=False)
    """Distances by the name of the metric: ``error`` (square root of relMSE), ``relmse``, ``mse``, ``mare`` and
    ``flip``. The distances hold for this one image, not for the average over renders. Known noise of the other image is
    subtracted. If that noise is too large, the value is NaN, and ``high`` is an upper limit."""
    bias_p: float | None
    """P-value of the test that both images have equal expected values. If it is small, one of the two images is biased.
    None if the files do not allow the test, or if few bright pixels make the noise."""
    own: Interval | None
    """Relative error that the image's own file states, with its interval and any stated reason to doubt it; None if the
    file states no error."""
    doubt: str
    """Reason, in words, why the other image may lack light, so that the intervals of the metrics may miss the truth.
    The file of the other image states the reason; empty if it states none."""
    seconds: float | None
    """Rendering time in seconds; None if the file does not state it."""
    least_bias: float | None = None
    """Relative difference, equal in all pixels, that the test behind ``bias_p`` finds in nine of ten pairs of images;
    None without the test, or if no difference would be found."""

    def as_dict(self) -> dict[str, Any]:
        """Return the fields by name as JSON data; ``own`` is named ``own_estimate``."""
        return {**fields_to_json(self, without=("own",)), "own_estimate": to_json(self.own)}


@dataclass(frozen=True, repr=False)
class Comparison(Shown):
    """Result of `compare`: distances of one or two images from a reference, and the ratios of two images.

    A and B are the first and the second image that were compared.
    """

    size: tuple[int, int]
    """Width and height, in pixels."""
    against: Path
    """File that stands for the truth: the reference, or the second image if there is no reference."""
    images: tuple[Compared, ...]
    """Distances of the first and the second image from the reference; without a reference, of the first from the
    second."""
    ratio: Interval | None
    """Error of the first image divided by the error of the second, for these two images only; below 1, the first is
    nearer to the reference. None if there is no reference, or if its noise is too large. The ends of the interval are
    NaN if the file of the reference has no standard errors."""
    efficiency: Interval | None
    """Efficiency of the first image, 1 / (error² x seconds), divided by the efficiency of the second, for these two
    images only. None if there is no ratio, or if a file does not state its time."""
    notes: tuple[str, ...]
    """Sentences on facts that limit the numbers, such as a noisy reference."""
    same: str = ""
    """Sentence on two images with the same pixels, such as a file that was given twice; empty without such a pair."""
    order: str = ""
    """Sentence on two files that may be in the wrong order: the second, which is taken as the truth, does not tell its
    noise, and the first does. Empty in other cases."""
    unlike: str = ""
    """Sentence on pictures for displays, such as PNG files, that are compared with files of radiance; empty in other
    cases."""

    def __str__(self) -> str:
        lines = [line for line in (self.same, self.unlike, self.order) if line]
        for image in self.images:
            error = image.metrics["error"]
            said = f"{error:%}" if error.trusted else percent(error.value)
            if math.isnan(error.value):
                said = "not known, the other image is too noisy"
            lines.append(f"{image.path.name}: error {said}, against {self.against.name}")
        if self.ratio is not None and len(self.images) > 1:
            first, second = (image.path.name for image in self.images)
            ratio = self.ratio
            times = f"{ratio}" if math.isfinite(ratio.low) else figure(ratio.value)
            lines.insert(0, f"{first} has {times} times the error of {second}")
        return "\n".join([*lines, *self.notes])

    def as_dict(self) -> dict[str, Any]:
        """Return the comparison as JSON data; numbers that are unknown or not finite are None."""
        return fields_to_json(self)


def compare(a: Render, b: Render, reference: Render | None = None) -> Comparison:
    """Return the distance of image A from image B, or the distances of both images from a reference.

    Parameters
    ----------
    a, b, reference
        Results, or image files of any renderer with channels R, G and B in linear light, all of one size.

    Raises
    ------
    ImageError
        If a file cannot be read, lacks a channel, has a pixel that is not finite, or is of another size.

    Examples
    --------
    >>> found = et.compare("a.exr", "b.exr")
    >>> found.size
    (16, 16)
    >>> sorted(found.images[0].metrics)[:2]
    ['error', 'flip']
    """
    files = [_File.read(render) for render in ((a, b) if reference is None else (a, b, reference))]
    _check_sizes(files)
    truth = files[-1]
    subjects = files[:-1]
    pairs = [_Pair(file, truth) for file in subjects]
    compared = tuple(_compared(pair) for pair in pairs)
    ratio = _ratio(pairs[0], pairs[1]) if reference is not None else None
    if ratio is not None and truth.doubt:
        ratio = ratio.doubted(f"the error that {truth.path.name} states is in doubt")
    efficiency = None if ratio is None else _efficiency(ratio, compared)
    height, width = truth.image.shape[:2]
    notes = tuple(_notes(files, compared, reference is not None and ratio is None))
    return Comparison(
        (width, height),
        truth.path,
        compared,
        ratio,
        efficiency,
        notes,
        _same_pixels(files),
        _order(files),
        _unlike(files),
    )


@dataclass(frozen=True, eq=False)
class _File:
    path: Path
    image: Floats
    errors: Floats | None
    """Standard errors, as the file states them; None if there are none, or if one is invalid."""
    noise: Noise | None
    picture: Picture

    @classmethod
    def read(cls, render: Render) -> _File:
        path, (picture, film) = name_of(render), as_picture(render)
        try:
            image = picture.image.astype(np.float64)
            stated = picture.standard_error
        except ImageError as error:
            raise ImageError(f"{path}: {error}") from None
        if not np.isfinite(image).all():
            y, x, channel = (int(i[0]) for i in np.nonzero(~np.isfinite(image)))
            value = image[y, x, channel]
            raise ImageError(f"{path}: pixel {x},{y} is not finite: {'RGB'[channel]} is {value}")
        known = stated is not None and bool(np.isfinite(stated).all() and (stated >= 0.0).all())
        errors = stated.astype(np.float64) if stated is not None and known else None
        return cls(path, image, errors, Noise.of_render(picture, film), picture)

    @property
    def doubt(self) -> str:
        """Reason why the error that the file's record states is in doubt; empty if it is not, or if there is none."""
        own = _own(self)
        return "" if own is None else own.doubt

    def said(self, key: str) -> Any:
        """Return the value of a key in the file's record."""
        return self.picture.record.get(key)


def _check_sizes(files: Iterable[_File]) -> None:
    sizes = {file.path: "x".join(str(n) for n in file.image.shape[1::-1]) for file in files}
    if len(set(sizes.values())) > 1:
        listed = ", ".join(f"{path} is {size}" for path, size in sizes.items())
        raise ImageError(f"images of different sizes cannot be compared: {listed}")


@dataclass(frozen=True, eq=False)
class _Pair:
    """An image and the image that it is measured against."""

    file: _File
    truth: _File

    @cached_property
    def noise(self) -> Noise | None:
        """Noise of the truth that is subtracted; None if it is unknown or zero, or if both may have the same noise."""
        noise = self.truth.noise
        return None if noise is None or not noise.variance.any() or _same_seed(self.file, self.truth) else noise

    @cached_property
    def reference(self) -> Reference:
        """The truth for metrics from which noise cannot be subtracted."""
        none = np.zeros_like(self.truth.image)
        return Reference(self.truth.image, none if self.noise is None else self.noise.variance)

    def difference(self, relative: bool = True) -> Difference:
        """Return how far the image is from a truth whose noise is known."""
        assert self.noise is not None
        return Difference.of(self.file.image, self.truth.image, self.noise, relative)

    @cached_property
    def relative(self) -> Difference:
        """The difference relative to the truth."""
        return self.difference()


def _compared(pair: _Pair) -> Compared:
    names = [name for name in METRICS if name != "flip" or available()]
    metrics = dict(measure(pair.file.image, pair.reference, names))
    if pair.noise is not None:
        relmse, mse = pair.relative.measured, pair.difference(relative=False).measured
        metrics |= {"error": relmse.map(signed_root), "relmse": relmse, "mse": mse}
    seconds = pair.file.said("seconds")
    known = float(seconds) if isinstance(seconds, int | float) and seconds > 0 else None
    test, own = _test(pair.file, pair.truth), _own(pair.file)
    bias_p = None if test is None else test.p
    least = None if test is None or math.isinf(test.least) else test.least
    metrics |= {name: metrics[name].in_unit("%") for name in ("error", "mare")}
    return Compared(pair.file.path, metrics, bias_p, own, pair.truth.doubt, known, least)


def _own(file: _File) -> Interval | None:
    """Return the estimate that a file's record states, with its doubt."""
    said = file.said("error")
    if not isinstance(said, dict) or said.get("value") is None:
        return None
    found = Interval.from_dict({"low": None, "high": None, **said})
    return replace(found, low=max(found.low, 0.0))


def _test(first: _File, second: _File) -> Agreement | None:
    """Test equal expectations by the block means, if both files know their errors and are independent.

    None if they do not, or if few pixels make the noise. For renders with many seeds use
    `equaltime.statistics.agreement`.
    """
    height, width = first.image.shape[:2]
    blocks = (height // _BLOCK) * (width // _BLOCK)
    if first.errors is None or second.errors is None or blocks < FEWEST_BLOCKS or _same_seed(first, second):
        return None
    images = (first.image, np.square(first.errors)), (second.image, np.square(second.errors))
    return compare_pair(*images, _BLOCK, _DEGREES)


def _same_seed(first: _File, second: _File) -> bool:
    """Tell whether both have a seed in common, and so random numbers; a merged file has the seeds of all its parts.

    This holds for different scenes too: leaving out an effect, or another path length, does not change the other
    numbers.
    """
    return bool(_seeds(first) & _seeds(second))


def _seeds(file: _File) -> set[int]:
    sources = file.said("sources")
    parts = [part.get("seed") for part in sources if isinstance(part, dict)] if isinstance(sources, list) else []
    return {seed for seed in parts or [file.said("seed")] if isinstance(seed, int)}


def _same_pixels(files: list[_File]) -> str:
    """Return a sentence on the first two images whose pixels are all equal; empty if there are none."""
    for first, second in combinations(files, 2):
        if np.array_equal(first.image, second.image):
            twice = first.path.absolute() == second.path.absolute()
            if twice:
                return f"identical: {first.path} was given twice; give two files"
            noise = "to measure noise or bias, render one with another --seed"
            return f"identical: {first.path} and {second.path} have the same pixels, as exact repeats do; {noise}"
    return ""


def _order(files: list[_File]) -> str:
    """Return the sentence `Comparison.order`."""
    first, *_, truth = files
    if len(files) > 2 or truth.noise is not None or first.noise is None:
        return ""
    return (
        f"{truth.path.name} carries no standard errors: its noise is part of the error. If {first.path.name} is the "
        "truth, give it second."
    )


def _unlike(files: list[_File]) -> str:
    """Return the sentence `Comparison.unlike`."""
    pictures = [file.path.name for file in files if extension(file.path) in _DISPLAY]
    others = [file.path.name for file in files if extension(file.path) not in _DISPLAY]
    if not pictures or not others:
        return ""
    return (
        f"values for displays in {' and '.join(pictures)}, radiance in {' and '.join(others)}: most of the difference "
        "may come from that. Compare files of one kind."
    )


def _ratio(first: _Pair, second: _Pair) -> Interval | None:
    """Return the ratio of errors of two images, with the interval that follows from the reference's noise."""
    if first.noise is not None and second.noise is not None:
        if not (first.relative.measured.known and second.relative.measured.known):
            return None
        log, half = log_ratio(first.relative, second.relative)
        value, low, high = (exp(0.5 * x) for x in (log, log - half, log + half))
        found = Interval(value, low, high)
        share = max(first.relative.share, second.relative.share)
        if share > _NOISY:
            found = found.doubted(f"noise of {first.truth.path.name} may make {100 * share:.2g} % of the difference")
        few = block_means(first.relative.squares[..., 0]).size < FEWEST_BLOCKS
        return found.doubted("too few pixels") if few else found
    means = [float(contributions(pair.file.image, pair.reference).mean()) for pair in (first, second)]
    if min(means) <= 0.0:
        return None
    found = Interval(math.sqrt(means[0] / means[1]), math.nan, math.nan)
    if sharing := [pair.file.path.name for pair in (first, second) if _same_seed(pair.file, pair.truth)]:
        who = "both have" if len(sharing) == 2 else f"{sharing[0]} has"
        return found.doubted(f"{who} a seed in common with the reference")
    if first.truth.noise is None:
        return found.doubted("noise of the reference pulls it towards 1")
    return replace(found, low=found.value, high=found.value)  # the reference states that it has no noise


def _efficiency(ratio: Interval, compared: tuple[Compared, ...]) -> Interval | None:
    first, second = (image.seconds for image in compared)
    if first is None or second is None:
        return None

    def gain(error: float) -> float:
        square = error * error
        return second / first / square if square > 0.0 else math.inf

    return ratio.map(gain)


def _notes(files: list[_File], compared: tuple[Compared, ...], without_ratio: bool) -> Iterable[str]:
    truth = files[-1]
    if truth.noise is None and not _order(files):
        yield f"{truth.path} carries no standard errors: its noise is part of the errors, and they have no intervals"
    if is_mitsuba(truth.picture.software):
        yield f"{truth.path} is by Mitsuba: {CAVEAT}"
    for image in compared:
        if math.isnan(image.metrics["error"].value):
            yield (
                f"the error of {image.path} is unknown but for an upper limit: {truth.path} has so much noise itself. "
                f"Render {truth.path} with more samples"
            )
    told = set[str]()
    for file in files:
        if file.doubt:
            also = ", and so are all errors measured against it" if file is truth else ""
            again = without_numbers(file.doubt) in told
            why = f"{',' * bool(also)} for the same reason" if again else f": {file.doubt}"
            told.add(without_numbers(file.doubt))
            yield f"the error that {file.path} states is in doubt{also}{why}"
    if without_ratio:
        yield f"the ratio of errors is unknown: {truth.path} is too noisy to tell"
    if not available():
        yield f"flip is left out: it needs the package flip-evaluator: {install('report')}"
    for file in files:
        if extension(file.path) in _DISPLAY and not _unlike(files):
            yield f"{file.path} is made for displays: its values are taken as they are, and may not be linear"
        if file is not truth and _same_seed(file, truth) and not np.array_equal(file.image, truth.image):
            yield (
                f"{file.path} and {truth.path} have a seed in common: they are not independent. "
                "No noise is subtracted, and bias is not tested; render one with another --seed"
            )
    if len({(file.picture.window.x, file.picture.window.y) for file in files}) > 1:
        yield "the files lie at different places in the film"
    yield from different_problems([(file.path, file.picture.record) for file in files])
