"""Cameras with what they carry: film, reconstruction filter and sampler."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, ClassVar, Literal, Self

from pydantic import BeforeValidator, Field, NonNegativeFloat, PositiveFloat, PositiveInt, model_validator

from equaltime.scene.model.animation import Placement, RigidPlacement
from equaltime.scene.model.base import Kind, Plugin
from equaltime.scene.model.films import HdrFilm
from equaltime.scene.model.media import Medium
from equaltime.scene.model.values import IDENTITY, as_lower

__all__ = [
    *("MOST_SAMPLES", "Independent", "LdSampler", "MultiJitter", "Orthogonal", "Sampler", "Stratified"),
    *("Orthographic", "Perspective", "Projective", "Sensor", "Spherical", "ThinLens"),
]

FILM_DIAGONAL = math.hypot(36.0, 24.0)
"""Diagonal in mm of the 35 mm film that ``focal_length`` refers to."""
MOST_SAMPLES = 2**32
"""Largest number of samples per pixel, in any render: Sobol' points have 32 bits, so more would repeat the first."""


class SamplerPlugin(Plugin):
    """Base of the samplers: they give the default number of samples; the strategy gives the random numbers."""

    kind: ClassVar[Kind] = "sampler"
    hints: ClassVar[frozenset[str]] = frozenset({"sample_count", "seed", "type"})

    sample_count: Annotated[int, Field(gt=0, le=MOST_SAMPLES)] = 4
    """Samples per pixel, unless the render asks for another number."""
    seed: int = 0


class Jittered(SamplerPlugin):
    """Base of the samplers that jitter."""

    jitter: bool = True


class Independent(SamplerPlugin):
    """Independent random numbers."""

    type: Literal["independent"] = "independent"


class Stratified(Jittered):
    """Stratified numbers."""

    type: Literal["stratified"] = "stratified"


class MultiJitter(Jittered):
    """Correlated multi-jittered numbers."""

    type: Literal["multijitter"] = "multijitter"


class Orthogonal(Jittered):
    """Numbers from an orthogonal array."""

    type: Literal["orthogonal"] = "orthogonal"
    strength: PositiveInt = 2


class LdSampler(SamplerPlugin):
    """Low-discrepancy numbers."""

    type: Literal["ldsampler"] = "ldsampler"


Sampler = Annotated[Independent | Stratified | MultiJitter | Orthogonal | LdSampler, Field(discriminator="type")]
"""Any sampler."""


def _as_millimetres(value: object) -> object:
    if not isinstance(value, str):
        return value
    try:
        return float(value.removesuffix("mm"))
    except ValueError:
        raise ValueError("expected a length such as '50mm'") from None


class SensorPlugin(Plugin):
    """Base of the sensors: at the origin, they look along +z, with +x to the left of the image and +y up."""

    kind: ClassVar[Kind] = "sensor"
    roles: ClassVar[Mapping[Kind, str]] = {"film": "film", "sampler": "sampler", "medium": "medium"}
    later: ClassVar[frozenset[str]] = frozenset({"srf"})
    hints: ClassVar[frozenset[str]] = frozenset({"sampler", "shutter_open", "shutter_close"})

    near_clip: PositiveFloat | None = None
    """Nearest visible distance, measured along the camera's axis; no limit unless given."""
    far_clip: PositiveFloat | None = None
    """Farthest visible distance, measured along the camera's axis; no limit unless given."""
    shutter_open: float = 0.0
    """Time at which the exposure begins. Animated objects are seen at all times of the exposure, with equal weight."""
    shutter_close: float = 0.0
    """Time at which the exposure ends."""
    film: HdrFilm = HdrFilm()
    sampler: Sampler = Independent()
    medium: Medium | None = None
    """The medium that the camera is in."""

    @model_validator(mode="after")
    def _clips_in_order(self) -> Self:
        if self.near_clip is not None and self.far_clip is not None and self.near_clip >= self.far_clip:
            raise ValueError(f"near_clip ({self.near_clip:g}) must be smaller than far_clip ({self.far_clip:g})")
        return self

    @model_validator(mode="after")
    def _opens_before_it_closes(self) -> Self:
        begin, end = self.shutter_open, self.shutter_close
        if end < begin:
            raise ValueError(f"shutter_close ({end:g}) must not be before shutter_open ({begin:g})")
        return self


