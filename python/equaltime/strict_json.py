"""JSON text and data without NaN and Infinity, because many JSON readers refuse these words."""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Callable, Collection, Mapping
from numbers import Integral, Real
from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

from pydantic import BaseModel

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

__all__ = ["fields_to_json", "json_text", "to_json"]


@runtime_checkable
class _HasData(Protocol):
    def as_dict(self) -> dict[str, Any]: ...


def json_text(
    data: object,
    *,
    indent: int | None = None,
    sort_keys: bool = False,
    ensure_ascii: bool = True,
    default: Callable[[Any], object] | None = None,
) -> str:
    """Return ``data`` as JSON text, with ``null`` for every number that is not finite.

    The options mean the same as in `json.dumps`. Values that ``default`` returns are treated in the same way. Raises
    ValueError for a dict key that is not finite, because ``null`` cannot be a key.
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


def to_json(value: object) -> Any:
    """Return a value as JSON data; a dataclass or a model becomes an object of its fields.

    A value with a method ``as_dict`` becomes the result of this method. Numbers that are not finite become None. An
    object of any other type becomes its text, ``str(value)``.
    """
    if isinstance(value, _HasData):
        return value.as_dict()
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return fields_to_json(value)
    if isinstance(value, BaseModel):
        return value.model_dump(mode="json")
    if isinstance(value, Mapping):
        return {f"{key:g}" if isinstance(key, float) else str(key): to_json(entry) for key, entry in value.items()}
    if isinstance(value, tuple | list):
        return [to_json(entry) for entry in value]
    return _plain(value)


def fields_to_json(value: DataclassInstance, *, without: Collection[str] = ()) -> dict[str, Any]:
    """Return the fields of a dataclass as JSON data, converted by `to_json`; ``without`` names fields to leave out."""
    names = [field.name for field in dataclasses.fields(value) if field.name not in without]
    return {name: to_json(getattr(value, name)) for name in names}


def _plain(value: object) -> str | int | float | None:
    if value is None or isinstance(value, str | bool):
        return value
    if isinstance(value, Integral):
        return int(value)
    if isinstance(value, Real):
        return float(value) if math.isfinite(value) else None
    return str(value)
