"""The picture that a film asks for: the channels of the first part of a saved render, and their precision.

Light is kept as R, G, B with the primaries of Rec. 709. A film may ask for another form of the picture
(``pixel_format``, ``component_format``). Other programs read that form, and the render itself is kept beside it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from equaltime.images.image_files import RGB, linear_rgb
from equaltime.scene.model import HdrFilm
from equaltime.scene.primaries import REC709, to_xyz

__all__ = ["ALPHA", "FilmPicture"]

ALPHA: Final = "A"
_COLORS: Final = {"rgb": RGB, "luminance": ("Y",), "xyz": ("X", "Y", "Z")}


@dataclass(frozen=True)
class FilmPicture:
    """Form of the picture; the default is the form of the render itself."""

    colors: str = "rgb"
    """``rgb``, ``luminance`` or ``xyz``."""
    alpha: bool = False
    """Whether alpha is written."""
    half: bool = False
    """Whether numbers are rounded to 16 bits."""

    @classmethod
    def of(cls, film: HdrFilm) -> FilmPicture:
        """Return the form that a film asks for. Numbers have 32 bits unless the film names another format."""
        half = film.component_format == "float16" and "component_format" in film.model_fields_set
        return cls(film.colors, film.has_alpha, half)

    @classmethod
    def from_dict(cls, data: Mapping[str, Any] | None) -> FilmPicture:
        """Read the data of `as_dict`; None stands for the default form."""
        return cls() if data is None else cls(data["colors"], data["alpha"], data["half"])

    def as_dict(self) -> dict[str, Any]:
        """Return the form as JSON data."""
        return asdict(self)

    @property
    def is_exact(self) -> bool:
        """Whether the picture has R, G and B of the render to the bit."""
        return self.colors == "rgb" and not self.half

    def channels(self, alpha: NDArray[np.float32] | None) -> tuple[str, ...]:
        """Return the names of the channels; alpha is among them where it is known."""
        return _COLORS[self.colors] + ((ALPHA,) if self.alpha and alpha is not None else ())

    def pixels(self, image: NDArray[np.float32], alpha: NDArray[np.float32] | None) -> NDArray[np.float32]:
        """Return the picture (H, W, C) for linear RGB (H, W, 3) that is already multiplied by alpha (associated)."""
        planes: NDArray[Any] = image
        if self.colors != "rgb":
            matrix = to_xyz(REC709)
            planes = image @ (matrix if self.colors == "xyz" else matrix[1:2]).T.astype(np.float32)
        if self.alpha and alpha is not None:
            planes = np.concatenate([planes, alpha[..., None]], axis=-1)
        return np.ascontiguousarray(planes, np.float32)

    @property
    def attributes(self) -> Mapping[str, Any]:
        """Attributes that tell readers the colour space of R, G and B; empty if the picture has other channels."""
        return linear_rgb() if self.colors == "rgb" else {}
