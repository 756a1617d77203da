"""The light that makes the noise of a render: direct or indirect, by lamp, by surface, and by technique.

A small film is rendered a few times with independent seeds, and its light is split (`equaltime.quoting.noise_parts`).
The share of a part of the light in the variance is ``Cov(part, whole) / Var(whole)``, where whole stands for the image.
It is a share of error² for that film and its samples per pixel: edges make more of the error there than on a larger
film. Shares of one kind sum to 1, since each covariance of two parts is divided equally between them. A part that
cancels noise of others has a negative share. For indirect light and the rest, three more numbers are stated: the noise
that each would make alone, and twice their covariance. These sum to 1 as well. Intervals are at 95 %, by the jackknife
over seeds.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from equaltime.quoting.light_parts import KINDS_OF_PARTS
from equaltime.quoting.noise_parts import REFERENCE, measure_noise_parts
from equaltime.scene import Scene
from equaltime.scene.scene import smaller
from equaltime.statistics.intervals import Interval
from equaltime.strategy import Strategy
from equaltime.strict_json import fields_to_json

__all__ = ["LEAST_PATHS", "NoiseLight", "noise_light"]

REPEATS = 8
MOST_PIXELS = 64 * 64
MOST_SAMPLES, LEAST_SAMPLES = 8, 2
LEAST_PIXELS = 24 * 24
_SPLITTING = 2.5
"""Largest cost of a path whose light is split, in paths of a render: 1.6 to 2.1 measured, and the start."""
_COST = REFERENCE + _SPLITTING * REPEATS
LEAST_PATHS = _COST * LEAST_SAMPLES * LEAST_PIXELS
"""Least number of camera paths that `noise_light` needs for a result."""


@dataclass(frozen=True)
class NoiseLight:
    """Light that makes the noise of a render: shares of error², as fractions with their 95 % intervals."""

    seen: Interval
    """Share of error² of light that the camera sees directly, as at edges of lamps. ``seen``, ``direct`` and
    ``indirect`` sum to 1."""
    direct: Interval
    """Share of error² of direct light: paths that leave a lamp and are scattered once on the way to the camera."""
    indirect: Interval
    """Share of error² of indirect light: paths that are scattered more than once."""
    alone: Interval
    """Fraction of error² that would remain if indirect light had no noise."""
    indirect_alone: Interval
    """Fraction of error² that would remain if only indirect light had noise."""
    common: Interval
    """Twice the covariance of indirect light and all other light, as a fraction of the variance. ``common``, ``alone``
    and ``indirect_alone`` sum to 1."""
    kinds: Mapping[str, Mapping[str, Interval]] = field(hash=False)
    """Shares of error² by kind (``length`` of the path, ``way`` or technique, ``bsdf`` and ``surface`` that the
    light of a source falls on, ``light`` source), then by name. The shares of each kind sum to 1."""
    size: tuple[int, int]
    """Width and height of the measured film, in pixels."""
    samples: int
    """Samples per pixel in each repeat."""
    repeats: int
    """Number of renders with independent seeds."""
    doubt: str = ""
    """Reason, in words, why the intervals cannot be trusted: few bright paths make the noise. Empty if they can be
    trusted."""

    def as_dict(self) -> dict[str, Any]:
        """Return the fields by name as JSON data."""
        return fields_to_json(self, without=() if self.doubt else ("doubt",))


def noise_light(
    scene: Scene,
    strategy: Strategy,
    paths: float,
    seed: int = 0,
    threads: int = 0,
) -> NoiseLight | None:
    """Return the share of a render's error² that each kind of light makes, measured on a small film.

    The shares tell which light to sample better, or to leave out, for an image with less noise.

    Parameters
    ----------
    scene, strategy
        Scene and strategy of the render.
    paths
        Work that the measurement may take, as a number of camera paths; at most 1.7 million are used.
    seed
        First seed; each repeat takes the next one.
    threads
        Number of worker threads; 0 is one for each processor.

    Returns
    -------
    NoiseLight | None
        Shares of light; None if ``paths`` is less than `LEAST_PATHS`.
    """
    if paths < LEAST_PATHS:
        return None
    small = smaller(scene, min(MOST_PIXELS, paths / (_COST * LEAST_SAMPLES)))
    _, _, width, height = small.model.sensor.film.crop
    most = max(LEAST_SAMPLES, min(MOST_SAMPLES, paths / (_COST * width * height)))
    samples = 2 ** math.floor(math.log2(most))
    seed = min(seed, 2**64 - 1 - REPEATS)
    parts = measure_noise_parts(small, strategy, REPEATS, samples, seed, threads)
    return NoiseLight(
        seen=parts.share("length", lambda what: _length(what) == 1),
        direct=parts.share("length", lambda what: _length(what) == 2),
        indirect=parts.share("length", lambda what: _length(what) > 2),
        alone=_positive(parts.apart(2)[1]),
        indirect_alone=_positive(parts.apart(2)[0]),
        common=parts.common(2),
        kinds={kind: parts.shares(kind) for kind in KINDS_OF_PARTS},
        size=(width, height),
        samples=samples,
        repeats=REPEATS,
        doubt=parts.doubt,
    )


def _positive(share: Interval) -> Interval:
    """Return a share that cannot be negative, with its lower end raised to 0."""
    return replace(share, low=max(share.low, 0.0))


def _length(what: str) -> int:
    return int(what.split()[0])
