"""Root node of the scene model, which holds the whole scene."""

from __future__ import annotations

from typing import ClassVar, Literal, Self

from pydantic import model_validator

from equaltime.scene.model.base import Kind, Plugin
from equaltime.scene.model.emitters import FreeEmitter
from equaltime.scene.model.integrators import Integrator, Path
from equaltime.scene.model.sensors import Sensor
from equaltime.scene.model.shapes import Shape

__all__ = ["SceneModel"]


class SceneModel(Plugin):
    """The complete scene, with references resolved and unused objects left out."""

    kind: ClassVar[Kind] = "scene"

    type: Literal["scene"] = "scene"
    integrator: Integrator = Path()
    sensor: Sensor
    shapes: tuple[Shape, ...] = ()
    emitters: tuple[FreeEmitter, ...] = ()
    """All emitters except area lights, which are fields of their shapes."""

    @model_validator(mode="after")
    def _one_environment(self) -> Self:
        if sum(emitter.surrounds for emitter in self.emitters) > 1:
            raise ValueError("a scene can have only one environment (constant or envmap)")
        return self
