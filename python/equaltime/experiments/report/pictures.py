"""Images of a report, read from the files that a summary names and converted to PNG for the page."""

from __future__ import annotations

import base64
import io
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from equaltime.errors import EqualtimeError, ImageError
from equaltime.experiments.model.summary import SceneResult, StrategyResult
from equaltime.experiments.run.folder import read_array
from equaltime.experiments.run.reference import read
from equaltime.extras import optional
from equaltime.images import image_files as images
from equaltime.images.exposure import automatic_stops
from equaltime.images.log_scale import LogScale
from equaltime.images.metrics import Reference, contributions

__all__ = [
    "Bar",
    "Pictures",
    "colour_bar",
    "coloured",
    "data_uri",
    "error_map",
    "load_pictures",
    "spread_map",
    "squares",
]

Floats = NDArray[np.float64]
Images = NDArray[np.float32]
Bytes = NDArray[np.uint8]


@dataclass(frozen=True, eq=False)
class Pictures:
    """Images of one scene that a report shows and computes maps from, in linear RGB: those that could be read."""

    reference: Reference
    own: Mapping[str, Reference]
    """Reference with which each strategy is compared, by label: the scene's, or one for the strategy's renderer alone.
    """
    runs: Mapping[str, Images]
    """Final images of each strategy's K repeats, (K, H, W, 3), by label of the strategy; float32 saves memory."""
    samples: Mapping[str, Floats]
    """Number of samples of each pixel, (H, W), by label of the strategy."""
    variances: Mapping[str, Floats]
    """Variance of one sample of each pixel, (H, W), by label of the strategy, as the mean of the repeats; infinite in
    pixels where a repeat does not know the variance. Strategies whose renderer does not report the variance are left
    out."""
    stops: float
    """Exposure of all images: linear values are multiplied by 2 to this power."""
    missing: tuple[str, ...]
    """One sentence for each strategy whose images could not be read."""

    @property
    def squares(self) -> dict[str, Floats]:
        """Relative squared error of each pixel in each of K runs, (K, H, W), by label of the strategy."""
        return {label: squares(runs, self.own[label]) for label, runs in self.runs.items()}


def load_pictures(scene: SceneResult) -> Pictures | str:
    """Return the images of a scene, read from files; without a readable reference, return a sentence that says why."""
    if scene.reference is None:
        return "The records name no reference image, so nothing can be shown beside it."
    try:
        reference = read(scene.reference).reference
    except EqualtimeError as error:
        return f"The reference cannot be shown: {error}"
    shape = reference.mean.shape
    runs: dict[str, Images] = {}
    samples: dict[str, Floats] = {}
    variances: dict[str, Floats] = {}
    own: dict[str, Reference] = {}
    missing = []
    for strategy in scene.strategies:
        label = strategy.label
        try:
            own[label] = reference if strategy.reference is None else read(strategy.reference).reference
            samples[label] = _read_samples(strategy, shape[:2])
            if strategy.variances:
                variances[label] = _read_variance(strategy, shape[:2])
            runs[label] = _read_runs(strategy, shape)
        except EqualtimeError as error:
            missing.append(f"There is no picture of {label}: {error}")
    return Pictures(reference, own, runs, samples, variances, automatic_stops(reference.mean), tuple(missing))


def squares(runs: NDArray[Any], reference: Reference) -> Floats:
    """Return the relative squared error of each pixel of K images, (K, H, W); ``runs`` are the images, (K, H, W, 3).

    The reference's own noise is subtracted, so that a value may be negative by chance.
    """
    return np.stack([contributions(run, reference) for run in runs])


def error_map(pixels: Floats) -> Floats:
    """Return the relative error of each pixel (H, W): the root of its mean squared error over K runs.

    ``pixels`` are the relative squared errors of the pixels in K runs, (K, H, W).
    """
    return np.asarray(np.sqrt(np.maximum(pixels.mean(axis=0), 0.0)))


def spread_map(runs: NDArray[Any], reference: Reference) -> Floats | None:
    """Return the relative standard error of each pixel of one run (H, W); None for fewer than two runs.

    The estimate comes from the spread over the K images in ``runs`` (K, H, W, 3). Errors are relative to ``reference``.
    """
    if len(runs) < 2:
        return None
    with np.errstate(divide="ignore", invalid="ignore"):
        relative = runs.var(axis=0, ddof=1, dtype=np.float64) / reference.denominator
    return np.asarray(np.sqrt(np.nan_to_num(relative, posinf=0.0).mean(axis=2)))


def coloured(values: Floats, low: float, high: float, colours: str) -> Bytes:
    """Colour values (H, W) by the Matplotlib colour map named ``colours``, and return sRGB bytes (H, W, 3).

    The scale is logarithmic from ``low`` to ``high``.
    """
    # 64 colours: noise in full colour compresses badly, and a hundredth of the range is invisible
    steps = np.round(LogScale(low, high).position(values) * 63.0) / 63.0
    return np.asarray(optional("matplotlib").colormaps[colours](steps, bytes=True)[..., :3])


@dataclass(frozen=True)
class Bar:
    """Colour bar beside maps: evenly spaced colours, and labels of low end, middle and high end."""

    colours: tuple[str, ...]
    ticks: tuple[str, ...]


def colour_bar(colours: str, steps: int = 9) -> tuple[str, ...]:
    """Return ``steps`` evenly spaced colours of the Matplotlib colour map named ``colours``, as ``#rrggbb``."""
    return tuple(
        optional("matplotlib.colors").to_hex(colour)
        for colour in optional("matplotlib").colormaps[colours](np.linspace(0.0, 1.0, steps))
    )


def data_uri(pixels: Bytes) -> str:
    """Encode sRGB bytes (H, W, 3) as PNG, and return the PNG as a data URI for an HTML page."""
    file = io.BytesIO()
    optional("PIL.Image").fromarray(pixels).save(file, "PNG")
    return "data:image/png;base64," + base64.b64encode(file.getvalue()).decode()


def _read_runs(strategy: StrategyResult, shape: tuple[int, ...]) -> Images:
    paths = strategy.images or ((strategy.image,) if strategy.image else ())
    if not paths:
        raise ImageError("the records name none")
    return np.stack([_read_image(path, shape) for path in paths])


def _read_samples(strategy: StrategyResult, shape: tuple[int, ...]) -> Floats:
    if strategy.samples is None:
        return np.full(shape, float(strategy.curve.spp[-1]) if strategy.curve.spp else math.nan)
    return _read_image(strategy.samples, shape).astype(np.float64)


def _read_variance(strategy: StrategyResult, shape: tuple[int, ...]) -> Floats:
    try:
        repeats = [read_array(path, shape, infinite=True) for path in strategy.variances]
    except FileNotFoundError as error:
        raise ImageError(f"{error.filename}: {error.strerror}") from error
    return np.asarray(np.mean(repeats, axis=0, dtype=np.float64))


def _read_image(path: Path, shape: tuple[int, ...]) -> Images:
    try:
        image = images.read(path).image if path.suffix != ".npy" else read_array(path, shape)
    except FileNotFoundError as error:
        raise ImageError(f"{path}: {error.strerror}") from error
    if image.shape != shape:
        raise ImageError(f"{path}: has shape {image.shape}, not {shape}")
    return np.asarray(image, np.float32)
