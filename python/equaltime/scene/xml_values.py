"""Parsers for XML elements that hold a value (such as ``<float>``) or a step of a transform (such as ``<rotate>``).

Each parser takes the attributes of one element as a dict, after a check that all required attributes are present.
Invalid values raise ValueError with a readable message.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from equaltime.scene import transforms
from equaltime.scene.model import SpectralCurve, Spectrum
from equaltime.scene.model.spectra import blackbody
from equaltime.scene.model.values import from_hex, from_srgb
from equaltime.scene.spectrum_values import parse_spectrum

__all__ = ["OLD_VALUES", "STEPS", "VALUES", "Rule", "number"]

Attributes = Mapping[str, str]
T = TypeVar("T")
Vec3 = tuple[float, float, float]

_BETWEEN: Final = re.compile(r"[\s,]+")
"""Separator of numbers."""


@dataclass(frozen=True, slots=True)
class Rule(Generic[T]):
    """Rule for reading one kind of XML element: its required and optional attributes, and the parser of its value."""

    required: tuple[str, ...]
    optional: tuple[str, ...]
    parse: Callable[[Attributes], T]


def number(text: str) -> float:
    """Return the finite number in `text`; raises ValueError for any other text."""
    try:
        number = float(text)
    except ValueError:
        raise ValueError(f"expected a number, found {text!r}") from None
    if "_" in text:  # Python accepts underscores in numbers, Mitsuba does not
        raise ValueError(f"expected a number, found {text!r}")
    if not math.isfinite(number):
        raise ValueError(f"expected a finite number, found {text!r}")
    return number


def _numbers(text: str) -> list[float]:
    return [number(word) for word in _BETWEEN.split(text.strip(", \t\r\n"))]


def _integer(text: str) -> int:
    try:
        integer = int(text)
    except ValueError:
        raise ValueError(f"expected an integer, found {text!r}") from None
    if "_" in text:
        raise ValueError(f"expected an integer, found {text!r}")
    return integer


def _boolean(text: str) -> bool:
    if text.lower() not in ("true", "false"):
        raise ValueError(f"expected 'true' or 'false', found {text!r}")
    return text.lower() == "true"


def _three(text: str) -> Vec3:
    numbers = _numbers(text)
    if len(numbers) not in (1, 3):
        raise ValueError(f"expected one number or three, found {len(numbers)} in {text!r}")
    return (numbers[0], numbers[0], numbers[0]) if len(numbers) == 1 else (numbers[0], numbers[1], numbers[2])


def _vector(attributes: Attributes, default: float | None = None) -> Vec3:
    """Read a vector from ``value`` or from ``x``, ``y`` and ``z``, which are all required unless there is a default."""
    parts = {"x", "y", "z"} & set(attributes)
    if "value" in attributes:
        if parts:
            raise ValueError("give either 'value' or 'x', 'y' and 'z'")
        return _three(attributes["value"])
    missing = sorted({"x", "y", "z"} - parts)
    if default is None and missing:
        raise ValueError(f"needs 'value' or 'x', 'y' and 'z'; '{missing[0]}' is missing")
    x, y, z = (number(attributes[axis]) if axis in parts else default or 0.0 for axis in "xyz")
    return x, y, z


def _direction(text: str) -> Vec3:
    numbers = _numbers(text)
    if len(numbers) != 3:
        raise ValueError(f"expected three numbers, found {len(numbers)} in {text!r}")
    return numbers[0], numbers[1], numbers[2]


def _look_at(attributes: Attributes) -> NDArray[np.float64]:
    up = _direction(attributes["up"]) if "up" in attributes else None
    return transforms.look_at(_direction(attributes["origin"]), _direction(attributes["target"]), up)


def _blackbody(attributes: Attributes) -> SpectralCurve:
    """Read the spectrum of a black body at ``5000`` or ``5000K``, times a scale."""
    kelvins, scale = number(attributes["temperature"].strip().rstrip("kK")), number(attributes.get("scale", "1"))
    if kelvins <= 0.0 or scale < 0.0:
        raise ValueError("a black body needs a temperature above 0 and a scale that is not negative")
    light = blackbody(kelvins)
    return SpectralCurve(light.wavelengths, tuple(scale * power for power in light.values))


def _old_spectrum(text: str) -> Spectrum | SpectralCurve | Vec3:
    """Read a spectrum, or three numbers, which are the samples in a Mitsuba 0.x that renders in RGB."""
    words = _BETWEEN.split(text.strip(", \t\r\n"))
    return _direction(text) if len(words) == 3 and ":" not in text else parse_spectrum(text)


def _srgb(text: str) -> Vec3:
    """Read a colour in encoded sRGB: ``#rrggbb``, or numbers from 0 to 1."""
    if text.strip().startswith("#"):
        return from_hex(text)
    red, green, blue = map(from_srgb, _three(text))
    return red, green, blue


def _rgb(text: str) -> Vec3:
    """Read a colour: one number or three, in linear sRGB, or ``#rrggbb``, in encoded sRGB."""
    return from_hex(text) if text.strip().startswith("#") else _three(text)


NAMED = ("name", "value")
XYZ = ("value", "x", "y", "z")
INTENT = ("intent",)
"""Attribute of Mitsuba 0.x that says whether a colour is a reflectance or emission; here without effect."""

VALUES: Final[dict[str, Rule[object]]] = {
    "boolean": Rule(NAMED, (), lambda a: _boolean(a["value"])),
    "float": Rule(NAMED, (), lambda a: number(a["value"])),
    "integer": Rule(NAMED, (), lambda a: _integer(a["value"])),
    "point": Rule(("name",), XYZ, _vector),
    "rgb": Rule(NAMED, (), lambda a: _rgb(a["value"])),
    "spectrum": Rule(NAMED, (), lambda a: parse_spectrum(a["value"])),
    "string": Rule(NAMED, (), lambda a: a["value"]),
    "vector": Rule(("name",), XYZ, _vector),
}
"""Rules for the elements that give a parameter its value, by tag."""

OLD_VALUES: Final[dict[str, Rule[object]]] = {
    "blackbody": Rule(("name", "temperature"), ("scale",), lambda a: _blackbody(a)),
    "rgb": Rule(NAMED, INTENT, lambda a: _rgb(a["value"])),
    "spectrum": Rule(NAMED, INTENT, lambda a: _old_spectrum(a["value"])),
    "srgb": Rule(NAMED, INTENT, lambda a: _srgb(a["value"])),
}
"""Rules for value elements that only Mitsuba before version 2 had, or that differed there, by tag."""

STEPS: Final[dict[str, Rule[NDArray[np.float64]]]] = {
    "lookat": Rule(("origin", "target"), ("up",), _look_at),
    "lookAt": Rule(("origin", "target"), ("up",), _look_at),
    "matrix": Rule(("value",), (), lambda a: transforms.matrix(_numbers(a["value"]))),
    "rotate": Rule(("angle",), XYZ, lambda a: transforms.rotate(_vector(a, 0.0), number(a["angle"]))),
    "scale": Rule((), XYZ, lambda a: transforms.scale(_vector(a, 1.0))),
    "translate": Rule((), XYZ, lambda a: transforms.translate(_vector(a, 0.0))),
}
"""Rules for the steps of a transform, by tag; ``lookAt`` is the tag before version 2."""
