"""Values that cannot be changed can be put into sets, whatever dictionaries are in them."""

from __future__ import annotations

import dataclasses
import importlib
import inspect
import pkgutil
import re
from collections.abc import Iterator
from pathlib import Path

import equaltime as et

CORNELL = Path(__file__).parents[2] / "scenes" / "cornell-box.toml"
UNHASHABLE = re.compile(r"\b(Mapping|dict|list|set|NDArray|Floats|Array)\[|\b(Floats|Array)\b")


def frozen_values() -> Iterator[type]:
    """Yield the frozen dataclasses of the package that compare by their fields; without embreex, of all that loads."""
    for module in pkgutil.walk_packages(et.__path__, "equaltime."):
        if module.name.endswith("__main__"):
            continue
        try:
            loaded = importlib.import_module(module.name)
        except ImportError as error:
            if error.name != "embreex":
                raise
            continue
        for _, value in inspect.getmembers(loaded, inspect.isclass):
            if value.__module__ == module.name and dataclasses.is_dataclass(value):
                options = value.__dataclass_params__  # type: ignore[attr-defined]  # every dataclass has them
                if options.frozen and options.eq:
                    yield value


def test_no_field_that_has_no_hash_is_in_the_hash_of_a_value() -> None:
    found = [
        f"{value.__module__}.{value.__name__}.{field.name}: {field.type}"
        for value in frozen_values()
        for field in dataclasses.fields(value)
        if field.hash is not False and not str(field.type).startswith("Callable")
        if UNHASHABLE.search(str(field.type))
    ]
    assert found == []


def test_values_that_are_equal_have_one_hash() -> None:
    scene = et.load(CORNELL).with_(size=(8, 8), max_depth=2)
    result = et.render(scene, spp=4)
    again = dataclasses.replace(result.stats, phases=dict(result.stats.phases))
    assert {result.stats, again} == {result.stats}
    assert result.stats != dataclasses.replace(result.stats, phases={"render": 1.0})
    path = et.replay(scene, pixel=(1, 1), sample=0)
    quote = et.quote(scene, error=0.5, why=True)
    values = {result.origin, path, quote, result.error, result}
    assert len(values) == 5
