"""Pictures of a scene at equal time: images with crops, maps of variances, errors, standard errors, sample counts."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from equaltime.experiments.model.summary import SceneResult, StrategyResult
from equaltime.experiments.report.captions import mean_of_runs, this_run
from equaltime.experiments.report.looks import Style
from equaltime.experiments.report.pictures import (
    Bar,
    Pictures,
    colour_bar,
    coloured,
    data_uri,
    error_map,
    spread_map,
)
from equaltime.experiments.report.words import percent
from equaltime.images.log_scale import LogScale
from equaltime.images.preview import reduced, srgb_bytes
from equaltime.images.variance_picture import scale_of
from equaltime.statistics.in_words import figure

__all__ = ["Crop", "Frame", "Series", "Window", "choose_crops", "kinds_of"]

Floats = NDArray[np.float64]
Window = tuple[int, int, int, int]

_LONGEST_CROP = 160
_ERRORS = "magma"
_DECADES = 2.0
"""Length of the scale of errors, in powers of ten."""
_COUNTS = "cividis"
_VARIANCES = "gray_r"


@dataclass(frozen=True)
class Crop:
    """An enlarged window of an image, for a page."""

    uri: str
    """The enlarged window as a PNG in a data URI."""
    window: tuple[int, int, int, int]
    """Window of the image: x, y, width, height in pixels."""


@dataclass(frozen=True)
class Frame:
    """One picture of a series; the page shows one picture of a series at a time."""

    label: str
    look: Style | None
    """Colour, marker and line style of the strategy; None for the reference."""
    uri: str
    alt: str
    caption: str
    crops: tuple[Crop, ...] = ()

    @property
    def key(self) -> str:
        """Text that identifies the picture in its series, even if a strategy is labelled "reference"."""
        return f"strategy {self.label}" if self.look else "reference"


@dataclass(frozen=True)
class Series:
    """A series of pictures, one per strategy: all are images, or all are maps of one quantity."""

    name: str
    slug: str
    """Name of the series, made safe for ids in the page."""
    explanation: str
    bar: Bar | None
    """Colour bar of the maps; None for images."""
    frames: tuple[Frame, ...]


def kinds_of(scene: SceneResult, pictures: Pictures, looks: Mapping[str, Style], longest: int) -> tuple[Series, ...]:
    """Return the series of pictures of a scene: images, maps of variances, errors, standard errors, sample counts.

    Each series has one picture per strategy, the best strategy first; the series of images begins with the reference.
    Variances are left out if no renderer reports them, and sample counts if each strategy has one count in all pixels.
    Pictures with a side longer than ``longest`` pixels are reduced by averaging blocks of pixels. Crops are never
    reduced. ``looks`` gives colour, marker and line style by label of a strategy.
    """
    shown = [strategy for strategy in _best_first(scene) if strategy.label in pictures.runs]
    if not shown:
        return ()
    pixels = pictures.squares
    shape = pictures.reference.mean.shape[:2]
    crops = _inside(scene.crops, shape) or choose_crops(pixels, shape)
    errors = {label: error_map(own) for label, own in pixels.items()}
    spreads = {label: spread_map(runs, pictures.own[label]) for label, runs in pictures.runs.items()}
    found = [_images(scene, shown, pictures, looks, crops, longest)]
    if any(np.isfinite(variance).any() for variance in pictures.variances.values()):
        found.append(_variances(shown, pictures, looks, longest))
    scale = LogScale.of(errors.values(), _DECADES)
    bar = Bar(colour_bar(_ERRORS), (percent(scale.low), percent(scale.middle), percent(scale.high)))

    def paint(values: Floats) -> NDArray[np.uint8]:
        return coloured(np.sqrt(reduced(values**2, longest)), scale.low, scale.high, _ERRORS)

    means = {strategy.label: mean_of_runs(strategy) or this_run(strategy) for strategy in shown}
    found.append(_maps("Error", _ERROR_WORDS, bar, means, errors, paint, looks))
    known = {one.label: spread for one in shown if (spread := spreads[one.label]) is not None}
    typical = {label: f"standard error {_root_mean(own)}" for label, own in known.items()}
    if known:
        found.append(_maps("Standard error", _SPREAD_WORDS, bar, typical, known, paint, looks))
    if any(np.ptp(pictures.samples[strategy.label]) > 0.0 for strategy in shown):
        found.append(_counts(shown, pictures, looks, longest))
    return tuple(found)


def _best_first(scene: SceneResult) -> list[StrategyResult]:
    """Return the strategies with the scene's standard first, else the one with the smallest error at equal time."""

    def place(strategy: StrategyResult) -> tuple[bool, float]:
        error = strategy.error_at_budget.value
        return strategy.label != scene.standard, error if math.isfinite(error) else math.inf

    best = sorted(scene.strategies, key=place)[:1]
    return [*best, *(strategy for strategy in scene.strategies if strategy not in best)]


