"""Effects (features of scenes such as lens or media): their table, and the effects that a scene uses.

An entry of the table has a title, a test for objects that use the effect, and the stand-in that replaces the effect if
it is left out. The core chooses its kernels by effects (`_core.Scene.effects`), and decides whether a scene uses each
of these effects. `derive` asks the core, and finds the other effects, which have no code of their own in a kernel.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Final

from equaltime.scene import Scene
from equaltime.scene.compile_media import sees_media
from equaltime.scene.core import BSDF_MODELS, PHASE_FUNCTIONS
from equaltime.scene.inert import is_inert, shown
from equaltime.scene.model import (
    Animation,
    Aov,
    Area,
    BlendBsdf,
    BsdfPlugin,
    BumpMap,
    Constant,
    Cylinder,
    Deformation,
    Depth,
    Directional,
    Disk,
    EnvMap,
    Instance,
    IntegratorPlugin,
    Mask,
    Medium,
    MeshFile,
    NormalMap,
    Null,
    Orthographic,
    Plugin,
    Point,
    Principled,
    RoughConductor,
    RoughDielectric,
    Solid,
    Sphere,
    Spherical,
    Spot,
    TexturePlugin,
    ThinDielectric,
    ThinLens,
)
from equaltime.scene.motion import moves

__all__ = ["KINDS", "Effect", "Reason", "derive", "kind_of", "nodes_of"]


@dataclass(frozen=True)
class Effect:
    """Description of an effect, a feature of scenes (such as media) that costs time and may be left out of a render.

    It has the effect's name, its title, a test for objects that use the effect, and the stand-in if the effect is left
    out.
    """

    name: str
    title: str
    calls: Callable[[Plugin], bool]
    """Function that returns True for a node that uses the effect; it is not called for nodes that change nothing."""
    instead: str | None = None
    """Stand-in that replaces the effect, such as ``vacuum``; None if the effect cannot be left out."""

    @property
    def scatterers(self) -> frozenset[str]:
        """BSDFs and phase functions, by the core's names, whose light is attributed to the effect."""
        if self.name == "media":
            return frozenset(PHASE_FUNCTIONS)
        models = {**PHASE_FUNCTIONS, **{type: model["effect"] for type, model in BSDF_MODELS.items()}}
        return frozenset(name for name, effect in models.items() if effect == self.name)


def _is_anisotropic(node: Plugin) -> bool:
    if isinstance(node, Principled):
        return node.anisotropic != 0.0
    return isinstance(node, RoughConductor | RoughDielectric) and node.alphas[0] != node.alphas[1]


def _fills(node: Plugin) -> bool:
    return isinstance(node, Medium) or (isinstance(node, Solid) and node.priority is not None)


def _is_animated(node: Plugin) -> bool:
    deforms = isinstance(node, MeshFile) and isinstance(node.filename, Deformation)
    return deforms or isinstance(getattr(node, "to_world", None), Animation)


def _hides(node: Plugin) -> bool:
    return isinstance(node, IntegratorPlugin) and node.hides_emitters


def _shines(node: Plugin) -> bool:
    return isinstance(node, Area | Point | Spot | Directional | Constant | EnvMap)


def _one_of(*types: type[Plugin]) -> Callable[[Plugin], bool]:
    return lambda node: isinstance(node, types)


def _models(effect: str) -> Callable[[Plugin], bool]:
    """Return a test for the BSDFs and phase functions that belong to an effect by the core's own word."""

    def calls(node: Plugin) -> bool:
        if node.kind == "phase":
            return PHASE_FUNCTIONS[node.title] == effect
        model = BSDF_MODELS.get(node.title) if isinstance(node, BsdfPlugin) else None
        return model is not None and model["effect"] == effect

    return calls


