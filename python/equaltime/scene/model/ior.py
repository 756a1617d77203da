"""Indices of refraction by Mitsuba's material names (measured near 589 nm; mostly Hecht, *Optics*, 4th edition)."""

from __future__ import annotations

from equaltime.words import suggestion

__all__ = ["IOR", "as_ior"]

IOR = {
    "vacuum": 1.0,
    "helium": 1.000036,
    "hydrogen": 1.000132,
    "air": 1.000277,
    "carbon dioxide": 1.00045,
    "water": 1.3330,
    "acetone": 1.36,
    "ethanol": 1.361,
    "carbon tetrachloride": 1.461,
    "glycerol": 1.4729,
    "benzene": 1.501,
    "silicone oil": 1.52045,
    "bromine": 1.661,
    "water ice": 1.31,
    "fused quartz": 1.458,
    "pyrex": 1.470,
    "acrylic glass": 1.49,
    "polypropylene": 1.49,
    "bk7": 1.5046,
    "sodium chloride": 1.544,
    "amber": 1.55,
    "pet": 1.5750,
    "diamond": 2.419,
}


def as_ior(value: object) -> object:
    """Return the index of refraction of the material named `value`, such as ``water``.

    A `value` that is not a string is returned unchanged. Raises ValueError for an unknown name.
    """
    if not isinstance(value, str):
        return value
    try:
        return IOR[value.lower()]
    except KeyError:
        raise ValueError(f"expected a number or a material, found {value!r}{suggestion(value, IOR)}") from None
