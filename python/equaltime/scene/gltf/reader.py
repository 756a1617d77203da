"""Reads glTF 2.0 files (.gltf, .glb) into the scene tree."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from pathlib import Path
from typing import Any, Final, TypeVar

import numpy as np
from numpy.typing import NDArray

from equaltime.scene.gltf.account import check_account
from equaltime.scene.gltf.animations import JUST, Clip, played
from equaltime.scene.gltf.document import NOT_USED, Document, Malformed, parse
from equaltime.scene.gltf.extent import check_extent
from equaltime.scene.gltf.ids import Ids
from equaltime.scene.gltf.materials import GltfMaterials
from equaltime.scene.gltf.nodes import STANDING, Placed, placed
from equaltime.scene.gltf.shapes import Asked, GltfShapes
from equaltime.scene.gltf.views import light, sensor
from equaltime.scene.report import Report
from equaltime.scene.search import Search
from equaltime.scene.studio import (
    NOT_FRAMED,
    SKY,
    SUN,
    SUN_ANGLE,
    UPS,
    VIEWS,
    Z_UP,
    Strength,
    choice,
    default_camera,
    framed,
    ground,
    leaving_out,
    number_of,
    sky,
    soft_sun,
    strength,
    sun,
    sun_angle,
    switch,
    unused,
)
from equaltime.scene.tree import Child, Object, Place, add, plant
from equaltime.words import shortened, suggestion

__all__ = ["read_gltf"]

DEFINITIONS: Final = (
    *("animation", "camera", "crease_angle", "face_normals", "ground", "scene", "shutter", "sky", "sun", "sun_angle"),
    *("time", "up", "view"),
)
"""Names that ``-D`` may set. Animation, camera and scene are chosen by name or number. The shutter is two times, of
opening and closing, in seconds of the animation; ``time`` shows a still at one time. The others: see
`equaltime.scene.bare_mesh.DEFINITIONS`. The view takes the place of the file's cameras. Without ``sun_angle`` the sun
is directional, and without ``crease_angle`` meshes without normals are flat, as the format says."""
PLACES_SHOWN: Final = 3
Value = TypeVar("Value")


def read_gltf(
    file: str, content: bytes, defines: Mapping[str, object], report: Report, search: Search
) -> Object | None:
    """Return the scene in a glTF file as a scene tree, or None if the file has errors.

    `content` has the bytes of the file named `file`. `defines` has the values of the option ``-D``; see `DEFINITIONS`.
    Errors and notes are added to `report`. The other files that the glTF file names are recorded in `search`.
    """
    place = Place(file)
    for name in sorted(set(defines) - set(DEFINITIONS)):
        report.add(place, unused(name, DEFINITIONS))
    folder = Path(file).parent
    try:
        document = parse(Path(file).name, content, lambda name: search.note(folder / name))
        check_extent(document)
        check_account(document)
        scene = _GltfScene(document, place, defines).read()
    except Malformed as error:
        for where, message in error.problems:
            report.add(place.key(where) if where else place, message)
        return None
    for message, places in document.notes.items():
        report.note(_told(message, list(places)))
    return scene


def _told(message: str, places: list[str]) -> str:
    """Return a note with the places where it applies."""
    named = [place for place in places if place]
    shown = named[:PLACES_SHOWN]
    more = f" and {len(named) - len(shown)} more" if len(named) > len(shown) else ""
    return f"{message} ({', '.join(shown)}{more})" if shown else message


class _GltfScene:
    """A document that is being made into a scene."""

    def __init__(self, document: Document, place: Place, defines: Mapping[str, object]) -> None:
        self._document = document
        self._gltf = document.gltf
        self._place = place
        self._defines = defines
        self._ids = Ids()
        self._materials = GltfMaterials(document, place, self._ids)
        self._clip = self._played()
        self._asked = self._changes()
        self._shapes = GltfShapes(document, place, self._materials, self._ids, self._clip, self._asked)

    def read(self) -> Object:
        """Return the scene; raises `Malformed`."""
        nodes = list(placed(self._document, self._chosen_scene(), self._clip, root=self._asked.root))
        shapes = self._shapes.of(nodes)
        if not shapes:
            raise Malformed(("", "there is nothing to see: no node of the scene has a mesh with triangles"))
        made = (light(self._document, at, self._place, self._ids) for at in nodes)
        lights = [emitter for emitter in made if emitter is not None]
        daylight = self._daylight(lights, shapes)
        camera = self._camera(nodes)
        if self._clip is not None:
            add(camera, "shutter_open", self._clip.times[0])
            add(camera, "shutter_close", self._clip.times[-1])
        self._note_what_is_left_out()
        media = self._materials.media
        integrator = [plant("integrator", "volpath", self._place, "integrator")] if media else []
        parts = [*integrator, camera, *self._materials.bsdfs, *media, *shapes, *self._ground(), *lights, *daylight]
        return Object(self._place, "scene", "scene", children=[Child(part.id, part) for part in parts])

    def _chosen_scene(self) -> int | None:
        scenes = self._gltf.scenes
        if "scene" in self._defines:
            return self._choice("scene", [scene.name for scene in scenes])
        return (self._gltf.scene or 0) if scenes else None

    def _choice(self, what: str, names: list[str | None]) -> int:
        """Return the index that a definition chooses, by name or by number, among things with these names."""
        wanted = str(self._defines[what])
        if wanted in names:
            return names.index(wanted)
        if wanted.isascii() and wanted.isdecimal() and int(wanted[:9]) < len(names):
            return int(wanted)
        known = [name for name in names if name] or [str(i) for i in range(len(names))]
        raise Malformed(("", f"the file has no {what} {shortened(wanted, 40)}{suggestion(wanted, known)}"))

    def _camera(self, nodes: list[Placed]) -> Object:
        """Return the requested camera or view, or the first camera, or one that has everything in view."""
        cameras = [at for at in nodes if at.node.camera is not None]
        times = () if self._clip is None else self._clip.times
        names = [at.node.name or self._gltf.cameras[at.node.camera].name for at in cameras]
        if "camera" in self._defines:
            if "view" in self._defines:
                raise Malformed(("", "-D camera= and -D view= both choose the camera; give one of them"))
            return sensor(self._document, cameras[self._choice("camera", names)], self._place, times)
        if cameras and "view" not in self._defines:
            if len(cameras) > 1:
                known = ", ".join(str(name or i) for i, name in enumerate(names))
                self._document.note(
                    f"of {len(cameras)} cameras the first is used; -D camera=... takes another of {known}", ""
                )
            return sensor(self._document, cameras[0], self._place, times)
        if not cameras:
            self._document.note("the file has no camera: a camera that sees the whole scene is added", "")
        if self._clip is None:
            corners = self._shapes.corners()
        else:  # all frames of an animation have one camera
            whole = played(self._document, self._clip.number, None)
            corners = self._shapes.reach(placed(self._document, self._chosen_scene(), whole, root=self._asked.root))
        boxes = list(corners.reshape(-1, 8, 3))
        seen = framed(boxes)
        if len(seen) < len(boxes):
            self._document.note(NOT_FRAMED, "")
        return default_camera(np.concatenate(seen) if seen else corners, self._place, self._view)

    @property
    def _view(self) -> str:
        """The side of the default camera and of the added sun."""
        return self._defined(partial(choice, name="view", among=VIEWS), "view", "front")

    def _changes(self) -> Asked:
        """Return the changes to all meshes that definitions ask for."""
        up = self._defined(partial(choice, name="up", among=UPS), "up", "y")
        flat = self._defined(partial(switch, name="face_normals"), "face_normals", False)
        angle = partial(number_of, name="crease_angle", most=180.0)
        crease = self._defined(angle, "crease_angle", 0.0) if "crease_angle" in self._defines else None
        return Asked(Z_UP if up == "z" else STANDING, flat, crease)

    def _daylight(self, lights: list[Object], shapes: list[Object]) -> list[Object]:
        """Return the requested sky and sun, or default ones if the file has no lights.

        Glowing surfaces are not lights in glTF: other viewers light such files too.
        """
        if {"sky", "sun"} & set(self._defines):
            radiance, irradiance = self._strength("sky"), self._strength("sun")
            if lights and not np.any(radiance) and not np.any(irradiance):
                said = "; ".join(f"-D {name}=0" for name in ("sky", "sun") if name in self._defines)
                self._document.note(f"{said}: no light is added, and those of the file stay", "")
        elif lights:
            if "sun_angle" in self._defines:
                raise Malformed(("", "'sun_angle' needs a sun, but the file has its own lights; add -D sun=1.5"))
            return []
        else:
            radiance, irradiance = SKY, SUN
            glowing = any(child.name == "emitter" for shape in shapes for child in shape.children)
            known = "no lights except emitting surfaces" if glowing else "no light"
            added = f"a sky of radiance {SKY:g} and a sun of irradiance {SUN:g} are added"
            ways = "-D sky=... and -D sun=... set them, -D sun_angle=5 softens shadows"
            self._document.note(f"the file has {known}: {added}; {ways}", "")
        take = self._ids.take
        daylight = (sky(radiance, self._place, take("sky")), self._sun(irradiance, take("sun")))
        return [light for light in daylight if light is not None]

    def _sun(self, irradiance: Strength, name: str) -> Object | None:
        """Return a directional sun, or one of the requested angular radius."""
        if "sun_angle" not in self._defines:
            return sun(irradiance, self._place, name, self._view)
        angle = self._defined(sun_angle, "sun_angle", SUN_ANGLE)
        return soft_sun(irradiance, self._bounds(), self._place, self._view, angle, name)

    def _strength(self, name: str) -> Strength:
        """Return the strength of the light that a definition adds; 0 without the definition."""
        none: Strength = 0.0
        return self._defined(partial(strength, name=name), name, none)

    def _ground(self) -> list[Object]:
        """Return the requested ground; none without the definition."""
        none: Strength = 0.0
        reflectance = self._defined(partial(strength, name="ground", most=1.0), "ground", none)
        own = self._shapes.grounds() if "ground" in self._defines else []
        leave_out = f"; {leaving_out(own)}" if own else ""
        if not np.any(reflectance):
            if "ground" in self._defines:
                stays = "none is added to glTF, and the file's own stays"
                self._document.note(f"-D ground=0 changes nothing: {stays}{leave_out}", "")
            return []
        if own:
            self._document.note(f"-D ground= adds a ground below the file's own, which hides it{leave_out}", "")
        return [ground(reflectance, self._bounds(), self._place, self._ids.take("ground"))]

    def _bounds(self) -> NDArray[np.float64]:
        """Return the least and the largest coordinates (2, 3) of all shapes."""
        corners = self._shapes.corners()
        return np.stack([corners.min(axis=0), corners.max(axis=0)])

    def _defined(self, read: Callable[[object], Value], name: str, default: Value) -> Value:
        """Return the value of a definition, as ``read`` reads it, or the default without the definition."""
        try:
            return read(self._defines[name]) if name in self._defines else default
        except ValueError as error:
            raise Malformed(("", str(error))) from error

    def _played(self) -> Clip | None:
        """Return the requested or first animation over the shutter's time; None without times or animations."""
        shutter = self._shutter()
        names = [animation.name for animation in self._gltf.animations]
        number = self._choice("animation", names) if "animation" in self._defines else 0
        if shutter is None:
            if "animation" in self._defines:
                raise Malformed(("", "'animation' needs a time: add -D time=0.5 or -D shutter=0.5,0.52"))
            return None
        if not names:
            self._document.note("the file has no animations: it is the same at all times", "")
            return None
        if len(names) > 1 and "animation" not in self._defines:
            known = ", ".join(str(name or i) for i, name in enumerate(names))
            self._document.note(
                f"of {len(names)} animations the first is played; -D animation=... takes another of {known}", ""
            )
        clip = played(self._document, number, shutter)
        if clip.times[0] > clip.ends * (1.0 + JUST):
            self._document.note(f"the animation ends at {clip.ends:g} s: later times show its end", "")
        return clip

    def _shutter(self) -> tuple[float, float] | None:
        """Return when the shutter opens and closes, in seconds, by ``shutter`` or ``time``; None without either."""
        asked = [name for name in ("shutter", "time") if name in self._defines]
        if len(asked) == 2:
            raise Malformed(("", "give either 'time', for a still, or 'shutter', for motion blur, not both"))
        if not asked:
            return None
        (name,) = asked
        given = self._defines[name]
        several = given if isinstance(given, Iterable) else [given]
        words: Iterable[Any] = given.split(",") if isinstance(given, str) else several
        try:
            times = [float(word) for word in words]
        except (TypeError, ValueError):
            times = []
        expected = "two times in seconds, such as 0.5,0.54" if name == "shutter" else "a time in seconds, such as 1.5"
        if len(times) != (2 if name == "shutter" else 1) or not -math.inf < times[0] <= times[-1] < math.inf:
            raise Malformed(("", f"'{name}' must be {expected}, found {shortened(given, 40)}"))
        return times[0], times[-1]

    def _note_what_is_left_out(self) -> None:
        for name, fate in self._document.extensions.items():
            if fate == NOT_USED:
                self._document.note(f"the extension {shortened(name, 60)} is not used", "")
        if len(self._gltf.scenes) > 1 and "scene" not in self._defines:
            self._document.note(f"one of {len(self._gltf.scenes)} scenes is shown; -D scene=... takes another", "")
        if self._gltf.animations and self._clip is None:
            self._document.note(
                "animations are not played: everything stands as in the file; -D time=0.5 shows it at half a second, "
                "-D shutter=0.5,0.52 blurs what moves, and -D shutter=0,1 converts the first second",
                "",
            )
