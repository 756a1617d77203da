"""The images that a report is made of: read from the files that a summary names, written as PNG into the page."""

from __future__ import annotations

import base64
import math
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from equaltime.errors import EqualtimeError, ImageError
from equaltime.experiments.model.summary import SceneResult, StrategyResult
from equaltime.experiments.report.maps import squares
from equaltime.experiments.run.arrays import read_array
from equaltime.experiments.run.reference import read
from equaltime.extras import optional
from equaltime.images import image_files as images
from equaltime.images import preview
from equaltime.images.metrics import Reference

__all__ = ["Pictures", "coloured", "data_uri", "exposed", "load_pictures"]

Floats = NDArray[np.float64]
Images = NDArray[np.float32]
Bytes = NDArray[np.uint8]


@dataclass(frozen=True, eq=False)
class Pictures:
    """All images of one scene, linear RGB; what could not be read is left out and said."""

    reference: Reference
    own: Mapping[str, Reference]
    """Label → what the strategy is held against: the reference, or one of its own."""
    runs: Mapping[str, Images]
    """Label → final images of its repeats (K, H, W, 3), in float32: of large images they are much to hold."""
    samples: Mapping[str, Floats]
    """Label → samples of each pixel (H, W)."""
    stops: int
    """Exposure at which all of them are shown: linear values times 2 to this power."""
    missing: tuple[str, ...]
    """What could not be read, one sentence each."""

    @property
    def squares(self) -> dict[str, Floats]:
        """Label → relative squared errors of each run's pixels (K, H, W)."""
        return {label: squares(runs, self.own[label]) for label, runs in self.runs.items()}


def load_pictures(scene: SceneResult) -> Pictures | str:
    """Read the images of a scene, or say in a sentence why it has none to show."""
    if scene.reference is None:
        return "The records name no reference image, so nothing can be shown beside it."
    try:
        reference = read(scene.reference).reference
    except EqualtimeError as error:
        return f"The reference cannot be shown: {error}"
    shape = reference.mean.shape
    runs: dict[str, Images] = {}
    samples: dict[str, Floats] = {}
    own: dict[str, Reference] = {}
    missing = []
    for strategy in scene.strategies:
        label = strategy.label
        try:
            own[label] = reference if strategy.reference is None else read(strategy.reference).reference
            samples[label] = _read_samples(strategy, shape[:2])
            runs[label] = _read_runs(strategy, shape)
        except EqualtimeError as error:
            missing.append(f"Of {label} there is no picture: {error}")
    return Pictures(reference, own, runs, samples, _stops(reference.mean), tuple(missing))


def exposed(image: NDArray[Any], stops: int) -> Bytes:
    """Return the bytes in which a linear image is shown."""
    return preview.srgb_bytes(image.astype(np.float64) * 2.0**stops)


def coloured(values: Floats, low: float, high: float, colours: str) -> Bytes:
    """Colour (H, W) values by a Matplotlib colour map, logarithmically from ``low`` to ``high``."""
    position = np.log(np.maximum(values, low) / low) / math.log(high / low)
    # few colours, since noise in full colour compresses badly and nobody sees a hundredth of the range
    steps = np.round(np.clip(np.nan_to_num(position, nan=0.0), 0.0, 1.0) * 63.0) / 63.0
    return np.asarray(optional("matplotlib").colormaps[colours](steps, bytes=True)[..., :3])


def data_uri(pixels: Bytes) -> str:
    """Return (H, W, 3) bytes as a PNG in an address that holds it all."""
    with tempfile.TemporaryDirectory(prefix="equaltime-") as folder:
        path = Path(folder) / "picture.png"
        images.write(path, "png", [images.Part(("R", "G", "B"), pixels, {"oiio:ColorSpace": "sRGB"})])
        return "data:image/png;base64," + base64.b64encode(path.read_bytes()).decode()


def _read_runs(strategy: StrategyResult, shape: tuple[int, ...]) -> Images:
    paths = strategy.images or ((strategy.image,) if strategy.image else ())
    if not paths:
        raise ImageError("the records name none")
    return np.stack([_read_image(path, shape) for path in paths])


def _read_samples(strategy: StrategyResult, shape: tuple[int, ...]) -> Floats:
    if strategy.samples is None:
        return np.full(shape, float(strategy.curve.spp[-1]) if strategy.curve.spp else math.nan)
    return _read_image(strategy.samples, shape).astype(np.float64)


def _read_image(path: Path, shape: tuple[int, ...]) -> Images:
    try:
        image = images.read(path).image if path.suffix != ".npy" else read_array(path, shape)
    except FileNotFoundError as error:
        raise ImageError(f"{path}: {error.strerror}") from error
    if image.shape != shape:
        raise ImageError(f"{path}: has shape {image.shape}, not {shape}")
    return np.asarray(image, np.float32)


def _stops(mean: Floats) -> int:
    """Choose the exposure: none, unless nearly all of the reference would be black or white."""
    bright = float(np.percentile(mean.mean(axis=2), 90.0))
    wanted = -math.log2(bright) - 0.5 if bright > 0.0 and math.isfinite(bright) else 0.0
    return 0 if abs(wanted) < 2.0 else round(wanted)
