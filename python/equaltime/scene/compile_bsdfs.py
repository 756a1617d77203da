"""Hands BSDFs and textures to the core, the renderer in C++. Equal ones are added once, even under different names.

A leaf BSDF wraps no other BSDF; a function of its own adds it. A blend becomes a mixture of the BSDFs that it wraps. A
mask becomes a mixture with a null BSDF. Bump and normal maps bend the normals of every leaf that they wrap.

If a texture gives a parameter of a BSDF, the BSDF is first added with a placeholder value for this parameter. The
texture is then bound to the parameter by name.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from equaltime.scene.assets import Assets
from equaltime.scene.core import SceneBuilder, Unsupported, constant
from equaltime.scene.model import (
    Bitmap,
    BlendBsdf,
    Bsdf,
    BumpMap,
    Checkerboard,
    Color,
    Conductor,
    Dielectric,
    Diffuse,
    Mask,
    MeshAttribute,
    NormalMap,
    Null,
    Plastic,
    Plugin,
    Principled,
    RoughConductor,
    RoughDielectric,
    RoughPlastic,
    Texture,
    TexturePlugin,
    ThinDielectric,
)

__all__ = ["BsdfCompiler", "Textures"]


class Textures:
    """Adds textures to the core's scene builder, each once, and gives their indices in the core."""

    def __init__(self, builder: SceneBuilder, assets: Assets) -> None:
        self._builder = builder
        self._assets = assets
        self._known: dict[Texture, int] = {}

    def index(self, texture: Texture) -> int:
        """Add `texture` if it is new, and return its index in the core; raises ValueError if its file is unusable."""
        if isinstance(texture, MeshAttribute) and texture.times is not None:
            raise Unsupported(texture, "'times' of a 'mesh_attribute' is for parameters of BSDFs")
        nameless = texture.model_copy(update={"id": None})
        if nameless not in self._known:
            self._known[nameless] = self._add(texture)
        return self._known[nameless]

    def bind(self, bsdf: int, name: str, value: object) -> None:
        """Bind the texture `value` to a parameter of a BSDF in the core; do nothing if `value` is no texture.

        `name` is the name of the parameter, and `bsdf` is the BSDF's index in the core.
        """
        if isinstance(value, MeshAttribute) and value.times is not None:
            self._builder.bind(bsdf, name, self.index(_alone(value)), self.index(value.times))
        elif isinstance(value, Bitmap | Checkerboard | MeshAttribute):
            self._builder.bind(bsdf, name, self.index(value))

    def hand_over(self, shape: int, attributes: Mapping[str, NDArray[np.float64]], wanted: Iterable[Plugin]) -> None:
        """Give a shape's mesh attributes to the textures that read them.

        `shape` is the shape's number in the core. `attributes` are the mesh's arrays by name. The textures are the
        `MeshAttribute` plugins in `wanted`. Raises `Unsupported` for a texture whose attribute is missing.
        """
        looked_at = {self.index(_alone(node)): node for node in wanted if isinstance(node, MeshAttribute)}
        for index, texture in looked_at.items():
            values = attributes.get(texture.name)
            if values is None:
                raise Unsupported(texture, f"the shape has no attribute '{texture.name}'{_what_there_is(attributes)}")
            per_face = texture.name.startswith("face_")
            self._builder.set_attribute(shape, index, texture.numbers(values), per_face=per_face)

    def _add(self, texture: Texture) -> int:
        if isinstance(texture, Bitmap):
            image = self._assets.texture(texture)
            return self._builder.add_bitmap(
                image.texels,
                srgb=image.srgb and not texture.raw,
                filter=texture.filter_type,
                wrap=texture.wrap_mode,
                to_uv=texture.uv_rows,
            )
        if isinstance(texture, Checkerboard):
            colors = constant(texture.color0), constant(texture.color1)
            return self._builder.add_checkerboard(*colors, to_uv=texture.uv_rows)
        return self._builder.add_mesh_attribute()


