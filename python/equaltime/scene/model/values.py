"""Types of parameters (vectors, colours, transforms), with the validators that convert or refuse a user's values.

Each validator accepts every usual way to write a value. Results are floats or nested tuples of floats, so that nodes
stay hashable and comparable.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from numbers import Real
from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import AfterValidator, BeforeValidator

from equaltime.scene.model.spectra import SpectralCurve, Spectrum

__all__ = [
    "EQUAL_ENERGY",
    "IDENTITY",
    "Coefficient",
    "Color",
    "Matrix",
    "Numbers",
    "Radiance",
    "Reflectance",
    "RigidTransform",
    "Share",
    "Transform",
    "Vec3",
    "as_array",
    "as_coefficient",
    "as_lower",
    "as_number",
    "as_radiance",
    "as_reflectance",
    "as_share",
    "as_weight",
    "from_hex",
    "from_srgb",
    "linear_scale",
    "mirrors",
    "scale_across",
    "without_shear",
]

Color = tuple[float, float, float]
Row = tuple[float, float, float, float]
Matrix = tuple[Row, Row, Row, Row]

IDENTITY: Matrix = ((1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0), (0.0, 0.0, 0.0, 1.0))

EQUAL_ENERGY = (1.204794, 0.948291, 0.908916)
"""Linear sRGB colour of emission with the value 1 at all wavelengths. Mitsuba 3's RGB mode gives the same colour, up to
float32 rounding. A constant reflectance stays grey."""

SHAPE_TOLERANCE = 1e-3
"""Relative deviation up to which a linear map counts as a rotation or a uniform scale: Mitsuba's limit for cameras."""
_ROUNDED = 1e-7
"""Relative deviation of a rotation that rounding to float32 can cause."""


def _numbers(value: object, count: int) -> tuple[float, ...] | None:
    """Return `value` as `count` floats, or None if it is not a sequence of `count` numbers."""
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if isinstance(value, str) or not isinstance(value, Sequence) or len(value) != count:
        return None
    if not all(isinstance(v, Real) and not isinstance(v, bool) for v in value):
        return None
    return tuple(float(v) for v in value)


def _as_vec3(value: object) -> object:
    numbers = _numbers(value, 3)
    if numbers is None:
        raise ValueError("expected three numbers")
    return numbers


def _as_color(value: object) -> object:
    if isinstance(value, SpectralCurve):
        return value.reflectance
    if isinstance(value, Spectrum):
        value = value.value
    if isinstance(value, Real) and not isinstance(value, bool):
        return (float(value),) * 3
    if isinstance(value, str) and value.lstrip().startswith("#"):
        return from_hex(value)
    numbers = _numbers(value, 3)
    if numbers is None:
        raise ValueError("expected a colour: one number or three, or sRGB such as '#20c040'")
    return numbers


def from_hex(text: str) -> Color:
    """Return the linear sRGB colour of ``#rrggbb`` or ``#rgb``, hexadecimal digits of encoded sRGB, as on web pages.

    ``#ff0000`` is (1, 0, 0), and ``#808080`` is 0.216 in each channel. Raises ValueError for any other text.
    """
    digits = text.strip()[1:]
    if not re.fullmatch(r"#(?:[0-9a-fA-F]{3}){1,2}", text.strip()):
        raise ValueError(
            f"expected '#' and six hexadecimal digits of a colour, such as #20c040, found {text.strip()!r}"
        )
    size = len(digits) // 3
    encoded = (int((2 * digits[i : i + size])[:2], 16) / 255.0 for i in range(0, len(digits), size))
    red, green, blue = map(from_srgb, encoded)
    return red, green, blue


def from_srgb(encoded: float) -> float:
    """Return the linear value of a channel that is encoded by sRGB, both from 0 to 1 (IEC 61966-2-1)."""
    return encoded / 12.92 if encoded <= 0.04045 else float(((encoded + 0.055) / 1.055) ** 2.4)


def _as_radiance(value: object) -> object:
    if isinstance(value, SpectralCurve):
        return value.emission
    if isinstance(value, Spectrum):
        return tuple(value.value * channel for channel in EQUAL_ENERGY)
    return _as_color(value)


def _within_unit(color: Color) -> Color:
    if not all(0.0 <= c <= 1.0 for c in color):
        raise ValueError("must lie in [0, 1]: a surface cannot reflect more than it receives")
    return color


