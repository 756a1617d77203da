"""Changes to parameters of a scene's model; new values are checked like a scene file's."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from numbers import Integral
from typing import Any, TypeVar

from pydantic import ValidationError

from equaltime.errors import Problem, SceneError
from equaltime.scene.model import Aov, Integrator, Moment, Path, Plugin
from equaltime.scene.validate import explain
from equaltime.words import shortened

__all__ = ["changed", "deep", "several"]

P = TypeVar("P", bound=Plugin)


def deep(integrator: Integrator, max_depth: int) -> Integrator:
    """Return `integrator` with another `max_depth`.

    In an `Aov` or a `Moment`, the first integrator inside changes. An integrator without this parameter is replaced by
    a `Path`.
    """
    if isinstance(integrator, Moment | Aov) and integrator.integrators:
        return changed(integrator, integrators=(deep(integrator.integrators[0], max_depth),))
    return changed(integrator if isinstance(integrator, Path) else Path(), max_depth=max_depth)


def changed(plugin: P, **changes: object) -> P:
    """Return `plugin` with the parameters in `changes` replaced, by name; an invalid value raises SceneError."""
    try:
        return plugin.replace(**changes)
    except ValidationError as error:
        problems = (Problem(name, message) for name, message in explain(type(plugin), error).items())
        raise SceneError(tuple(problems)) from error


def several(what: str, given: object, names: Sequence[str]) -> tuple[Any, ...]:
    """Return the values in `given` as a tuple; raises ValueError if there is not exactly one value for each name.

    NumPy integers become Python integers. The error message is such as "size is (width, height), found 3", where `what`
    is ``size``, and `names` are ``width`` and ``height``.
    """
    values = tuple(given) if isinstance(given, Iterable) else ()
    if len(values) != len(names):
        raise ValueError(f"{what} is ({', '.join(names)}), found {shortened(given, 80)}")
    return tuple(int(v) if isinstance(v, Integral) and not isinstance(v, bool) else v for v in values)
