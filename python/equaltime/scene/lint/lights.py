"""Checks for hazards of emitters.

The hazards are zero power, facing away from the whole scene, and light that no sampling technique finds.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from equaltime.film.unseen import FAR_APART
from equaltime.scene.compile_media import sees_media
from equaltime.scene.geometry import DiskSurface, SphereSurface
from equaltime.scene.lint.facts import Finding, encloses, first_places, within
from equaltime.scene.lint.parts import Array, LintScene, Part, leaves, lets_light_through
from equaltime.scene.model import (
    Area,
    BsdfPlugin,
    Conductor,
    Constant,
    Dielectric,
    Directional,
    EnvMap,
    Mask,
    Plugin,
    Point,
    RoughConductor,
    RoughDielectric,
    Spot,
    ThinDielectric,
)

__all__ = ["check_lights"]

AWAY = 1e-12
"""Distance from the plane of a flat light up to which a point counts as in the plane: a few rounding errors. The
distance is a fraction of the size of the scene."""
MOST_POINTS = 64
"""Largest number of points of a lamp that are tested for being inside glass; a mesh with more gives every k-th."""
FLAT = 1e-4
"""Largest angle, in radians, between the normals of the triangles of a light that counts as flat."""


def check_lights(world: LintScene) -> Iterator[Finding]:
    """Yield findings for emitters of `world` whose light is missing or hard to find.

    Reported emitters have no power, are very dim beside others, face away from the scene, or are enclosed by opaque
    shapes. Point, spot and directional lights are also reported in scenes with smooth glass or mirrors: no sampling
    technique finds their caustics. Lamps inside smooth glass are reported as noisy.
    """
    model = world.scene.model
    nodes = {
        id(node): node
        for node in model.nodes()
        if isinstance(node, Area | Point | Spot | Directional | Constant | EnvMap)
    }
    dark = [node for node in nodes.values() if _is_dark(node, world)]
    if dark:
        yield Finding(
            "dark-lights",
            "note",
            f"lights without power: {len(dark)}",
            first_places(world.called(node) for node in dark),
            len(dark),
            "leaves them out: they cost nothing",
            "remove them, or give them the radiance they should have",
        )
    if len(dark) == len(nodes):
        yield Finding(
            "no-light",
            "warning",
            "nothing in the scene emits light",
            (),
            1,
            "renders a black image",
            "add an emitter: a constant one is the simplest",
        )
    black = set(map(id, dark))
    yield from _far_apart(world, [node for node in nodes.values() if id(node) not in black])
    yield from _turned_away(world)
    yield from _enclosed(world)
    yield from _through_glass(world)
    yield from _lamps_in_glass(world)


def _is_dark(node: Plugin, world: LintScene) -> bool:
    if isinstance(node, EnvMap):
        return node.scale == 0.0 or not world.scene.assets.image(node).any()
    name = {"point": "intensity", "spot": "intensity", "directional": "irradiance"}.get(node.title, "radiance")
    value = getattr(node, name)
    return isinstance(value, tuple) and not any(value)


def _far_apart(world: LintScene, lights: list[Plugin]) -> Iterator[Finding]:
    """Find lights so dim beside the brightest that picking lights by power hardly ever picks them."""
    for name in ("radiance", "intensity", "irradiance"):
        spans = [(node, *span) for node in lights if (span := _span(node, name, world)) is not None]
        most = max((high for _, _, high in spans), default=0.0)
        dim = [(node, low) for node, low, _ in spans if low * FAR_APART < most]
        if not dim:
            continue
        yield Finding(
            "radiance-range",
            "warning",
            f"lights of which a {name} is more than {FAR_APART:.0e} times below the brightest: {len(dim)}; "
            f"ratio: {most / min(low for _, low in dim):.2g}",
            first_places(world.called(node) for node, _ in dim),
            len(dim),
            "renders them, but where lights are picked by their power, hardly any sample is aimed at these: light that "
            "only aimed rays find may be missing where they alone shine",
            "leave the dim ones out, or render them by themselves; lights=uniform picks all alike",
        )


def _span(node: Plugin, name: str, world: LintScene) -> tuple[float, float] | None:
    """Return the smallest and the largest positive value of a light's colour or environment map, or None."""
    if isinstance(node, EnvMap):
        if name != "radiance":
            return None
        values, scale = np.asarray(world.scene.assets.image(node)), node.scale
    else:
        value = getattr(node, name, None)
        values, scale = np.array(value if isinstance(value, tuple) else (), dtype=float), 1.0
    least = float(np.min(values, where=values > 0.0, initial=np.inf))
    return (scale * least, scale * float(values.max())) if least < np.inf else None


