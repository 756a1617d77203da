"""The tag of a picture (PNG or JPEG) that holds what repeats its render: seed, strategy, limits and scene."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

from equaltime.errors import ImageError
from equaltime.images.preview import REPEAT
from equaltime.rendering.render_record import checked
from equaltime.strict_json import json_text

__all__ = ["from_repeat", "to_repeat"]

_MEASURED: Final[Mapping[str, Any]] = {
    **{"seconds": 0.0, "looks": [], "paths": 0, "rays": 0, "shadow_rays": 0, "threads": 1, "kernel": ""},
    **{"effects": [], "build": None, "revisions": []},
}
"""Keys that a record needs and that repeat nothing, with a value that stands for none."""
_UNREPEATED: Final = frozenset({*_MEASURED, "runs", "phases", "rays_per_s", "focus", "radiance_range", "degrees"})


def to_repeat(
    record: Mapping[str, Any],
    stops: float,
    background: Sequence[float] | None = None,
    saved: Path | None = None,
) -> str:
    """Return JSON text with the part of a record that repeats the render, for the tags of its picture.

    ``stops`` is the picture's exposure, and ``background`` the colour behind transparent pixels. ``saved`` is the
    file of the render if the picture was made from it. The text has no measured times, so that equal pictures have
    equal files.
    """
    kept = {key: value for key, value in record.items() if key not in _UNREPEATED}
    behind = {} if background is None else {"background": [float(value) for value in background]}
    file = {} if saved is None else {"saved": os.fspath(saved)}
    return json_text({**kept, "exposure": stops, **behind, **file})


def from_repeat(text: str, path: str | os.PathLike[str]) -> Mapping[str, Any]:
    """Return the record of a picture's render (scene, strategy, seed, ...), with its exposure in stops.

    ``text`` is the tag that `to_repeat` wrote into the picture file ``path``. It holds no measured times and counts:
    those keys of the record are 0. The record's key ``background`` is the colour that the picture was saved with, or
    None. The key ``saved`` is the file of the render from which the picture was made, or None. Raises `ImageError` if
    the tag is damaged.
    """
    try:
        said = {"saved": None, **json.loads(text)}
        said["exposure"] = float(said["exposure"])
        said["background"] = None if said.get("background") is None else [*map(float, said["background"])]
        if not isinstance(said["saved"], str | None):
            raise TypeError
    except (ValueError, TypeError, KeyError):
        raise ImageError(f"{path}: its tag {REPEAT!r} is damaged") from None
    return checked({**_MEASURED, **said}, path)