def _alone(texture: MeshAttribute) -> MeshAttribute:
    """Return the attribute without the texture that multiplies it."""
    return texture.model_copy(update={"times": None})


def _what_there_is(attributes: Mapping[str, object]) -> str:
    return f"; it has {', '.join(map(repr, attributes))}" if attributes else ""


def _color(value: Texture | Color) -> Color:
    """Return `value` if it is a constant colour; for a texture, return the placeholder (0.5, 0.5, 0.5)."""
    return (0.5, 0.5, 0.5) if isinstance(value, TexturePlugin) else value


def _number(value: Texture | float) -> float:
    """Return `value` if it is a number; for a texture, return the placeholder 0.5."""
    return 0.5 if isinstance(value, TexturePlugin) else value


@dataclass(frozen=True, slots=True)
class Bend:
    """A bump or normal map, `by`, that bends the normals of a leaf BSDF (one that wraps no other).

    If `turned`, a bent normal on the back of the surface is the negative of the front's bent normal; otherwise it is
    the mirror image.
    """

    by: BumpMap | NormalMap
    turned: bool


class BsdfCompiler:
    """Adds BSDFs to the core's scene builder, each once, and gives their indices in the core."""

    def __init__(self, builder: SceneBuilder, textures: Textures) -> None:
        self._builder = builder
        self._textures = textures
        self._known: dict[tuple[Bsdf, bool, Bend | None], int] = {}

    def index(self, bsdf: Bsdf | None, turned: bool = False) -> int | None:
        """Add the BSDF of one side of a surface if it is new, and return its index in the core.

        Return None if `bsdf` is None, for a side that absorbs all light. If `turned`, a bent normal on the back of the
        surface is the negative of the front's bent normal; otherwise it is the mirror image. `wrappers.turns` finds
        `turned`.
        """
        return None if bsdf is None else self._index(bsdf, turned, None)

    def _index(self, bsdf: Bsdf, turned: bool, bend: Bend | None) -> int:
        key = bsdf.model_copy(update={"id": None}), turned, bend
        if key not in self._known:
            self._known[key] = self._add(bsdf, turned, bend)
        return self._known[key]

    def _add(self, bsdf: Bsdf, turned: bool, bend: Bend | None) -> int:
        if isinstance(bsdf, Mask):
            nothing, hidden = self._builder.add_null(), self._index(bsdf.bsdf, turned, bend)
            return self._mixture(nothing, hidden, bsdf.opacity, bsdf.cutoff)
        if isinstance(bsdf, BlendBsdf):
            first, second = (self._index(part, turned, bend) for part in bsdf.bsdf)
            return self._mixture(first, second, bsdf.weight)
        if isinstance(bsdf, BumpMap) and bsdf.scale == 0.0:
            return self._index(bsdf.bsdf, turned, bend)  # saves the memory of its texture
        if isinstance(bsdf, BumpMap | NormalMap):
            if bend is not None:
                raise Unsupported(bsdf, f"a '{bsdf.type}' within a '{bend.by.type}' is not supported")
            return self._index(bsdf.bsdf, turned, Bend(bsdf, turned))
        step = LEAVES.get(type(bsdf))
        if step is None:
            raise Unsupported(bsdf)
        index = step(self._builder, bsdf)
        for name, value in vars(bsdf).items():
            self._textures.bind(index, name, value)
        if bend is not None and not isinstance(bsdf, Null):
            self._bend(index, bend)
        return index

    def _bend(self, index: int, bend: Bend) -> None:
        by = bend.by
        self._builder.bend(
            index,
            self._textures.index(by.texture if isinstance(by, BumpMap) else by.normalmap),
            bump=isinstance(by, BumpMap),
            scale=by.scale if isinstance(by, BumpMap) else 1.0,
            flip_invalid=by.flip_invalid_normals,
            shadowing=by.use_shadowing_function,
            turned=bend.turned,
        )

    def _mixture(self, first: int, second: int, weight: Texture | float, cutoff: float | None = None) -> int:
        index = self._builder.add_mixture(first, second, _number(weight), cutoff)
        self._textures.bind(index, "weight", weight)
        return index