def _not_negative(color: Color) -> Color:
    if not all(c >= 0.0 for c in color):
        raise ValueError("must not be negative")
    return color


def as_reflectance(value: object) -> Color:
    """Return `value` as three factors in [0, 1], for red, green and blue.

    The `value` is one number, three numbers or a spectrum; anything else raises ValueError. A spectral curve whose sRGB
    channels exceed 1 is cut to 1, as in Mitsuba: saturated colours may lie outside of sRGB.
    """
    red, green, blue = _finite(_as_color(value))
    if isinstance(value, SpectralCurve):
        red, green, blue = min(red, 1.0), min(green, 1.0), min(blue, 1.0)
    return _within_unit((red, green, blue))


def as_coefficient(value: object) -> Color:
    """Return `value` as three non-negative numbers, for red, green and blue.

    The `value` is one number, three numbers or a spectrum; anything else raises ValueError.
    """
    return _not_negative(_finite(_as_color(value)))


def as_radiance(value: object) -> Color:
    """Return `value` as emission in linear sRGB: three non-negative numbers.

    The `value` is one number, three numbers or a spectrum; anything else raises ValueError.
    """
    return _not_negative(_finite(_as_radiance(value)))


def as_number(value: object) -> float:
    """Return `value` as one number. A colour or spectrum becomes the mean of its channels, as in Mitsuba.

    Raises ValueError for anything else, and for numbers that are not finite.
    """
    color = _finite(_as_color(value))
    return color[0] if len(set(color)) == 1 else sum(color) / 3.0


def as_lower(value: object) -> object:
    """Return a string in lower case. A `value` that is not a string is returned unchanged."""
    return value.lower() if isinstance(value, str) else value


def as_share(value: object) -> float:
    """Return `value` as one number in [0, 1]; a colour or spectrum becomes the mean of its channels.

    Raises ValueError for anything else, and for a number outside [0, 1].
    """
    if not 0.0 <= (number := as_number(value)) <= 1.0:
        raise ValueError("must lie in [0, 1]")
    return number


def as_weight(value: object) -> float:
    """Return `value` as one number in [0, 1]; a colour or spectrum becomes the mean of its channels.

    A single number or a uniform spectrum is clamped to [0, 1], as in Mitsuba. A colour or a curve raises ValueError if
    its mean is outside.
    """
    if isinstance(value, Real | Spectrum):
        return min(max(as_number(value), 0.0), 1.0)
    return as_share(value)


def _finite(color: object) -> Color:
    assert isinstance(color, tuple)
    if not all(math.isfinite(c) for c in color):
        raise ValueError("expected finite numbers")
    return color


def _as_matrix(value: object) -> object:
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        raise ValueError("expected a transform: a 4x4 matrix or a list of steps") from None
    if array.shape != (4, 4):
        raise ValueError(f"expected a 4x4 matrix, not one of shape {array.shape}")
    return tuple(map(tuple, array.tolist()))


def _invertible(matrix: Matrix) -> Matrix:
    if matrix[3] != (0.0, 0.0, 0.0, 1.0):
        raise ValueError("the last row of a transform must be 0 0 0 1; projections are not supported")
    if abs(_volume(matrix)) < 1e-12:
        raise ValueError("the transform is singular: it flattens space, so that it cannot be inverted")
    return matrix


def _rigid(matrix: Matrix) -> Matrix:
    scale = linear_scale(matrix)
    if scale is None or abs(scale - 1.0) > SHAPE_TOLERANCE:
        found = "scales unevenly or shears" if scale is None else f"scales by {scale:g}"
        raise ValueError(f"must keep lengths, but {found}; leave only rotations, reflections and translations")
    return matrix


def as_array(matrix: Matrix) -> NDArray[np.float64]:
    """Return a transform as an array (4, 4) that maps column vectors from local to world space."""
    return np.array(matrix, dtype=np.float64)


def linear_scale(matrix: Matrix) -> float | None:
    """Return the factor by which a transform scales all lengths.

    Returns None if the factor depends on the direction by more than the tolerance `SHAPE_TOLERANCE`.
    """
    linear = as_array(matrix)[:3, :3]
    largest = float(np.abs(linear).max()) or 1.0  # so that squares neither overflow nor vanish
    gram = (linear / largest).T @ (linear / largest)
    square = float(np.trace(gram)) / 3.0
    if np.abs(gram - square * np.eye(3)).max() > 2.0 * SHAPE_TOLERANCE * square:
        return None
    return math.sqrt(square) * largest


