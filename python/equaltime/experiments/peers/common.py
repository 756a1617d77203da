"""Functions that all peers (other renderers) share: box-filtered scenes, seeds, and checks of images."""

from __future__ import annotations

import dataclasses
import hashlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

from equaltime.errors import PeerError
from equaltime.scene import Scene
from equaltime.scene.model import Box

__all__ = ["checked_image", "render_seed", "uneven_samples", "with_box_filter"]


def with_box_filter(scene: Scene) -> Scene:
    """Return the scene with a box filter, the only filter for which all renderers have the same expected image.

    With wider filters, some renderers splat samples, which correlates pixels. Renderers also weight the image border
    differently.
    """
    sensor = scene.model.sensor
    if isinstance(sensor.film.rfilter, Box):
        return scene
    film = sensor.film.replace(rfilter=Box())
    return dataclasses.replace(scene, model=scene.model.replace(sensor=sensor.replace(film=film)))


def checked_image(image: NDArray[Any], scene: Scene, who: str) -> NDArray[np.float32]:
    """Return an image of a peer (another renderer) as float32 (H, W, 3), after checking it.

    An image of the whole film is cut to the scene's crop window. ``who`` names the peer in errors. Raises PeerError for
    an image of another size or with a pixel that is not finite.
    """
    (x, y, width, height), (full_width, full_height) = scene.model.sensor.film.crop, scene.size
    if image.shape == (full_height, full_width, 3):
        image = image[y : y + height, x : x + width]
    if image.shape != (height, width, 3):
        found = "x".join(map(str, image.shape[1::-1])) + (f" with {image.shape[2]} channels" if image.ndim > 2 else "")
        raise PeerError(f"{who}: expected an image of {width}x{height} with 3 channels, found {found}")
    finite = np.isfinite(image).all(axis=2)
    if not finite.all():
        row, column = np.argwhere(~finite)[0]
        count = f"{finite.size - np.count_nonzero(finite)} of {finite.size} pixels are not finite"
        raise PeerError(f"{who}: {count}; the first is ({column}, {row}): {image[row, column].tolist()}")
    return np.ascontiguousarray(image, dtype=np.float32)


def uneven_samples(samples: NDArray[np.int64] | None, scene: Scene) -> NDArray[np.int64] | None:
    """Return the sample count of each pixel of a peer's image (H, W), cut to the scene's crop window.

    A peer is another renderer. Returns None without counts, if all counts are equal, or if their array has another size
    than the image.
    """
    (x, y, width, height), (full_width, full_height) = scene.model.sensor.film.crop, scene.size
    if samples is not None and samples.shape == (full_height, full_width):
        samples = samples[y : y + height, x : x + width]
    if samples is None or samples.shape != (height, width) or (samples == samples[0, 0]).all():
        return None
    return np.ascontiguousarray(samples)


def render_seed(seed: int, spp: int) -> int:
    """Return the seed of one render of a run: a 31-bit hash of the run's seed and the samples per pixel."""
    content = hashlib.blake2b(f"{seed} {spp}".encode(), digest_size=4)
    return int.from_bytes(content.digest(), "little") >> 1
