"""Hands BSDFs and textures to the core, the renderer in C++. Equal ones are added once, even under different names.

A leaf BSDF wraps no other BSDF. A blend becomes a mixture of the BSDFs that it wraps. A
mask becomes a mixture with a null BSDF. Bump and normal maps bend the normals of every leaf that they wrap.

If a texture gives a parameter of a BSDF, the BSDF is first added with a placeholder value for this parameter. The
texture is then bound to the parameter by name.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from equaltime.scene.assets import Assets
from equaltime.scene.core import BSDF_MODELS, SceneBuilder, Unsupported, constant
from equaltime.scene.model import (
    Bitmap,
    BlendBsdf,
    Bsdf,
    BsdfPlugin,
    BumpMap,
    Checkerboard,
    Mask,
    MeshAttribute,
    NormalMap,
    Null,
    Plugin,
    Texture,
    TexturePlugin,
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
                raise Unsupported(bsdf, f"a '{bsdf.title}' within a '{bend.by.type}' is not supported")
            return self._index(bsdf.bsdf, turned, Bend(bsdf, turned))
        if isinstance(bsdf, Null):
            return self._builder.add_null()
        index = _add_leaf(self._builder, bsdf)
        for name, value in bsdf.textures().items():
            self._textures.bind(index, name, value)
        if bend is not None:
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
        index = self._builder.add_mixture(
            first, second, PLACEHOLDER if isinstance(weight, TexturePlugin) else weight, cutoff
        )
        self._textures.bind(index, "weight", weight)
        return index


def _add_leaf(builder: SceneBuilder, bsdf: BsdfPlugin) -> int:
    """Add a leaf BSDF to a builder, with the placeholder 0.5 for each parameter that a texture gives; return its index.

    Raises `Unsupported` if the core does not have the BSDF.
    """
    if bsdf.title not in BSDF_MODELS:
        raise Unsupported(bsdf)
    given = bsdf.parameters()
    values = {name: PLACEHOLDER if isinstance(given[name], TexturePlugin) else given[name] for name in given}
    return builder.add_bsdf(bsdf.title, **values)


PLACEHOLDER: Final = 0.5
"""Value of a parameter, a number or a grey, until the texture is bound to it that gives it."""