def without_shear(matrix: Matrix, about: Sequence[float] = (0.0, 0.0, 0.0)) -> NDArray[np.float64]:
    """Return a transform as an array (4, 4), with small shear and small differences of scale between axes removed.

    A rotation written with four digits has both, but shapes that are sampled in closed form must have neither. A
    transform in which either exceeds `SHAPE_TOLERANCE` is returned unchanged. The corrected transform maps
    the point `about` as before.
    """
    result, scale = as_array(matrix), linear_scale(matrix)
    if scale is None:
        return result
    left, _, right = np.linalg.svd(result[:3, :3])
    nearest = scale * left @ right
    if np.abs(nearest - result[:3, :3]).max() <= _ROUNDED * scale:
        return result
    result = result.copy()
    result[:3, 3] += (result[:3, :3] - nearest) @ np.array(about)
    result[:3, :3] = nearest
    return result


def scale_across(matrix: Matrix, axis: Sequence[float]) -> float | None:
    """Return the factor by which a transform scales lengths perpendicular to `axis` (3 numbers), such as a radius.

    Returns None if the factor depends on the direction, or if the transform shears.
    """
    along = np.array(_unit((axis[0], axis[1], axis[2])))
    x = np.cross(along, np.eye(3)[int(np.abs(along).argmin())])
    x /= np.linalg.norm(x)
    turned = as_array(matrix)[:3, :3] @ np.column_stack([x, np.cross(along, x), along])
    lengths = np.linalg.norm(turned, axis=0)
    angles = (turned / lengths).T @ (turned / lengths) - np.eye(3)
    if np.abs(angles).max() > SHAPE_TOLERANCE or abs(lengths[0] / lengths[1] - 1.0) > SHAPE_TOLERANCE:
        return None
    return float(lengths[:2].mean())


def mirrors(matrix: NDArray[np.float64]) -> bool:
    """Tell whether a transform (4, 4) contains a reflection: True if its determinant is negative."""
    return _volume(matrix.tolist()) < 0.0


def _volume(matrix: Sequence[Sequence[float]]) -> float:
    """Return the signed volume of the unit vectors along the transform's axes: negative if it mirrors, 0 if flat."""
    columns = list(zip(*matrix[:3], strict=True))
    (a, b, c), (d, e, f), (g, h, i) = map(_unit, columns[:3])
    return a * (e * i - f * h) - d * (b * i - c * h) + g * (b * f - c * e)


def _unit(vector: tuple[float, float, float]) -> tuple[float, float, float]:
    """Return the vector at unit length; a zero vector stays zero."""
    x, y, z = vector
    largest = max(abs(x), abs(y), abs(z)) or 1.0  # so that the length does not overflow
    x, y, z = x / largest, y / largest, z / largest
    length = math.hypot(x, y, z) or 1.0
    return x / length, y / length, z / length


Vec3 = Annotated[tuple[float, float, float], BeforeValidator(_as_vec3)]
"""A point or a direction."""


def _as_numbers(value: object) -> object:
    if isinstance(value, str):
        try:
            return tuple(float(word) for word in re.split(r"[\s,]+", value.strip(", \t\r\n")))
        except ValueError:
            raise ValueError("expected numbers, separated by spaces or commas") from None
    return value


Reflectance = Annotated[Color, BeforeValidator(as_reflectance)]
"""A dimensionless factor in [0, 1] per channel; a single number is grey."""
Coefficient = Annotated[Color, BeforeValidator(as_coefficient)]
"""A non-negative number per channel, such as an index of refraction; a single number applies to all channels."""
Share = Annotated[float, BeforeValidator(as_share)]
"""A number in [0, 1]."""
Numbers = Annotated[tuple[float, ...], BeforeValidator(_as_numbers)]
"""Any number of numbers; as a text, with spaces or commas between them."""
Radiance = Annotated[Color, BeforeValidator(as_radiance)]
"""Emission per channel in linear sRGB; a single number is white."""
Transform = Annotated[Matrix, AfterValidator(_invertible), BeforeValidator(_as_matrix)]
"""An affine, invertible map from local to world space."""
RigidTransform = Annotated[Matrix, AfterValidator(_rigid), AfterValidator(_invertible), BeforeValidator(_as_matrix)]
"""A rotation or reflection followed by a translation."""
