"""Warnings of a picture that is black everywhere: its error may be stated as 0 %, and black is rarely intended."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from contextvars import ContextVar

from equaltime.errors import EqualtimeWarning, SceneError
from equaltime.rendering.result import Result
from equaltime.scene import Scene
from equaltime.scene.lint import Finding, lint
from equaltime.scene.model import Aov, Depth, Integrator

__all__ = ["black_picture", "reasons", "unwarned", "warn_if_black"]

_REASONS = ("camera-enclosed", "no-light", "lights-enclosed", "lights-turned-away", "lights-behind-glass")
"""Findings of lint that can make a picture black."""
_WARNS = ContextVar("_WARNS", default=True)
"""Whether renders of this thread warn. A filter of `warnings` would apply to all threads."""


def warn_if_black(result: Result, scene: Scene, stacklevel: int) -> Result:
    """Return the result unchanged, after a warning (`EqualtimeWarning`) if its picture is black everywhere.

    ``stacklevel`` selects the line of code that the warning names: 1 is the call of this function, 2 is the call of the
    function that made that call.
    """
    if _WARNS.get() and (message := black_picture(result, scene)):
        warnings.warn(message, EqualtimeWarning, stacklevel + 1)
    return result


@contextmanager
def unwarned() -> Iterator[None]:
    """Return a context in which renders do not warn of black pictures; renders of other threads still warn.

    A caller that reports a black picture itself uses the context, so that its user is not warned twice.
    """
    token = _WARNS.set(False)
    try:
        yield
    finally:
        _WARNS.reset(token)


def black_picture(result: Result, scene: Scene, known: Sequence[Finding] | None = None) -> str:
    """Return the text of the warning for a picture that is black everywhere; empty if no warning is needed.

    A warning is needed if all pixels are 0, the scene asks for an image, and one of two things holds. Either the upper
    limit of the image's error is 0, or the camera is inside a closed surface. ``known`` holds the findings of a quick
    run of `lint`; if it is None, `lint` is run.
    """
    if result.image.any() or _wants_no_light(scene.model.integrator):
        return ""
    findings = _findings(scene) if known is None else reasons(known)
    if result.error.high != 0.0 and not any(finding.check == "camera-enclosed" for finding in findings):
        return ""
    told = f"the picture is black everywhere, with an error of {result.error:%}: no sample has met any light"
    if not findings:
        return f"{told}; look at where the camera is and what emits light"
    return "; ".join([told, *map(_told, findings)])


def reasons(findings: Iterable[Finding]) -> list[Finding]:
    """Return the findings of `lint`, out of ``findings``, that can make a picture black.

    A camera inside a closed surface is such a finding.
    """
    return [finding for finding in findings if finding.check in _REASONS]


def _wants_no_light(integrator: Integrator) -> bool:
    return isinstance(integrator, Depth) or (isinstance(integrator, Aov) and not integrator.integrators)


def _findings(scene: Scene) -> list[Finding]:
    """Return the findings of lint that can make the picture black; none if lint cannot read a file."""
    with suppress(SceneError, ValueError):  # a file of the scene may be gone
        return reasons(lint(scene, fast=True))
    return []


def _told(finding: Finding) -> str:
    where = f" ({', '.join(finding.where)})" if finding.where else ""
    return f"{finding.check}: {finding.what}{where}; you can {finding.advice}"
