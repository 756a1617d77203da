"""Reads spectra as scene files write them: one value, pairs of wavelength and value, or a file of such pairs."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from functools import lru_cache
from pathlib import Path

from equaltime.scene.model import SpectralCurve, Spectrum
from equaltime.words import shortened

__all__ = ["curve", "parse_spectrum", "read_spectrum"]

LARGEST = 1 << 22
"""Largest size of a file of pairs, in bytes; a spectrum in steps of 0.1 nm takes about a hundred thousand bytes."""


def parse_spectrum(text: str) -> Spectrum | SpectralCurve:
    """Return the spectrum that `text` describes.

    The text is a number such as ``0.5``, or pairs of a wavelength in nm and a value, such as ``400:0.1, 500:0.2``.
    Raises ValueError for any other text.
    """
    words = re.split(r"[\s,]+", re.sub(r"\s*:\s*", ":", text.strip(", \t\r\n")))
    if not any(":" in word for word in words):
        if len(words) != 1:
            raise ValueError(f"expected one number, found {len(words)}; use <rgb> for a colour")
        return Spectrum(_number(words[0]))
    return curve(word.split(":") for word in words)


def curve(pairs: Iterable[object]) -> SpectralCurve:
    """Return the spectrum that goes through `pairs` of a wavelength in nm and a value; else raise ValueError."""
    points: list[tuple[float, float]] = []
    for pair in pairs:
        if not isinstance(pair, list | tuple) or len(pair) != 2:
            raise ValueError(f"expected pairs wavelength:value, found {_shown(pair)}")
        points.append((_number(pair[0]), _number(pair[1])))
    wavelengths, values = zip(*points, strict=True) if points else ((), ())
    return SpectralCurve(wavelengths, values)


def read_spectrum(path: Path) -> SpectralCurve:
    """Return the spectrum in the file at `path`; raises ValueError for an unreadable file.

    Each line of the file has a wavelength in nm and a value. Comments begin with ``#``.
    """
    try:
        with path.open("rb") as file:
            content = file.read(LARGEST + 1)
    except (OSError, ValueError) as error:
        raise ValueError(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}") from error
    if len(content) > LARGEST:
        raise ValueError(f"{path}: a spectrum of more than {LARGEST >> 20} MB")
    found = _curve_of(content)
    if isinstance(found, str):
        raise ValueError(f"{path}: {found}")
    return found


@lru_cache(maxsize=16)  # many parts of a scene may name one file
def _curve_of(content: bytes) -> SpectralCurve | str:
    """Return the curve in a file, or the reason why there is none."""
    lines = (line.partition("#")[0].split() for line in content.decode("utf-8-sig", "replace").splitlines())
    try:
        return curve(line for line in lines if line)
    except ValueError as error:
        return str(error)


def _number(value: object) -> float:
    try:
        number = float(value) if isinstance(value, str | int | float) else math.nan
    except (OverflowError, ValueError):
        number = math.nan
    if not math.isfinite(number) or (isinstance(value, str) and "_" in value):
        raise ValueError(f"expected a finite number, found {shortened(value, 60)}")
    return number


def _shown(pair: object) -> str:
    return repr(":".join(pair)) if isinstance(pair, list) and pair and isinstance(pair[0], str) else shortened(pair, 60)
