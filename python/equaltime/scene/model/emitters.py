"""Emitters: area lights on shapes, point lights, spot lights, directional lights, and environments."""

from __future__ import annotations

import math
from typing import Annotated, ClassVar, Literal, Self

from pydantic import Field, NonNegativeFloat, model_validator

from equaltime.scene.model.base import Kind, Plugin
from equaltime.scene.model.textures import RadianceTexture, Texture
from equaltime.scene.model.values import IDENTITY, Radiance, RigidTransform, Transform, Vec3, linear_scale

__all__ = ["Area", "Constant", "Directional", "EnvMap", "FreeEmitter", "Point", "Spot"]


class EmitterPlugin(Plugin):
    """Base class of all emitters: lights and environments."""

    kind: ClassVar[Kind] = "emitter"
    hints: ClassVar[frozenset[str]] = frozenset({"sampling_weight"})
    surrounds: ClassVar[bool] = False
    """True for an environment, which surrounds the scene; a scene can have at most one."""

    sampling_weight: NonNegativeFloat = 1.0
    """A sampling hint of Mitsuba, not used: the strategy decides how often each light is sampled."""


class Area(EmitterPlugin):
    """Diffuse emission from the front side of a shape; the emitter is nested in the shape."""

    type: Literal["area"] = "area"
    radiance: RadianceTexture = (1.0, 1.0, 1.0)
    """Radiance in W/(m^2 sr), per channel."""


class Point(EmitterPlugin):
    """A point light with the same intensity in all directions."""

    type: Literal["point"] = "point"
    intensity: Radiance = (1.0, 1.0, 1.0)
    """Radiant intensity in W/sr, per channel."""
    position: Vec3 | None = None
    to_world: Transform | None = None
    """Alternative to ``position``: a transform that maps the origin to the position."""

    @model_validator(mode="after")
    def _one_position(self) -> Self:
        if self.position is not None and self.to_world is not None:
            raise ValueError("give either position or to_world, not both")
        return self

    @property
    def world_position(self) -> tuple[float, float, float]:
        """Position in world space: x, y, z."""
        if self.to_world is not None:
            return (self.to_world[0][3], self.to_world[1][3], self.to_world[2][3])
        return self.position or (0.0, 0.0, 0.0)


class Spot(EmitterPlugin):
    """A spot light along +z of local space.

    The intensity falls linearly to 0 between the angles ``beam_width`` and ``cutoff_angle`` from the axis.
    """

    type: Literal["spot"] = "spot"
    intensity: Radiance = (1.0, 1.0, 1.0)
    """Radiant intensity inside ``beam_width``, in W/sr per channel."""
    cutoff_angle: Annotated[float, Field(gt=0.0, le=180.0)] = 20.0
    """Half the opening angle of the cone, in degrees. There is no light at larger angles from the axis."""
    beam_width: NonNegativeFloat | None = None
    """Angle from the axis, in degrees, at which the intensity begins to fall; by default 3/4 of ``cutoff_angle``."""
    texture: Texture | None = None
    """Texture that the light projects, times the intensity; the unit square of u and v is as wide as the cone."""
    to_world: Transform = IDENTITY

    @model_validator(mode="after")
    def _projects_ahead(self) -> Self:
        if self.texture is not None and self.cutoff_angle > 90.0:
            raise ValueError(f"cutoff_angle ({self.cutoff_angle:g}) of a spot with a texture must not exceed 90")
        return self

    @model_validator(mode="after")
    def _round_cone(self) -> Self:
        if linear_scale(self.to_world) is None:
            raise ValueError("to_world of a spot light must scale all directions alike, without shear")
        return self

    @property
    def beam(self) -> float:
        """Angle from the axis, in degrees, at which the intensity begins to fall.

        The angle is ``beam_width``, by default 3/4 of ``cutoff_angle``. It never exceeds ``cutoff_angle``.
        """
        return 0.75 * self.cutoff_angle if self.beam_width is None else min(self.beam_width, self.cutoff_angle)


class Directional(EmitterPlugin):
    """Parallel light from an infinite distance, in one direction."""

    type: Literal["directional"] = "directional"
    irradiance: Radiance = (1.0, 1.0, 1.0)
    """Irradiance in W/m^2 per channel, on a plane that faces the light."""
    direction: Vec3 | None = None
    """Direction in which the light travels in world space, of any length; by default +z of ``to_world``."""
    to_world: Transform | None = None
    """Alternative to ``direction``: a transform that maps +z to the direction."""

    @model_validator(mode="after")
    def _one_direction(self) -> Self:
        if self.direction is not None and self.to_world is not None:
            raise ValueError("give either direction or to_world, not both")
        if self.direction is not None and not any(self.direction):
            raise ValueError("the direction has no length")
        return self

    @property
    def world_direction(self) -> tuple[float, float, float]:
        """Direction in which the light travels in world space, as a unit vector."""
        if self.to_world is not None:
            x, y, z = (row[2] for row in self.to_world[:3])
        else:
            x, y, z = self.direction or (0.0, 0.0, 1.0)
        length = math.hypot(x, y, z)
        return x / length, y / length, z / length


class Constant(EmitterPlugin):
    """An environment with the same radiance from every direction."""

    surrounds: ClassVar[bool] = True
    hints: ClassVar[frozenset[str]] = EmitterPlugin.hints | {"to_world"}

    type: Literal["constant"] = "constant"
    radiance: Radiance = (1.0, 1.0, 1.0)
    """Radiance in W/(m^2 sr), per channel."""
    to_world: Transform = IDENTITY
    """Without effect: the radiance is the same in all directions."""


class EnvMap(EmitterPlugin):
    """An environment from an image in latitude-longitude (equirectangular) projection."""

    surrounds: ClassVar[bool] = True

    type: Literal["envmap"] = "envmap"
    filename: str
    """File of the image, relative to the scene file."""
    scale: NonNegativeFloat = 1.0
    """Factor by which the image's radiances are multiplied."""
    to_world: RigidTransform = IDENTITY
    mis_compensation: bool = False
    """A sampling hint of Mitsuba, not used."""

    hints: ClassVar[frozenset[str]] = frozenset({"sampling_weight", "mis_compensation"})
    later: ClassVar[frozenset[str]] = frozenset({"bitmap", "data"})


FreeEmitter = Annotated[Point | Spot | Directional | Constant | EnvMap, Field(discriminator="type")]
"""Any emitter that is not attached to a shape."""
