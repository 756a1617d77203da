"""Hands a scene to the core: one call of the builder for each part.

Each family of nodes has its own module; a new node is added there:

========================  ==============================================================================
`compile_bsdfs`           BSDFs and their wrappers, taken apart into sides by `sides`
`compile_textures`        textures; parameters that must be constants so far
`compile_media`           media between shapes, and the camera's medium
`compile_shapes`          shapes, placed in the world by `geometry`; groups and instances; area emitters
`compile_emitters`        emitters that are not shapes
`compile_sensors`         cameras, film and filters
========================  ==============================================================================

A node that the core does not support yet raises `Unsupported`, to which `Scene` adds its place.
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
from equaltime.scene.inert import is_inert, shown
from equaltime.scene.model import (
    LOOKS_AT_UV,
    Aov,
    Area,
    Constant,
    Direct,
    EnvMap,
    Instance,
    Mask,
    Null,
    SceneModel,
    ThinDielectric,
)
from equaltime.scene.motion import in_shutters
from equaltime.scene.unsupported import Unsupported

__all__ = ["compile_scene"]


def compile_scene(model: SceneModel, assets: Assets, builder: Builder) -> CoreScene:
    """Return the scene that `builder` builds from `model`.

    Raises ValueError if a file or the scene cannot be used. Its subclass `Unsupported` names a node that is not
    supported.
    """
    _refuse_other_images(model, assets)
    model = _unlit(in_shutters(model)) if model.integrator.max_depth == 0 else in_shutters(model)
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
