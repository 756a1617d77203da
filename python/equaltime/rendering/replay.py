"""One sample of a render, traced again vertex by vertex, with every factor that contributes to it.

The path goes through the same estimator as in a render, so its radiance is the render's sample, bit by bit. The
contributions of its vertices sum up to that radiance.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from equaltime.rendering.brightest import Brightest, brightest_sample
from equaltime.rendering.core import traced
from equaltime.rendering.job import DEFAULT_SPP, as_scene, check_arguments, is_whole
from equaltime.scene import Scene
from equaltime.scene.effects.leaving import leave_out
from equaltime.scene.model import MOST_SAMPLES
from equaltime.scene.naming import Names
from equaltime.strategy import Strategy
from equaltime.words import Shown

__all__ = ["Replay", "replay"]

Color = tuple[float, float, float]


@dataclass(frozen=True, repr=False)
class Replay(Shown):
    """The path of one sample of a render, vertex by vertex, to find the cause of a bright dot or a NaN.

    Lengths and radiance are in the scene's units. Probability densities of directions are per solid angle.
    """

    pixel: tuple[int, int]
    """Position in the whole film, from the left and from the top, in pixels."""
    sample: int
    seed: int
    strategy: str
    filter_weight: float
    """Weight of the sample's position under the pixel's filter."""
    radiance: Color
    """Contribution of the sample to its pixel: the sum over the vertices, in their order, times the filter's weight."""
    end: str
    """Reason why the path ends: ``escapes`` (leaves the scene), ``depth`` (has the largest depth), ``absorbed``,
    ``no_direction`` (no direction sampled), ``black`` (throughput 0), ``not_finite``, ``roulette``.
    """
    vertices: tuple[Mapping[str, Any], ...] = field(hash=False)
    """Vertices of the path, as dictionaries. ``origin`` and ``direction`` are the ray towards the vertex.
    ``throughput`` is the path's throughput at the start of the ray, and ``left`` after the medium along the ray.
    ``gathered`` is the path's radiance before the vertex. ``surface`` is the surface hit, and ``particle`` the position
    where a medium scatters the path before any surface. ``emitter`` is the emitter or environment that the ray meets.
    ``light`` is the sampled light, and ``scattering`` the scattering at the vertex. ``faults`` names the floating-point
    faults raised. ``from`` is the index of the vertex that the ray leaves, None at the camera. Keys of things that do
    not occur hold None."""
    brightest: Brightest | None = None
    """Comparison with the pixel's other samples, if the brightest sample was asked for; None otherwise."""

    def __str__(self) -> str:
        color = ", ".join(f"{channel:.4g}" for channel in self.radiance)
        lines = [f"pixel {self.pixel[0]},{self.pixel[1]}, sample {self.sample}: radiance ({color})"]
        if self.brightest is not None:
            lines.append(str(self.brightest))
        return "\n".join([*lines, f"{len(self.vertices)} vertices; the path ends: {self.end}"])

    @property
    def sum(self) -> Color:
        """Sum of the vertices' contributions, in float32 as in the render, times the weight of the pixel's filter."""
        total = np.zeros(3, np.float32)
        with np.errstate(over="ignore", invalid="ignore"):
            for vertex in self.vertices:
                for part in (vertex["emitter"], vertex["light"]):
                    if part is not None:
                        total += np.array(part.get("gathered", (0.0, 0.0, 0.0)), np.float32)
            red, green, blue = (total * np.float32(self.filter_weight)).tolist()
        return red, green, blue

    @property
    def first_nonfinite(self) -> tuple[int, str] | None:
        """First number of the path that is NaN or infinite, as (index of its vertex, name of the number).

        None if all numbers are finite.
        """
        for index, vertex in enumerate(self.vertices):
            if name := _nonfinite(vertex):
                return index, name
        return None

    def as_dict(self) -> dict[str, Any]:
        """Return the replay as JSON data. NaN and infinities, which JSON lacks, become the words nan, inf and -inf."""
        data = {name: getattr(self, name) for name in self.__dataclass_fields__}
        brightest = None if self.brightest is None else vars(self.brightest)
        record: dict[str, Any] = _as_json({**data, "sum": self.sum, "brightest": brightest})
        return record


