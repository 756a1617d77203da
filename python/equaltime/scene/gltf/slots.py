"""Slots: the parameters of glTF materials. A slot is a constant factor times some channels of a texture.

glTF packs several parameters into one image, such as roughness and metalness, or opacity and colour. Each parameter
becomes a bitmap of its own, multiplied by its factor. Eight-bit images stay eight-bit if their values do not change.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from equaltime.scene.picture_colors import linear_of_srgb
from equaltime.scene.pictures import Texels

__all__ = ["Slot", "TextureUse", "faded", "mask", "texture_use"]

Array = NDArray[Any]
FINEST_MASK = 4096
"""Longest side, in texels, to which a mask is enlarged, so that the edges of holes are smooth."""
ALPHA = (3,)
THINNEST = 1e-9
"""Scale of texture coordinates that replaces 0. Coordinates up to a million stay within a thousandth of a texture."""


@dataclass(frozen=True, slots=True)
class TextureUse:
    """A textureInfo object of glTF: how a material uses a texture, with a transform of the texture coordinates."""

    index: int
    """Index of the texture in the file."""
    uv_set: int = 0
    """Index of the set of texture coordinates."""
    offset: tuple[float, float] = (0.0, 0.0)
    """Offset of the texture coordinates u and v."""
    rotation: float = 0.0
    """Rotation of the texture coordinates, in radians."""
    scale: tuple[float, float] = (1.0, 1.0)
    """Scale of the texture coordinates u and v."""
    strength: float = 1.0
    """Factor on the x and y components of a normal texture: glTF's ``scale``."""

    @property
    def to_uv(self) -> NDArray[np.float64]:
        """Transform (4, 4) of the texture coordinates, for the parameter ``to_uv`` of the plugin `bitmap`.

        Coordinates are scaled, then rotated, then offset. The rotation is counter-clockwise as seen in the picture,
        with v downwards.
        """
        sine, cosine = math.sin(self.rotation), math.cos(self.rotation)
        result = np.eye(4)
        result[:2, :2] = np.array([[cosine, sine], [-sine, cosine]]) * self._sizes
        result[:2, 3] = self.offset
        return result

    @property
    def normal_turn(self) -> NDArray[np.float64]:
        """Matrix (2, 2) for x and y of a normal texture, from its own axes to the axes of the texture coordinates.

        The image is seen turned or mirrored by `to_uv`, and so are the slopes in it.
        """
        sine, cosine = math.sin(self.rotation), math.cos(self.rotation)
        width, height = self._sizes
        right, up = cosine / width, -sine / height  # direction to the right in the image
        length, side = math.hypot(right, up), math.copysign(1.0, width * height)
        return np.array([[right, -up * side], [up, right * side]]) / length

    @property
    def _sizes(self) -> tuple[float, float]:
        """`scale`, with `THINNEST` instead of 0, because a transform must be invertible."""
        width, height = self.scale
        return width or THINNEST, height or THINNEST


def texture_use(info: Any) -> TextureUse | None:
    """Convert a textureInfo object of glTF to a `TextureUse`. None stays None.

    `info` is an object of pygltflib, or a mapping if the textureInfo is inside an extension.
    """
    if info is None:
        return None
    fields: Mapping[str, Any] = info if isinstance(info, Mapping) else vars(info)
    transform = (fields.get("extensions") or {}).get("KHR_texture_transform", {})
    u, v = transform.get("offset", (0.0, 0.0))
    width, height = transform.get("scale", (1.0, 1.0))
    strength = fields.get("scale")
    return TextureUse(
        int(fields["index"]),
        int(transform.get("texCoord", fields.get("texCoord") or 0)),
        (float(u), float(v)),
        float(transform.get("rotation", 0.0)),
        (float(width), float(height)),
        1.0 if strength is None else float(strength),
    )


