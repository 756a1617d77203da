"""The materials of an OBJ file: finds and reads its libraries (MTL files), and makes BSDFs and emitters.

========================  ==========================================================================================
``Kd``, ``map_Kd``        `diffuse` on both sides; with an image, ``Kd`` is not used
Pr, Pm, their images      `principled` instead, if one of them is given
``d`` or ``Tr``, map_d    `mask`: where the material is not opaque, light passes as if there were no surface
``norm``                  `normalmap` within both sides: red leans along u, green along v, which is up in the picture
``bump``, ``map_bump``    `bumpmap` instead; white has the height ``-bm``, in the mesh's units. A picture of normals is
                          a `normalmap`, if ``-bm`` is 1. Not used beside ``norm``
``Ke``, ``map_Ke``        `area`, from the front side only; with an image, ``Ke`` is not used
========================  ==========================================================================================

The options ``-s``, ``-o`` and ``-clamp`` place an image. The image file is looked for beside the MTL file, then beside
the OBJ file.
"""

from __future__ import annotations

import math
import os
import re
from pathlib import Path
from typing import Final, Literal

import numpy as np

from equaltime.scene.core import MeshData, obj_name
from equaltime.scene.mtl import ImageMap, Material, read_mtl, shown
from equaltime.scene.pictures import largest, read_picture
from equaltime.scene.report import Account
from equaltime.scene.search import Search
from equaltime.scene.tree import Object, Place, plant

__all__ = ["GREY", "Content", "ObjMaterials", "content_of", "file_beside"]

GREY: Final = 0.5
"""Reflectance of faces without a material."""
_WHITE: Final = (1.0, 1.0, 1.0)
_BLACK: Final = (0.0, 0.0, 0.0)
_SHOWN: Final = {word.lower(): word for word in ("map_Kd", "map_Ke", "map_d", "map_Pr", "map_Pm", "norm", "bump")}
_COLORS: Final = frozenset({"map_kd", "map_ke"})
"""Words whose images hold colours; all other images hold plain numbers."""


