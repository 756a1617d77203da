"""Changes to a scene's model: path length, parameters, background and film; new values are checked like a file's."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from numbers import Integral
from typing import Any, Final, TypeVar

from pydantic import ValidationError

from equaltime.errors import Problem, SceneError
from equaltime.scene.model import Aov, Constant, EnvMap, Integrator, Moment, Path, Plugin, SceneModel
from equaltime.scene.validate import explain
from equaltime.words import shortened

__all__ = ["changed", "deep", "several", "smaller_film", "transparent"]

Size = tuple[int, int]
Crop = tuple[int, int, int, int]
P = TypeVar("P", bound=Plugin)
_WITH_ALPHA: Final = {"rgb": "rgba", "luminance": "luminance_alpha", "xyz": "xyza"}
"""Pixel formats with alpha, by the colours of the film."""


def deep(integrator: Integrator, max_depth: int) -> Integrator:
    """Return `integrator` with another `max_depth`, the largest number of segments of a path.

    If `integrator` wraps another one, as `Aov` and `Moment` do, the wrapped one changes. An integrator without this
    parameter is replaced by a `Path`.
    """
    if isinstance(integrator, Moment | Aov) and integrator.integrators:
        return changed(integrator, integrators=(deep(integrator.integrators[0], max_depth),))
    return changed(integrator if isinstance(integrator, Path) else Path(), max_depth=max_depth)


def transparent(model: SceneModel) -> SceneModel:
    """Return `model` with alpha in its film, and without the sky as the camera sees it.

    A scene with a sky gets the parameter ``hide_emitters``, which hides emitting shapes from the camera too. The sky
    and the shapes light everything else as before.
    """
    film = model.sensor.film
    seen = changed(film, pixel_format=_WITH_ALPHA[film.colors])
    model = changed(model, sensor=changed(model.sensor, film=seen))
    has_sky = any(isinstance(emitter, Constant | EnvMap) for emitter in model.emitters)
    return changed(model, integrator=_hiding(model.integrator)) if has_sky else model


def _hiding(integrator: Integrator) -> Integrator:
    if isinstance(integrator, Moment | Aov) and integrator.integrators:
        return changed(integrator, integrators=(_hiding(integrator.integrators[0]),))
    return changed(integrator, hide_emitters=True)


def changed(plugin: P, **changes: object) -> P:
    """Return `plugin` with the parameters in `changes` replaced, by name; an invalid value raises SceneError."""
    try:
        return plugin.replace(**changes)
    except ValidationError as error:
        problems = (Problem(name, message) for name, message in explain(type(plugin), error).items())
        raise SceneError(tuple(problems)) from error


def several(what: str, given: object, names: Sequence[str]) -> tuple[Any, ...]:
    """Return a setting that has several values, `given`, as a tuple with one value for each of `names`.

    NumPy integers become Python integers. Raises ValueError for another number of values. The message is such as "size
    is (width, height), found 3", where `what` is ``size``, and `names` are ``width`` and ``height``.
    """
    values = tuple(given) if isinstance(given, Iterable) else ()
    if len(values) != len(names):
        raise ValueError(f"{what} is ({', '.join(names)}), found {shortened(given, 80)}")
    return tuple(int(v) if isinstance(v, Integral) and not isinstance(v, bool) else v for v in values)


def smaller_film(size: Size, crop: Crop, scale: float) -> tuple[Size, Crop]:
    """Return a film's size (width, height) and crop window (x, y, width, height), scaled by `scale`.

    All numbers are whole pixels. Each side keeps at least one pixel.
    """
    (across, left, columns), (down, top, rows) = (
        _scaled(scale, *axis) for axis in zip(size, crop[:2], crop[2:], strict=True)
    )
    return (across, down), (left, top, columns, rows)


def _scaled(scale: float, length: int, start: int, extent: int) -> tuple[int, int, int]:
    """Return, scaled, a film's length along one axis, and the start and the extent of its crop window."""
    small = max(1, math.floor(length * scale + 1e-9))
    begin = min(round(start * scale), small - 1)
    end = min(small, max(begin + 1, round((start + extent) * scale)))
    return small, begin, end - begin
