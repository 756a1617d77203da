"""Hands a scene to the core: one call of the builder for each thing that the core shall know.

Each family has its own module, where a new node gets its step:

========================  ==============================================================================
`compile_bsdfs`           BSDFs and their wrappers, taken apart into sides by `sides`
`compile_textures`        textures, and what is a constant so far
`compile_media`           media, between shapes and round the camera
`compile_shapes`          shapes, placed in the world by `geometry`; groups and instances; area emitters
`compile_emitters`        the lights that are no shape
`compile_sensors`         cameras, film and filters
========================  ==============================================================================

A node that the core cannot use yet is refused with `Unsupported`, to which `Scene` adds its place.
"""

from __future__ import annotations

from equaltime.scene.assets import Assets
from equaltime.scene.builder import Builder, CoreScene
from equaltime.scene.compile_bsdfs import Materials
from equaltime.scene.compile_emitters import add_emitter
from equaltime.scene.compile_media import Media
from equaltime.scene.compile_sensors import set_film, set_sensor
from equaltime.scene.compile_shapes import Shapes
from equaltime.scene.compile_textures import Textures
from equaltime.scene.inert import shown
from equaltime.scene.model import LOOKS_AT_UV, Aov, SceneModel
from equaltime.scene.motion import in_shutters

__all__ = ["compile_scene"]


def compile_scene(model: SceneModel, assets: Assets, builder: Builder) -> CoreScene:
    """Return the scene that `builder` builds from `model`.

    Raises ValueError if a file or the scene cannot be used, and `Unsupported`, one of them, for a node that cannot.
    """
    model = in_shutters(model)
    textures = Textures(builder, assets)
    materials = Materials(builder, textures)
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
    return builder.build()
