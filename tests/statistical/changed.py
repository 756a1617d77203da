"""A SceneBuilder that changes what passes through it: lengths, brightness, colours. For scaled and slightly wrong twins
of any scene that loads.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

import equaltime as et
from equaltime import _core
from equaltime.scene.compile import compile_scene

__all__ = ["ChangedBuilder", "changed"]

Array = NDArray[np.float64]


@dataclass
class ChangedBuilder:
    """Lengths are multiplied by `length`, all light by `light`, colours of diffuse surfaces by `reflectance`.

    The light of points is power per solid angle, and grows with the square of lengths.
    """

    length: float = 1.0
    light: float = 1.0
    reflectance: float = 1.0
    inner: _core.SceneBuilder = field(default_factory=_core.SceneBuilder)

    def __getattr__(self, name: str) -> Any:
        """Pass on what does not change: BSDFs without colours, the film, the building itself."""
        return getattr(self.inner, name)

    def _place(self, point: ArrayLike) -> Array:
        return np.asarray(point, dtype=float) * self.length

    def _transform(self, matrix: ArrayLike, axes: float) -> Array:
        out = np.array(matrix, dtype=float)
        out[:3, 3] = self._place(out[:3, 3])
        out[:3, :3] *= axes
        return out

    def _lit(self, sides: dict[str, Any]) -> dict[str, Any]:
        radiance = sides["radiance"]
        return sides | {"radiance": None if radiance is None else np.asarray(radiance) * self.light}

    def add_bsdf(self, type: str, **parameters: Any) -> int:
        if type == "diffuse":
            parameters["reflectance"] = np.asarray(parameters["reflectance"]) * self.reflectance
        return self.inner.add_bsdf(type, **parameters)

    def add_mesh(self, vertices: ArrayLike, *arrays: Any, **sides: Any) -> int:
        return self.inner.add_mesh(self._place(vertices), *arrays, **self._lit(sides))

    def add_rectangle(self, to_world: ArrayLike, **sides: Any) -> int:
        return self.inner.add_rectangle(self._transform(to_world, self.length), **self._lit(sides))

    def add_disk(self, to_world: ArrayLike, **sides: Any) -> int:
        return self.inner.add_disk(self._transform(to_world, self.length), **self._lit(sides))

    def add_sphere(self, center: ArrayLike, radius: float, **sides: Any) -> int:
        return self.inner.add_sphere(self._place(center), radius * self.length, **self._lit(sides))

    def add_cylinder(self, base: ArrayLike, end: ArrayLike, radius: float, **sides: Any) -> int:
        return self.inner.add_cylinder(self._place(base), self._place(end), radius * self.length, **self._lit(sides))

    def add_instance(self, group: int, to_world: ArrayLike) -> int:
        return self.inner.add_instance(group, self._transform(to_world, 1.0))

    def add_moving_instance(self, group: int, times: ArrayLike, matrices: ArrayLike) -> int:
        return self.inner.add_moving_instance(group, times, [self._transform(m, 1.0) for m in np.asarray(matrices)])

    def add_point_light(self, position: ArrayLike, intensity: ArrayLike) -> int:
        bright = np.asarray(intensity) * self.light * self.length**2
        return self.inner.add_point_light(self._place(position), bright)

    def add_spot_light(self, position: ArrayLike, direction: Any, intensity: ArrayLike, *angles: float) -> int:
        bright = np.asarray(intensity) * self.light * self.length**2
        return self.inner.add_spot_light(self._place(position), direction, bright, *angles)

    def add_directional_light(self, direction: Any, irradiance: ArrayLike) -> int:
        return self.inner.add_directional_light(direction, np.asarray(irradiance) * self.light)

    def add_constant_environment(self, radiance: ArrayLike) -> None:
        self.inner.add_constant_environment(np.asarray(radiance) * self.light)

    def add_image_environment(self, pixels: ArrayLike, scale: float, to_world: ArrayLike) -> None:
        self.inner.add_image_environment(pixels, scale * self.light, to_world)

    def set_perspective(
        self,
        to_world: ArrayLike,
        fov: float,
        near: float | None = None,
        far: float | None = None,
        *more: Any,
        **lens: Any,
    ) -> None:
        near, far = (None if clip is None else clip * self.length for clip in (near, far))
        lengths = {name: lens[name] * self.length for name in ("aperture_radius", "focus_distance") if name in lens}
        self.inner.set_perspective(self._transform(to_world, 1.0), fov, near, far, *more, **lens | lengths)

    def set_orthographic(self, to_world: ArrayLike, *clips: Any) -> None:
        self.inner.set_orthographic(self._transform(to_world, self.length), *clips)


def changed(scene: et.Scene, **changes: Any) -> _core.Scene:
    """Return the compiled scene with changes; the same as `scene.core` if there are none."""
    return compile_scene(scene.model, scene.assets, ChangedBuilder(**changes))  # type: ignore[arg-type]
