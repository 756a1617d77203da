"""Problems of invalid experiments: contradictions between values, and the messages about them."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from itertools import pairwise
from pathlib import Path
from typing import Any, get_args

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from equaltime.errors import Problem
from equaltime.validation import NOUNS, explain
from equaltime.words import error_of, shortened, suggestion

__all__ = [
    "DEFAULT_TARGETS",
    "crossed",
    "explained",
    "file_name",
    "name_of_scene",
    "name_of_strategy",
    "unfit_character",
]

DEFAULT_TARGETS = (0.10, 0.05, 0.02, 0.01)

_NOUNS = {
    **NOUNS,
    "int_type": "a whole number",
    "string_type": "a text",
    "tuple_type": "a list",
    "dict_type": "a table",
    "model_type": "a table",
    "model_attributes_type": "a table",
    "path_type": "the name of a file",
}


def name_of_scene(entry: object, number: int) -> str:
    """Return the name of a scene of an experiment: its given name, else its file's name, else ``scene-N``.

    ``entry`` is the scene's entry in the experiment, checked or not. The file's name is without its suffix. ``number``
    is the scene's index from 0; N is one more.
    """
    source = _get(_get(entry, "scene"), "source") if not isinstance(_get(entry, "scene"), Mapping) else None
    path = _get(entry, "path") or source
    given = _get(entry, "name")
    return str(given) if given else Path(str(path)).stem if path else f"scene-{number + 1}"


def name_of_strategy(entry: object) -> str:
    """Return the name of a strategy of an experiment: its label, else its text, else the name of its renderer.

    ``entry`` is the strategy's entry in the experiment, checked or not.
    """
    if isinstance(entry, str):
        return entry
    peer = _get(entry, "peer")
    for name in (_get(entry, "label"), _get(entry, "strategy"), _get(peer, "renderer"), peer, _get(entry, "python")):
        if name:
            return str(name) if not isinstance(name, Mapping | BaseModel) or _get(name, "name") else "command"
    return ""


def file_name(text: str) -> str:
    """Return the text as a file name: characters that some file systems do not allow become ``-``."""
    return re.sub(r"[^\w.+=-]+", "-", text).strip("-.") or "_"


def explained(model: type[BaseModel], error: ValidationError) -> tuple[Problem, ...]:
    """Return pydantic's errors as problems of an experiment, each with its path of keys and a message in plain words.

    ``model`` is the class of settings that was checked.
    """
    problems: dict[Problem, None] = {}
    for details in error.errors(include_url=False):
        location = _without_union(details["loc"])
        if details["type"] == "too_short" and details["input"]:
            continue  # its entries are invalid, which is reported for each of them
        if details["type"] == "missing" and isinstance(location[-1], int):
            location = location[:-1]
        place = _path(location)
        for message in _message(model, location, details).splitlines():
            problems[Problem(place, message)] = None
    return tuple(problems)


def crossed(values: Mapping[str, Any]) -> tuple[Problem, ...]:
    """Return a problem for each contradiction between an experiment's values, such as ``spp`` beside ``budget``.

    ``values`` are the experiment's fields by name; missing values are ignored.
    """
    return tuple(
        Problem(place, message)
        for check in (
            *(_scene_problems, _strategy_problems, _ladder_problems, _reference_problems, _theirs_problems),
            _quick_problems,
        )
        for place, message in check(values)
    )


def _scene_problems(values: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    scenes = _list(values.get("scenes"))
    for number, entry in enumerate(scenes):
        path, scene = _get(entry, "path"), _get(entry, "scene")
        loaded = scene is not None and not isinstance(scene, Mapping)  # which may stand beside its path
        if isinstance(entry, Mapping | BaseModel) and (path is None) == (scene is None) and not loaded:
            yield f"scenes[{number}]", "a scene has either 'path', a scene file, or 'scene', the scene as a table"
        if _get(entry, "define") and _get(entry, "path") is None:
            yield f"scenes[{number}].define", "only the variables of a file can be defined"
    names = [name_of_scene(entry, number) for number, entry in enumerate(scenes)]
    yield from _alike("scenes", "name", names)
    labels = [name_of_strategy(entry) for entry in _list(values.get("strategies"))]
    taken = {f"{file_name(name)}--{file_name(label)}": (name, label) for name in names for label in labels}
    for number, name in enumerate(names):
        if file_name(name) in taken:
            scene, strategy = taken[file_name(name)]
            yield (
                f"scenes[{number}].name",
                f"'{name}' is already the name of the reference of '{strategy}' on '{scene}'",
            )


def _strategy_problems(values: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    strategies = _list(values.get("strategies"))
    for number, entry in enumerate(strategies):
        if isinstance(entry, Mapping | BaseModel):
            if sum(_get(entry, key) is not None for key in ("strategy", "peer", "python")) != 1:
                yield f"strategies[{number}]", "give one of 'strategy', 'peer' and 'python'"
            yield from _peer_problems(f"strategies[{number}].peer", _get(entry, "peer"))
    labels = [name_of_strategy(entry) for entry in strategies]
    yield from _alike("strategies", "label", labels)
    baseline = values.get("baseline")
    if isinstance(baseline, str) and baseline and labels and baseline not in labels:
        yield "baseline", f"no strategy has the label '{baseline}'{suggestion(baseline, labels)}"


def _peer_problems(place: str, peer: object) -> Iterator[tuple[str, str]]:
    if not isinstance(peer, Mapping | BaseModel):
        return
    command = _get(peer, "command")
    if (command is None) == (_get(peer, "renderer") is None):
        yield place, "a peer has either 'renderer' or 'command'"
    if isinstance(command, str):
        if missing := [word for word in ("{spp}", "{seed}", "{out}") if word not in command]:
            yield f"{place}.command", f"the command does not use {', '.join(missing)}"
        for key in ("variant", "integrator", "sampler"):
            if _get(peer, key) is not None:
                yield f"{place}.{key}", "not for a command"


def _ladder_problems(values: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    spp = values.get("spp")
    if spp is not None and values.get("budget") is not None:
        yield "spp", "give either 'budget' or 'spp'"
    if spp is not None and values.get("counts"):
        yield "spp", "gives the counts of all runs already; counts of an earlier experiment have no place beside it"
    counts = [count for count in _list(spp) if isinstance(count, int)]
    if any(b <= a for a, b in pairwise(counts)):
        yield "spp", f"the sample counts must rise, found {shortened(counts, 80)}"


def _reference_problems(values: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    if _get(values.get("reference"), "file") is not None and len(_list(values.get("scenes"))) > 1:
        yield "reference.file", "one file cannot be the reference of several scenes"


def _theirs_problems(values: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Find published numbers whose strategy, scene or target the experiment does not have."""
    labels = [name_of_strategy(entry) for entry in _list(values.get("strategies"))]
    names = [name_of_scene(entry, number) for number, entry in enumerate(_list(values.get("scenes")))]
    targets = [*map(_fraction, _list(values.get("targets")) or DEFAULT_TARGETS)]
    for number, entry in enumerate(_list(_get(values.get("theirs"), "numbers"))):
        place = f"theirs.numbers[{number}]"
        for key, known in (("strategy", labels), ("scene", names)):
            name = _get(entry, key)
            if isinstance(name, str) and name and name not in known:
                yield f"{place}.{key}", f"the experiment has no {key} '{name}'{suggestion(name, known)}"
        target = _fraction(_get(entry, "target"))
        if target is not None and target not in targets:
            yield f"{place}.target", f"{target} is none of the targets {shortened(list(targets), 80)}"


