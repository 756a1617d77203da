"""Hands a scene to the core: one call of the builder for each thing that the core shall know."""

from __future__ import annotations

from equaltime import _core
from equaltime.scene.assets import Assets
from equaltime.scene.geometry import DiskSurface, MeshSurface, QuadSurface, Surface, surface
from equaltime.scene.model import (
    Bsdf,
    Conductor,
    Constant,
    Dielectric,
    Diffuse,
    FreeEmitter,
    Gaussian,
    HdrFilm,
    Perspective,
    Point,
    RoughConductor,
    SceneModel,
    Tent,
    as_array,
)

__all__ = ["compile_scene"]


def compile_scene(model: SceneModel, assets: Assets, builder: _core.SceneBuilder) -> _core.Scene:
    """Return the scene that `builder` builds from `model`; raises ValueError if a file or the scene cannot be used."""
    materials: dict[Bsdf, int] = {}
    for shape in model.shapes:
        _add_surface(builder, surface(shape, assets), materials)
    for emitter in model.emitters:
        _add_emitter(builder, emitter, assets)
    _set_camera(builder, model.sensor)
    _set_film(builder, model.sensor.film)
    return builder.build()


def _add_surface(builder: _core.SceneBuilder, placed: Surface, materials: dict[Bsdf, int]) -> None:
    front = _material(builder, placed.sides.front, materials)
    back = _material(builder, placed.sides.back, materials)
    radiance = placed.sides.radiance
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
    else:
        builder.add_sphere(
            placed.center.tolist(),
            placed.radius,
            flip_normals=flipped,
            front=front,
            back=back,
            radiance=radiance,
            pole=placed.pole.tolist(),
        )


def _material(builder: _core.SceneBuilder, bsdf: Bsdf | None, materials: dict[Bsdf, int]) -> int | None:
    """Return the index of `bsdf`; equal ones share one, whatever they are called."""
    if bsdf is None:
        return None
    nameless = bsdf.model_copy(update={"id": None})
    if nameless not in materials:
        materials[nameless] = _add_material(builder, nameless)
    return materials[nameless]


def _add_material(builder: _core.SceneBuilder, bsdf: Bsdf) -> int:
    if isinstance(bsdf, Diffuse):
        return builder.add_diffuse(bsdf.reflectance)
    if isinstance(bsdf, RoughConductor):
        return builder.add_rough_conductor(bsdf.distribution, *bsdf.alphas, bsdf.eta, bsdf.k, bsdf.specular_reflectance)
    if isinstance(bsdf, Conductor):
        return builder.add_conductor(bsdf.eta, bsdf.k, bsdf.specular_reflectance)
    if isinstance(bsdf, Dielectric):
        ior = bsdf.int_ior / bsdf.ext_ior
        return builder.add_dielectric(ior, bsdf.specular_reflectance, bsdf.specular_transmittance)
    raise TypeError(f"{type(bsdf).__name__} is not a leaf")


def _add_emitter(builder: _core.SceneBuilder, emitter: FreeEmitter, assets: Assets) -> None:
    """Add a light, unless it is dark."""
    if isinstance(emitter, Point):
        if any(emitter.intensity):
            builder.add_point_light(emitter.world_position, emitter.intensity)
    elif isinstance(emitter, Constant):
        if any(emitter.radiance):
            builder.add_constant_environment(emitter.radiance)
    elif emitter.scale > 0.0 and (pixels := assets.image(emitter)).any():
        builder.add_image_environment(pixels, emitter.scale, as_array(emitter.to_world))


def _set_camera(builder: _core.SceneBuilder, sensor: Perspective) -> None:
    offset = (sensor.principal_point_offset_x, sensor.principal_point_offset_y)
    builder.set_perspective(as_array(sensor.to_world), sensor.x_fov, sensor.near_clip, sensor.far_clip, offset)


def _set_film(builder: _core.SceneBuilder, film: HdrFilm) -> None:
    rfilter = film.rfilter
    parameter = 0.5  # half the width of a box
    if isinstance(rfilter, Tent):
        parameter = rfilter.radius
    elif isinstance(rfilter, Gaussian):
        parameter = rfilter.stddev
    builder.set_film(film.width, film.height, film.crop, rfilter.type, parameter)