def _turned_away(world: LintScene) -> Iterator[Finding]:
    """Find flat lights with neither a shape nor the camera in front of them."""
    corners = [part.bounds for part in world.parts if not part.grouped]
    if not corners or world.skipped or any(part.grouped for part in world.parts):
        return  # a skipped mesh, or an instance, which only the core places, may be in front of the light
    boxes = np.array([*corners, np.array([world.camera, world.camera])])
    size = float((boxes[:-1, 1].max(axis=0) - boxes[:-1, 0].min(axis=0)).max())
    found = []
    for number, part in enumerate(world.parts):
        if part.surface.sides.radiance is None or (plane := _plane(part)) is None:
            continue
        place, normal = plane
        before = (np.where(normal > 0.0, boxes[:, 1], boxes[:, 0]) - place) @ normal
        before[number] = 0.0  # the box of a tilted light reaches in front of its plane
        if float(before.max()) <= AWAY * size:
            found.append(part)
    if found:
        yield Finding(
            "lights-turned-away",
            "warning",
            f"flat lights with nothing before their front, neither a shape nor the camera: {len(found)}",
            first_places(part.name for part in found),
            len(found),
            "samples them as any other light, and finds nothing",
            "flip_normals = true on the shape turns the light round",
        )


def _plane(part: Part) -> tuple[Array, Array] | None:
    """Return a point of a flat light and the unit normal of its front; None if it is not flat or too complex."""
    if isinstance(part.surface, DiskSurface):
        x, y, _, place = part.surface.to_world[:3].T
        normal = np.cross(x, y)
        mirrored = float(np.linalg.det(part.surface.to_world[:3, :3])) < 0.0
        normal = -normal if part.surface.flip_normals != mirrored else normal
        length = float(np.linalg.norm(normal))
        return (place, normal / length) if length > 0.0 else None
    mesh = part.mesh
    if mesh is None or len(mesh.faces) > 64:
        return None
    a, b, c = (mesh.vertices[mesh.faces[:, k].astype(np.intp)] for k in range(3))
    normals = np.cross(b - a, c - a)
    lengths = np.linalg.norm(normals, axis=1)
    if not (lengths > 0.0).all():
        return None
    normals /= lengths[:, None]
    return (a[0], normals[0]) if (normals @ normals[0] > np.cos(FLAT)).all() else None


def _enclosed(world: LintScene) -> Iterator[Finding]:
    """Find point and spot lights inside closed opaque shapes that do not contain the camera."""
    solid = [part for part in world.parts if not part.grouped and not lets_light_through(part)]
    lights = [e for e in world.scene.model.emitters if isinstance(e, Point | Spot) and not _is_dark(e, world)]
    shut = [part for part in solid if not within(world.camera, part)]
    found = [light for light in lights if any(within(_place(light), part) for part in shut)]
    if found:
        yield Finding(
            "lights-enclosed",
            "warning",
            f"lights inside closed opaque shapes that the camera is not in: {len(found)}",
            first_places(world.called(light) for light in found),
            len(found),
            "samples them as any other light, and finds nothing outside",
            "move the light out of the shape, or remove it",
        )