_IMAGE_WORDS = (
    "Each picture is one run: the first of its strategy, at its end. Its caption gives the relative error of this run, "
    "and the mean of all runs: the root mean square, which is the last point of the strategy's curve. Tables "
    "compare errors at equal time, which may be another time."
)
_ERROR_WORDS = (
    "Relative error of each pixel at the end of the runs: the root mean square of all runs, with the reference's own "
    "noise subtracted. The captions give that of all pixels. The colours are the same for all strategies."
)
_SPREAD_WORDS = (
    "Typical distance of a pixel of one run from the mean of all runs, relative and coloured as the error is. The "
    "captions give the root mean square over all pixels. Where the error is clearly larger, all runs differ from the "
    "reference alike: the strategy is biased there, or the runs or the reference lack light."
)
_VARIANCE_WORDS = (
    "Variance of one sample of each pixel, in squared units of the image: the mean of all repeats. Darker is higher, "
    "on one scale for all strategies, from {low} (white) or less to {high} (black) or more. The variance shows where "
    "light is hard to find, whatever the number of samples."
)
_COUNT_WORDS = "Samples of each pixel at the end of the run that is shown."


def choose_crops(pixels: Mapping[str, Floats], shape: tuple[int, ...], count: int = 2) -> tuple[Window, ...]:
    """Return the square windows in which the strategies' errors differ most, to show them enlarged.

    The windows (x, y, width, height) do not overlap.

    Parameters
    ----------
    pixels
        Squared errors of each strategy's pixels in K repeats, (K, H, W), by label.
    shape
        Height and width of the image, in pixels.
    count
        Largest number of windows.
    """
    side = max(1, min(min(shape), _LONGEST_CROP, round(max(shape) / 6)))
    sums = [_window_means(np.maximum(own.mean(axis=0), 0.0), side) for own in pixels.values()]
    floor = 1e-3 * max(float(values.max()) for values in sums) + 1e-30
    score = np.std([np.log(values + floor) for values in sums], axis=0) * np.sqrt(np.max(sums, axis=0) + floor)
    chosen: list[Window] = []
    while len(chosen) < count and np.isfinite(score).any():
        y, x = (int(place) for place in np.unravel_index(int(np.argmax(score)), score.shape))
        chosen.append((x, y, side, side))
        apart = side + side // 2
        score[max(0, y - apart) : y + apart, max(0, x - apart) : x + apart] = -np.inf
    return tuple(chosen)


def _inside(crops: Sequence[Window], shape: tuple[int, ...]) -> tuple[Window, ...]:
    """Cut windows at the image's border, and drop windows outside it: an experiment's scenes differ in size."""
    height, width = shape
    cut = ((x, y, min(w, width - x), min(h, height - y)) for x, y, w, h in crops)
    return tuple(window for window in cut if min(window[2:]) > 0)


def _window_means(values: Floats, side: int) -> Floats:
    """Return the mean of every square window (H - side + 1, W - side + 1), from a summed-area table."""
    area = np.pad(values, ((1, 0), (1, 0))).cumsum(axis=0).cumsum(axis=1)
    total = area[side:, side:] - area[:-side, side:] - area[side:, :-side] + area[:-side, :-side]
    return np.asarray(np.maximum(total / side**2, 0.0))


