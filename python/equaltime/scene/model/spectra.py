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

__all__ = ["SpectralCurve", "Spectrum", "blackbody"]

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


TABLE: Final = tuple(
    tuple(map(float, line.split()))
    for line in """\
360 0.0001299 3.917e-06 0.0006061 46.6383
365 0.0002321 6.965e-06 0.001086 49.3637
370 0.0004149 1.239e-05 0.001946 52.0891
375 0.0007416 2.202e-05 0.003486 51.0323
380 0.001368 3.9e-05 0.00645 49.9755
385 0.002236 6.4e-05 0.01055 52.3118
390 0.004243 0.00012 0.02005 54.6482
395 0.00765 0.000217 0.03621 68.7015
400 0.01431 0.000396 0.06785 82.7549
405 0.02319 0.00064 0.1102 87.1204
410 0.04351 0.00121 0.2074 91.486
415 0.07763 0.00218 0.3713 92.4589
420 0.13438 0.004 0.6456 93.4318
425 0.21477 0.0073 1.03905 90.057
430 0.2839 0.0116 1.3856 86.6823
435 0.3285 0.01684 1.62296 95.7736
440 0.34828 0.023 1.74706 104.865
445 0.34806 0.0298 1.7826 110.936
450 0.3362 0.038 1.77211 117.008
455 0.3187 0.048 1.7441 117.41
460 0.2908 0.06 1.6692 117.812
465 0.2511 0.0739 1.5281 116.336
470 0.19536 0.09098 1.28764 114.861
475 0.1421 0.1126 1.0419 115.392
480 0.09564 0.13902 0.81295 115.923
485 0.05795 0.1693 0.6162 112.367
490 0.03201 0.20802 0.46518 108.811
495 0.0147 0.2586 0.3533 109.082
500 0.0049 0.323 0.272 109.354
505 0.0024 0.4073 0.2123 108.578
510 0.0093 0.503 0.1582 107.802
515 0.0291 0.6082 0.1117 106.296
520 0.06327 0.71 0.07825 104.79
525 0.1096 0.7932 0.05725 106.239
530 0.1655 0.862 0.04216 107.689
535 0.22575 0.91485 0.02984 106.047
540 0.2904 0.954 0.0203 104.405
545 0.3597 0.9803 0.0134 104.225
550 0.43345 0.99495 0.00875 104.046
555 0.51205 1 0.00575 102.023
560 0.5945 0.995 0.0039 100
565 0.6784 0.9786 0.00275 98.1671
570 0.7621 0.952 0.0021 96.3342
575 0.8425 0.9154 0.0018 96.0611
580 0.9163 0.87 0.00165 95.788
585 0.9786 0.8163 0.0014 92.2368
590 1.0263 0.757 0.0011 88.6856
595 1.0567 0.6949 0.001 89.3459
600 1.0622 0.631 0.0008 90.0062
605 1.0456 0.5668 0.0006 89.8026
610 1.0026 0.503 0.00034 89.5991
615 0.9384 0.4412 0.00024 88.6489
620 0.85445 0.381 0.00019 87.6987
625 0.7514 0.321 0.0001 85.4936
630 0.6424 0.265 5e-05 83.2886
635 0.5419 0.217 3e-05 83.4939
640 0.4479 0.175 2e-05 83.6992
645 0.3608 0.1382 1e-05 81.863
650 0.2835 0.107 0 80.0268
655 0.2187 0.0816 0 80.1207
660 0.1649 0.061 0 80.2146
665 0.1212 0.04458 0 81.2462
670 0.0874 0.032 0 82.2778
675 0.0636 0.0232 0 80.281
680 0.04677 0.017 0 78.2842
685 0.0329 0.01192 0 74.0027
690 0.0227 0.00821 0 69.7213
695 0.01584 0.005723 0 70.6652
700 0.0113592 0.004102 0 71.6091
705 0.00811092 0.002929 0 72.979
710 0.00579035 0.002091 0 74.349
715 0.00410946 0.001484 0 67.9765
720 0.00289933 0.001047 0 61.604
725 0.00204919 0.00074 0 65.7448
730 0.00143997 0.00052 0 69.8856
735 0.000999949 0.0003611 0 72.4863
740 0.000690079 0.0002492 0 75.087
745 0.000476021 0.0001719 0 69.3398
750 0.000332301 0.00012 0 63.5927
755 0.000234826 8.48e-05 0 55.0054
760 0.00016615 6e-05 0 46.4182
765 0.000117413 4.24e-05 0 56.6118
770 8.30753e-05 3e-05 0 66.8054
775 5.87065e-05 2.12e-05 0 65.0941
780 4.15099e-05 1.499e-05 0 63.3828
785 2.93533e-05 1.06e-05 0 63.8434
790 2.06738e-05 7.4657e-06 0 64.304
795 1.45598e-05 5.2578e-06 0 61.8779
800 1.0254e-05 3.7029e-06 0 59.4519
805 7.22146e-06 2.6078e-06 0 55.7054
810 5.08587e-06 1.8366e-06 0 51.959
815 3.58165e-06 1.2934e-06 0 54.6998
820 2.52252e-06 9.1093e-07 0 57.4406
825 1.77651e-06 6.4153e-07 0 58.8765
830 1.25114e-06 4.5181e-07 0 60.3125
""".splitlines()
)
"""The CIE 1931 standard observer and the standard illuminant D65, every 5 nm (CIE 015:2004, tables 1 and 4).

Columns: wavelength in nm, the colour matching functions x, y, z, and the relative power of D65.
"""


Color = tuple[float, float, float]
Array = NDArray[np.float64]
