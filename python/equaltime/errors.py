"""All errors that equaltime raises on purpose, and the category of all its warnings.

::

    EqualtimeError
    ├── SceneError          a scene cannot be read; carries every problem that was found
    ├── StrategyError       a strategy that does not exist or makes no sense
    ├── EffectError         an effect that does not exist, or that cannot be left out
    ├── ExperimentError     an experiment or its records cannot be used; carries every problem that was found
    ├── ImageError          an image file cannot be read, written, resumed or merged
    └── RenderError
        ├── BrightImage     a pixel is more than float32 can hold; carries the result
        ├── SampleError     a sample is unusable; carries the data that replay the sample
        │   ├── NonFiniteSample  the sample is NaN or infinite
        │   └── FaultySample     the sample raised a floating-point fault
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
    """Warning that a result may not be what was meant, such as a picture that is black everywhere."""


class EqualtimeError(Exception):
    """Base class of all errors that equaltime raises on purpose. The message is written for the user."""


@dataclass(frozen=True)
class Problem:
    """One mistake in a scene or an experiment, with the file and line (or path of keys) where it was found."""

    place: str
    """``file:line`` or ``file: key.path``, as exact as the format allows."""
    message: str
    """Text that says which value was found, which values are allowed, and often the nearest known name."""

    def __str__(self) -> str:
        return f"{self.place}: {self.message}" if self.place else self.message


class SceneError(EqualtimeError):
    """Raised if a scene cannot be read; ``problems`` lists every mistake found, not just the first."""

    def __init__(self, problems: tuple[Problem, ...]) -> None:
        self.problems = problems
        super().__init__("\n".join(map(str, problems)))

    def __reduce__(self) -> tuple[type[Self], tuple[object, ...]]:
        return type(self), (self.problems,)


class EffectError(EqualtimeError):
    """Raised if effects cannot be left out as requested; an effect is a feature of the scene or of its light.

    Reasons are an unknown effect, an effect that must stay, and a bias above the requested error.
    """


class StrategyError(EqualtimeError):
    """Raised if a strategy does not exist or its settings do not fit together; the message gives the reason."""


class ExperimentError(EqualtimeError):
    """Raised if an experiment or its records (saved results) cannot be used; ``problems`` lists every mistake found."""

    def __init__(self, problems: tuple[Problem, ...]) -> None:
        self.problems = problems
        super().__init__("\n".join(map(str, problems)))

    def __reduce__(self) -> tuple[type[Self], tuple[object, ...]]:
        return type(self), (self.problems,)


class ImageError(EqualtimeError):
    """Raised if an image file cannot be read, written, resumed or merged."""


class RenderError(EqualtimeError):
    """Raised if a render fails or cannot begin, such as for lack of memory."""


class BrightImage(RenderError):
    """Raised if a pixel is larger than float32 can hold. ``result`` holds the render, with infinity at this pixel."""

    def __init__(self, pixel: str, value: float, result: object = None, kept: str = "") -> None:
        self.pixel, self.value, self.result, self.kept = pixel, value, result, kept
        where = f" (infinite in {kept}, which has all samples)" if kept else ""
        super().__init__(f"{pixel} is {value:.3g}{where}, more than an image of float32 can hold")

    def __reduce__(self) -> tuple[type[Self], tuple[object, ...]]:
        return type(self), (self.pixel, self.value, self.result, self.kept)

    def with_result(self, result: object, kept: str = "") -> Self:
        """Return a copy of this error that carries another result, such as one with the outputs beside the image.

        ``kept`` names the file in which that result is saved; empty if it is not saved.
        """
        return type(self)(self.pixel, self.value, result, kept)


class SampleError(RenderError):
    """Raised if a sample is NaN or infinite, or if its computation raised a floating-point fault.

    A render raises the error at the end of the pass over the image in which the sample was rendered. ``pixel`` is the
    sample's pixel (x, y) in the whole film, and ``index`` its number within the pixel. ``seed`` is the seed of the
    render. ``result`` is the render so far. ``command`` is a command line, as a tuple of words, that shows the sample's
    path; empty if no command can show the path.
    """

    kind: ClassVar[str] = "bad sample"
    """Name of the problem in the error message, unless the argument ``what`` names it."""

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
        """Return a copy of this error with ``words``, such as options, appended to ``command``.

        An empty command stays empty.
        """
        command = (*self.command, *words) if self.command else ()
        return type(self)(self.pixel, self.index, self.seed, self.result, command, self.what)


class NonFiniteSample(SampleError):
    """Raised if a sample is NaN or infinite."""

    kind = "non-finite sample"


class FaultySample(SampleError):
    """Raised if a sample caused a floating-point fault, even if its value is finite; ``what`` names the fault."""


class PeerError(RenderError):
    """Raised if another renderer is missing, failed, or gave no image that can be compared."""
