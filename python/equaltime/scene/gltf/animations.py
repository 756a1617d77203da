"""Animations of a glTF file: transforms of nodes and deformations of meshes while the shutter is open."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from equaltime.scene.gltf.accessors import floats
from equaltime.scene.gltf.document import Document, Malformed

__all__ = ["NO_TURN", "Clip", "played"]

Array = NDArray[np.float64]

PARTS: Final = 16
"""Number of equal parts of the shutter's time. A key is computed at the ends of each part, because nested nodes do not
move along straight lines."""
MOST_KEYS: Final = 512
WIDTHS: Final = {"translation": "VEC3", "rotation": "VEC4", "scale": "VEC3"}
PATHS: Final = (*WIDTHS, "weights")
NO_TURN: Final = "a rotation whose four numbers are 0 counts as none"
JUST: Final = 1e-6
"""Duration of a jump with STEP interpolation, as a fraction of the shutter's time."""


@dataclass(frozen=True, slots=True, eq=False)
class _Channel:
    """One parameter of one node over time."""

    times: Array
    values: Array
    """(times, components), or with CUBICSPLINE (times, 3, components): tangent in, value, tangent out"""
    interpolation: str
    turns: bool
    """Whether the values are quaternions."""

    def at(self, time: float) -> Array:
        after = int(np.searchsorted(self.times, time, side="right"))
        cubic = self.interpolation == "CUBICSPLINE"
        keys = self.values[:, 1] if cubic else self.values
        if after == 0 or after == len(self.times) or self.interpolation == "STEP":
            held: Array = keys[max(after - 1, 0)]
            return held
        span = self.times[after] - self.times[after - 1]
        u = (time - self.times[after - 1]) / span
        a, b = keys[after - 1], keys[after]
        if cubic:  # Hermite spline of the specification
            out, into = span * self.values[after - 1, 2], span * self.values[after, 0]
            u2, u3 = u**2, u**3
            curve: Array = (
                (2 * u3 - 3 * u2 + 1) * a + (u3 - 2 * u2 + u) * out + (3 * u2 - 2 * u3) * b + (u3 - u2) * into
            )
            return curve
        if self.turns:
            return _slerp(a, b, u)
        straight: Array = (1 - u) * a + u * b
        return straight


def _slerp(a: Array, b: Array, u: float) -> Array:
    a, b = a / np.linalg.norm(a), b / np.linalg.norm(b)
    b = -b if a @ b < 0.0 else b
    angle = 2.0 * np.arctan2(np.linalg.norm(b - a), np.linalg.norm(b + a))
    weights = np.array([1.0 - u, u])
    turned: Array = (np.sin(weights * angle) / np.sin(angle) if angle > 1e-9 else weights) @ np.array([a, b])
    return turned


@dataclass(frozen=True, slots=True, eq=False)
class Clip:
    """The section of a glTF animation while the shutter is open, with the properties of nodes at any time."""

    times: tuple[float, ...]
    """Times at which transforms are evaluated, in seconds, from opening to closing of the shutter."""
    number: int
    """Index of the animation in the file."""
    ends: float
    """Time of the animation's last key, in seconds; infinite without keys."""
    _channels: dict[tuple[int, str], _Channel]

    def fields(self, node: int, time: float) -> dict[str, Array]:
        """Return the animated properties of node `node` at `time`, in seconds.

        Possible keys are ``translation``, ``rotation``, ``scale`` and ``weights``. Properties without animation are
        left out.
        """
        return {path: self._channels[node, path].at(time) for path in PATHS if (node, path) in self._channels}

    @property
    def even(self) -> tuple[float, ...]:
        """Evenly spaced times, in seconds, at which deforming meshes are evaluated; one time for a still.

        The core requires equal spacing.
        """
        if len(self.times) == 1:
            return self.times
        return tuple(np.linspace(self.times[0], self.times[-1], PARTS + 1).tolist())

    def morphing(self, node: int) -> tuple[float, ...]:
        """Return the times, in seconds, at which to evaluate the morph targets of node `node`.

        The tuple is empty if the weights of the morph targets are not animated. It has one time if the animated weights
        are constant.
        """
        channel, begin, end = self._channels.get((node, "weights")), self.times[0], self.times[-1]
        if channel is None:
            return ()
        if all((channel.at(time) == channel.at(begin)).all() for time in self.times):
            return (begin,)
        straight = channel.interpolation == "LINEAR" and not ((begin < channel.times) & (channel.times < end)).any()
        return (begin, end) if straight else self.even


