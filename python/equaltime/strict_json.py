"""JSON without NaN and Infinity, which every reader accepts."""

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
    """Return ``data`` as JSON text, in which every number that is not finite is null.

    The options are as for `json.dumps`. Numbers in values that ``default`` returns become null too. Raises ValueError
    for a key that is not finite, because null cannot be a key.
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
