"""Spectra, which vary with wavelength, and their colours in linear sRGB.

The colour of a curve is its integral against the CIE 1931 observer. A reflectance, or any other factor, is multiplied
by the illuminant D65 before the integration; emission is not multiplied. The integral is a sum over 1000 wavelengths,
as in Mitsuba 3's RGB mode. Negative channels (outside the gamut) become zero.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from equaltime.scene.model.cie import TABLE

__all__ = ["SpectralCurve", "Spectrum", "blackbody"]

Color = tuple[float, float, float]
Array = NDArray[np.float64]

STEPS: Final = 1000
D65_LUMINANCE: Final = 98.99741751876255
"""Luminance by which Mitsuba divides D65. The luminance of D65 in `TABLE` is 0.11 % smaller. A constant reflectance is
therefore 0.11 % darker than its value, as in Mitsuba's images."""
PLANCK: Final = 6.62607015e-34
LIGHT_SPEED: Final = 299792458.0
BOLTZMANN: Final = 1.380649e-23
XYZ_TO_SRGB: Final = np.array(
    [[3.240479, -1.537150, -0.498535], [-0.969256, 1.875991, 0.041556], [0.055648, -0.204043, 1.057311]]
)
"""Matrix from CIE XYZ to linear sRGB (Rec. 709 primaries, D65 white), in the digits in common use."""


@dataclass(frozen=True, slots=True)
class Spectrum:
    """A spectrum with the same value at every wavelength. As a reflectance it is grey, as emission slightly red."""

    value: float


@dataclass(frozen=True, slots=True)
class SpectralCurve:
    """A spectrum that is linear between its points, and zero before the first and after the last."""

    wavelengths: tuple[float, ...]
    """Wavelengths in nm, increasing."""
    values: tuple[float, ...]

    def __post_init__(self) -> None:
        if len(self.wavelengths) != len(self.values) or len(self.values) < 2:
            raise ValueError("a spectrum needs at least two wavelengths, and a value for each")
        if not all(map(math.isfinite, (*self.wavelengths, *self.values))):
            raise ValueError("expected finite numbers in a spectrum")
        if any(a >= b for a, b in zip(self.wavelengths, self.wavelengths[1:], strict=False)):
            raise ValueError("the wavelengths of a spectrum must increase")

    @property
    def emission(self) -> Color:
        """Colour of emitted light with this spectrum, in linear sRGB."""
        return self._color(under_d65=False)

    @property
    def reflectance(self) -> Color:
        """Colour, in linear sRGB, of a surface that is lit by D65 and has this curve as its reflectance."""
        return self._color(under_d65=True)

    def _color(self, *, under_d65: bool) -> Color:
        table = np.array(TABLE)
        grid = np.linspace(table[0, 0], table[-1, 0], STEPS)
        curve = np.interp(grid, self.wavelengths, self.values, left=0.0, right=0.0)
        if under_d65:
            curve *= np.interp(grid, table[:, 0], table[:, 4]) / D65_LUMINANCE
        observer: Array = np.stack([np.interp(grid, table[:, 0], column) for column in table[:, 1:4].T])
        xyz = (observer * curve).sum(axis=1) / observer[1].sum()
        red, green, blue = np.maximum((XYZ_TO_SRGB * xyz).sum(axis=1), 0.0).tolist()
        return red, green, blue


def blackbody(temperature: float) -> SpectralCurve:
    """Return the spectral radiance of a black body at `temperature` kelvins, by Planck's law.

    The curve has a value every nm from 360 nm to 830 nm, in W/(m^2 sr nm).
    """
    nanometres = np.arange(360.0, 831.0, 1.0)
    metres = 1e-9 * nanometres
    exponent = PLANCK * LIGHT_SPEED / (BOLTZMANN * temperature * metres)
    with np.errstate(over="ignore"):
        power = 2.0 * PLANCK * LIGHT_SPEED**2 / metres**5 / np.expm1(exponent) * 1e-9
    return SpectralCurve(tuple(nanometres.tolist()), tuple(power.tolist()))