def played(document: Document, number: int, shutter: tuple[float, float] | None) -> Clip:
    """Return the section of animation `number` of `document` while the shutter is open, as a `Clip`.

    The pair `shutter` has the times of opening and closing, in seconds; for a still they are equal. None stands for the
    whole animation. Raises `Malformed` if the data of the animation is not valid.
    """
    animation = document.gltf.animations[number]
    channels: dict[tuple[int, str], _Channel] = {}
    for i, channel in enumerate(animation.channels):
        place = f"animations[{number}].channels[{i}]"
        if channel.target.node is None:
            continue
        targets = _targets(document, channel.target.node)
        if channel.target.path not in PATHS or (channel.target.path == "weights" and not targets):
            document.note(f"'{channel.target.path}' is not animated: it stays as in the file", place)
            continue
        if channel.target.path in WIDTHS and document.gltf.nodes[channel.target.node].matrix:
            document.note("the matrix of a node that an animation moves is not used", f"nodes[{channel.target.node}]")
        if channel.sampler >= len(animation.samplers):
            raise Malformed((f"{place}.sampler", f"expected one of {len(animation.samplers)} samplers"))
        sampler = animation.samplers[channel.sampler]
        found = _channel(document, sampler, channel.target.path, targets, place)
        if (channel.target.node, channel.target.path) in channels:
            document.note(f"'{channel.target.path}' of a node has several channels: the last is used", place)
        channels[channel.target.node, channel.target.path] = found
    if shutter is None:
        times = np.concatenate([np.zeros(1), *(channel.times for channel in channels.values())])
        shutter = float(times.min()), float(times.max())
    ends = max((float(channel.times[-1]) for channel in channels.values()), default=float("inf"))
    return Clip(_moments(list(channels.values()), shutter), number, ends, channels)


def _targets(document: Document, node: int) -> int:
    """Return how many morph targets the mesh of a node has."""
    mesh = document.gltf.nodes[node].mesh
    return 0 if mesh is None else max(len(p.targets or ()) for p in document.gltf.meshes[mesh].primitives)


def _channel(document: Document, sampler: Any, path: str, targets: int, place: str) -> _Channel:
    times = floats(document, sampler.input, "SCALAR")[:, 0]
    values = floats(document, sampler.output, WIDTHS.get(path, "SCALAR"))
    width = targets if path == "weights" else 1  # elements of the accessor for one value
    interpolation = sampler.interpolation or "LINEAR"
    keys = (3 * len(times) if interpolation == "CUBICSPLINE" else len(times)) * width
    if not len(times):
        raise Malformed((place, "needs at least one time"))
    if len(values) != keys or not np.isfinite(values).all():
        raise Malformed((place, f"expected {keys} finite values for {len(times)} times, found {len(values)}"))
    if not np.isfinite(times).all() or (np.diff(times) <= 0.0).any():
        raise Malformed((place, "the times of an animation must be finite and increase"))
    values = values.reshape((len(times), 3, -1) if interpolation == "CUBICSPLINE" else (len(times), -1))
    if path == "rotation" and interpolation == "LINEAR" and not values.any(axis=1).all():
        document.note(NO_TURN, place)
        values[~values.any(axis=1)] = (0.0, 0.0, 0.0, 1.0)
    return _Channel(times, values, interpolation, path == "rotation")


def _moments(channels: list[_Channel], shutter: tuple[float, float]) -> tuple[float, ...]:
    """Return the times to evaluate: evenly spaced ones, all keys, and the times just before a step."""
    begin, end = shutter
    if begin == end:
        return (begin,)
    moments = [np.linspace(begin, end, PARTS + 1)]
    for channel in channels:
        moments.append(channel.times)
        if channel.interpolation == "STEP":
            moments.append(channel.times - JUST * (end - begin))
    found = np.unique(np.concatenate(moments))
    inside = found[(begin <= found) & (found <= end)]
    return tuple((inside if len(inside) <= MOST_KEYS else moments[0]).tolist())
