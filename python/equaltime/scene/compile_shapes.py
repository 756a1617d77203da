"""Hands shapes to the core, with the materials and the light of their sides."""

from __future__ import annotations

from equaltime.scene.assets import Assets
from equaltime.scene.builder import Builder
from equaltime.scene.compile_bsdfs import Materials
from equaltime.scene.compile_textures import Textures
from equaltime.scene.geometry import CylinderSurface, DiskSurface, MeshSurface, QuadSurface, Surface, surface
from equaltime.scene.model import Color, Instance, Shape, TexturePlugin
from equaltime.scene.unsupported import Unsupported

__all__ = ["add_shape"]


def add_shape(builder: Builder, shape: Shape, assets: Assets, materials: Materials, textures: Textures) -> None:
    """Add `shape`; raises ValueError if its file cannot be used, `Unsupported` if the core cannot use it yet."""
    if isinstance(shape, Instance):
        raise Unsupported(shape)
    for medium in (shape.interior, shape.exterior):
        if medium is not None:
            raise Unsupported(medium)
    placed = surface(shape, assets)
    front, back = materials.index(placed.sides.front), materials.index(placed.sides.back)
    _add_surface(builder, placed, front, back, _radiance(placed))


def _radiance(placed: Surface) -> Color | None:
    radiance = placed.sides.radiance
    if isinstance(radiance, TexturePlugin):
        raise Unsupported(radiance, f"an area emitter with a texture ('{radiance.type}') is not supported yet")
    return radiance


def _add_surface(
    builder: Builder, placed: Surface, front: int | None, back: int | None, radiance: Color | None
) -> None:
    if isinstance(placed, MeshSurface):
        builder.add_mesh(
            placed.vertices, placed.faces, placed.normals, placed.uvs, front=front, back=back, radiance=radiance
        )
        return
    flipped = placed.flip_normals
    if isinstance(placed, QuadSurface):
        builder.add_rectangle(placed.to_world, flip_normals=flipped, front=front, back=back, radiance=radiance)
    elif isinstance(placed, DiskSurface):
        builder.add_disk(placed.to_world, flip_normals=flipped, front=front, back=back, radiance=radiance)
    elif isinstance(placed, CylinderSurface):
        ends = placed.base.tolist(), placed.end.tolist()
        builder.add_cylinder(*ends, placed.radius, flip_normals=flipped, front=front, back=back, radiance=radiance)
    else:
        builder.add_sphere(
            placed.center.tolist(),
            placed.radius,
            flip_normals=flipped,
            front=front,
            back=back,
            radiance=radiance,
            pole=placed.pole.tolist(),
            meridian=placed.meridian.tolist(),
            mirrored=placed.mirrored,
        )
