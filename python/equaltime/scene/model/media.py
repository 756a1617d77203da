"""Media and their phase functions."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Final, Literal, get_args

from pydantic import AfterValidator, Field, NonNegativeFloat, model_validator

from equaltime.scene.model.base import Kind, Plugin
from equaltime.scene.model.values import Coefficient, Numbers, Reflectance, Share, as_coefficient

__all__ = [
    "PHASES",
    "BlendPhase",
    "HenyeyGreenstein",
    "Homogeneous",
    "Isotropic",
    "Medium",
    "Phase",
    "Rayleigh",
    "TabPhase",
]


def _curve(values: tuple[float, ...]) -> tuple[float, ...]:
    if len(values) < 2 or min(values) < 0.0 or max(values) == 0.0:
        raise ValueError("expected at least two numbers from 0 on, one of them above 0")
    return values


class Isotropic(Plugin):
    """The isotropic phase function: light is scattered equally in all directions."""

    kind: ClassVar[Kind] = "phase"
    type: Literal["isotropic"] = "isotropic"


class HenyeyGreenstein(Plugin):
    """The phase function of Henyey and Greenstein (1941).

    Its mean cosine is ``g``: above 0, light is scattered mostly forward; below 0, mostly backward.
    """

    kind: ClassVar[Kind] = "phase"
    type: Literal["hg"] = "hg"
    g: Annotated[float, Field(gt=-1.0, lt=1.0)] = 0.8


class Rayleigh(Plugin):
    """The Rayleigh phase function, for particles much smaller than the wavelength, such as air.

    At the scattering angle t, its value is 3/(16 pi) (1 + cos^2 t).
    """

    kind: ClassVar[Kind] = "phase"
    type: Literal["rayleigh"] = "rayleigh"


class TabPhase(Plugin):
    """A phase function of a table.

    Its values stand at evenly spaced cosines of the angle by which light is turned. The first is at -1, for light that
    turns back; the last is at 1, for light that goes straight on. Between them it is linear. Only ratios matter.
    """

    kind: ClassVar[Kind] = "phase"
    type: Literal["tabphase"] = "tabphase"
    values: Annotated[Numbers, AfterValidator(_curve)]


class BlendPhase(Plugin):
    """Two phase functions, mixed by a weight; each of the two may itself be a blend."""

    kind: ClassVar[Kind] = "phase"
    roles: ClassVar[Mapping[Kind, str]] = {"phase": "phase"}
    lists: ClassVar[frozenset[str]] = frozenset({"phase"})

    type: Literal["blendphase"] = "blendphase"
    weight: Share
    """Share of the second phase function, in [0, 1]: 0 is the first alone, 1 the second alone."""
    phase: Annotated[tuple[Phase, ...], Field(min_length=2, max_length=2)]


Phase = Annotated[Isotropic | HenyeyGreenstein | Rayleigh | TabPhase | BlendPhase, Field(discriminator="type")]
"""Any phase function. All but blends are models of the core of the same ``type``, with the same parameters."""
PHASES: Final[tuple[type[Plugin], ...]] = get_args(get_args(Phase)[0])
"""The classes in `Phase`."""


class Homogeneous(Plugin):
    """A homogeneous medium: its extinction, albedo and phase function are constant."""

    kind: ClassVar[Kind] = "medium"
    roles: ClassVar[Mapping[Kind, str]] = {"phase": "phase"}
    hints: ClassVar[frozenset[str]] = frozenset({"sample_emitters", "has_spectral_extinction"})

    type: Literal["homogeneous"] = "homogeneous"
    albedo: Reflectance = (0.75, 0.75, 0.75)
    """Single-scattering albedo: the fraction of the extinction that is scattering, in [0, 1] per channel."""
    sigma_t: Coefficient = (1.0, 1.0, 1.0)
    """Extinction coefficient per channel, per unit of length of the scene."""
    scale: NonNegativeFloat = 1.0
    """Factor by which the extinction is multiplied."""
    phase: Phase = Isotropic()
    sample_emitters: bool = True
    """A sampling hint of Mitsuba, not used, like ``has_spectral_extinction``."""
    has_spectral_extinction: bool = True

    @model_validator(mode="before")
    @classmethod
    def _by_parts(cls, given: Any) -> Any:
        """Accept ``sigma_s`` and ``sigma_a``, as in older versions of Mitsuba; their sum is the extinction."""
        parts = {"sigma_s", "sigma_a"} & given.keys() if isinstance(given, Mapping) else set()
        if not parts:
            return given
        if parts != {"sigma_s", "sigma_a"} or {"sigma_t", "albedo"} & given.keys():
            raise ValueError("a medium has 'sigma_t' and 'albedo', or 'sigma_s' and 'sigma_a', not some of both")
        scattered, absorbed = as_coefficient(given["sigma_s"]), as_coefficient(given["sigma_a"])
        sums = [s + a for s, a in zip(scattered, absorbed, strict=True)]
        albedo = [s / t if t > 0.0 else 0.0 for s, t in zip(scattered, sums, strict=True)]
        return {k: v for k, v in given.items() if k not in parts} | {"sigma_t": sums, "albedo": albedo}


BlendPhase.model_rebuild()
Medium = Homogeneous
"""Any medium."""
