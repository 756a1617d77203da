"""Cameras and samplers. A camera contains its film and its sampler."""

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
"""Diagonal of 35 mm film (36 mm by 24 mm), in mm; ``focal_length`` refers to this film."""
MOST_SAMPLES = 2**32
"""Largest number of samples per pixel of a render. Sobol' points have 32 bits, so further points would repeat."""


class SamplerPlugin(Plugin):
    """Base class of the samplers, which set the default number of samples per pixel.

    The `Strategy` of a render, not the sampler, decides which random numbers are used.
    """

    kind: ClassVar[Kind] = "sampler"
    hints: ClassVar[frozenset[str]] = frozenset({"sample_count", "seed", "type"})

    sample_count: Annotated[int, Field(gt=0, le=MOST_SAMPLES)] = 4
    """Samples per pixel, unless the render sets another number."""
    seed: int = 0


class Jittered(SamplerPlugin):
    """Base class of the samplers with the parameter ``jitter``, which has no effect."""

    jitter: bool = True


class Independent(SamplerPlugin):
    """Mitsuba's sampler of independent random numbers. Only its ``sample_count`` is used.

    The `Strategy` of a render decides how samples are drawn, so they need not be independent.
    """

    type: Literal["independent"] = "independent"


class Stratified(Jittered):
    """Mitsuba's stratified sampler. Only its ``sample_count`` is used.

    The `Strategy` of a render decides how samples are drawn, so they need not be stratified.
    """

    type: Literal["stratified"] = "stratified"


class MultiJitter(Jittered):
    """Mitsuba's correlated multi-jittered sampler. Only its ``sample_count`` is used.

    The `Strategy` of a render decides how samples are drawn.
    """

    type: Literal["multijitter"] = "multijitter"


class Orthogonal(Jittered):
    """Mitsuba's orthogonal array sampler. Only its ``sample_count`` is used.

    The `Strategy` of a render decides how samples are drawn.
    """

    type: Literal["orthogonal"] = "orthogonal"
    strength: PositiveInt = 2


class LdSampler(SamplerPlugin):
    """Mitsuba's low-discrepancy sampler. Only its ``sample_count`` is used.

    The `Strategy` of a render decides how samples are drawn, so they need not be of low discrepancy.
    """

    type: Literal["ldsampler"] = "ldsampler"


Sampler = Annotated[Independent | Stratified | MultiJitter | Orthogonal | LdSampler, Field(discriminator="type")]
"""Any sampler."""


def _as_millimetres(value: object) -> object:
    if not isinstance(value, str):
        return value
    try:
        return float(value.removesuffix("mm"))
    except ValueError:
        raise ValueError("expected a length in millimetres, such as '50mm'") from None


class SensorPlugin(Plugin):
    """Base class of the sensors.

    In local space, a sensor looks from the origin along +z, with +x to the left and +y up.
    """

    kind: ClassVar[Kind] = "sensor"
    roles: ClassVar[Mapping[Kind, str]] = {"film": "film", "sampler": "sampler", "medium": "medium"}
    later: ClassVar[frozenset[str]] = frozenset({"srf"})
    hints: ClassVar[frozenset[str]] = frozenset({"sampler", "shutter_open", "shutter_close"})

    near_clip: PositiveFloat | None = None
    """Nearest visible distance, measured along the camera's axis; no limit unless given."""
    far_clip: PositiveFloat | None = None
    """Farthest visible distance, measured along the camera's axis; no limit unless given."""
    shutter_open: float = 0.0
    """Time at which the exposure begins. All times of the exposure have equal weight in the image."""
    shutter_close: float = 0.0
    """Time at which the exposure ends."""
    film: HdrFilm = HdrFilm()
    sampler: Sampler = Independent()
    medium: Medium | None = None
    """Medium around the camera. If None, paths begin in the interior medium of the shapes around the camera, if any."""

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
    """Base class of the cameras with a field of view."""

    to_world: RigidPlacement = IDENTITY
    fov: Annotated[float, Field(gt=0.0, lt=180.0)] | None = None
    """Field of view in degrees along ``fov_axis``, over the whole film."""
    fov_axis: Annotated[Literal["x", "y", "diagonal", "smaller", "larger"], BeforeValidator(as_lower)] = "x"
    focal_length: Annotated[PositiveFloat, BeforeValidator(_as_millimetres)] | None = None
    """Focal length on 35 mm film, in mm, instead of ``fov``; 50 mm if neither of the two is given."""

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
    """A pinhole camera in perspective projection."""

    hints: ClassVar[frozenset[str]] = SensorPlugin.hints | {"focus_distance"}

    type: Literal["perspective"] = "perspective"
    focus_distance: PositiveFloat | None = None
    """Without effect: a pinhole has no focus. Accepted because Mitsuba has this parameter."""
    principal_point_offset_x: float = 0.0
    """Horizontal shift of the principal point from the centre of the film, in film widths."""
    principal_point_offset_y: float = 0.0
    """Vertical shift of the principal point from the centre of the film, in film heights."""


class ThinLens(Projective):
    """A thin-lens camera with a round or polygonal aperture. One distance is in focus."""

    type: Literal["thinlens"] = "thinlens"
    aperture_radius: NonNegativeFloat
    """Radius of the aperture, in the scene's units of length; 0 is a pinhole."""
    blades: Annotated[int, Field(ge=3, le=1000)] | None = None
    """Number of corners of a polygonal aperture, an extension to Mitsuba. The corners lie at ``aperture_radius``."""
    rotation: float = 0.0
    """Angle of the polygon's first corner, in degrees from the camera's +x towards +y; an extension to Mitsuba."""
    focus_distance: PositiveFloat | None = None
    """Distance of the plane in focus, measured along the camera's axis; by default ``far_clip``, or else 10000."""

    @model_validator(mode="after")
    def _only_polygons_turn(self) -> Self:
        if "rotation" in self.model_fields_set and self.blades is None:
            raise ValueError("rotation needs blades: a round lens looks the same")
        return self

    @property
    def focus(self) -> float:
        """Distance of the plane in focus, measured along the camera's axis.

        The distance is ``focus_distance``, or else ``far_clip``, or else 10000 as in Mitsuba.
        """
        return self.focus_distance or self.far_clip or 1e4


class Orthographic(SensorPlugin):
    """An orthographic camera. In local space, the image is two units wide, from -1 to 1 in x."""

    hints: ClassVar[frozenset[str]] = SensorPlugin.hints | {"focus_distance"}

    type: Literal["orthographic"] = "orthographic"
    to_world: Placement = IDENTITY
    """Placement of the camera; the scale of the transform sets the size of the visible area."""
    focus_distance: PositiveFloat | None = None
    """Without effect: everything is in focus. Accepted because Mitsuba has this parameter."""


class Spherical(SensorPlugin):
    """A camera that sees all directions from one point, in latitude-longitude projection.

    The plugin is from Mitsuba 0.6, and an extension to Mitsuba 3. The width of the film is a full turn about the
    camera's y axis, and the height goes from +y to -y. The centre of the film looks along +z.
    """

    type: Literal["spherical"] = "spherical"
    to_world: RigidPlacement = IDENTITY
    near_clip: PositiveFloat | None = None
    """Nearest visible distance from the camera; no limit unless given."""
    far_clip: PositiveFloat | None = None
    """Farthest visible distance from the camera; no limit unless given."""


Sensor = Annotated[Perspective | ThinLens | Orthographic | Spherical, Field(discriminator="type")]
"""Any sensor."""
