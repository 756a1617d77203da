"""A loaded scene: its model (plugins and parameters), its files, and the scene in the core (the renderer in C++)."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from time import perf_counter
from typing import Any, Final

import numpy as np

from equaltime import _core
from equaltime.errors import Problem, RenderError, SceneError
from equaltime.examples import example_of
from equaltime.images.image_files import PICTURES, RENDERED
from equaltime.scene import deforming, export, geometry
from equaltime.scene.assets import Assets
from equaltime.scene.bare_mesh import MESHES, read_mesh
from equaltime.scene.changes import changed, deep, several, smaller_film
from equaltime.scene.changes import transparent as without_sky
from equaltime.scene.checks import check_parts
from equaltime.scene.compile import compile_scene
from equaltime.scene.compile_media import unseen_media
from equaltime.scene.core import Unsupported
from equaltime.scene.dict_reader import read_dict
from equaltime.scene.frames import Frame
from equaltime.scene.geometry import Surface, seen_whole
from equaltime.scene.gltf import read_gltf
from equaltime.scene.grounds import own_grounds
from equaltime.scene.inert import shown
from equaltime.scene.model import (
    Animation,
    Area,
    Bitmap,
    Deformation,
    Disk,
    EnvMap,
    HdrFilm,
    MeshFile,
    Plugin,
    SceneModel,
    mesh_files,
)
from equaltime.scene.motion import closed_shutter, in_shutters, still
from equaltime.scene.report import Report
from equaltime.scene.resolve import Resolved, resolve, unmerged
from equaltime.scene.search import Search
from equaltime.scene.studio import leaving_out, strength
from equaltime.scene.substitutes import Substitution, substituted
from equaltime.scene.toml_reader import read_toml
from equaltime.scene.tree import NOWHERE, Object, Places
from equaltime.scene.xml_reader import read_xml
from equaltime.words import Shown, shortened

__all__ = ["Scene", "digest", "load", "load_dict", "load_file", "named_files", "smaller"]

VERSION = "equaltime scene 1"
"""Version of the digest (a hash of the scene). Change the version if equal contents must get another digest than
before."""


def digest(model: SceneModel, assets: Assets) -> str:
    """Return the SHA-256, in hexadecimal digits, of everything that can change the image.

    Parameters and the contents of files count. Names of objects, paths of files, output formats and sampling hints do
    not. The order of shapes and emitters counts, because the bits of an image depend on it.
    """
    content = json.dumps([VERSION, _canonical(in_shutters(model), assets)], sort_keys=True, allow_nan=False)
    return hashlib.sha256(content.encode()).hexdigest()


def _canonical(value: object, assets: Assets) -> object:
    if isinstance(value, Plugin):
        fields = {name: getattr(value, name) for name in type(value).model_fields if name not in {"id", *value.hints}}
        fields = {name: field for name, field in fields.items() if field is not None or name not in value.newer}
        if isinstance(filename := fields.get("filename"), str | Deformation):
            fields["filename"] = _contents(filename, assets)
        if isinstance(value, HdrFilm) and value.crop == (0, 0, value.width, value.height):
            fields |= {"crop_width": None, "crop_height": None}  # a window of the whole film is none
        return {name: _canonical(field, assets) for name, field in fields.items()}
    if isinstance(value, Animation):
        return {"times": value.times, "matrices": value.matrices}
    if isinstance(value, tuple):
        return [_canonical(item, assets) for item in value]
    return value


def _contents(filename: str | Deformation, assets: Assets) -> object:
    """Return the SHA-256 of a file's content.

    For an animation whose files differ, return its times, the SHA-256 of each file, and the time at which it is held.
    """
    sums = [assets.sha256(name) for name in mesh_files(filename)]
    if not isinstance(filename, Deformation) or len(set(sums)) == 1:
        return sums[0]
    return {"times": filename.times, "files": sums, "held": filename.held}


Reader = Callable[[str, bytes, Mapping[str, object], Report, Search], Object | None]


def _gltf(file: str, content: bytes, defines: Mapping[str, object], report: Report, search: Search) -> Object | None:
    return read_gltf(file, content, defines, report, search)


GLTF: Final = (".gltf", ".glb")

READERS: Final[dict[str, Reader]] = {
    **{".toml": read_toml, ".xml": read_xml},
    **dict.fromkeys(GLTF, _gltf),
    **dict.fromkeys(MESHES, read_mesh),
}

_EDITED: Final = (".toml", ".xml")
"""Suffixes of scene files that are edited by hand."""

_HIDES_LAMPS: Final = (
    "the background is transparent, so the camera sees neither sky nor lamps (hide_emitters); "
    "they light the scene as before"
)
_KEEPS_GROUND: Final = "the ground is a surface, not background: it stays opaque and fills the picture; "
_WITHOUT_ADDED: Final = "-D ground=0 leaves it out"
_SHAPE: Final = re.compile(r"shape (\d+): (.*)", re.DOTALL)


@dataclass(frozen=True, eq=False, repr=False)
class Scene(Shown):
    """A loaded and checked scene, ready to render: its model, its files and the warnings about them; immutable."""

    model: SceneModel
    """All plugins of the scene and their parameters, with references replaced by the plugins."""
    source: Path | None
    """The file from which the scene was read; None for a scene made from a dictionary."""
    assets: Assets = field(repr=False)
    """The meshes and images that the scene names."""
    warnings: tuple[str, ...] = ()
    """Warnings, as text, about harmless oddities of the files and about replaced plugins."""
    substitutions: tuple[Substitution, ...] = ()
    """Plugins and parameters that were replaced or left out, as the argument ``substitute`` of `load` allowed."""
    places: Places = field(default=NOWHERE, repr=False)
    """Files and lines at which the scene's plugins are described."""
    _seconds: dict[str, float] = field(default_factory=dict, repr=False)
    _own_max_depth: int | None = field(default=None, repr=False)
    """The value of `own_max_depth`, once `with_` has changed the path length."""
    defines: Mapping[str, str] = field(default_factory=dict, repr=False)
    """Values for the variables of the file, as text, with which it was read."""
    transparent: bool = False
    """Whether `with_` made the background transparent; False if only the scene's film asks for alpha."""
    frame: Frame | None = None
    """The frame whose shutter the scene has; None unless `equaltime.scene.frame_scenes.frames_of` made the scene."""

    def __str__(self) -> str:
        width, height = self.size
        shapes = len(self.model.shapes)
        depth = "paths of any length" if self.max_depth < 0 else f"paths up to depth {self.max_depth}"
        return f"{self.source or 'made in memory'}: {width}x{height}, {shapes} shapes, {depth}"

    def __getstate__(self) -> dict[str, Any]:
        """Return the state for a copy or another process: everything except the core's scene, which is rebuilt."""
        return {name: value for name, value in self.__dict__.items() if name != "core"}

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the whole film in pixels, whatever the crop window."""
        return self.model.sensor.film.size

    @property
    def max_depth(self) -> int:
        """Largest number of segments of a path, Mitsuba's ``max_depth``; -1 if there is no limit."""
        return self.model.integrator.max_depth

    @property
    def own_max_depth(self) -> int:
        """Largest number of segments of a path when the scene was loaded; changes by `with_` do not affect it.

        It is -1 if there is no limit.
        """
        return self.max_depth if self._own_max_depth is None else self._own_max_depth

    @property
    def spp(self) -> int | None:
        """Number of samples per pixel that the scene file asks for, or None if the file gives no number."""
        sensor = self.model.sensor
        given = "sampler" in sensor.model_fields_set and "sample_count" in sensor.sampler.model_fields_set
        return sensor.sampler.sample_count if given else None

    @property
    def extensions(self) -> dict[str, str] | None:
        """Extensions that the scene's glTF file uses, as a dict from the name to words; None for other files.

        The words name the plugin or parameter that represents the extension, or are ``not used``.
        """
        if self.source is None or self.source.suffix.lower() not in GLTF:
            return None
        return self.assets.extensions(self.source.name)

    @property
    def files(self) -> tuple[Path, ...]:
        """Every file from which the scene was read: scene file, included files, meshes, images, spectra."""
        found = {*self.assets.files, *([] if self.source is None else [self.source])}
        return tuple(sorted(path for path in found if path.is_file()))

    @property
    def timings(self) -> dict[str, float]:
        """Seconds spent so far, by phase: ``load`` reads all files, ``build`` makes the core's scene."""
        return dict(self._seconds)

    def to_dict(self) -> dict[str, Any]:
        """Return the scene as the dictionary that `load_dict` reads: valid JSON, with absolute file names.

        ``mitsuba.load_dict`` reads the dictionary too, once all transforms (nested lists) are replaced by Mitsuba's
        type; see `equaltime.scene.export.with_transforms`. Raises ValueError if a file is missing or has changed.
        """
        return export.scene_dict(self.model, self.assets.absolute)

    def write(self, path: str | Path, *, copy: bool = False, overwrite: bool = False) -> tuple[Path, ...]:
        """Write the scene as a TOML or XML file, and return the paths of the written files.

        Reading the file gives the same scene, with the same bits in every image. With `copy`, meshes and images are
        copied into a folder beside the new file. Otherwise the new file names their present paths. With
        `overwrite`, an existing file `path` is replaced. Raises SceneError on failure. See `equaltime.scene.export`.
        """
        path = Path(path)
        try:
            return export.convert(self.model, self.assets, path, copy=copy, overwrite=overwrite)
        except (OSError, ValueError) as error:
            raise SceneError((Problem(str(path), getattr(error, "strerror", None) or str(error)),)) from error

    def surfaces(self) -> Iterator[Surface]:
        """Yield the surfaces of all shapes in world space, in the model's order.

        Animated shapes are at the time halfway between opening and closing of the shutter.
        """
        return geometry.surfaces(still(self.model), self.assets)

    @cached_property
    def digest(self) -> str:
        """SHA-256, in hexadecimal digits, of everything that can change the image, contents of files included."""
        return digest(self.model, self.assets)

    @cached_property
    def core(self) -> _core.Scene:
        """The scene in the core (the renderer in C++), built at its first use.

        Raises
        ------
        SceneError
            If the core cannot use the scene.
        RenderError
            If there is not enough memory, or there are not enough threads, to build the scene.
        """
        started = perf_counter()
        try:
            core = compile_scene(self.model, self.assets, _core.SceneBuilder())
        except Unsupported as error:
            place = self.places.of(error.node) or self.source or ""
            raise SceneError((Problem(str(place), str(error)),)) from error
        except ValueError as error:
            raise SceneError((self._problem(str(error)),)) from error
        except RuntimeError as error:
            if not str(error).startswith("Embree"):
                raise
            problem = f"not enough memory or threads to build the scene ({error})"
            raise RenderError(f"{self.source}: {problem}" if self.source else problem) from error
        self.assets.release()
        self._seconds["build"] = perf_counter() - started
        return core

    def _has_added_ground(self) -> bool:
        """Tell whether a ground was added to the scene's file: to a mesh by default, to glTF if ``-D ground=`` asks."""
        suffix = "" if self.source is None else self.source.suffix.lower()
        if suffix not in MESHES and suffix not in GLTF:
            return False
        return bool(np.any(strength(self.defines.get("ground", float(suffix in MESHES)), "ground")))

    def _without_ground(self) -> Iterator[str]:
        """Yield clauses on how to leave out the scene's grounds: one that was added, and grounds of its own."""
        added = self._has_added_ground()
        if added:
            yield _WITHOUT_ADDED
        grounds = own_grounds(self.model, self.assets)
        own = [shape for shape in grounds if not (added and isinstance(shape, Disk))]
        if own and self.source is not None and self.source.suffix.lower() in _EDITED:
            yield f"to leave it out, delete it ({', '.join(map(self.place_of, own))})"
        elif own:
            yield leaving_out([shape.id for shape in own])

    def _problem(self, message: str) -> Problem:
        """Return the core's error as a problem, with the place of the shape that it names, if any."""
        about = _SHAPE.match(message)
        built = shown(self.model)
        if about and int(about[1]) < len(built) <= len(self.places.shapes):
            return Problem(str(self.places.shapes[built[int(about[1])]]), about[2])
        return Problem(str(self.source or ""), message)

    def place_of(self, part: Plugin) -> str:
        """Return the file and line, as text, at which the plugin `part` is described; empty if it is in no file."""
        return str(self.places.of(part) or "")

    def replaced(self, model: SceneModel) -> Scene:
        """Return this scene with another `model` (plugins and parameters), which must use the same files."""
        return dataclasses.replace(self, model=model, _seconds={"load": self._seconds.get("load", 0.0)})

    def with_(
        self,
        *,
        size: tuple[int, int] | None = None,
        crop: tuple[int, int, int, int] | None = None,
        max_depth: int | None = None,
        shutter: tuple[float, float] | None = None,
        transparent: bool = False,
    ) -> Scene:
        """Return the scene with another film size, crop window (x, y, width, height), path length or shutter.

        `size` is (width, height) in pixels; without a crop, the whole film is rendered. `max_depth` is the largest
        number of segments of a path. A new value changes the image to which a render converges, and errors are measured
        from that image. `shutter` holds the times of opening and closing, in the units of the scene's animations; equal
        times make a still. With `transparent`, images get alpha, and the camera does not see the sky.

        Raises
        ------
        SceneError
            For invalid values.
        ValueError
            If a size, a crop or a shutter has the wrong number of values.
        """
        model, film = self.model, self.model.sensor.film
        changes: dict[str, Any] = {}
        if size is not None:
            width, height = several("size", size, ("width", "height"))
            changes |= {"width": width, "height": height}
            crop = (0, 0, width, height) if crop is None else crop
        if crop is not None:
            values = several("crop", crop, ("x", "y", "width", "height"))
            names = ("crop_offset_x", "crop_offset_y", "crop_width", "crop_height")
            changes |= dict(zip(names, values, strict=True))
        if changes:
            model = changed(model, sensor=changed(model.sensor, film=changed(film, **changes)))
        if shutter is not None:
            opens, closes = several("shutter", shutter, ("open", "close"))
            model = changed(model, sensor=changed(model.sensor, shutter_open=opens, shutter_close=closes))
        if max_depth is not None:
            model = changed(model, integrator=deep(model.integrator, max_depth))
        closed = None if shutter is None else closed_shutter(self.model)  # this call chooses the times
        warnings = tuple(warning for warning in self.warnings if warning != closed)
        if transparent and not self.transparent:
            model = without_sky(model)
            hides_lamps = model.integrator.hides_emitters and any(isinstance(node, Area) for node in model.nodes())
            warnings += (_HIDES_LAMPS,) * hides_lamps + tuple(f"{_KEEPS_GROUND}{way}" for way in self._without_ground())
        return dataclasses.replace(
            self.replaced(model),
            warnings=warnings,
            transparent=transparent or self.transparent,
            frame=self.frame if shutter is None else None,
            _own_max_depth=self.own_max_depth,
        )


