"""A studio for models that bring no camera, no lights or no ground.

glTF files without a camera or without lights get a camera, a sky and a directional sun. A bare mesh (OBJ, PLY) also
gets a matt ground, and its sun is a far sphere, whose shadows are soft. A glTF file gets such a ground and such a sun
on demand.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from equaltime.scene import transforms
from equaltime.scene.model.values import Color, from_hex
from equaltime.scene.tree import Object, Place, plant
from equaltime.words import nearest, shortened

__all__ = [
    "ASPECT",
    "NOT_FRAMED",
    "SKY",
    "SUN",
    "SUN_ANGLE",
    "UPS",
    "VIEWS",
    "Z_UP",
    "Strength",
    "are_grounds",
    "choice",
    "default_camera",
    "film",
    "framed",
    "ground",
    "leaving_out",
    "number_of",
    "sky",
    "soft_sun",
    "strength",
    "sun",
    "sun_angle",
    "switch",
    "unused",
]

Array = NDArray[np.float64]
Strength = float | Color
"""A radiance, an irradiance or a reflectance: one number, or three in linear sRGB."""

LONG_SIDE: Final = 768
ASPECT: Final = 4.0 / 3.0
"""Width divided by height of the image, for cameras that do not set this ratio."""
VIEWS: Final = ("front", "right", "back", "left")
"""Sides of the model from which the default camera may look, each a quarter turn to the right of the one before. The
side ``front`` is +z."""
UPS: Final = ("y", "z")
"""Axes of a mesh that may point up."""
Z_UP: Final = np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, -1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
"""Transform that turns +z up (+y), and -y, the front of many programs in which +z is up, to the front (+z)."""
SKY: Final = 0.5
SUN: Final = 1.5
"""Default radiance of the sky (`SKY`) and irradiance of the sun (`SUN`) of glTF files. With both, white surfaces that
face the sun are white in the image."""
_FOV: Final = 40.0
_MARGIN: Final = 1.1
_CAMERA: Final = (0.6, 0.45, 1.0)
"""Direction from the centre of the model to the default camera: to the front (+z), a little to the right and above."""
_SUNLIGHT: Final = (0.5, -1.0, -0.8)
SUN_ANGLE: Final = 5.0
"""Default angular radius of the soft sun, in degrees: the edge of a shadow is as wide as a sixth of its distance from
what casts it."""
_SUN_ANGLES: Final = (0.1, 45.0)
"""Range of this radius. A larger sun would reach below the ground: its centre is 46.7 degrees above it. A smaller one
would look like the smallest, which is smaller than the sun (0.27 degrees), and would be noisier in mirrors."""
_FAR: Final = 1e4
"""Distance of the soft sun, in diagonals of the model: all that the camera sees of the ground is lit alike."""
_WIDE: Final = 100.0
"""Radius of the ground, in diagonals of the model: beyond what the default camera sees."""
_GAP: Final = 1e-4
"""Distance from the model down to the ground, in diagonals of the model: surfaces must not coincide."""


NOT_FRAMED: Final = "the model's own ground is far wider than all else: the camera frames all else"
_FLAT: Final = 0.01
"""Largest height of a ground, in widths of it."""
_WIDER: Final = 3.0
"""Smallest width of a ground that is not framed, in widths of all else: around less, the model still fills a third of
the picture."""


def film(aspect: float, place: Place) -> Object:
    """Return a film of the given ratio of width to height."""
    width, height = (LONG_SIDE, LONG_SIDE / aspect) if aspect >= 1.0 else (LONG_SIDE * aspect, LONG_SIDE)
    return plant("film", "hdrfilm", place, width=max(1, round(width)), height=max(1, round(height)))


def default_camera(points: Array, place: Place, view: str = "front") -> Object:
    """Return a perspective camera of the scene tree from a side of `VIEWS`, which sees all ``points`` (N, 3).

    The points fill the width or the height of the image, up to a margin, and are centred along the other.
    """
    if len(points) == 0:
        points = np.array([[-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]])
    back = _turned(_CAMERA, view) / math.hypot(*_CAMERA)
    right = np.cross((0.0, 1.0, 0.0), back) / math.hypot(back[0], back[2])
    axes = np.column_stack([right, np.cross(back, right), back])
    middle = 0.5 * points.min(axis=0) + 0.5 * points.max(axis=0)
    x, y, z = ((points - middle) @ axes).T
    half = math.tan(math.radians(_FOV) / 2.0) / _MARGIN
    (across, far), (up, high) = _nearest(x, z, half * ASPECT), _nearest(y, z, half)
    distance = max(far, high) - float(z.max())
    target = middle + axes @ (across, up, z.max())
    origin = target + (distance or 1.0) * back
    to_world = transforms.look_at(origin.tolist(), target.tolist(), (0.0, 1.0, 0.0))
    return plant("sensor", "perspective", place, to_world=to_world, fov=_FOV, fov_axis="y", film=film(ASPECT, place))


def framed(parts: Sequence[Array]) -> list[Array]:
    """Return the parts of a model that the default camera frames: all, except grounds (`are_grounds`)."""
    return [part for part, ground in zip(parts, are_grounds(parts), strict=True) if not ground]


def are_grounds(parts: Sequence[Array]) -> list[bool]:
    """Tell of each part of a model whether it is a ground: flat, and far wider than all else.

    A part is a set of points (N, 3), such as the corners of a mesh's box. A ground lies below the middle of the parts
    that are not flat; without such parts, there is no ground.
    """
    boxes = np.array([[part.min(axis=0), part.max(axis=0)] for part in parts]).reshape(-1, 2, 3)
    sizes = boxes[:, 1] - boxes[:, 0]
    widths = np.hypot(sizes[:, 0], sizes[:, 2])
    flat = sizes[:, 1] <= _FLAT * widths
    if flat.all():
        return [False] * len(parts)
    low, high = boxes[~flat, 0].min(axis=0), boxes[~flat, 1].max(axis=0)
    below = boxes[:, 1, 1] <= 0.5 * low[1] + 0.5 * high[1]
    wide = widths > _WIDER * math.hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2])
    found: list[bool] = (flat & below & wide).tolist()
    return found


def _nearest(x: Array, z: Array, half: float) -> tuple[float, float]:
    """Return the apex (x, z) that is nearest to points in a plane and has them within ``half`` of z on either side."""
    right, left = float(np.max(x + half * z)), float(np.max(half * z - x))
    return 0.5 * (right - left), 0.5 * (right + left) / half


def sky(radiance: Strength, place: Place, name: str = "sky") -> Object | None:
    """Return a constant environment with radiance `radiance` in W/(m² sr), or None if the radiance is 0."""
    return plant("emitter", "constant", place, name, radiance=radiance) if np.any(radiance) else None


def sun(irradiance: Strength, place: Place, name: str = "sun", view: str = "front") -> Object | None:
    """Return a directional light with irradiance `irradiance` in W/m², or None if the irradiance is 0.

    The light comes from above the left shoulder of the camera of ``view``.
    """
    if not np.any(irradiance):
        return None
    return plant(
        "emitter", "directional", place, name, irradiance=irradiance, direction=tuple(_turned(_SUNLIGHT, view).tolist())
    )


def soft_sun(
    irradiance: Strength,
    bounds: Array,
    place: Place,
    view: str = "front",
    angle: float = SUN_ANGLE,
    name: str = "sun",
) -> Object | None:
    """Return a far, emitting sphere that gives the model ``irradiance`` in W/m²; None if ``irradiance`` is 0.

    ``bounds`` (2, 3) are the least and the largest coordinates of the model. The light comes from above the camera's
    left shoulder. ``angle`` is the angular radius of the sun, in degrees; it does not change the irradiance.
    """
    if not np.any(irradiance):
        return None
    middle, size = _extent(bounds)
    center = middle - _FAR * size * _turned(_SUNLIGHT, view) / math.hypot(*_SUNLIGHT)
    sine = math.sin(math.radians(angle))
    lamp = plant("emitter", "area", place, radiance=_over(irradiance, math.pi * sine**2))
    return plant("shape", "sphere", place, name, center=tuple(center.tolist()), radius=_FAR * size * sine, emitter=lamp)


def ground(reflectance: Strength, bounds: Array, place: Place, name: str = "ground") -> Object:
    """Return a matt disk just below a model; ``bounds`` (2, 3) are the model's least and largest coordinates."""
    middle, size = _extent(bounds)
    lying = transforms.rotate((1.0, 0.0, 0.0), -90.0) @ transforms.scale((_WIDE * size,) * 3)
    down = transforms.translate((float(middle[0]), float(bounds[0, 1] - _GAP * size), float(middle[2])))
    bsdf = plant("bsdf", "diffuse", place, reflectance=reflectance)
    return plant("shape", "disk", place, name, to_world=down @ lying, bsdf=bsdf)


