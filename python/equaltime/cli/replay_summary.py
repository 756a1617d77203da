"""One line on a replayed path: the surfaces by name, and the light that added most to the sample."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

from equaltime.rendering.replay import Replay
from equaltime.scene.effects.leaving import LUMINANCE
from equaltime.words import percent

__all__ = ["path_in_short"]

_SHOWN: Final = 8
"""Most surfaces that the line names, so that it stays readable; of longer paths the first and the last are named."""
_NAMED: Final = re.compile(r"'(.*)' \(.*\)", re.DOTALL)
"""Name of an object that has an id, as `equaltime.scene.naming.Name` writes it."""


def path_in_short(path: Replay) -> str | None:
    """Return the line on a path: its surfaces up to the vertex that added most, the light, and the share in percent.

    Shares are of luminance. Return None if a number of the path is not finite: shares then have no meaning.
    """
    parts = [*_parts(path.vertices)]
    total = sum(luminance for _, _, luminance in parts)
    if path.first_nonfinite is not None or not math.isfinite(total):
        return None
    if total <= 0.0:
        return f"path: {' -> '.join(_surfaces(path.vertices, len(path.vertices) - 1)) or 'no surface'}: no light"
    index, kind, luminance = max(parts, key=lambda part: part[2])
    light = _short(path.vertices[index][kind]["light"]["name"])
    last = index if kind == "light" else path.vertices[index]["from"]
    chain = [*_surfaces(path.vertices, last), light]
    how = "aims at" if kind == "light" else "meets"
    share = percent(luminance / total)
    return f"path: {' -> '.join(chain)}: vertex {index + 1} {how} this light, which adds {share} of the sample"


def _parts(vertices: Sequence[Mapping[str, Any]]) -> Iterator[tuple[int, str, float]]:
    """Yield all that adds to the path: index of the vertex, ``emitter`` or ``light``, and luminance."""
    for index, vertex in enumerate(vertices):
        for kind in ("emitter", "light"):
            if vertex[kind] is not None and "gathered" in vertex[kind]:
                gathered = vertex[kind]["gathered"]
                yield index, kind, sum(weight * value for weight, value in zip(LUMINANCE, gathered, strict=True))


def _surfaces(vertices: Sequence[Mapping[str, Any]], last: int | None) -> list[str]:
    """Return the names of the surfaces and media from the camera to the vertex ``last``."""
    chain: list[str] = []
    while last is not None:
        vertex = vertices[last]
        if vertex["particle"] is not None:
            chain.append("a medium")
        elif vertex["surface"] is not None:
            chain.append(_short(vertex["surface"]["name"]))
        last = vertex["from"]
    chain.reverse()
    left_out = len(chain) - _SHOWN
    half = _SHOWN // 2
    return [*chain[:half], f"({left_out} more)", *chain[-half:]] if left_out > 0 else chain


def _short(name: str) -> str:
    """Return the id of an object, or type and file of one without an id; of a copy, the name of the copy."""
    name = name.rsplit(", seen as ", 1)[-1]
    if found := _NAMED.fullmatch(name):
        return found[1]
    kind, _, place = name.partition(", ")
    return f"{kind} ({Path(place).name})" if place else kind