KINDS: Final[Mapping[str, Effect]] = {
    kind.name: kind
    for kind in (
        Effect("analytic_shapes", "spheres, disks and cylinders", _one_of(Sphere, Disk, Cylinder)),
        Effect(
            "smooth_normals",
            "normals interpolated over meshes",
            lambda node: isinstance(node, MeshFile) and not node.face_normals,
        ),
        Effect("rough_conductors", "rough metals", _models("rough_conductors")),
        Effect("anisotropy", "roughness that depends on the direction", _is_anisotropic),
        Effect("specular", "mirrors and clear glass", _models("specular")),
        Effect("layered", "plastics and rough diffuse surfaces", _models("layered")),
        Effect("rough_dielectrics", "frosted glass", _models("rough_dielectrics")),
        Effect("principled", "the principled model", _models("principled")),
        Effect("point_lights", "points, spots and directional lights", _one_of(Point, Spot, Directional)),
        Effect("environment", "light from all around", _one_of(Constant, EnvMap), "black"),
        Effect("lens", "any camera except a pinhole", _one_of(ThinLens, Orthographic, Spherical), "a pinhole"),
        Effect("textures", "textures", lambda node: isinstance(node, TexturePlugin), "their means"),
        Effect("normal_maps", "normal and bump maps", _one_of(NormalMap, BumpMap), "none"),
        Effect("instances", "copies of groups of shapes", _one_of(Instance)),
        Effect("masks", "masks, blends and null BSDFs", _one_of(Mask, BlendBsdf, Null, ThinDielectric), "opaque"),
        Effect("media", "media, and shapes that overlap with priorities", _fills, "vacuum"),
        Effect("phase_blends", "phase functions other than Henyey and Greenstein's", _models("phase_blends")),
        Effect("motion", "motion while the shutter is open", _is_animated, "the shutter's centre"),
        Effect("hidden_emitters", "lights hidden from the camera", _hides, "visible lights"),
        Effect("many_lights", "a choice among lights", _shines),
        Effect("long_paths", "light that was scattered more than once", lambda _: False, "truncate=2"),
        Effect("outputs", "outputs beside the image", _one_of(Aov, Depth)),
    )
}


def kind_of(name: str) -> Effect:
    """Return the description of the effect called `name`.

    An effect that only the core (the renderer in C++) knows gets a description whose test matches no object of a scene.
    """
    return KINDS.get(name) or Effect(name, name.replace("_", " "), lambda _: False)


@dataclass(frozen=True)
class Reason:
    """An object of the scene that uses an effect, such as a BSDF, with its place in the file, to show to the user."""

    place: str
    """Position of the object in its file: ``file:line`` or ``file: key.path``; empty for a scene made in memory."""
    what: str
    """Family and type of the object, such as ``bsdf 'dielectric'``."""

    def __str__(self) -> str:
        return f"{self.place}: {self.what}" if self.place else self.what


def derive(scene: Scene) -> Mapping[str, tuple[Reason, ...]]:
    """Return the effects that a scene uses: a mapping from the name of an effect to the objects that use the effect.

    If no single object causes an effect, its only entry stands for the scene as a whole. Objects that change nothing in
    the image are left out (see `equaltime.scene.inert`). Raises SceneError if the core cannot use the scene.
    """
    nodes = list(nodes_of(scene))
    called = {name: kind_of(name) for name, used in scene.core.effects().items() if used}
    if scene.core.lights > 1:
        called["many_lights"] = KINDS["many_lights"]
    found = {name: tuple(_reasons(scene, kind, nodes)) for name, kind in called.items()}
    if outputs := tuple(_reasons(scene, KINDS["outputs"], nodes)):
        found["outputs"] = outputs
    if scene.max_depth == -1 or scene.max_depth > 2:
        limit = "without limit" if scene.max_depth == -1 else f"of up to {scene.max_depth} segments"
        found["long_paths"] = (Reason(scene.place_of(scene.model.integrator), f"paths {limit}"),)
    whole = Reason(str(scene.source or ""), "the scene as a whole")
    ordered = [name for name in (*KINDS, *called) if name in found]
    return {name: found[name] or (whole,) for name in dict.fromkeys(ordered)}


def nodes_of(scene: Scene) -> Iterator[Plugin]:
    """Iterate over all nodes that are built, each once."""
    model, seen = scene.model, set[int]()
    shapes = (model.shapes[number] for number in shown(model))
    for part in (model.integrator, model.sensor, *shapes, *model.emitters):
        yield from _within(part, seen)


def _within(node: Plugin, seen: set[int]) -> Iterator[Plugin]:
    """Iterate over a node and the nodes in it, without those seen before: groups and materials are shared."""
    if id(node) in seen:
        return
    seen.add(id(node))
    yield node
    for name in type(node).model_fields:
        value = getattr(node, name)
        for item in value if isinstance(value, tuple) else (value,):
            if isinstance(item, Plugin):
                yield from _within(item, seen)


def _reasons(scene: Scene, kind: Effect, nodes: list[Plugin]) -> Iterator[Reason]:
    for node in nodes:
        rests = kind.name == "motion" and not moves(node, scene.model.sensor)
        if kind.name == "masks" and isinstance(node, ThinDielectric):  # a vertex of the path, unless media are seen
            rests = not sees_media(scene.model.integrator)
        if kind.calls(node) and not rests and not is_inert(node, scene.assets):
            yield Reason(scene.place_of(node), f"{node.kind} '{node.title}'")
