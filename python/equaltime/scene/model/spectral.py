"""Plugins for Mitsuba's spectra, and for Mitsuba's constant volume.

A scene that was read contains none of these plugins: each has been replaced by its colour.
"""

from __future__ import annotations

from typing import ClassVar, Literal, Self

from pydantic import NonNegativeFloat, PositiveFloat, model_validator

from equaltime.scene.model.base import Kind, Plugin
from equaltime.scene.model.spectra import SpectralCurve, blackbody
from equaltime.scene.model.values import IDENTITY, Coefficient, Color, Numbers, Transform

__all__ = [
    *("D65", "Blackbody", "ConstVolume", "Irregular", "RawConstant", "Regular", "SpectrumPlugin", "Srgb", "Uniform"),
]


class SpectrumPlugin(Plugin):
    """Base class of Mitsuba's spectra, which are replaced by colours or curves when a scene is read."""

    kind: ClassVar[Kind] = "texture"

    @property
    def meaning(self) -> Color | SpectralCurve:
        """Value of the spectrum: a colour in linear sRGB, or a curve over wavelengths if its colour depends on the use.

        Mitsuba converts the curve of an emitter to another colour than the same curve as a reflectance. The reader
        therefore converts a curve only when it knows where the scene uses the spectrum.
        """
        raise NotImplementedError


class Uniform(SpectrumPlugin):
    """A spectrum with one value for all wavelengths. As a colour, it has the same value in all channels."""

    type: Literal["uniform"] = "uniform"
    value: float = 1.0

    @property
    def meaning(self) -> Color:
        """Colour with ``value`` in all three channels."""
        return (self.value,) * 3


class RawConstant(SpectrumPlugin):
    """One number or three numbers, used as a colour without conversion."""

    type: Literal["rawconstant"] = "rawconstant"
    value: Coefficient

    @property
    def meaning(self) -> Color:
        """Colour given by ``value``, unchanged."""
        return self.value


class Srgb(SpectrumPlugin):
    """A colour in linear sRGB."""

    type: Literal["srgb"] = "srgb"
    color: Coefficient

    @property
    def meaning(self) -> Color:
        """Colour given by ``color``, unchanged."""
        return self.color


class D65(SpectrumPlugin):
    """The illuminant D65, multiplied by a number and a colour."""

    type: Literal["d65"] = "d65"
    scale: NonNegativeFloat = 1.0
    color: Coefficient = (1.0, 1.0, 1.0)

    @property
    def meaning(self) -> Color:
        """Colour ``scale`` times ``color``. The illuminant itself has the factor 1, because D65 is white in sRGB."""
        red, green, blue = self.color
        return self.scale * red, self.scale * green, self.scale * blue


class Regular(SpectrumPlugin):
    """A spectrum of values at equally spaced wavelengths, in nm."""

    type: Literal["regular"] = "regular"
    wavelength_min: PositiveFloat
    wavelength_max: PositiveFloat
    values: Numbers

    @model_validator(mode="after")
    def _makes_a_curve(self) -> Self:
        _ = self.meaning
        return self

    @property
    def meaning(self) -> SpectralCurve:
        """Curve through the values, linear between the wavelengths."""
        last = max(len(self.values) - 1, 1)
        step = (self.wavelength_max - self.wavelength_min) / last
        return SpectralCurve(tuple(self.wavelength_min + i * step for i in range(len(self.values))), self.values)


class Irregular(SpectrumPlugin):
    """A spectrum of values at given wavelengths, in nm."""

    type: Literal["irregular"] = "irregular"
    wavelengths: Numbers
    values: Numbers

    @model_validator(mode="after")
    def _makes_a_curve(self) -> Self:
        _ = self.meaning
        return self

    @property
    def meaning(self) -> SpectralCurve:
        """Curve through the values, linear between the wavelengths."""
        return SpectralCurve(self.wavelengths, self.values)


class Blackbody(SpectrumPlugin):
    """The emission of a black body."""

    type: Literal["blackbody"] = "blackbody"
    temperature: PositiveFloat
    """Temperature, in kelvins."""
    wavelength_min: PositiveFloat = 360.0
    wavelength_max: PositiveFloat = 830.0

    @model_validator(mode="after")
    def _makes_a_curve(self) -> Self:
        _ = self.meaning
        return self

    @property
    def meaning(self) -> SpectralCurve:
        """Planck's curve from ``wavelength_min`` to ``wavelength_max`` (nm), in W/(m^2 sr nm)."""
        whole = blackbody(self.temperature)
        inside = [
            (wavelength, power)
            for wavelength, power in zip(whole.wavelengths, whole.values, strict=True)
            if self.wavelength_min <= wavelength <= self.wavelength_max
        ]
        wavelengths, powers = zip(*inside, strict=True) if inside else ((), ())
        return SpectralCurve(wavelengths, powers)


class ConstVolume(SpectrumPlugin):
    """A volume with one value everywhere, for parameters of media and of phase functions."""

    kind: ClassVar[Kind] = "volume"
    hints: ClassVar[frozenset[str]] = frozenset({"to_world"})

    type: Literal["constvolume"] = "constvolume"
    value: Coefficient = (1.0, 1.0, 1.0)
    """Value of the volume: a number, a colour or a spectrum."""
    to_world: Transform = IDENTITY
    """Without effect: the value is the same everywhere."""

    @property
    def meaning(self) -> Color:
        """Colour given by ``value``, unchanged."""
        return self.value
