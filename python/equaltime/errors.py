"""Every error that equaltime raises on purpose, and its category of warnings.

::

    EqualtimeError
    ├── SceneError          a scene cannot be read; carries every problem that was found
    ├── StrategyError       a strategy that does not exist or makes no sense
    ├── EffectError         an effect that does not exist, or that cannot be left out
    ├── ExperimentError     an experiment or its records cannot be used; carries every problem that was found
    ├── ImageError          an image file cannot be read, written, taken up or merged
    └── RenderError
        ├── BrightImage     a pixel is more than float32 can hold; carries the result
        ├── SampleError     a sample went wrong; carries what replays it
        │   ├── NonFiniteSample  it was NaN or infinite
        │   └── FaultySample     it raised a floating-point fault, and these are looked for
        └── PeerError       another renderer is missing, failed, or gave no image that can be compared
"""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Self

__all__ = [
    "BrightImage",
    "EffectError",
    "EqualtimeError",
    "EqualtimeWarning",
    "ExperimentError",
    "FaultySample",
    "ImageError",
    "NonFiniteSample",
    "PeerError",
    "Problem",
    "RenderError",
    "SampleError",
    "SceneError",
    "StrategyError",
]


class EqualtimeWarning(UserWarning):
    """A result may not be what was meant, such as a picture that is black everywhere."""


class EqualtimeError(Exception):
    """Base of all errors raised on purpose; its text is meant for people."""


@dataclass(frozen=True)
class Problem:
    """One mistake in a scene or an experiment, with its place."""

    place: str
    """``file:line`` or ``file: key.path``, as exact as the format allows."""
    message: str
    """The finding, the expectation, and the nearest known name."""

    def __str__(self) -> str:
        return f"{self.place}: {self.message}" if self.place else self.message


class SceneError(EqualtimeError):
    """A scene cannot be read; ``problems`` lists everything that was found, not just the first."""

    def __init__(self, problems: tuple[Problem, ...]) -> None:
        self.problems = problems
        super().__init__("\n".join(map(str, problems)))

    def __reduce__(self) -> tuple[type[Self], tuple[object, ...]]:
        return type(self), (self.problems,)


class EffectError(EqualtimeError):
    """An effect that does not exist, or cannot be left out of a scene, with those that can."""


class StrategyError(EqualtimeError):
    """A strategy that does not exist or a combination that makes no sense, with the reason."""


class ExperimentError(EqualtimeError):
    """An experiment, or its records, cannot be used; ``problems`` lists everything that was found."""

    def __init__(self, problems: tuple[Problem, ...]) -> None:
        self.problems = problems
        super().__init__("\n".join(map(str, problems)))

    def __reduce__(self) -> tuple[type[Self], tuple[object, ...]]:
        return type(self), (self.problems,)


class ImageError(EqualtimeError):
    """An image file cannot be read, written, taken up or merged."""


class RenderError(EqualtimeError):
    """Rendering failed after it had begun."""


class BrightImage(RenderError):
    """A pixel is more than float32 can hold; ``result`` has infinity there, and all samples."""

    def __init__(self, pixel: str, value: float, result: object = None, kept: str = "") -> None:
        self.pixel, self.value, self.result, self.kept = pixel, value, result, kept
        where = f" (infinite in {kept}, which has all samples)" if kept else ""
        super().__init__(f"{pixel} is {value:.3g}{where}, more than an image of float32 can hold")

    def __reduce__(self) -> tuple[type[Self], tuple[object, ...]]:
        return type(self), (self.pixel, self.value, self.result, self.kept)

    def with_result(self, result: object, kept: str = "") -> Self:
        """Return the error with another result, and the file where that is kept if it is."""
        return type(self)(self.pixel, self.value, result, kept)


class SampleError(RenderError):
    """A sample went wrong: its pass was finished, then this was raised.

    ``pixel`` is its place in the whole film, and ``command`` shows its path.
    """

    kind: ClassVar[str] = "bad sample"
    """Name of the problem if ``what`` is not given."""

    def __init__(
        self,
        pixel: tuple[int, int],
        index: int,
        seed: int,
        result: object,
        command: Sequence[str] = (),
        what: str | None = None,
    ) -> None:
        self.pixel, self.index, self.seed, self.result, self.command = pixel, index, seed, result, tuple(command)
        self.what = self.kind if what is None else what
        shown = f"; its path: {shlex.join(command)}" if command else ""
        super().__init__(f"{self.what} at pixel {pixel[0]},{pixel[1]}, sample {index}, seed {seed}{shown}")

    def __reduce__(self) -> tuple[type[Self], tuple[object, ...]]:
        return type(self), (self.pixel, self.index, self.seed, self.result, self.command, self.what)

    def with_words(self, *words: str) -> Self:
        """Return the error with more words of the command, if there is one."""
        command = (*self.command, *words) if self.command else ()
        return type(self)(self.pixel, self.index, self.seed, self.result, command, self.what)


class NonFiniteSample(SampleError):
    """A sample was NaN or infinite."""

    kind = "non-finite sample"


class FaultySample(SampleError):
    """A sample raised a floating-point fault, which ``what`` names, whatever its value."""


class PeerError(RenderError):
    """Another renderer is missing, failed, or gave no image that can be compared."""
