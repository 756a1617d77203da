"""The words around the number that a render states, which is the image's error or only its noise.

``max_depth`` belongs to the problem. If the scene asks for longer paths than the image has, the number does not contain
the difference. The bias of a strategy is not in it either, unless a pilot has measured it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeGuard

from equaltime.strategy import Strategy

if TYPE_CHECKING:
    from equaltime.rendering.result import Origin

__all__ = ["Stated", "different_problems", "other_depth", "paths_up_to", "shorter", "stated"]

_COMPARE = "the bias is not in the noise: `equaltime compare` with a render by `best` measures it"


@dataclass(frozen=True)
class Stated:
    """The words around the number that a render states."""

    noun: Literal["error", "noise", "noise and measured bias"]
    """``error`` if nothing is missing in the number."""
    paths: str
    """The paths of the image, such as ``paths up to depth 2``, if the scene asks for others; else empty."""
    by_strategy: bool
    """Whether the strategy is biased by an amount that is not in the number."""
    missing: str
    """What the number says nothing of, and what measures it; empty if it is the whole error."""

    @property
    def of_paths(self) -> str:
        """The paths as they follow the number."""
        return f" of {self.paths}" if self.paths else ""


def paths_up_to(depth: int) -> str:
    """Return ``all paths``, or ``paths up to depth 2``."""
    return "all paths" if depth < 0 else f"paths up to depth {depth}"


def shorter(depth: int, other: int | None) -> int:
    """Return the smaller of two depths; -1 is no limit, and so is None."""
    if other is None or other < 0:
        return depth
    return other if depth < 0 else min(depth, other)


def other_depth(depth: int, asked: int) -> str:
    """Return ``paths up to depth 2; the scene asks for all paths``; empty if both depths are the same."""
    return "" if depth == asked else f"{paths_up_to(depth)}; the scene asks for {paths_up_to(asked)}"


def different_problems(records: Sequence[tuple[Path, Mapping[str, Any]]]) -> Iterator[str]:
    """Note where images, given with their records, are of different problems, or of another than their scene's."""
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
    """Return the words for a render of this origin."""
    strategy = Strategy.parse(origin.strategy) if origin.backend == "core" else Strategy()
    longest = shorter(origin.max_depth, strategy.truncate)
    if any(name.startswith("long_paths") for name in origin.without):  # the cut is measured, and in the number
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
    """Return which option of ``render`` measures what the paths bring that are longer than the longest of the image."""
    if longest < 1:
        return ""
    instead = "" if max_depth == asked else f" instead of `--max-depth {max_depth}`"
    return f": `--without long_paths={longest}`{instead} measures the difference"