def leaving_out(grounds: Sequence[str | None]) -> str:
    """Return a clause on how to remove a model's own grounds, which are shapes with these names, None without one."""
    blocks = " and ".join(f"[{name}]" for name in grounds if name) or "its block"
    return f"to leave out the file's own ground, 'equaltime convert' the file to TOML and delete {blocks} there"


def number_of(given: object, name: str, most: float = math.inf, least: float = 0.0, other: str = "") -> float:
    """Return ``given``, the user's value of the scene variable ``name`` (command line: ``-D name=value``), as a number.

    Raises ValueError unless it is a finite number in [``least``, ``most``]. ``other`` is what may be given besides.
    """
    try:
        value = float(str(given))
    except ValueError:
        value = math.nan
    if not least <= value <= most or math.isinf(value):
        allowed = f"of at least {least:g}" if math.isinf(most) else f"from {least:g} to {most:g}"
        raise ValueError(f"'{name}' must be a number {allowed}{other}, found {shortened(given, 40)}")
    return value


def strength(given: object, name: str, most: float = math.inf) -> Strength:
    """Return ``given``, the user's value of the scene variable ``name``, as a number or a colour in linear sRGB.

    A colour is given in hexadecimal digits of encoded sRGB, ``#20c040``. Raises ValueError for any other text, and
    unless a number is in [0, ``most``].
    """
    if not isinstance(given, str) or not given.lstrip().startswith("#"):
        return number_of(given, name, most, other=" or a colour such as #20c040")
    try:
        return from_hex(given)
    except ValueError as error:
        raise ValueError(f"'{name}': {error}") from None


