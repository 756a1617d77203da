"""Export of scenes: as a dictionary, as TOML, or as XML for Mitsuba 3.

`plain` converts a scene model to nested dictionaries with Mitsuba's names. `look_at` replaces matrices of cameras by
origin, target and up direction. `toml_writer` and `xml_writer` convert such a dictionary to text. `files` names files,
copies them, and writes the contents of a glTF file as separate files. The function `convert` combines all steps.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Final

from equaltime.errors import Problem, SceneError
from equaltime.files import beside, give_new_name, replacing
from equaltime.scene.assets import Assets
from equaltime.scene.export.files import Folder, portable, relative
from equaltime.scene.export.look_at import with_look_at
from equaltime.scene.export.plain import PlainWriter, scene_dict, with_transforms
from equaltime.scene.export.toml_writer import write_toml
from equaltime.scene.export.xml_writer import write_xml
from equaltime.scene.gltf import split
from equaltime.scene.model import SceneModel

__all__ = ["FORMATS", "PlainWriter", "convert", "scene_dict", "with_transforms"]


FORMATS: Final[dict[str, Callable[[Mapping[str, Any]], str]]] = {".toml": write_toml, ".xml": write_xml}
"""Functions that turn a scene's dictionary into text, by the suffix of the scene file."""


def convert(
    model: SceneModel, assets: Assets, file: Path, *, copy: bool = False, overwrite: bool = False
) -> tuple[Path, ...]:
    """Write the scene to the file `file`, and return all files that were written, `file` first.

    The suffix of `file` decides the format; see `FORMATS`. The written scene names meshes and images relative to
    `file`. With `copy`, meshes and images are first copied into a folder beside `file`; a glTF file is copied with the
    buffers and images that it names. For XML, with `copy` or without, meshes and bitmaps of glTF files and parts of OBJ
    files become separate files in that folder.

    Raises SceneError for an unknown format, or if `file` exists and `overwrite` is False. Raises ValueError if a file
    of the scene is missing.
    """
    if file.suffix.lower() not in FORMATS:
        known = " or ".join(FORMATS)
        raise SceneError((Problem(str(file), f"cannot write a scene as '{file.suffix}'; expected {known}"),))
    if file.exists() and not overwrite:
        raise SceneError((Problem(str(file), "is there already; choose another name, or overwrite=True replaces it"),))
    folder = Folder(file.parent / f"{file.stem}_files")
    if file.suffix.lower() == ".xml":
        model = portable(model, assets, folder)

    def name(filename: str) -> str:
        """Return the name of a file in the written scene; a fragment that names a part stays."""
        path, inside = assets.path(filename), split(filename)[1]
        if copy and path.resolve().parent != folder.path.resolve():
            path = folder.copy(path, () if inside is None else assets.companions(filename))
        return relative(path, file.parent) + ("" if inside is None else f"#{inside}")

    text = FORMATS[file.suffix.lower()](with_look_at(scene_dict(model, name)))
    with replacing(file) if overwrite else beside(file) as fresh:
        fresh.write_text(text, encoding="utf-8", newline="\n")
        if not overwrite:
            give_new_name(fresh, file)
    return file, *folder.written