def _through_glass(world: LintScene) -> Iterator[Finding]:
    """Find lights without extent beside smooth mirrors or glass: no ray meets such lights, so caustics are lost."""
    lights = [
        e for e in world.scene.model.emitters if isinstance(e, Point | Spot | Directional) and not _is_dark(e, world)
    ]
    smooth = [part for part in world.parts if any(map(_is_smooth, leaves(part.shape.bsdf)))]
    if not lights or not smooth:
        return
    freely = sees_media(world.scene.model.integrator)
    glass = [part for part in smooth if any(_hides(leaf, freely) for leaf in leaves(part.shape.bsdf))]
    inside = [light for light in lights if any(_within(light, part) for part in glass)]
    if inside:
        yield Finding(
            "lights-behind-glass",
            "warning",
            f"lights without extent inside smooth glass, through which no technique connects to them: {len(inside)}",
            first_places(world.called(light) for light in inside),
            len(inside),
            "renders the scene without their light",
            "put a small sphere with an area emitter in their place, or make the glass rough; thindielectric lets them "
            "shine through with the integrator volpath",
        )
    if len(inside) < len(lights):
        yield Finding(
            "caustics-left-out",
            "note",
            f"lights without extent: {len(lights) - len(inside)}; smooth mirrors and glass, which pass on light "
            f"of theirs that no technique finds: {len(smooth)}",
            first_places(
                [*(world.called(light) for light in lights if light not in inside), *(p.name for p in smooth)]
            ),
            len(lights) - len(inside),
            "renders the scene without such caustics; shadows of smooth glass are black, but for those of "
            "thindielectric with the integrator volpath",
            "use small area lights, a sun as wide as it is, or rough surfaces, where the caustics matter",
        )


def _lamps_in_glass(world: LintScene) -> Iterator[Finding]:
    """Find emitting shapes inside closed smooth glass that does not contain the camera."""
    lamps = [part for part in world.parts if _is_lamp(part, world)]
    glass = [part for part in world.parts if lamps and _is_glass(part) and not within(world.camera, part)]
    found = [lamp for lamp in lamps if any(encloses(part, _outline(lamp)) for part in glass)]
    if found:
        yield Finding(
            "lamps-in-glass",
            "note",
            f"lamps inside smooth glass, through which no light sample reaches them: {len(found)}",
            first_places(part.name for part in found),
            len(found),
            "renders their light in full, but with much noise: only paths that hit a lamp by chance bring it, and the "
            "smaller the lamp, the fewer they are",
            "enlarge the lamp, or remove glass that does not matter; a point light shines through thindielectric with "
            "the integrator volpath",
        )


def _is_lamp(part: Part, world: LintScene) -> bool:
    return part.shape.emitter is not None and not part.grouped and not _is_dark(part.shape.emitter, world)


def _is_glass(part: Part) -> bool:
    """Tell whether every part of the BSDF is smooth glass: with any integrator it blocks light samples of lamps."""
    parts = [*leaves(part.shape.bsdf)]
    return bool(parts) and all(_hides(leaf, freely=False) for leaf in parts) and not isinstance(part.shape.bsdf, Mask)


def _outline(part: Part) -> Array:
    """Return points (N, 3) on the surface: ends of a sphere's axes, vertices of a mesh, or corners of the bounds."""
    if isinstance(part.surface, SphereSurface):
        axes = part.surface.radius * np.eye(3)
        return np.asarray(part.surface.center + np.concatenate([axes, -axes]))
    if part.mesh is not None:
        return part.mesh.vertices[:: 1 + len(part.mesh.vertices) // MOST_POINTS]
    return np.array(np.meshgrid(*part.bounds.T)).reshape(3, -1).T


def _is_smooth(leaf: BsdfPlugin) -> bool:
    """Tell whether the BSDF reflects and transmits into single directions only."""
    return isinstance(leaf, Conductor | Dielectric) and not isinstance(leaf, RoughConductor | RoughDielectric)


def _hides(leaf: BsdfPlugin, freely: bool) -> bool:
    """Tell whether the BSDF is glass that blocks lights without extent; with ``freely``, thin glass does not."""
    return isinstance(leaf, Dielectric) and _is_smooth(leaf) and not (freely and isinstance(leaf, ThinDielectric))


def _place(light: Point | Spot) -> Array:
    return np.array(light.world_position) if isinstance(light, Point) else np.array(light.to_world)[:3, 3]


def _within(light: Plugin, part: Part) -> bool:
    return isinstance(light, Point | Spot) and within(_place(light), part)
