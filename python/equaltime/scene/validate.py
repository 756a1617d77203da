"""Turns pydantic's errors about the parameters of a plugin into messages in plain words."""

from __future__ import annotations

from collections.abc import Mapping, Set
from typing import Any, Final

import numpy as np
from pydantic import ValidationError
from pydantic_core import ErrorDetails

from equaltime.scene.model import NO_MORE, NOT_YET, Animation, Plugin
from equaltime.scene.report import MOST_TOLD
from equaltime.validation import expectation
from equaltime.words import nearest, shortened, suggestion

__all__ = ["explain"]


_EQUALS: Final = (
    ("alpha", "roughness"),
    ("reflectance", "diffuse_reflectance", "base_color", "color", "albedo", "specular_reflectance"),
    ("int_ior", "eta", "ior"),
)
"""Parameters of surfaces that have one meaning, by the names that they have in types of surfaces and other programs."""
_ROUGHNESS: Final = {"alpha": ", the square of the roughness", "roughness": ", the square root of alpha"}
"""Measures of roughness, with their meanings: a number for one of them does not suit the other."""


def explain(plugin: type[Plugin], error: ValidationError) -> dict[str, str]:
    """Return a message for each invalid parameter of a `plugin`, by the parameter's name.

    The name "" stands for a message about the whole plugin. `error` is the error that pydantic raised.
    """
    messages: dict[str, str] = {}
    for details in error.errors(include_url=False):
        if len(messages) > MOST_TOLD:
            break
        name = str(details["loc"][0]) if details["loc"] else ""
        messages.setdefault(name, _message(plugin, name, details))
    return messages


def _message(plugin: type[Plugin], name: str, details: ErrorDetails) -> str:
    kind, context = details["type"], details.get("ctx", {})
    title = plugin.model_fields["type"].default
    if kind == "extra_forbidden":
        if name in plugin.later:
            return f"'{name}' of '{title}' is {NOT_YET}; --substitute leaves it out"
        if name in plugin.old:
            return f"'{name}' of '{title}' is {NO_MORE}; --substitute leaves it out"
        known = {*plugin.model_fields, *plugin.later} - {"type"}
        return f"unknown parameter '{name}' of '{title}'{_equal(name, known) or suggestion(name, known)}"
    if kind == "missing":
        return f"'{title}' needs '{name}'"
    found = details["input"]
    if kind == "value_error":  # one of the model's own checks, whose message lacks only the value
        message = str(context["error"])
        tells_all = not name or shown(found) in message or _is_matrix(found) or isinstance(found, Animation)
        return message if tells_all else f"{message}; found {shown(found)}"
    return f"{expectation(details)}, found {shown(found)}{_near(kind, context, found)}"


def _equal(name: str, known: Set[str]) -> str:
    """Return the end of a message on a parameter that other types have by another name; empty without such a name."""
    words = {word for group in _EQUALS for word in group} | known
    meant = name if name in words else nearest(name, words)
    group = next((group for group in _EQUALS if meant in group), ())
    if meant in known or not (same := next((word for word in group if word in known), None)):
        return ""
    note = _ROUGHNESS.get(same, "") if meant in _ROUGHNESS else ""
    return f"; did you mean '{same}'{note}?"


def _near(kind: str, context: Mapping[str, object], found: object) -> str:
    if kind != "literal_error" or not isinstance(found, str):
        return ""
    hint = suggestion(found, str(context["expected"]).replace("'", "").replace(" or ", ", ").split(", "))
    return hint if "did you mean" in hint else ""


def shown(value: object) -> str:
    """Return `value` as text for a message: a plugin as its type, any other value in at most 80 characters."""
    if isinstance(value, Plugin):
        return repr(getattr(value, "type", type(value).__name__))
    if isinstance(value, tuple) and all(isinstance(item, Plugin) for item in value):
        return ", ".join(map(shown, value)) or "none"
    return shortened(value, 80)


def _is_matrix(found: Any) -> bool:
    try:
        return np.ndim(found) == 2
    except ValueError:  # lists of different lengths
        return False