def _fraction(value: object) -> object:
    """Return the fraction that a text in per cent stands for; any other value is returned unchanged."""
    with suppress(ValueError):
        return error_of(value) if isinstance(value, str) else value
    return value


def _quick_problems(values: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Find scenes and strategies that ``quick`` keeps and the experiment does not have."""
    names = [name_of_scene(entry, number) for number, entry in enumerate(_list(values.get("scenes")))]
    labels = [name_of_strategy(entry) for entry in _list(values.get("strategies"))]
    for key, known in (("scenes", names), ("strategies", labels)):
        for number, name in enumerate(_list(_get(values.get("quick"), key))):
            if isinstance(name, str) and name not in known:
                yield f"quick.{key}[{number}]", f"the experiment has no '{name}'{suggestion(name, known)}"


def unfit_character(name: str) -> str:
    """Return the first character of a name that the records (a CSV file) cannot hold, as text such as ``U+000A``.

    Returns an empty text if there is no such character. The characters are control characters, line and paragraph
    separators, and unpaired surrogates.
    """
    found = next((one for one in name if unicodedata.category(one) in ("Cc", "Cs", "Zl", "Zp")), None)
    if found is None:
        return ""
    called = unicodedata.name(found, "")
    return f"U+{ord(found):04X}" + (f" ({called})" if called else "")


def _alike(place: str, key: str, names: Sequence[str]) -> Iterator[tuple[str, str]]:
    """Find names that are no single line of text, or that clash as names or as file names."""
    seen: dict[str, int] = {}
    for number, name in enumerate(names):
        where = f"{place}[{number}].{key}"
        if character := unfit_character(name):
            yield where, f"must be one line of text, found {character} in {shortened(name, 80)}"
        before = seen.setdefault(file_name(name).casefold(), number)
        if before == number:
            continue
        if names[before] == name:
            yield where, f"'{name}' is {place}[{before}] already; give each a '{key}' of its own"
        else:
            yield where, f"'{name}' is too much like {place}[{before}], '{names[before]}': they are names of files too"


def _message(model: type[BaseModel], location: Sequence[str | int], details: ErrorDetails) -> str:
    kind, found = details["type"], details["input"]
    if kind == "missing" and isinstance(found, list | tuple):
        return f"has too few entries: {shortened(found, 80)}"
    if kind == "too_short":
        return "must not be empty"
    if kind == "too_long":
        return f"has more than {details['ctx']['max_length']} entries: {shortened(found, 80)}"
    known = _keys(model, location) if kind == "extra_forbidden" else ()
    return explain(details, known, _NOUNS)


def _keys(model: type[BaseModel], location: Sequence[str | int]) -> set[str]:
    """Return the allowed keys of the table that contains ``location``."""
    for step in location[:-1]:
        if isinstance(step, str):
            model = _model_in(model.model_fields[step].annotation) or model
    return set(model.model_fields)


def _model_in(annotation: Any) -> type[BaseModel] | None:
    """Return the first model found in a field's type, at any depth of nesting."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    return next((found for part in get_args(annotation) if (found := _model_in(part))), None)


def _without_union(location: Sequence[str | int]) -> tuple[str | int, ...]:
    """Remove the steps that pydantic adds for members of a union, such as ``is-instance[Scene]``."""
    return tuple(step for step in location if not (isinstance(step, str) and "[" in step))


def _path(location: Sequence[str | int]) -> str:
    return "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in location).removeprefix(".")


def _get(value: object, key: str) -> Any:
    return value.get(key) if isinstance(value, Mapping) else getattr(value, key, None)


def _list(value: object) -> Sequence[Any]:
    return value if isinstance(value, list | tuple) else ()
