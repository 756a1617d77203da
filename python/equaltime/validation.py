"""Pydantic's errors in plain words: what was expected, what was found, and the nearest known name."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from pydantic_core import ErrorDetails

from equaltime.words import shortened, suggestion

__all__ = ["NOUNS", "expectation", "explain"]

NOUNS: Mapping[str, str] = {
    "bool_type": "true or false",
    "float_type": "a number",
    "int_type": "an integer",
    "string_type": "a string",
    "finite_number": "a finite number",
}
"""Expected values in words, by pydantic's type of error."""
_LIMITS = {"gt": "more than", "ge": "at least", "lt": "less than", "le": "at most"}


def explain(details: ErrorDetails, known: Iterable[str] = (), nouns: Mapping[str, str] = NOUNS) -> str:
    """Return one of pydantic's errors as a message for the user, such as ``expected a number, found 'x'``.

    Parameters
    ----------
    details
        One of the errors that ``ValidationError.errors(include_url=False)`` lists.
    known
        Names to suggest for an unknown key.
    nouns
        Expected values in words, by pydantic's type of error.
    """
    kind = details["type"]
    if kind == "extra_forbidden":
        name = str(details["loc"][-1])
        return f"unknown key '{name}'{suggestion(name, known)}"
    if kind == "missing":
        return "is missing"
    if kind == "value_error":  # one of the model's own checks
        return str(details["ctx"]["error"])
    return f"{expectation(details, nouns)}, found {shortened(details['input'], 80)}"


def expectation(details: ErrorDetails, nouns: Mapping[str, str] = NOUNS) -> str:
    """Return in words the value that one of pydantic's errors expected: ``expected a number``, ``must be at least 1``.

    ``nouns`` has expected values in words, by pydantic's type of error.
    """
    kind, context = details["type"], details.get("ctx", {})
    if kind in nouns:
        return f"expected {nouns[kind]}"
    if kind == "literal_error":
        return f"expected {context['expected']}"
    if kind == "union_tag_invalid":
        return f"expected one of {context['expected_tags']}"
    if kind == "model_type":
        return f"expected an object of type {str(context['class_name']).lower()!r}"
    for limit, words in _LIMITS.items():
        if limit in context:
            return f"must be {words} {_number(context[limit])}"
    return details["msg"].removeprefix("Input ").lower()


def _number(limit: object) -> str:
    return f"{limit:g}" if isinstance(limit, float) else str(limit)
