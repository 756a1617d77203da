"""Film and reconstruction filters.

The position of a sample is drawn in proportion to the filter of its pixel, so that the sample counts for one pixel
only. For a filter f with negative lobes, the position is drawn in proportion to abs(f). The weight of the sample is
then c or -c, with the sign of f. Here c is the integral of abs(f) divided by the integral of f. The mean of the samples
is the filtered image, without bias, and no sample is dropped or clamped.

The signs add noise even where the image is uniform. The standard deviation of this noise, per sample, is sqrt(c^2 - 1)
times the radiance. The factor is 0.56 with ``mitchell`` (c = 1.14), 0.92 with ``catmullrom`` (1.36) and 1.6 with
``lanczos`` (1.85). The variance of the weighted samples includes this noise, and so do all error bars.
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
"""Bytes of memory per pixel that the error about too large a film states; two replicates alone take 80."""


class Box(Plugin):
    """A box filter, one pixel wide: all samples have the same weight."""

    kind: ClassVar[Kind] = "rfilter"
    type: Literal["box"] = "box"


class Tent(Plugin):
    """A tent filter, which falls linearly from the centre of the pixel."""

    kind: ClassVar[Kind] = "rfilter"
    type: Literal["tent"] = "tent"
    radius: PositiveFloat = 1.0
    """Distance from the centre at which the filter reaches zero, in pixels."""


class Gaussian(Plugin):
    """A Gaussian filter, truncated at four standard deviations and shifted down so that it ends at zero."""

    kind: ClassVar[Kind] = "rfilter"
    type: Literal["gaussian"] = "gaussian"
    stddev: PositiveFloat = 0.5
    """Standard deviation, in pixels."""


class Mitchell(Plugin):
    """A cubic spline filter with a radius of 2 pixels, with negative lobes (Mitchell and Netravali 1988)."""

    kind: ClassVar[Kind] = "rfilter"
    type: Literal["mitchell"] = "mitchell"
    B: float = 1.0 / 3.0
    C: float = 1.0 / 3.0


class CatmullRom(Plugin):
    """The Catmull-Rom filter: the cubic spline of `Mitchell` with its parameters B = 0 and C = 1/2."""

    kind: ClassVar[Kind] = "rfilter"
    type: Literal["catmullrom"] = "catmullrom"


class Lanczos(Plugin):
    """A sinc filter with a radius of ``lobes`` pixels, multiplied by a window.

    The window is the main lobe of a wider sinc.
    """

    kind: ClassVar[Kind] = "rfilter"
    type: Literal["lanczos"] = "lanczos"
    lobes: PositiveInt = 3


Filter = Annotated[Box | Tent | Gaussian | Mitchell | CatmullRom | Lanczos, Field(discriminator="type")]
"""Any reconstruction filter."""


class HdrFilm(Plugin):
    """The film: size of the image in pixels, crop window, reconstruction filter and pixel format.

    The name of the output file decides the file format; the parameter ``file_format`` has no effect.
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
    """Channels of the image file: R, G, B or Y or X, Y, Z. Alpha (A) is the fraction of paths that hit a surface."""
    component_format: Annotated[Literal["float16", "float32", "uint32"], BeforeValidator(as_lower)] = "float16"
    """Number format of the image file: 16-bit floats only if the scene names ``float16``, 32-bit floats otherwise."""
    sample_border: bool = False
    """Without effect: pixels at the border use the whole filter, too."""
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
        """Size (width, height) of the whole film, in pixels."""
        return self.width, self.height

    @property
    def colors(self) -> str:
        """Channels of the image file without alpha: ``rgb``, ``luminance`` or ``xyz``."""
        return {"rgba": "rgb", "luminance_alpha": "luminance", "xyza": "xyz"}.get(self.pixel_format, self.pixel_format)

    @property
    def has_alpha(self) -> bool:
        """True if the image file has an alpha channel, the opacity of each pixel."""
        return self.colors != self.pixel_format

    @property
    def crop(self) -> tuple[int, int, int, int]:
        """Crop window (x, y, width, height) in pixels.

        The window is the whole film if the scene sets no crop window.
        """
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