class ObjMaterials:
    """The materials of an OBJ file, read from the libraries (MTL files) that it names, as BSDFs and emitters.

    The truth value of this object is False if no library has any material.
    """

    def __init__(self, path: Path, libraries: list[tuple[bytes, int]], account: Account, search: Search) -> None:
        self._path = path
        self._account = account
        self._search = search
        self._found: dict[bytes, tuple[str, Material]] = {}
        self._libraries: dict[str, None] = {}
        self._contents: dict[str, Content] = {}
        for rest, line in libraries:
            if not rest:
                account.tell("'mtllib' names no file", f"{self._path.name}:{line}")
            for name in self._names(rest):
                if name not in self._libraries:
                    self._read(name, line)

    def __bool__(self) -> bool:
        """Tell whether there are any materials."""
        return bool(self._found)

    def of(self, name: bytes) -> tuple[str, Material] | None:
        """Return a pair: the file name of a library, and the material called `name` in it. None if there is none.

        The name is also tried without quotes, and without a comment such as `` #3`` at its end.
        """
        for spelling in dict.fromkeys((name, _unquoted(name), re.sub(rb"\s+#\d+$", b"", name))):
            for known in dict.fromkeys((spelling, b'"' + spelling + b'"')):
                if known in self._found:
                    return self._found[known]
        return None

    def _names(self, rest: bytes) -> list[str]:
        """Return the files that an ``mtllib`` statement names: one, whose name may have blanks, or several."""
        for spelling in dict.fromkeys((rest, obj_name(rest), _unquoted(obj_name(rest)))):
            if (name := file_beside(self._path, "", spelling)) is not None:
                return [name]
        words = [_unquoted(word) for word in re.findall(rb'"[^"]*"|\S+', obj_name(rest))]
        return [file_beside(self._path, "", word) or os.fsdecode(word) for word in words]

    def _read(self, name: str, line: int) -> None:
        self._libraries[name] = None
        told = shown(os.fsencode(name))
        try:
            content = _content(self._search.note(self._path.parent / name))
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or error
            self._account.tell(f"the materials of '{told}' are left out: {reason}", f"{self._path.name}:{line}")
            return
        for material, said in read_mtl(content, told, self._account).items():
            if material in self._found:
                first = shown(os.fsencode(self._found[material][0]))
                message = f"the material '{shown(material)}' is defined in '{first}' too: the last one counts"
                self._account.tell(message, f"{told}:{said.line}")
            self._found[material] = name, said

    def bsdf(self, library: str, material: Material, own: object, place: Place, mesh: MeshData) -> Object:
        """Return the BSDF of a `material` for both sides of `mesh`, as an object of the scene tree.

        `library` is the file name of the material's MTL file. `own` is the mesh's reflectance (a colour or texture),
        used if the material has no ``Kd`` or ``map_Kd``. `place` is the file and line for messages.
        """

        def given(word: str, number: object) -> object:
            return self._image_or(number, word, library, material, place, has_uvs=mesh.uvs is not None)

        color = given("map_kd", material.color) or own
        roughness, metallic = given("map_pr", material.roughness), given("map_pm", material.metallic)
        if roughness is None and metallic is None:
            front = plant("bsdf", "diffuse", place, reflectance=color)
        else:
            front = plant("bsdf", "principled", place, base_color=color, roughness=roughness, metallic=metallic)
        both = plant("bsdf", "twosided", place, bsdf=self._bent(front, library, material, place, mesh))
        opacity = given("map_d", material.opacity)
        if opacity == 1.0:
            return both
        if opacity == 0.0:
            self._tell("a material is wholly transparent: nothing is seen of it", library, material.line)
        return plant("bsdf", "mask", place, opacity=opacity, bsdf=both)

    def emitter(self, library: str, material: Material, place: Place, *, has_uvs: bool) -> Object | None:
        """Return the area emitter of a material, as an object of the scene tree; None for zero radiance.

        An image of the radiance is used only if `has_uvs`: if the mesh has texture coordinates. `library` is the file
        name of the material's MTL file. `place` is the file and line for messages.
        """
        radiance = self._image_or(material.radiance, "map_ke", library, material, place, has_uvs=has_uvs)
        return None if radiance == _BLACK else plant("emitter", "area", place, radiance=radiance)

    def _bent(self, bsdf: Object, library: str, material: Material, place: Place, mesh: MeshData) -> Object:
        """Return `bsdf`, wrapped in the normal or bump map of the material, if there is one."""
        word = "norm" if "norm" in material.images else "bump"
        if word == "norm" and "bump" in material.images:
            self._tell("'bump' is not used beside 'norm'", library, material.images["bump"].line)
        name = self._file(library, material, word, has_uvs=mesh.uvs is not None)
        if name is None:
            return bsdf
        image = material.images[word]
        texture = _bitmap(name, image, place, raw=True)
        if word == "bump" and not self._holds_normals(name, library, image):
            return plant("bsdf", "bumpmap", place, texture=texture, scale=image.multiplier, bsdf=bsdf)
        if (option := _turning(image)) is not None:
            self._tell(f"a normal map is not used with {option}", library, image.line)
            return bsdf
        if word == "bump":
            self._tell("the image of 'bump' is coloured and is used as a normal map", library, image.line)
        if _is_mirrored(mesh):
            self._tell("a normal map leans the wrong way along v on faces that mirror it", library, image.line)
        return plant("bsdf", "normalmap", place, normalmap=texture, bsdf=bsdf)

    def _holds_normals(self, name: str, library: str, image: ImageMap) -> bool:
        """Tell whether the picture of ``bump`` holds normals instead of heights; it is read once."""
        if name not in self._contents:
            self._contents[name] = content_of(self._search.note(self._path.parent / name))
        if self._contents[name] == "colours":
            self._tell("the image of 'bump' is coloured: its luminance is the height", library, image.line)
        return self._contents[name] == "normals"

    def _image_or(
        self, number: object, word: str, library: str, material: Material, place: Place, *, has_uvs: bool
    ) -> object:
        """Return the image of a material, or else `number`; a number that an image replaces is reported."""
        name = self._file(library, material, word, has_uvs=has_uvs)
        if name is None:
            return number
        if number not in (None, 1.0, _WHITE, _BLACK if word == "map_ke" else None):
            self._tell(f"'{_SHOWN[word].removeprefix('map_')}' is not used beside an image", library, material.line)
        return _bitmap(name, material.images[word], place, raw=word not in _COLORS)

    def _file(self, library: str, material: Material, word: str, *, has_uvs: bool) -> str | None:
        """Return the file of a material's image, or None; an unusable image is reported."""
        image = material.images.get(word)
        if image is None:
            return None
        folder = os.path.dirname(library)
        spellings = (image.rest, obj_name(image.rest), _unquoted(obj_name(image.rest)))
        names = (
            file_beside(self._path, base, s) for base in dict.fromkeys((folder, "")) for s in dict.fromkeys(spellings)
        )
        name = next((name for name in names if name is not None), None)
        if name is None:
            self._tell(f"the image '{shown(spellings[1])}' is left out: no such file", library, image.line)
        elif not has_uvs:
            self._tell(f"'{_SHOWN[word]}' is not used: the faces of the material have no vt", library, image.line)
        return name if has_uvs else None

    def _tell(self, kind: str, library: str, line: int) -> None:
        self._account.tell(kind, f"{shown(os.fsencode(library))}:{line}")


