"""Light sources: attached to a shape (area), at a point, or all around."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal, Self

from pydantic import Field, NonNegativeFloat, model_validator

from equaltime.scene.model.base import Kind, Plugin
from equaltime.scene.model.values import IDENTITY, Radiance, RigidTransform, Transform, Vec3

__all__ = ["Area", "Constant", "EnvMap", "FreeEmitter", "Point"]


class EmitterPlugin(Plugin):
    """Base of the emitters."""

    kind: ClassVar[Kind] = "emitter"
    hints: ClassVar[frozenset[str]] = frozenset({"sampling_weight"})
    surrounds: ClassVar[bool] = False
    """Whether it shines from all around, of which a scene can have one."""

    sampling_weight: NonNegativeFloat = 1.0
    """A sampling hint of Mitsuba; which light is sampled how often is the strategy's business here."""


class Area(EmitterPlugin):
    """Diffuse emission from the front side of the shape that it is nested in."""

    type: Literal["area"] = "area"
    radiance: Radiance = (1.0, 1.0, 1.0)
    """W/(m^2 sr) per channel."""


class Point(EmitterPlugin):
    """Light from a single point, the same in all directions."""

    type: Literal["point"] = "point"
    intensity: Radiance = (1.0, 1.0, 1.0)
    """W/sr per channel."""
    position: Vec3 | None = None
    to_world: Transform | None = None
    """Another way to give the position: where this takes the origin."""

    @model_validator(mode="after")
    def _one_position(self) -> Self:
        if self.position is not None and self.to_world is not None:
            raise ValueError("give either position or to_world, not both")
        return self

    @property
    def world_position(self) -> tuple[float, float, float]:
        """The position in world space."""
        if self.to_world is not None:
            return (self.to_world[0][3], self.to_world[1][3], self.to_world[2][3])
        return self.position or (0.0, 0.0, 0.0)


class Constant(EmitterPlugin):
    """The same radiance from every direction."""

    surrounds: ClassVar[bool] = True

    type: Literal["constant"] = "constant"
    radiance: Radiance = (1.0, 1.0, 1.0)
    """W/(m^2 sr) per channel."""


class EnvMap(EmitterPlugin):
    """Radiance from all around, given by an image in latitude and longitude."""

    surrounds: ClassVar[bool] = True

    type: Literal["envmap"] = "envmap"
    filename: str
    """The image, relative to the scene file."""
    scale: NonNegativeFloat = 1.0
    """Factor on the image's values."""
    to_world: RigidTransform = IDENTITY
    mis_compensation: bool = False
    """A sampling hint of Mitsuba, not used."""

    hints: ClassVar[frozenset[str]] = frozenset({"sampling_weight", "mis_compensation"})
    later: ClassVar[frozenset[str]] = frozenset({"bitmap", "data"})


FreeEmitter = Annotated[Point | Constant | EnvMap, Field(discriminator="type")]
"""The emitters that stand on their own in a scene."""
