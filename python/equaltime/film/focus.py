"""Light that specular surfaces focus: a reason to doubt an error, known from the scene before the first sample.

If a small lamp shines through glass or by way of a mirror, paths meet its light by chance alone: no sampling technique
aims at the lamp. A diffuse surface meets a lamp of solid angle ``Ω`` with at most the share ``p = Ω / π`` of its
samples. Let n be the samples of a pixel. While ``n p`` is small, most pixels have met none of that light, and their
variance does not show that it is missing. The error is then higher than its interval says. Two numbers tell whether the
missing light can matter: the radiance of a white surface in that light, and the share of paths that meet specular
surfaces.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from equaltime.film.sums import focused_light
from equaltime.machine import worker_threads
from equaltime.statistics.in_words import figure, rounded

__all__ = ["Focus"]

_PATHS = 4096
_SURFACES = "specular surfaces"
"""Words for surfaces of unknown kinds."""
_SMALL = 0.25
"""Largest share of a diffuse surface's samples for a small emitter: the first samples meet larger ones."""
_MANY = 10.0
"""Expected meetings of a pixel's samples with focused light from which its variance shows that light."""
_RARELY = 1.0 / 64.0
"""Share of a diffuse surface's samples at which 64 of them meet a small emitter once on average."""
_MATTERS = 0.5
"""Least share of the stated error that light without a variance must be able to make to be a reason for doubt."""


@dataclass(frozen=True)
class Focus:
    """Light that specular surfaces of a scene focus: three numbers that tell whether a render's error can be trusted.

    ``paths`` tells how often paths meet such surfaces. ``light`` bounds the radiance of a white surface in the focused
    light. ``share`` bounds the share of a surface's samples that meet the focused emitters.
    """

    paths: float
    """Share of paths that meet a specular surface."""
    light: float
    """Bound of the radiance of a white diffuse surface in the focused light, with emitters that nothing occludes.

    It is the mean over the specular vertices of the paths of ``∫ L dω / π``, with L the emitters' luminance, in the
    units of the image.
    """
    share: float
    """Largest share of a diffuse surface's samples that meet the emitters: their effective solid angle over π."""
    surfaces: str = _SURFACES
    """Kinds of surfaces that may focus light in the scene, in words: ``glass and mirrors``."""

    @classmethod
    def of(
        cls,
        scene: Any,
        settings: Any,
        seed: int,
        threads: int,
        whole_film: bool = False,
        surfaces: Callable[[], str] = str,
    ) -> Focus:
        """Return how much light the specular surfaces of a core's scene focus, estimated from 4096 paths.

        ``settings`` are the core's settings of the render, and ``seed`` is the seed of the paths. The paths start in
        the crop window, or with ``whole_film`` in the whole film. ``threads`` is the number of threads; 0 is one for
        each processor. ``surfaces`` returns the kinds of the scene's specular surfaces in words; empty if unknown.
        """
        vertices, radiance, solid_angle = focused_light(
            scene, settings, seed, worker_threads(threads), _PATHS, whole_film
        )
        return cls(vertices / _PATHS, radiance, solid_angle / math.pi, surfaces() or _SURFACES)

    @classmethod
    def none(cls) -> Focus:
        """Return the focused light of a scene without specular surfaces: all three numbers are 0."""
        return cls(0.0, 0.0, 0.0)

    @property
    def possible(self) -> bool:
        """Whether specular surfaces focus light of emitters so small that the first samples may miss them."""
        return self.paths > 0.0 and self.light > 0.0 and self.share < _SMALL

    @property
    def rarely_met(self) -> bool:
        """Whether focused light (caustics) is so rare that most pixels meet it at most once in 64 samples."""
        return self.possible and self.share < _RARELY

    def rare(self, samples: float) -> bool:
        """Tell whether the ``samples`` of a pixel, a number, may have met no focused light.

        The variance of such a pixel does not contain that light, so the stated error may be too small.
        """
        return self.possible and samples * self.share < _MANY

    def doubt(self, samples: float, error: float, mean: float) -> str:
        """Return, in words, why focused light may make the true error larger than stated; empty if it cannot.

        Parameters
        ----------
        samples
            Samples per pixel, on average.
        error
            Relative error that the render states for the image: 0.02 is 2 %.
        mean
            Mean of the image over pixels and channels.
        """
        if not self.rare(samples) or not mean > 0.0:
            return ""
        unmet = self.light / mean * math.sqrt(self.paths * min(1.0, 1.0 / (samples * self.share)))
        if unmet < _MATTERS * error:
            return ""
        often = rounded(1.0 / self.share)
        return (
            f"small bright emitters reach the image by way of {self.surfaces}, where samples meet them by chance, at "
            f"most one in {often}; light that the {figure(samples)} samples of a pixel have not met is not in the "
            "error; more samples, or larger and dimmer emitters, bring it in"
        )

    @classmethod
    def from_dict(cls, data: Mapping[str, Any] | None) -> Focus:
        """Return the object from its fields by name in ``data``; for None, all three numbers are 0 (`Focus.none`)."""
        if data is None:
            return cls.none()
        return cls(data["paths"], data["light"], data["share"], data.get("surfaces") or _SURFACES)
