"""Finds the plugins of a scene that change nothing in the image.

Such plugins do not count as effects (features with a cost). They are left out of the core's scene, or simplified.

The core itself simplifies textures of one colour, masks and blends that show a single BSDF, flat normal and bump maps,
and lenses without aperture. Lights of zero power are never added.

This module finds invisible surfaces: a `null`, and glass with the index of refraction of its surroundings. Crossing a
surface adds to a path's length, except that volumetric integrators do not count a `null` or thin glass. An invisible
surface can be left out in two cases:

- If paths have no limit, every invisible surface can be left out. An exception is glass in a scene with a point, spot
  or directional light, because these lights do not shine through glass.
- If the integrator is volumetric, a `null` and thin glass can be left out.

A surface that emits light or bounds a medium always stays, even if the medium has no density.
"""

from __future__ import annotations

import numpy as np

from equaltime.scene.assets import Assets
from equaltime.scene.compile_media import sees_media
from equaltime.scene.model import (
    Aov,
    Area,
    Bitmap,
    BlendBsdf,
    BlendPhase,
    Bsdf,
    BumpMap,
    Checkerboard,
    Constant,
    Depth,
    Dielectric,
    Directional,
    EnvMap,
    Instance,
    Mask,
    Medium,
    NormalMap,
    Null,
    Plugin,
    Point,
    RoughDielectric,
    SceneModel,
    Shape,
    Solid,
    Spot,
    ThinDielectric,
    ThinLens,
)

__all__ = ["is_inert", "shown"]

WHITE = (1.0, 1.0, 1.0)


def shown(model: SceneModel) -> tuple[int, ...]:
    """Return the indices of the shapes from which the core's scene is built: all except invisible surfaces.

    In two cases no shape is left out. Integrators for other outputs than the image, `aov` and `depth`, count an
    invisible surface as a hit. With ``hide_emitters``, the camera sees an emitter only after a path has met a surface,
    and an invisible surface may be that surface.
    """
    integrator = model.integrator
    # outputs count these surfaces, and so do paths to hidden emitters
    counted = isinstance(integrator, Aov | Depth) or integrator.hides_emitters
    endless, freely = integrator.max_depth == -1, sees_media(integrator)
    if counted or not (endless or freely):
        return tuple(range(len(model.shapes)))
    aimed_at = any(isinstance(emitter, Point | Spot | Directional) for emitter in model.emitters)
    glass = (Dielectric,) if endless and not aimed_at else (ThinDielectric,) if freely else ()
    return tuple(i for i, shape in enumerate(model.shapes) if not _is_nothing(shape, glass))


def _is_nothing(shape: Shape, glass: tuple[type[Dielectric], ...]) -> bool:
    if isinstance(shape, Instance):
        return all(_is_nothing(part, glass) for part in shape.shapegroup.shapes)
    bounds_nothing = shape.interior is None and shape.exterior is None and shape.priority is None
    return bounds_nothing and _is_dark(shape) and shape.bsdf is not None and _is_clear(shape.bsdf, glass)


def _is_dark(shape: Solid) -> bool:
    return shape.emitter is None or (isinstance(shape.emitter.radiance, tuple) and not any(shape.emitter.radiance))


def _is_clear(bsdf: Bsdf, glass: tuple[type[Dielectric], ...]) -> bool:
    """Tell whether all light passes straight and unchanged; `glass` lists the types of glass that may be clear."""
    if isinstance(bsdf, Null):
        return True
    if isinstance(bsdf, Dielectric) and not isinstance(bsdf, RoughDielectric):
        return isinstance(bsdf, glass) and bsdf.int_ior == bsdf.ext_ior and bsdf.specular_transmittance == WHITE
    if isinstance(bsdf, Mask):
        return bsdf.opacity == 0.0 or _is_clear(bsdf.bsdf, glass)
    return isinstance(bsdf, BlendBsdf) and all(_is_clear(part, glass) for part in bsdf.bsdf)


def is_inert(node: Plugin, assets: Assets) -> bool:
    """Tell whether `node` itself changes nothing in the image, such as a light of zero power or an opaque mask.

    A plugin inside `node`, such as the BSDF under a mask, may still change the image. Raises ValueError if a file
    cannot be read.
    """
    if isinstance(node, Area):
        return isinstance(node.radiance, tuple) and not any(node.radiance)
    if isinstance(node, Point | Spot):
        return not any(node.intensity)
    if isinstance(node, Directional):
        return not any(node.irradiance)
    if isinstance(node, Constant):
        return not any(node.radiance)
    if isinstance(node, EnvMap):
        return node.scale == 0.0 or not assets.image(node).any()
    if isinstance(node, Medium):
        return node.scale == 0.0 or not any(node.sigma_t)
    if isinstance(node, ThinLens):
        return node.aperture_radius == 0.0
    if isinstance(node, Checkerboard | Bitmap):
        return _is_constant(node, assets)
    if isinstance(node, Mask):
        return node.opacity == 1.0
    if isinstance(node, BlendBsdf):
        return node.weight in (0.0, 1.0) or node.bsdf[0] == node.bsdf[1]
    if isinstance(node, BlendPhase):
        return node.weight in (0.0, 1.0) or node.phase[0] == node.phase[1]
    if isinstance(node, BumpMap):
        height = node.texture  # the squares of a checkerboard have no slope, whatever their heights
        flat = isinstance(height, Checkerboard) or (isinstance(height, Bitmap) and _is_constant(height, assets))
        return flat or node.scale == 0.0
    return isinstance(node, NormalMap) and _is_flat(node, assets)


def _is_constant(texture: Checkerboard | Bitmap, assets: Assets) -> bool:
    if isinstance(texture, Checkerboard):
        return texture.color0 == texture.color1
    texels = assets.texture(texture).texels
    return bool((texels[0] == texels[0, 0]).all() and (texels == texels[0, 0]).all())


def _is_flat(bent: NormalMap, assets: Assets) -> bool:
    """Tell whether the map leaves normals unchanged; one of bytes cannot: its 128 leans by a third of a degree."""
    texture = bent.normalmap
    if isinstance(texture, Checkerboard):
        color = texture.color0
        return isinstance(color, tuple) and color == texture.color1 and color[0] == color[1] == 0.5 < color[2]
    if not isinstance(texture, Bitmap) or not _is_constant(texture, assets):
        return False
    texels = assets.texture(texture)
    normal = np.broadcast_to(texels.texels[0, 0], 3)
    return texels.texels.dtype != np.uint8 and normal[0] == normal[1] == 0.5 < normal[2]
