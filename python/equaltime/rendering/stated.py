"""Words for the number that a render states as its error: whether it is the whole error or only the noise.

If the scene asks for longer paths than the image has (``max_depth``), the number does not contain the difference. It
contains the bias of a strategy only if a pilot has measured that bias.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, TypeGuard

from equaltime.rendering.origin import Origin
from equaltime.statistics.in_words import count
from equaltime.strategy import Strategy

__all__ = [
    "Stated",
    "asked_samples",
    "different_problems",
    "not_as_asked",
    "other_depth",
    "paths_up_to",
    "samples_in_words",
    "shorter",
    "stated",
]

_COMPARE = "the bias is not in the noise: `equaltime compare` with a render by `best` measures it"


@dataclass(frozen=True)
class Stated:
    """Words that tell what the error stated by a render contains: its name, the paths, and the missing errors.

    A command prints them beside the number, so that noise alone is not called the error.
    """

    noun: Literal["error", "noise", "noise and measured bias"]
    """Name of the number; ``error`` if nothing is missing in it."""
    paths: str
    """Paths of the image, such as ``paths up to depth 2``, if the scene asks for others; else empty."""
    by_strategy: bool
    """Whether the strategy is biased by an amount that the stated number does not include."""
    missing: str
    """Errors that the stated number does not include, and how to measure them; empty if it is the whole error."""

    @property
    def of_paths(self) -> str:
        """Words to print after the error, such as ``of paths up to depth 2``: the paths that the image contains.

        The text is empty if these are exactly the paths that the scene asks for.
        """
        return f" of {self.paths}" if self.paths else ""


def paths_up_to(depth: int) -> str:
    """Return ``paths of any length`` for a negative depth, else words such as ``paths up to depth 2``."""
    return "paths of any length" if depth < 0 else f"paths up to depth {depth}"


def samples_in_words(spp: float, asked: int | None) -> str:
    """Return a mean number of samples a pixel in words, and why it is not the number ``asked``.

    ``asked`` is the number that ended the render; None if another limit did. Adaptive counts follow the noise, so that
    their mean is a few percent off.
    """
    return f"{count(spp)} samples a pixel{not_as_asked(spp, asked)}"


def not_as_asked(spp: float, asked: int | None) -> str:
    """Return in brackets why a mean number of samples a pixel is not the number ``asked``; empty if it is."""
    return "" if asked is None or round(spp) == asked else f" (for {asked:,}: more where it is noisy)"


def asked_samples(stopped_by: str, position: Sequence[int] | None) -> int | None:
    """Return the samples a pixel that were asked for, if they ended a render; None if another limit did.

    ``stopped_by`` and ``position`` are the values of its record.
    """
    return position[0] if stopped_by == "spp" and position else None


def shorter(depth: int, other: int | None) -> int:
    """Return the smaller of the path depth limits ``depth`` and ``other``; negative or None is no limit."""
    if other is None or other < 0:
        return depth
    return other if depth < 0 else min(depth, other)


def other_depth(depth: int, asked: int) -> str:
    """Return words such as ``paths up to depth 2; the scene asks for paths of any length``; empty if equal.

    ``depth`` is the largest path depth in the image, and ``asked`` the one that the scene asks for; negative: no limit.
    """
    return "" if depth == asked else f"{paths_up_to(depth)}; the scene asks for {paths_up_to(asked)}"


def different_problems(records: Sequence[tuple[Path, Mapping[str, Any]]]) -> Iterator[str]:
    """Yield notes, in words, for a comparison of images that show different scenes or have different path depths.

    A note also tells if the depth of the images is not the depth that their scene asks for. ``records`` holds the path
    and the record (JSON data on how it was made) of each image.
    """
    depths = {path: depth for path, said in records if _is_depth(depth := said.get("max_depth"))}
    shown = set(depths.values())
    if len(shown) > 1:
        listed = ", ".join(f"{path} shows {paths_up_to(depth)}" for path, depth in depths.items())
        yield f"images of two problems: {listed}. The noise that an image states does not contain the difference"
    for depth in shown if len(shown) == 1 else ():
        asked = {asked for _, said in records if _is_depth(asked := said.get("scene_max_depth"))}
        yield from (f"the images show {other_depth(depth, other)}" for other in asked - {depth})
    digests, names = ({str(said[key]) for _, said in records if said.get(key)} for key in ("digest", "scene"))
    if len(digests) > 1 and (len(shown) < 2 or len({Path(name).name for name in names}) > 1):
        yield "the files say that they show different scenes"


def _is_depth(value: object) -> TypeGuard[int]:
    return isinstance(value, int)


def stated(origin: Origin) -> Stated:
    """Return the words for the number that a render states as its error; ``origin`` tells how the render was made."""
    strategy = Strategy.parse(origin.strategy) if origin.backend == "core" else Strategy()
    longest = shorter(origin.max_depth, strategy.truncate)
    if any(name.startswith("long_paths") for name in origin.without):  # the number contains the measured cut
        strategy = strategy.model_copy(update={"truncate": None})
    asked = origin.max_depth if origin.scene_max_depth is None else origin.scene_max_depth
    depth = shorter(origin.max_depth, strategy.truncate)
    if depth == asked and not strategy.biased:
        return Stated("error", "", False, "")
    paths, missing = "", []
    if depth != asked:
        paths = paths_up_to(depth)
        measure = _measure(longest, origin.max_depth, asked) if shorter(depth, asked) == depth else ""
        missing.append(f"the scene asks for {paths_up_to(asked)}{measure}")
    if strategy.model_copy(update={"truncate": None}).biased:
        missing.append(_COMPARE)
    noun: Literal["noise", "noise and measured bias"] = "noise and measured bias" if origin.without else "noise"
    return Stated(noun, paths, strategy.biased, "; ".join(missing))


def _measure(longest: int, max_depth: int, asked: int) -> str:
    """Return the option of ``render`` that measures the light of paths longer than the image's longest; else empty."""
    if longest < 1:
        return ""
    instead = "" if max_depth == asked else f" instead of `--max-depth {max_depth}`"
    return f": `--without long_paths={longest}`{instead} measures the difference"
