"""Form of the picture that a film asks for: its channels and precision in the first subimage of a saved render.

Light is kept as R, G, B with the primaries of Rec. 709. A film may ask for other channels or another precision
(``pixel_format``, ``component_format``). Other programs read that picture, and the file holds the render itself beside
it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from equaltime.images.image_files import RGB, linear_rgb
from equaltime.scene.model import HdrFilm
from equaltime.scene.picture_colors import REC709, to_xyz

__all__ = ["ALPHA", "FilmPicture"]

ALPHA: Final = "A"
_COLORS: Final = {"rgb": RGB, "luminance": ("Y",), "xyz": ("X", "Y", "Z")}


@dataclass(frozen=True)
class FilmPicture:
    """Form of the picture in a saved render, as the film asks for it: its colours, alpha and precision.

    The default is R, G, B in 32 bits without alpha.
    """

    colors: str = "rgb"
    """Channels of the picture: ``rgb``, ``luminance`` or ``xyz``."""
    alpha: bool = False
    """Whether the picture has alpha."""
    half: bool = False
    """Whether the picture's numbers are rounded to 16 bits."""

    @classmethod
    def of(cls, film: HdrFilm) -> FilmPicture:
        """Return the form of the picture that a film asks for.

        Numbers have 16 bits only if the film names that format, else 32 bits.
        """
        half = film.component_format == "float16" and "component_format" in film.model_fields_set
        return cls(film.colors, film.has_alpha, half)

    @classmethod
    def from_dict(cls, data: Mapping[str, Any] | None) -> FilmPicture:
        """Return the form of a picture from its fields as JSON data; None stands for the default form."""
        return cls() if data is None else cls(data["colors"], data["alpha"], data["half"])

    @property
    def is_exact(self) -> bool:
        """Whether the picture has exactly the render's values of R, G and B, so that a file needs no second copy."""
        return self.colors == "rgb" and not self.half

    def channels(self, alpha: NDArray[np.float32] | None) -> tuple[str, ...]:
        """Return the names of the picture's channels.

        Alpha is one of them if the film asks for it and ``alpha`` is not None.
        """
        return _COLORS[self.colors] + ((ALPHA,) if self.alpha and alpha is not None else ())

    def pixels(self, image: NDArray[np.float32], alpha: NDArray[np.float32] | None) -> NDArray[np.float32]:
        """Return a linear RGB image (H, W, 3) converted to the channels that the film asks for, (H, W, C).

        ``image`` is already multiplied by ``alpha`` (H, W). ``alpha`` is None for a film without alpha.
        """
        planes: NDArray[Any] = image
        if self.colors != "rgb":
            matrix = to_xyz(REC709)
            planes = image @ (matrix if self.colors == "xyz" else matrix[1:2]).T.astype(np.float32)
        if self.alpha and alpha is not None:
            planes = np.concatenate([planes, alpha[..., None]], axis=-1)
        return np.ascontiguousarray(planes, np.float32)

    @property
    def attributes(self) -> Mapping[str, Any]:
        """File attributes that state the colour space of R, G and B; empty if the picture has other channels."""
        return linear_rgb() if self.colors == "rgb" else {}
