"""Hands emitters that are not shapes to the core, unless their power is zero."""

from __future__ import annotations

from equaltime.scene.assets import Assets
from equaltime.scene.builder import Builder
from equaltime.scene.compile_textures import Textures
from equaltime.scene.model import (
    Constant,
    Directional,
    FreeEmitter,
    MeshAttribute,
    Point,
    Spot,
    as_array,
    without_shear,
)
from equaltime.scene.unsupported import Unsupported

__all__ = ["add_emitter"]


def add_emitter(builder: Builder, emitter: FreeEmitter, assets: Assets, textures: Textures) -> None:
    """Add an emitter, unless its power is zero; raises `Unsupported` if the core cannot use it yet."""
    if isinstance(emitter, Point):
        if any(emitter.intensity):
            builder.add_point_light(emitter.world_position, emitter.intensity)
    elif isinstance(emitter, Spot):
        _add_spot(builder, emitter, textures)
    elif isinstance(emitter, Directional):
        if any(emitter.irradiance):
            builder.add_directional_light(emitter.world_direction, emitter.irradiance)
    elif isinstance(emitter, Constant):
        if any(emitter.radiance):
            builder.add_constant_environment(emitter.radiance)
    elif emitter.scale > 0.0 and (pixels := assets.image(emitter)).any():
        builder.add_image_environment(pixels, emitter.scale, without_shear(emitter.to_world))


def _add_spot(builder: Builder, spot: Spot, textures: Textures) -> None:
    if isinstance(spot.texture, MeshAttribute):
        raise Unsupported(spot.texture, "a spot light has no mesh whose attribute it could project")
    if not any(spot.intensity):
        return
    x, y, z, position = as_array(spot.to_world)[:3].T.tolist()
    index = builder.add_spot_light(position, z, spot.intensity, spot.cutoff_angle, spot.beam)
    if spot.texture is not None:
        builder.project(index, textures.index(spot.texture), u_axis=x, v_axis=y)
