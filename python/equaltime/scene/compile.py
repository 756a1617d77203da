"""Hands a scene to the core, the renderer in C++: shapes, emitters, camera, film and filter.

Each family of plugins has its module, to which a new plugin of the family is added:

========================  ==============================================================================
`compile_bsdfs`           BSDFs and their wrappers; textures, and placeholders for the parameters that they give
`compile_media`           media between shapes, and the camera's medium
`compile_shapes`          shapes, placed in the world by `geometry`; groups and instances; area emitters
`compile`                 emitters that are not shapes; cameras, film and filters
========================  ==============================================================================

A plugin that the core does not support yet raises `Unsupported`. `Scene` adds the plugin's file and line.
"""

from __future__ import annotations

from equaltime.scene.assets import Assets
from equaltime.scene.compile_bsdfs import BsdfCompiler, Textures
from equaltime.scene.compile_media import Media
from equaltime.scene.compile_shapes import Shapes
from equaltime.scene.core import CoreScene, SceneBuilder, Unsupported
from equaltime.scene.inert import is_inert, shown
from equaltime.scene.model import (
    LOOKS_AT_UV,
    Animation,
    Aov,
    Area,
    Box,
    CatmullRom,
    Constant,
    Direct,
    Directional,
    EnvMap,
    Filter,
    FreeEmitter,
    Gaussian,
    HdrFilm,
    Instance,
    Lanczos,
    Mask,
    MeshAttribute,
    Mitchell,
    Null,
    Orthographic,
    Point,
    SceneModel,
    Sensor,
    Spherical,
    Spot,
    Tent,
    ThinDielectric,
    ThinLens,
    as_array,
    poses,
    without_shear,
)
from equaltime.scene.motion import in_shutters

__all__ = ["add_emitter", "compile_scene", "set_film", "set_sensor"]


def add_emitter(builder: SceneBuilder, emitter: FreeEmitter, assets: Assets, textures: Textures) -> None:
    """Add `emitter` to the core's scene in `builder`, unless the emitter gives no light.

    Raises `Unsupported` if the core cannot use the emitter, and ValueError if a file cannot be used.
    """
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


def _add_spot(builder: SceneBuilder, spot: Spot, textures: Textures) -> None:
    if isinstance(spot.texture, MeshAttribute):
        raise Unsupported(spot.texture, "a spot light cannot project a mesh attribute, because it has no mesh")
    if not any(spot.intensity):
        return
    x, y, z, position = as_array(spot.to_world)[:3].T.tolist()
    index = builder.add_spot_light(position, z, spot.intensity, spot.cutoff_angle, spot.beam)
    if spot.texture is not None:
        builder.project(index, textures.index(spot.texture), u_axis=x, v_axis=y)


def set_sensor(builder: SceneBuilder, sensor: Sensor) -> None:
    """Set the camera of the core's scene in `builder`.

    For an animated `sensor`, the times of its keys must be in units of the shutter: 0 at opening, 1 at closing.
    """
    to_world, near, far = as_array(poses(sensor.to_world)[0]), sensor.near_clip, sensor.far_clip
    if isinstance(sensor.to_world, Animation):
        builder.move_sensor(sensor.to_world.times, sensor.to_world.matrices)
    if isinstance(sensor, Orthographic):
        builder.set_orthographic(to_world, near, far)
    elif isinstance(sensor, Spherical):
        builder.set_spherical(to_world, near, far)
    elif isinstance(sensor, ThinLens):
        builder.set_perspective(
            to_world,
            sensor.x_fov,
            near,
            far,
            aperture_radius=sensor.aperture_radius,
            focus_distance=sensor.focus,
            blades=sensor.blades or 0,
            rotation_degrees=sensor.rotation,
        )
    else:
        offset = (sensor.principal_point_offset_x, sensor.principal_point_offset_y)
        builder.set_perspective(to_world, sensor.x_fov, near, far, offset)


def set_film(builder: SceneBuilder, film: HdrFilm) -> None:
    """Set the film of the core's scene in `builder`, with its reconstruction filter."""
    builder.set_film(film.width, film.height, film.crop, *_filter(film.rfilter))


def _filter(rfilter: Filter) -> tuple[str, float] | tuple[str, float, float]:
    """Return the core's name of the filter, and its parameters."""
    if isinstance(rfilter, Box):
        return "box", 0.5  # half its width
    if isinstance(rfilter, Tent):
        return "tent", rfilter.radius
    if isinstance(rfilter, Gaussian):
        return "gaussian", rfilter.stddev
    if isinstance(rfilter, Mitchell):
        return "mitchell", rfilter.B, rfilter.C
    if isinstance(rfilter, CatmullRom):
        return "mitchell", 0.0, 0.5
    assert isinstance(rfilter, Lanczos)
    return "lanczos", float(rfilter.lobes)


def compile_scene(model: SceneModel, assets: Assets, builder: SceneBuilder) -> CoreScene:
    """Build `model` with `builder`, and return the core's scene.

    Raises ValueError if a file or the scene cannot be used. For a plugin that the core does not support, the error is
    of the subclass `Unsupported`, and holds the plugin.
    """
    _refuse_other_images(model, assets)
    model = _unlit(in_shutters(model)) if model.integrator.max_depth == 0 else in_shutters(model)
    textures = Textures(builder, assets)
    materials = BsdfCompiler(builder, textures)
    media = Media(builder, model)
    shapes = Shapes(builder, assets, materials, textures, media)
    for number in shown(model):
        shapes.add(model.shapes[number])
    for emitter in model.emitters:
        add_emitter(builder, emitter, assets, textures)
    if isinstance(model.integrator, Aov) and any(what in LOOKS_AT_UV for _, what in model.integrator.channels):
        builder.keep_uvs()
    if model.integrator.hides_emitters:
        builder.hide_emitters()
    set_sensor(builder, model.sensor)
    media.surround(model.sensor)
    set_film(builder, model.sensor.film)
    try:
        return builder.build()
    except ValueError as error:
        raise media.at_place(error) from error


def _unlit(model: SceneModel) -> SceneModel:
    """Return the model without emitters: paths of length 0 see none."""
    dark = [shape if isinstance(shape, Instance) else shape.replace(emitter=None) for shape in model.shapes]
    return model.replace(shapes=tuple(dark), emitters=())


def _refuse_other_images(model: SceneModel, assets: Assets) -> None:
    """Raise `Unsupported` where Mitsuba's ``direct`` hides emitters differently from its other integrators.

    Mitsuba's ``direct`` shows hidden emitters behind a pane, and does not look through emitting shapes.
    """
    direct = next((node for node in model.integrator.nodes() if isinstance(node, Direct)), None)
    if direct is None or not model.integrator.hides_emitters:
        return
    lights = [node for node in model.nodes() if isinstance(node, Area | Constant | EnvMap)]
    seen = next((node for node in lights if not is_inert(node, assets)), None)
    panes = (node for node in model.nodes() if isinstance(node, Null | Mask | ThinDielectric))
    pane = next((node for node in panes if not is_inert(node, assets)), None)
    if seen is not None and (isinstance(seen, Area) or pane is not None):
        behind = "" if pane is None or isinstance(seen, Area) else f" behind '{pane.title}'"
        message = f"hide_emitters of 'direct' is not supported where '{seen.title}'{behind} would be seen"
        raise Unsupported(direct, f"{message}: Mitsuba hides it in another way there; 'volpath' hides it")