class Projective(SensorPlugin):
    """Base of the cameras with a field of view."""

    to_world: RigidPlacement = IDENTITY
    fov: Annotated[float, Field(gt=0.0, lt=180.0)] | None = None
    """Field of view in degrees along ``fov_axis``, over the whole film."""
    fov_axis: Annotated[Literal["x", "y", "diagonal", "smaller", "larger"], BeforeValidator(as_lower)] = "x"
    focal_length: Annotated[PositiveFloat, BeforeValidator(_as_millimetres)] | None = None
    """Focal length in mm on 35 mm film, instead of ``fov``; 50 mm if neither is given."""

    @model_validator(mode="after")
    def _one_field_of_view(self) -> Self:
        if self.focal_length is not None and {"fov", "fov_axis"} & self.model_fields_set:
            raise ValueError("give either fov (with fov_axis) or focal_length, not both")
        if "fov_axis" in self.model_fields_set and self.fov is None:
            raise ValueError("fov_axis needs fov")
        if not 0.0 < self.x_fov < 180.0:
            raise ValueError(f"the horizontal field of view, {self.x_fov:g} degrees, must lie between 0 and 180")
        return self

    @property
    def x_fov(self) -> float:
        """Horizontal field of view of the whole film, in degrees."""
        aspect = self.film.width / self.film.height
        if self.fov is None:
            half, axis = FILM_DIAGONAL / (2.0 * (self.focal_length or 50.0)), "diagonal"
        else:
            half, axis = math.tan(math.radians(self.fov) / 2.0), self.fov_axis
        if axis == "y" or axis == ("smaller" if aspect > 1.0 else "larger"):
            half *= aspect
        elif axis == "diagonal":
            half /= math.sqrt(1.0 + aspect**-2)
        elif self.fov is not None:
            return self.fov
        return math.degrees(2.0 * math.atan(half))


class Perspective(Projective):
    """A pinhole camera."""

    hints: ClassVar[frozenset[str]] = SensorPlugin.hints | {"focus_distance"}

    type: Literal["perspective"] = "perspective"
    focus_distance: PositiveFloat | None = None
    """Accepted for Mitsuba's sake; a pinhole has no focus."""
    principal_point_offset_x: float = 0.0
    """Shift of the principal point from the middle of the film, in film widths."""
    principal_point_offset_y: float = 0.0
    """Shift of the principal point from the middle of the film, in film heights."""


class ThinLens(Projective):
    """A camera with a round or polygonal lens, in focus at one distance."""

    type: Literal["thinlens"] = "thinlens"
    aperture_radius: NonNegativeFloat
    """Radius of the lens, in the scene's units of length; 0 is a pinhole."""
    blades: Annotated[int, Field(ge=3, le=1000)] | None = None
    """Number of corners: the lens is a regular polygon with its corners at the radius. An extension to Mitsuba."""
    rotation: float = 0.0
    """Angle of the polygon's first corner, in degrees from the camera's +x towards +y; an extension to Mitsuba."""
    focus_distance: PositiveFloat | None = None
    """Distance of the plane in focus, measured along the axis; see `focus`."""

    @model_validator(mode="after")
    def _only_polygons_turn(self) -> Self:
        if "rotation" in self.model_fields_set and self.blades is None:
            raise ValueError("rotation needs blades: a round lens looks the same")
        return self

    @property
    def focus(self) -> float:
        """Distance of the plane in focus: without ``focus_distance`` the far clip, by default Mitsuba's 10000."""
        return self.focus_distance or self.far_clip or 1e4


class Orthographic(SensorPlugin):
    """Parallel rays: the image is two units wide, from -1 to 1 in x, before ``to_world``."""

    hints: ClassVar[frozenset[str]] = SensorPlugin.hints | {"focus_distance"}

    type: Literal["orthographic"] = "orthographic"
    to_world: Placement = IDENTITY
    """Placement of the camera; its scale sets how much is visible."""
    focus_distance: PositiveFloat | None = None
    """Accepted for Mitsuba's sake; everything is in focus."""


class Spherical(SensorPlugin):
    """All directions from one point, equal angles apart: Mitsuba 0.6's plugin, an extension to Mitsuba 3.

    The film's width is one turn round the camera's y axis; its height goes from +y to -y. The film's middle looks along
    +z.
    """

    type: Literal["spherical"] = "spherical"
    to_world: RigidPlacement = IDENTITY
    near_clip: PositiveFloat | None = None
    """Nearest visible distance from the camera; no limit unless given."""
    far_clip: PositiveFloat | None = None
    """Farthest visible distance from the camera; no limit unless given."""


Sensor = Annotated[Perspective | ThinLens | Orthographic | Spherical, Field(discriminator="type")]
"""Any sensor."""