def _diffuse(builder: SceneBuilder, bsdf: Diffuse) -> int:
    return builder.add_diffuse(_color(bsdf.reflectance))


def _conductor(builder: SceneBuilder, bsdf: Conductor) -> int:
    eta, k = map(_color, bsdf.ior)
    return builder.add_conductor(eta, k, _color(bsdf.specular_reflectance))


def _rough_conductor(builder: SceneBuilder, bsdf: RoughConductor) -> int:
    (eta, k), (alpha_u, alpha_v) = map(_color, bsdf.ior), map(_number, bsdf.alphas)
    reflectance = _color(bsdf.specular_reflectance)
    return builder.add_rough_conductor(bsdf.distribution, alpha_u, alpha_v, eta, k, reflectance)


def _dielectric(builder: SceneBuilder, bsdf: Dielectric) -> int:
    reflectance, transmittance = _color(bsdf.specular_reflectance), _color(bsdf.specular_transmittance)
    return builder.add_dielectric(bsdf.int_ior / bsdf.ext_ior, reflectance, transmittance)


def _thin_dielectric(builder: SceneBuilder, bsdf: ThinDielectric) -> int:
    reflectance, transmittance = _color(bsdf.specular_reflectance), _color(bsdf.specular_transmittance)
    return builder.add_thin_dielectric(bsdf.int_ior / bsdf.ext_ior, reflectance, transmittance)


def _rough_dielectric(builder: SceneBuilder, bsdf: RoughDielectric) -> int:
    reflectance, transmittance = _color(bsdf.specular_reflectance), _color(bsdf.specular_transmittance)
    alpha_u, alpha_v = map(_number, bsdf.alphas)
    ior = bsdf.int_ior / bsdf.ext_ior
    return builder.add_rough_dielectric(bsdf.distribution, alpha_u, alpha_v, ior, reflectance, transmittance)


def _plastic(builder: SceneBuilder, bsdf: Plastic) -> int:
    diffuse, specular = _color(bsdf.diffuse_reflectance), _color(bsdf.specular_reflectance)
    return builder.add_plastic(bsdf.int_ior / bsdf.ext_ior, diffuse, specular, bsdf.nonlinear)


def _rough_plastic(builder: SceneBuilder, bsdf: RoughPlastic) -> int:
    diffuse, specular = _color(bsdf.diffuse_reflectance), _color(bsdf.specular_reflectance)
    ior = bsdf.int_ior / bsdf.ext_ior
    return builder.add_rough_plastic(bsdf.distribution, bsdf.alpha, ior, diffuse, specular, bsdf.nonlinear)


def _principled(builder: SceneBuilder, bsdf: Principled) -> int:
    numbers = {name: _number(getattr(bsdf, name)) for name in PRINCIPLED}
    return builder.add_principled(_color(bsdf.base_color), ior=bsdf.ior, **numbers)


def _null(builder: SceneBuilder, _: Null) -> int:
    return builder.add_null()


PRINCIPLED: Final = (
    *("roughness", "anisotropic", "metallic", "spec_trans", "spec_tint", "sheen", "sheen_tint", "flatness"),
    *("clearcoat", "clearcoat_gloss"),
)
"""Parameters of `Principled` that are single numbers and may be textures."""
Step = Callable[[SceneBuilder, Any], int]
LEAVES: Final[dict[type, Step]] = {
    Diffuse: _diffuse,
    Conductor: _conductor,
    RoughConductor: _rough_conductor,
    Dielectric: _dielectric,
    ThinDielectric: _thin_dielectric,
    RoughDielectric: _rough_dielectric,
    Plastic: _plastic,
    RoughPlastic: _rough_plastic,
    Principled: _principled,
    Null: _null,
}
"""Functions that add a leaf BSDF (one that wraps no other) to a builder, by the type of the BSDF."""
