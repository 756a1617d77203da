"""Film and reconstruction filters.

A sample's position is drawn from its pixel's filter, so that the sample counts for one pixel only. A filter with
negative lobes is drawn by its absolute value, and the sample weighs c or -c. Here c is the integral of the absolute
value over the integral of the filter. The mean is the filtered image, without bias, and no sample is dropped or
clamped. The signs add noise even where the image is even: sqrt(c^2 - 1) of the radiance per sample. This noise is 0.56
with ``mitchell`` (c = 1.14), 0.92 with ``catmullrom`` (1.36) and 1.6 with ``lanczos`` (1.85). The variance of the
weighted samples includes it, and so do all error bars.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar, Literal, Self

from pydantic import BeforeValidator, Field, NonNegativeInt, PositiveFloat, PositiveInt, model_validator

from equaltime.scene.model.base import Kind, Plugin
from equaltime.scene.model.values import as_lower

__all__ = ["Box", "CatmullRom", "Filter", "Gaussian", "HdrFilm", "Lanczos", "Mitchell", "Tent"]

MAX_SIDE = 1_000_000
"""Largest width or height of the film, in pixels: libpng's limit, since the preview of an image is a PNG file."""
MAX_PIXELS = 2**28
PIXEL_BYTES = 112
"""Bytes per pixel of the film: count, mean and second moment of two replicates, in double precision."""


class Box(Plugin):
    """A box, one pixel wide: all samples weigh the same."""

    kind: ClassVar[Kind] = "rfilter"
    type: Literal["box"] = "box"


class Tent(Plugin):
    """A tent that falls linearly from the middle of the pixel."""

    kind: ClassVar[Kind] = "rfilter"
    type: Literal["tent"] = "tent"
    radius: PositiveFloat = 1.0
    """Distance from the middle at which the filter reaches zero, in pixels."""


class Gaussian(Plugin):
    """A Gaussian that is cut at four standard deviations and lowered to zero there."""

    kind: ClassVar[Kind] = "rfilter"
    type: Literal["gaussian"] = "gaussian"
    stddev: PositiveFloat = 0.5
    """Standard deviation, in pixels."""


class Mitchell(Plugin):
    """A cubic spline of radius 2 that is negative at its rim (Mitchell and Netravali 1988)."""

    kind: ClassVar[Kind] = "rfilter"
    type: Literal["mitchell"] = "mitchell"
    B: float = 1.0 / 3.0
    C: float = 1.0 / 3.0


class CatmullRom(Plugin):
    """The cubic spline of radius 2 with B = 0 and C = 1/2: the sharpest of its family."""

    kind: ClassVar[Kind] = "rfilter"
    type: Literal["catmullrom"] = "catmullrom"


class Lanczos(Plugin):
    """A sinc windowed by the middle lobe of a wider sinc, ``lobes`` pixels to each side."""

    kind: ClassVar[Kind] = "rfilter"
    type: Literal["lanczos"] = "lanczos"
    lobes: PositiveInt = 3


Filter = Annotated[Box | Tent | Gaussian | Mitchell | CatmullRom | Lanczos, Field(discriminator="type")]
"""Any reconstruction filter."""


class HdrFilm(Plugin):
    """The image: its size, the part of it to render, and how samples become pixels.

    The name of the output file decides its format, whatever ``file_format`` says.
    """

    kind: ClassVar[Kind] = "film"
    roles: ClassVar[Mapping[Kind, str]] = {"rfilter": "rfilter"}
    hints: ClassVar[frozenset[str]] = frozenset(
        {"file_format", "pixel_format", "component_format", "sample_border", "compensate", "banner"}
    )

    type: Literal["hdrfilm"] = "hdrfilm"
    width: PositiveInt = 768
    height: PositiveInt = 576
    crop_offset_x: NonNegativeInt = 0
    crop_offset_y: NonNegativeInt = 0
    crop_width: PositiveInt | None = None
    crop_height: PositiveInt | None = None
    rfilter: Filter = Gaussian()
    file_format: Annotated[Literal["openexr", "exr", "rgbe", "pfm"], BeforeValidator(as_lower)] = "openexr"
    pixel_format: Annotated[
        Literal["luminance", "luminance_alpha", "rgb", "rgba", "xyz", "xyza"], BeforeValidator(as_lower)
    ] = "rgb"
    """Channels of the picture: R, G, B, or Y, or X, Y, Z. Alpha (A) is the share of paths that hit something."""
    component_format: Annotated[Literal["float16", "float32", "uint32"], BeforeValidator(as_lower)] = "float16"
    """Numbers of the picture: 16 bits if the scene names that format, 32 bits if it names none."""
    sample_border: bool = False
    """Without effect: every pixel gets its whole filter, also at the border."""
    compensate: bool = False
    """Without effect: sums are always kept in double precision."""
    banner: bool = False
    """Without effect, as in Mitsuba 3."""

    @model_validator(mode="after")
    def _fits(self) -> Self:
        x, y, w, h = self.crop
        if x + w > self.width or y + h > self.height:
            raise ValueError(
                f"the crop window, {w}x{h} from ({x}, {y}), does not fit into the film of {self.width}x{self.height}"
            )
        if max(self.width, self.height) > MAX_SIDE or w * h > MAX_PIXELS:
            raise ValueError(
                f"an image of {w}x{h} pixels would need {_memory(w * h)} of memory; the limit is {MAX_PIXELS} pixels "
                f"({_memory(MAX_PIXELS)}) and {MAX_SIDE} to a side"
            )
        return self

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the whole film."""
        return self.width, self.height

    @property
    def colors(self) -> str:
        """``rgb``, ``luminance`` or ``xyz``: the channels of the picture beside alpha."""
        return {"rgba": "rgb", "luminance_alpha": "luminance", "xyza": "xyz"}.get(self.pixel_format, self.pixel_format)

    @property
    def has_alpha(self) -> bool:
        """Whether the picture has alpha, the opacity of each pixel."""
        return self.colors != self.pixel_format

    @property
    def crop(self) -> tuple[int, int, int, int]:
        """The part to render: x, y, width, height; the whole film if the file names no part."""
        width = self.width if self.crop_width is None else self.crop_width
        height = self.height if self.crop_height is None else self.crop_height
        return self.crop_offset_x, self.crop_offset_y, width, height


def _memory(pixels: int) -> str:
    """Return the memory that a film of `pixels` pixels needs, as text with a unit."""
    amount = float(min(pixels * PIXEL_BYTES, 10**300))  # sides of hundreds of digits overflow a float
    for unit in ("B", "kB", "MB", "GB", "TB", "PB"):
        if amount < 1000.0:
            return f"{amount:.3g} {unit}"
        amount /= 1000.0
    return f"{amount:.3g} EB"