def _over(dividend: Strength, divisor: float) -> Strength:
    if isinstance(dividend, float):
        return dividend / divisor
    red, green, blue = dividend
    return red / divisor, green / divisor, blue / divisor


def sun_angle(given: object) -> float:
    """Return ``given``, the user's value of the scene variable ``sun_angle``, in degrees.

    The command line sets it by ``-D sun_angle=value``. Raises ValueError unless it is a number in the variable's range.
    """
    return number_of(given, "sun_angle", least=_SUN_ANGLES[0], most=_SUN_ANGLES[1])


def choice(given: object, name: str, among: Sequence[str]) -> str:
    """Return ``given``, the user's value of the scene variable ``name`` (command line: ``-D name=value``).

    Raises ValueError unless the value is one of the texts in ``among``.
    """
    if given not in among:
        near = nearest(str(given), among)
        found = shortened(given, 40) + (f"; did you mean '{near}'?" if near else "")
        raise ValueError(f"'{name}' must be {', '.join(among[:-1])} or {among[-1]}, found {found}")
    return str(given)


def unused(name: str, definitions: Collection[str]) -> str:
    """Return the error about ``name``, a definition that no model file has; ``definitions`` are those that all have."""
    near = nearest(name, definitions)
    *others, last = sorted(definitions)
    known = f"did you mean '{near}'?" if near else f"expected {', '.join(others)} or {last}"
    materials = "" if near else "; 'equaltime convert' writes a TOML file in which materials can be changed"
    return f"nothing in the scene uses the definition {shortened(name, 40)}; {known}{materials}"


def switch(given: object, name: str) -> bool:
    """Return ``given``, the user's value of the scene variable ``name`` (``-D name=value``), as a boolean.

    The value is a boolean, or one of the texts ``true`` and ``false``. Raises ValueError for any other value.
    """
    return given if isinstance(given, bool) else choice(given, name, ("true", "false")) == "true"


def _extent(bounds: Array) -> tuple[Array, float]:
    """Return the middle of a box and its diagonal; the diagonal of a point is 1."""
    return 0.5 * bounds[0] + 0.5 * bounds[1], math.hypot(*(bounds[1] - bounds[0])) or 1.0


def _turned(direction: tuple[float, float, float], view: str) -> Array:
    """Return a direction of the front view, turned to another view about the vertical."""
    x, y, z = direction
    for _ in range(VIEWS.index(view)):
        x, z = z, -x
    return np.array([x, y, z])