def load(path: str | Path, /, *, substitute: bool = False, **defines: object) -> Scene:
    """Read a scene file: TOML, Mitsuba 3's XML, or glTF 2.0 (see `equaltime.scene.gltf`).

    Parameters
    ----------
    path
        The scene file. Other files that it names are looked for relative to its folder. A single mesh (``.obj``,
        ``.ply``) is a scene too. If there is no such file, the name of an example (`equaltime.examples`) stands for it.
    substitute
        Do not refuse a scene with unsupported plugins. Replace them by similar plugins if possible, and else leave them
        out. `Scene.substitutions` and the warnings list the replacements.
    defines
        Values for the variables (``$name``) of the file, like ``-D name=value`` on the command line.

    Raises
    ------
    SceneError
        If the scene is invalid. The error lists all problems found, each with file and line.

    Examples
    --------
    >>> scene = et.load("scene.toml")
    >>> scene.size, scene.max_depth
    ((16, 16), 30)
    >>> scene.with_(size=(32, 24)).size
    (32, 24)
    """
    return load_file(path, defines, substitute=substitute)


def load_file(path: str | Path, defines: Mapping[str, object], *, substitute: bool = False) -> Scene:
    """Read a scene file, with the values of its variables in the mapping `defines`.

    A variable may have any name here, even the name of a keyword argument of `load`. With `substitute`, unsupported
    plugins are replaced by similar ones instead of being refused. Raises SceneError, which lists all problems, for an
    invalid scene.
    """
    started = perf_counter()
    path, report = Path(path), Report()
    if example := example_of(path):
        report.note(f"{path}: there is no such file, so the example {example} is used")
        path = example
    search = Search(path.parent)
    root = _read(path, defines, report, search)
    scene = _finish(root, report, path, search, started, substitute=substitute)
    return dataclasses.replace(scene, defines={name: _text(value) for name, value in defines.items()})


