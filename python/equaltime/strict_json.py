"""JSON text without NaN and Infinity, because many JSON readers refuse these words."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from typing import Any

__all__ = ["json_text"]


def json_text(
    data: object,
    *,
    indent: int | None = None,
    sort_keys: bool = False,
    ensure_ascii: bool = True,
    default: Callable[[Any], object] | None = None,
) -> str:
    """Return ``data`` as JSON text, with ``null`` for every number that is not finite.

    The options are as for `json.dumps`. Values that ``default`` returns are treated in the same way. Raises ValueError
    for a dict key that is not finite, because ``null`` cannot be a key.
    """
    return json.dumps(
        _finite(data),
        allow_nan=False,
        indent=indent,
        sort_keys=sort_keys,
        ensure_ascii=ensure_ascii,
        default=None if default is None else lambda value: _finite(default(value)),
    )


def _finite(data: object) -> object:
    if isinstance(data, float):
        return data if math.isfinite(data) else None
    if isinstance(data, Mapping):
        return {key: _finite(value) for key, value in data.items()}
    if isinstance(data, list | tuple):
        return [_finite(value) for value in data]
    return data
