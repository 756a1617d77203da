"""Integrators, which decide what light or quantity is computed.

The `Strategy` of a render decides how paths are sampled.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Annotated, ClassVar, Final, Literal, Self

from pydantic import Field, NonNegativeInt, PositiveInt, model_validator

from equaltime.scene.model.base import Kind, Plugin
from equaltime.words import suggestion

__all__ = [
    "LOOKS_AT_UV",
    "OUTPUTS",
    "OWN_OUTPUTS",
    "Aov",
    "Depth",
    "Direct",
    "Integrator",
    "IntegratorPlugin",
    "Moment",
    "Path",
    "VolPath",
    "VolPathMis",
]

OUTPUTS: Final = {
    **{"albedo": "RGB", "depth": "T", "position": "XYZ", "uv": "UV", "geo_normal": "XYZ", "sh_normal": "XYZ"},
    **{"prim_index": "I", "shape_index": "I", "dp_du": "XYZ", "dp_dv": "XYZ", "duv_dx": "UV", "duv_dy": "UV"},
}
"""Quantities that Mitsuba can write beside the image, each with one letter per channel. The letters end the channels'
names, as in ``depth.T``."""
OWN_OUTPUTS: Final = {"alpha": "A", "rays": "N", "time_from_rays": "T", "bounces": ""}
"""Quantities that Mitsuba does not have (`equaltime.rendering.outputs`), with one letter per channel. ``bounces`` has
channels for each path length instead."""
LOOKS_AT_UV: Final = frozenset({"uv", "dp_du", "dp_dv", "duv_dx", "duv_dy"})


class IntegratorPlugin(Plugin):
    """Base class of all integrators, which decide what light or quantity an image shows."""

    kind: ClassVar[Kind] = "integrator"
    hints: ClassVar[frozenset[str]] = frozenset({"block_size", "samples_per_pass", "timeout"})

    block_size: NonNegativeInt = 0
    """Without effect, like ``samples_per_pass``: the size of the blocks in which Mitsuba renders."""
    samples_per_pass: PositiveInt | None = None
    timeout: float = -1.0
    """Without effect: a time limit of Mitsuba, in seconds. The limit is a parameter of each render instead."""
    hide_emitters: bool = False
    """Hide emitters from the camera, as in Mitsuba: emitting shapes are invisible, and the environment looks black."""

    @property
    def hides_emitters(self) -> bool:
        """True if emitters are hidden from the camera."""
        return self.hide_emitters


class Path(IntegratorPlugin):
    """Global illumination by paths of up to ``max_depth`` segments."""

    hints: ClassVar[frozenset[str]] = IntegratorPlugin.hints | {"rr_depth"}

    type: Literal["path"] = "path"
    max_depth: Annotated[int, Field(ge=-1, lt=2**31)] = -1
    """Longest path, in segments. 0: no light, 1: emitted light only, 2: direct light too, and so on; -1: no limit."""
    rr_depth: PositiveInt = 5
    """Path length, in segments, from which Russian roulette may end a path; the `Strategy` may override the value."""


class VolPath(Path):
    """Global illumination with media. In a scene without media, `VolPath` is the same as `Path`."""

    type: Literal["volpath"] = "volpath"  # type: ignore[assignment]  # narrows the tag of Path


class VolPathMis(Path):
    """Another name of `VolPath`. The `Strategy` decides how the colour channels of a medium are sampled."""

    hints: ClassVar[frozenset[str]] = Path.hints | {"use_spectral_mis"}

    type: Literal["volpathmis"] = "volpathmis"  # type: ignore[assignment]  # narrows the tag of Path
    use_spectral_mis: bool = True
    """A sampling hint of Mitsuba, not used."""


class Direct(IntegratorPlugin):
    """Emitted and direct light only: a path integrator of depth 2."""

    hints: ClassVar[frozenset[str]] = IntegratorPlugin.hints | {"shading_samples", "emitter_samples", "bsdf_samples"}

    type: Literal["direct"] = "direct"
    shading_samples: PositiveInt | None = None
    """A sampling hint of Mitsuba, not used, like ``emitter_samples`` and ``bsdf_samples``."""
    emitter_samples: Annotated[int, Field(ge=0)] | None = None
    bsdf_samples: Annotated[int, Field(ge=0)] | None = None

    @property
    def max_depth(self) -> int:
        """Longest path, in segments. It is always 2: emitted and direct light."""
        return 2


class Depth(IntegratorPlugin):
    """Distance along the ray to the visible surface, as the output ``depth.T`` beside the image.

    The image shows emitted light only.
    """

    type: Literal["depth"] = "depth"

    @property
    def channels(self) -> tuple[tuple[str, str], ...]:
        """Outputs beside the image, as pairs (name, quantity). The only pair is (``depth``, ``depth``)."""
        return (("depth", "depth"),)

    @property
    def hides_emitters(self) -> bool:
        """Always False, as in Mitsuba: emitters have a distance, too."""
        return False

    @property
    def max_depth(self) -> int:
        """Longest path, in segments. It is always 1: the segment whose length is the distance."""
        return 1


Light = Annotated[Path | VolPath | VolPathMis | Direct, Field(discriminator="type")]


class Containing(IntegratorPlugin):
    """Base class of the integrators that add outputs to the image of a nested integrator."""

    roles: ClassVar[Mapping[Kind, str]] = {"integrator": "integrators"}
    lists: ClassVar[frozenset[str]] = frozenset({"integrators"})

    integrators: Annotated[tuple[Light, ...], Field(max_length=1)] = ()
    """The nested integrator, which makes the image; empty if there is none."""

    @property
    def max_depth(self) -> int:
        """Longest path of the nested integrator, in segments.

        Without a nested integrator, the value is 1, and the image shows emitted light only.
        """
        return self.integrators[0].max_depth if self.integrators else 1

    @property
    def hides_emitters(self) -> bool:
        """True if the nested integrator hides emitters from the camera. False without a nested integrator."""
        return bool(self.integrators) and self.integrators[0].hide_emitters


class Moment(Containing):
    """An integrator that renders the image of its nested integrator, and nothing else.

    In Mitsuba it also outputs second moments. They are left out, because every output here has standard errors.
    """

    type: Literal["moment"] = "moment"
    integrators: Annotated[tuple[Light, ...], Field(min_length=1, max_length=1)]


class Aov(Containing):
    """An integrator that outputs quantities of the first hit, such as depth, beside its nested integrator's image."""

    type: Literal["aov"] = "aov"
    aovs: str
    """Pairs ``name:quantity``, separated by commas, such as ``d:depth,n:sh_normal``; see `OUTPUTS`, `OWN_OUTPUTS`."""

    @model_validator(mode="after")
    def _known(self) -> Self:
        for _, what in self.channels:
            if what not in OUTPUTS and what not in OWN_OUTPUTS:
                raise ValueError(
                    f"'{what}' cannot be written beside the image{suggestion(what, {**OUTPUTS, **OWN_OUTPUTS})}"
                )
        return self

    @property
    def channels(self) -> tuple[tuple[str, str], ...]:
        """Outputs beside the image, as pairs (name, quantity) in the order of ``aovs``."""
        pairs = [pair.partition(":") for pair in re.split(r"[\s,]+", self.aovs.strip(", \t\r\n"))]
        return tuple((name, what) for name, _, what in pairs)


Integrator = Annotated[
    Path | VolPath | VolPathMis | Direct | Depth | Moment | Aov,
    Field(discriminator="type"),
]
"""Any integrator."""