def _text(value: object) -> str:
    """Return the value of a definition as the command line would give it."""
    several = isinstance(value, Iterable) and not isinstance(value, str)
    return ",".join(map(str, value)) if several else str(value)  # type: ignore[call-overload]


def load_dict(scene: Mapping[str, object], *, substitute: bool = False) -> Scene:
    """Read a scene from nested dictionaries, as ``mitsuba.load_dict`` takes them.

    Three spellings are allowed in addition. A sequence of three numbers stands for a colour. The name of an object
    stands for a reference to the object. Transforms may be NumPy arrays, nested lists or lists of steps (see
    `equaltime.scene.transforms.parse`). Files are looked for relative to the current folder. With `substitute`,
    unsupported plugins are replaced, as in `load`.

    Raises
    ------
    SceneError
        If the scene is invalid. The error lists all problems found, each with its path of keys.
    TypeError
        If `scene` is not a dictionary.

    Examples
    --------
    >>> film = {"type": "hdrfilm", "width": 8, "height": 6}
    >>> sky = {"type": "constant"}
    >>> et.load_dict({"type": "scene", "sensor": {"type": "perspective", "film": film}, "sky": sky}).size
    (8, 6)
    """
    if not isinstance(scene, Mapping):
        raise TypeError(f"expected a dictionary with 'type': 'scene', found {shortened(scene, 80)}")
    started = perf_counter()
    report, search = Report(), Search(Path.cwd())
    return _finish(read_dict(scene, report, search), report, None, search, started, substitute=substitute)