@dataclass(frozen=True, slots=True)
class Slot:
    """One parameter of a glTF material: a constant factor times some channels of a texture, if there is one."""

    factor: tuple[float, ...]
    """Constant factor: one number, or a colour."""
    texture: TextureUse | None = None
    channels: tuple[int, ...] = (0, 1, 2)
    """Indices of the texture's channels that are used, as many as the factor has numbers."""
    encoded: bool = False
    """True if integer texels are encoded as sRGB."""
    curve: Callable[[Array], Array] | None = None
    """Function applied to the product of factor and texture (..., channels); the result has 1 or 3 channels."""
    cutoff: float | None = None
    """Threshold that makes the parameter a mask: 1 where the value is at least the threshold, else 0; None: no mask."""

    @property
    def constant(self) -> tuple[float, ...]:
        """Value of the parameter without its texture: one number, or the channels of a colour."""
        value = np.array(self.factor)
        if self.curve is not None:
            value = self.curve(value)
        if self.cutoff is not None:
            value = (value >= self.cutoff).astype(np.float64)
        return tuple(value.tolist())

    @property
    def plain(self) -> bool:
        """Whether the texture's channels are the parameter's value: all factors are 1, without curve and cutoff."""
        return self.curve is None and self.cutoff is None and all(f == 1.0 for f in self.factor)

    @property
    def raw(self) -> bool:
        """Value of the parameter ``raw`` of the plugin `bitmap`: True if its texels must not be decoded from sRGB.

        It is False for texels that may be encoded as sRGB and come unchanged from the image.
        """
        return not (self.encoded and self.plain)

    @np.errstate(over="ignore", invalid="ignore")  # `bake` refuses texels that are not finite
    def texels(self, pixels: Array, wrap_mode: str, filter_type: str) -> Texels:
        """Return the bitmap of this parameter, computed from the pixels (H, W, 4) of the texture's image.

        The texture's sampler gives `wrap_mode` and `filter_type`, which are parameters of the plugin `bitmap`.
        """
        picked = pixels[..., list(self.channels)]
        if self.plain and picked.dtype == np.uint8:
            return Texels(np.ascontiguousarray(picked), self.encoded)
        values = _decoded(picked, self.encoded)
        if self.encoded and self.channels[-1:] == ALPHA:
            values[..., -1] = _decoded(picked[..., -1], False)
        if self.plain:
            return Texels(np.ascontiguousarray(values), False)
        values = values * np.array(self.factor).astype(np.float32)
        if self.curve is not None:
            values = self.curve(values)
        if self.cutoff is not None:
            return Texels(mask(values, min(self.cutoff, 2.0), wrap_mode, filter_type), False)
        half = pixels.dtype == np.uint8 and float(np.abs(values).max(initial=0.0)) < np.finfo(np.float16).max
        return Texels(np.ascontiguousarray(values, np.float16 if half else np.float32), False)


def _decoded(pixels: Array, encoded: bool) -> NDArray[np.float32]:
    """Return texels as linear float32 values."""
    if not np.issubdtype(pixels.dtype, np.integer):
        return pixels.astype(np.float32)
    values = np.linspace(0.0, 1.0, int(np.iinfo(pixels.dtype).max) + 1)
    if encoded:
        values = linear_of_srgb(values)
    table: NDArray[np.float32] = values.astype(np.float32)
    return table[pixels]


def faded(light: Slot, opacity: Slot) -> Slot | None:
    """Return the emission `light` multiplied by the opacity `opacity`, as one parameter (slot) of a material.

    Returns None if `light` and `opacity` have different textures.
    """
    cutoff, (alpha,) = opacity.cutoff, opacity.factor

    def seen(values: Array) -> Array:
        return values if cutoff is None else (values >= cutoff).astype(values.dtype)

    if opacity.texture is None:
        return replace(light, factor=tuple(c * opacity.constant[0] for c in light.factor))
    if light.texture is None:
        color = np.array(light.factor, np.float32)
        return Slot((alpha,), opacity.texture, ALPHA, curve=lambda a: seen(a) * color)
    if light.texture != opacity.texture:
        return None
    channels = (*light.channels, *ALPHA)
    return replace(
        light,
        factor=(*light.factor, alpha),
        channels=channels,
        curve=lambda values: np.asarray(values[..., :-1] * seen(values[..., -1:])),
    )


def mask(values: NDArray[np.float32], cutoff: float, wrap_mode: str, filter_type: str) -> NDArray[np.uint8]:
    """Return a mask on a finer grid: 255 where the interpolated `values` (H, W, 1) are at least `cutoff`, else 0.

    `wrap_mode` and `filter_type` are parameters of the plugin `bitmap`. Without interpolation
    ("nearest"), the mask has the grid of `values`.

    glTF interpolates first and then applies the cutoff, but a bitmap can only interpolate after the cutoff. This
    function therefore interpolates, with up to four times as many texels per side. The bitmap of the mask is then
    looked up without interpolation.
    """
    height, width, _ = values.shape
    coarse = np.all((values == values.min()) | (values == values.max())) and max(height, width) >= FINEST_MASK
    if coarse or filter_type == "nearest":
        return np.where(values >= cutoff, 255, 0).astype(np.uint8)
    times = max(1, min(4, FINEST_MASK // max(height, width)))
    fine = _finer(_finer(values, times, 0, wrap_mode), times, 1, wrap_mode)
    return np.where(fine >= cutoff, 255, 0).astype(np.uint8)


def _finer(values: Array, times: int, axis: int, wrap_mode: str) -> Array:
    """Return values interpolated linearly along an axis, at `times` as many places.

    Beyond the border, a repeated texture goes on with the texels of its other side. Any other repeats its last texel.
    """
    count = values.shape[axis]
    place = (np.arange(count * times) + 0.5) / times - 0.5
    low = np.floor(place).astype(np.intp)
    weight = (place - low).astype(np.float32)
    shape = [1] * values.ndim
    shape[axis] = -1
    beyond: Literal["wrap", "clip"] = "wrap" if wrap_mode == "repeat" else "clip"
    before, after = (values.take(at, axis=axis, mode=beyond) for at in (low, low + 1))
    finer: Array = before * (1 - weight.reshape(shape)) + after * weight.reshape(shape)
    return finer