def _images(
    scene: SceneResult,
    shown: Sequence[StrategyResult],
    pictures: Pictures,
    looks: Mapping[str, Style],
    crops: Sequence[Window],
    longest: int,
) -> Series:
    reference = pictures.reference.mean
    height, width = reference.shape[:2]
    caption = f"its own error: {percent(scene.reference_error)}" if scene.reference_error > 0.0 else "taken as exact"

    def frame(label: str, look: Style | None, image: NDArray[Any], alt: str, caption: str) -> Frame:
        cut = ((image[y : y + h, x : x + w], (x, y, w, h)) for x, y, w, h in crops)
        shown_crops = tuple(Crop(data_uri(srgb_bytes(part, pictures.stops)), window) for part, window in cut)
        uri = data_uri(srgb_bytes(reduced(image, longest), pictures.stops))
        return Frame(label, look, uri, alt, caption, shown_crops)

    frames = [frame("reference", None, reference, f"{scene.name}: reference", caption)]
    for strategy in shown:
        image, alt = pictures.runs[strategy.label][0], f"{scene.name} rendered by {strategy.label}"
        said = "; ".join(filter(None, (this_run(strategy), mean_of_runs(strategy))))
        frames.append(frame(strategy.label, looks[strategy.label], image, alt, said))
    exposure = f" ({pictures.stops:+g} stops)" if pictures.stops else ""
    words = [_IMAGE_WORDS, f"All pictures have the same exposure{exposure}."]
    if max(width, height) > longest:
        words.append("The whole image is shown reduced, which hides noise; the crops have every pixel.")
    return Series("Image", "image", " ".join(words), None, tuple(frames))


def _maps(
    name: str,
    words: str,
    bar: Bar,
    captions: Mapping[str, str],
    maps: Mapping[str, Floats],
    paint: Callable[[Floats], NDArray[np.uint8]],
    looks: Mapping[str, Style],
) -> Series:
    """Return a series of maps in the order of ``captions``, which are by label as the maps are."""
    frames = [
        Frame(label, looks[label], data_uri(paint(maps[label])), f"{name} map of {label}; {caption}", caption)
        for label, caption in captions.items()
    ]
    return Series(name, name.lower().replace(" ", "-"), words, bar, tuple(frames))


def _root_mean(values: Floats) -> str:
    return percent(float(np.sqrt(np.mean(values**2))))


def _variances(shown: Sequence[StrategyResult], pictures: Pictures, looks: Mapping[str, Style], longest: int) -> Series:
    """Return maps of the variance of one sample, of the strategies that tell it."""
    scale = scale_of(pictures.variances.values())
    frames = []
    for strategy in shown:
        if (values := pictures.variances.get(strategy.label)) is None:
            continue
        known = values[np.isfinite(values)]
        caption = f"mean {figure(float(known.mean()))}" if known.size else "not known"
        uri = data_uri(coloured(reduced(values, longest), scale.low, scale.high, _VARIANCES))
        alt = f"Variance map of {strategy.label}: {caption}"
        frames.append(Frame(strategy.label, looks[strategy.label], uri, alt, caption))
    bar = Bar(colour_bar(_VARIANCES), scale.ticks)
    low, _, high = scale.ticks
    return Series("Variance", "variance", _VARIANCE_WORDS.format(low=low, high=high), bar, tuple(frames))


def _counts(shown: Sequence[StrategyResult], pictures: Pictures, looks: Mapping[str, Style], longest: int) -> Series:
    """Return maps of sample counts; a strategy with equal counts in all pixels gives a uniform map."""
    maps = {strategy.label: np.maximum(pictures.samples[strategy.label], 1.0) for strategy in shown}
    low = min(float(values.min()) for values in maps.values())
    high = max(max(float(values.max()) for values in maps.values()), 2.0 * low)
    frames = []
    for strategy in shown:
        values = maps[strategy.label]
        least, most = int(values.min()), int(values.max())
        caption = f"{least} everywhere" if least == most else f"{least} to {most}, mean {values.mean():.1f}"
        uri = data_uri(coloured(reduced(values, longest), low, high, _COUNTS))
        alt = f"Sample-count map of {strategy.label}: {caption}"
        frames.append(Frame(strategy.label, looks[strategy.label], uri, alt, caption))
    bar = Bar(colour_bar(_COUNTS), (f"{low:.0f}", f"{(low * high) ** 0.5:.0f}", f"{high:.0f}"))
    return Series("Samples", "samples", _COUNT_WORDS, bar, tuple(frames))