def replay(
    scene: Scene | str | os.PathLike[str] | Mapping[str, Any],
    *,
    pixel: tuple[int, int],
    sample: int | None = None,
    spp: int | None = None,
    strategy: Strategy | str = "best",
    seed: int = 0,
    without: Sequence[str] = (),
) -> Replay:
    """Return the path of a sample of a pixel, exactly as a render with this seed traces it.

    ``pixel`` is (x, y) in the whole film, and ``sample`` the number of the sample in the pixel, from 0. Without
    ``sample``, the brightest of the pixel's first ``spp`` samples is replayed, and `Replay.brightest` compares the
    brightest with the others. Without ``spp``, the scene's own sample count is taken, or else 64. An adaptive render
    may have taken more samples of a noisy pixel. ``without`` names effects (features such as media) that are left out.

    Raises
    ------
    SceneError, StrategyError, EffectError
        If the scene or the strategy cannot be read, or an effect cannot be left out.
    ValueError
        If the pixel is not on the film, if both ``sample`` and ``spp`` are given, or if an argument is out of range or
        of another type.

    Examples
    --------
    >>> path = et.replay("scene.toml", pixel=(3, 4), sample=0)
    >>> path.pixel, len(path.vertices) > 0
    ((3, 4), True)
    >>> et.replay("scene.toml", pixel=(3, 4), spp=16).brightest.samples
    16
    """
    check_arguments(spp=spp, seed=seed)
    if sample is not None and spp is not None:
        raise ValueError("sample names one sample, and spp a number of samples to choose from: give only one of them")
    if sample is not None and not (is_whole(sample) and 0 <= sample < MOST_SAMPLES):
        raise ValueError(f"sample must be a whole number from 0 to {MOST_SAMPLES - 1}, found {sample!r}")
    if not (isinstance(pixel, Sequence) and len(pixel) == 2 and all(map(is_whole, pixel))):
        raise ValueError(f"pixel must be two whole numbers, (x, y), found {pixel!r}")
    chosen = Strategy.of(strategy)
    loaded, chosen = leave_out(as_scene(scene), chosen, without)
    x, y, width, height = loaded.model.sensor.film.crop
    if not (x <= pixel[0] < x + width and y <= pixel[1] < y + height):
        raise ValueError(f"pixel {pixel[0]},{pixel[1]} is not on the film, {width}x{height} from {x},{y}")
    brightest = None
    if sample is None:
        loaded = loaded.with_(crop=(*pixel, 1, 1))
        brightest = brightest_sample(loaded, chosen, spp or loaded.spp or DEFAULT_SPP, seed)
        sample = brightest.sample
    path = traced(loaded, chosen, pixel, sample, seed)
    names = Names(loaded)
    for vertex in path["vertices"]:
        _name(vertex, names)
    return Replay(
        pixel=pixel,
        sample=sample,
        seed=seed,
        strategy=chosen.name,
        filter_weight=path["filter_weight"],
        radiance=path["radiance"],
        end=path["end"],
        vertices=tuple(path["vertices"]),
        brightest=brightest,
    )


def _name(vertex: dict[str, Any], names: Names) -> None:
    """Add names and positions to the surfaces and lights of a vertex."""
    blocker = (vertex["light"] or {}).get("blocker")
    for surface in (vertex["surface"], blocker):
        if surface is not None:
            surface["name"] = str(names.shape(surface["shape"]))
            copy = None if surface["instance"] is None else str(names.instance(surface["instance"]))
            if copy not in (None, surface["name"]):  # a moving shape is an instance of itself
                surface["name"] += f", seen as {copy}"
    for found in (vertex["emitter"], vertex["light"]):
        if found is None:
            continue
        light = found["light"]
        number = light.pop("delta")
        if light["kind"] == "area":
            name = names.shape(light["shape"])
        else:
            name = names.environment() if light["kind"] == "environment" else names.delta_light(number)
            light["kind"] = name.type
        light["name"] = str(name)


def _nonfinite(value: Any) -> str | None:
    """Return the name of the first number inside that is not finite; blank if the value itself is that number."""
    if isinstance(value, float):
        return None if math.isfinite(value) else " "
    if isinstance(value, tuple):
        return " " if any(_nonfinite(item) for item in value) else None
    if isinstance(value, Mapping):
        for name, item in value.items():
            if inner := _nonfinite(item):
                return f"{name} {inner}".strip()
    return None


def _as_json(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {name: _as_json(item) for name, item in value.items()}
    if isinstance(value, tuple | list):
        return [_as_json(item) for item in value]
    return str(value) if isinstance(value, float) and not math.isfinite(value) else value