_EXPORT: Final = {".blend": "export it from Blender as glTF (File > Export > glTF 2.0, .glb)"}
"""Ways from files of other programs to a scene file, by the files' extensions."""


def _read(path: Path, defines: Mapping[str, object], report: Report, search: Search) -> Object | None:
    reader = READERS.get(path.suffix.lower())
    if reader is None:
        *most, last = READERS
        message = f"unknown kind of scene file; expected {', '.join(most)} or {last}"
        if way := _EXPORT.get(path.suffix.lower()):
            message += f"; {way}"
        if path.suffix.lower() in RENDERED:
            message = "a picture, not a scene; if equaltime rendered it, `equaltime info` tells how"
        elif path.suffix.lower() in PICTURES:
            message = "a picture, not a scene; a scene file names it as an environment map or a texture"
        if not path.suffix and not path.exists():
            message = "there is no such file, and no example of that name; `equaltime examples` lists them"
        raise SceneError((Problem(str(path), message),))
    try:
        content = path.read_bytes()
    except OSError as error:
        raise SceneError((Problem(str(path), f"cannot be read: {error.strerror or error}"),)) from error
    return reader(str(path), content, defines, report, search)


def _finish(
    root: Object | None, report: Report, source: Path | None, search: Search, started: float, *, substitute: bool
) -> Scene:
    """Return the scene of a tree, or raise SceneError with all problems."""
    assets = Assets(search)
    done: tuple[Substitution, ...] = ()
    if root is not None and substitute:
        root, done = substituted(root, assets.lost)
    resolved = Resolved(None, [], []) if root is None else resolve(unmerged(root, report), report)
    warnings = (*report.notes, *map(str, done), *check_parts(resolved, assets, report))
    report.raise_if_any()
    model = resolved.model
    assert model is not None, "a scene without problems has a model"
    if all(part is not model.sensor for _, part in resolved.parts):
        model = seen_whole(model, assets)
    odd = (unseen_media(model), closed_shutter(model), deforming.uneven(model))
    warnings += tuple(told for told in odd if told is not None)
    places = Places(tuple(node.place for node in resolved.shapes), [(part, n.place) for n, part in resolved.parts])
    return Scene(model, source, assets, warnings, done, places, {"load": perf_counter() - started})


def smaller(scene: Scene, most: float) -> Scene:
    """Return the scene with a smaller film, so that about `most` pixels are in its crop window, for quick renders.

    If the crop window of `scene` has `most` pixels or fewer, return `scene` itself.
    """
    crop = scene.model.sensor.film.crop
    scale = math.sqrt(most / (crop[2] * crop[3]))
    if scale >= 1.0:
        return scene
    size, window = smaller_film(scene.size, crop, scale)
    return scene.with_(size=size, crop=window)


def named_files(scene: Scene) -> tuple[Path, ...]:
    """Return the paths of all images and meshes that the scene names, sorted, each once."""
    named = {node.filename for node in scene.model.nodes() if isinstance(node, Bitmap | EnvMap | MeshFile)}
    return tuple(sorted({scene.assets.path(name) for filename in named for name in mesh_files(filename)}))
