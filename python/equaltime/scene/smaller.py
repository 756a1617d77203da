"""Scenes on a film with fewer pixels, for pilots (short renders that predict): the same view and crop window."""

from __future__ import annotations

import math

from equaltime.scene.scene import Scene

__all__ = ["smaller", "smaller_film"]

Size = tuple[int, int]
Crop = tuple[int, int, int, int]


def smaller(scene: Scene, most: float) -> Scene:
    """Return the scene with about `most` pixels in its crop window.

    If the crop window of `scene` has `most` pixels or fewer, return `scene` itself.
    """
    crop = scene.model.sensor.film.crop
    scale = math.sqrt(most / (crop[2] * crop[3]))
    if scale >= 1.0:
        return scene
    size, window = smaller_film(scene.size, crop, scale)
    return scene.with_(size=size, crop=window)


def smaller_film(size: Size, crop: Crop, scale: float) -> tuple[Size, Crop]:
    """Return a film's size (width, height) and crop window (x, y, width, height), scaled by `scale`.

    All numbers are whole pixels. Each side keeps at least one pixel.
    """
    (across, left, columns), (down, top, rows) = (
        _scaled(scale, *axis) for axis in zip(size, crop[:2], crop[2:], strict=True)
    )
    return (across, down), (left, top, columns, rows)


def _scaled(scale: float, length: int, start: int, extent: int) -> tuple[int, int, int]:
    """Return, scaled, a film's length along one axis, and the start and the extent of its crop window."""
    small = max(1, math.floor(length * scale + 1e-9))
    begin = min(round(start * scale), small - 1)
    end = min(small, max(begin + 1, round((start + extent) * scale)))
    return small, begin, end - begin