def _bitmap(name: str, image: ImageMap, place: Place, *, raw: bool) -> Object:
    wrap_mode = "clamp" if image.clamp else None
    return plant("texture", "bitmap", place, filename=name, to_uv=_to_uv(image), wrap_mode=wrap_mode, raw=raw or None)


def _turning(image: ImageMap) -> str | None:
    """Return an option that asks for normals other than those in the picture, or None."""
    if image.multiplier != 1.0:
        return "another '-bm' than 1"
    return "a negative '-s'" if min(image.scale) < 0.0 else None


def file_beside(path: Path, folder: str, name: bytes) -> str | None:
    """Return the path of the file `name` in `folder`; None if the file does not exist.

    `folder` and the returned path are relative to the folder of the file `path`. Backslashes of Windows are understood
    as separators.
    """
    for spelling in dict.fromkeys((name, name.replace(b"\\", b"/"))):
        found = os.path.join(folder, os.fsdecode(spelling))
        try:
            if spelling and (path.parent / found).is_file():
                return found
        except (OSError, ValueError):  # such as an invalid file name
            continue
    return None


def _to_uv(image: ImageMap) -> list[list[float]] | None:
    """Return the `to_uv` of an image, or None for the identity; the v of an OBJ file is turned over: 1 - v."""
    if image.scale == (1.0, 1.0) and image.offset == (0.0, 0.0):
        return None
    (su, sv), (ou, ov) = image.scale, image.offset
    return [[su, 0.0, 0.0, ou], [0.0, sv, 0.0, 1.0 - sv - ov], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]]


def _unquoted(name: bytes) -> bytes:
    return name[1:-1] if len(name) > 2 and name[:1] == name[-1:] == b'"' else name


def _content(path: Path) -> bytes:
    """Return the content of a library; raises OSError, or ValueError for an invalid name or UTF-16."""
    if path.exists() and not path.is_file():  # reading a device or a pipe may never end
        raise ValueError("not a regular file")
    content = path.read_bytes()
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise ValueError("the text is in UTF-16: save it in UTF-8 or ASCII")
    return content


# -- relief ------------------------------------------------------------------------------------------------------------

Content = Literal["grey", "normals", "colours"]
_SAMPLES: Final = 256
"""Largest number of rows and of columns of texels that are examined to tell normals from other colours."""
_SHARE: Final = 0.75
"""Fraction of the coloured texels that must be unit normals in a picture of normals."""


def content_of(path: Path) -> Content:
    """Return the kind of a picture's content: ``grey`` (heights), ``normals``, or else ``colours``.

    An unreadable picture counts as ``grey``. It is refused later, when the scene's pictures are read.
    """
    try:
        texels = read_picture(path, raw=True).texels
    except ValueError:
        return "grey"
    if texels.shape[2] == 1 or all((texels[..., 0] == texels[..., channel]).all() for channel in (1, 2)):
        return "grey"
    rows, columns = (math.ceil(size / _SAMPLES) for size in texels.shape[:2])
    few = texels[::rows, ::columns].astype(np.float64) / largest(texels)
    vectors = 2.0 * few[(few != few[..., :1]).any(axis=2)] - 1.0
    normals = (np.abs(np.linalg.norm(vectors, axis=1) - 1.0) < 0.1) & (vectors[:, 2] > 0.0)
    return "normals" if np.count_nonzero(normals) > _SHARE * len(vectors) else "colours"


def _is_mirrored(mesh: MeshData) -> bool:
    """Tell whether any face of a mesh, seen from its front, shows the image mirrored.

    The mesh must have texture coordinates, with v upwards in the image.
    """
    assert mesh.uvs is not None, "only what has uvs has an image"
    a, b, c = np.moveaxis(mesh.uvs[mesh.faces], 1, 0)
    (u1, v1), (u2, v2) = (b - a).T, (c - a).T
    return bool((u1 * v2 < u2 * v1).any())
