"""A checked glTF file: the JSON as objects of pygltflib, and the binary data that the JSON refers to.

Both containers are read: ``.glb``, and ``.gltf`` with data URIs or files beside it. Nothing in the file is trusted:
declared sizes are compared with the data before use. No file outside the folder of the document is opened.
"""

from __future__ import annotations

import base64
import binascii
import json
import struct
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import Any, Final
from urllib.parse import unquote, unquote_to_bytes

from equaltime.scene.gltf.rules import Problems
from equaltime.scene.gltf.schema import BASIS, DOCUMENT, MAPPING, UNREADABLE, typed
from equaltime.scene.gltf.surfaces import capped
from equaltime.words import shortened, suggestion

__all__ = ["NOT_USED", "Document", "Malformed", "Unreadable", "parse"]

NOT_USED: Final = "not used"
"""Entry in `Document.extensions` for an extension without a counterpart."""
MAGIC: Final = b"glTF"
JSON_CHUNK, BINARY_CHUNK = 0x4E4F534A, 0x004E4942
MOST_PROBLEMS: Final = 20
"""Largest number of problems that are reported for a file; more would not help."""


class Malformed(ValueError):
    """Error in a glTF file, with one or several problems.

    ``problems`` are pairs: a path in the JSON, such as ``nodes[2].mesh``, and a message.
    """

    def __init__(self, *problems: tuple[str, str]) -> None:
        self.problems = problems
        super().__init__("; ".join(f"{place}: {message}" if place else message for place, message in problems))


class Unreadable(Malformed):
    """Error in a glTF file: an image is missing, or its data cannot be decoded."""


@dataclass(eq=False)
class Document:
    """Checked content of one glTF file, from which the file is converted: JSON, binary data, and notes for the user."""

    json: Mapping[str, Any]
    """JSON of the file, checked against the schema."""
    gltf: Any
    """JSON as a `pygltflib.GLTF2`; all indices in the JSON are in range."""
    name: str
    """Name of the file, without the folder."""
    locate: Callable[[str], Path]
    """Function that returns the path of a file named relative to the document; raises ValueError for a missing file."""
    binary: memoryview | None
    """Binary chunk of a ``.glb``, or None."""
    size: int
    """Size of the file, in bytes."""
    notes: dict[str, dict[str, None]] = field(default_factory=dict)
    """Notes for the user on parts of the file that are changed or not used, in order of discovery. The keys are the
    notes; each value has the paths of the parts in the JSON as keys."""
    uses: dict[int, dict[str, int]] = field(default_factory=dict)
    """Uses of each image, by the image's index: a dict from the names of the material parameters that need the image to
    their numbers of texels."""
    _buffers: dict[int, memoryview] = field(default_factory=dict)

    @property
    def extensions(self) -> dict[str, str]:
        """Mitsuba plugins or parameters that the glTF extensions of the file become, in words, by the extension's name.

        The words come from `MAPPING`; an unsupported extension has the entry `NOT_USED`.
        """
        used = dict.fromkeys([*self.gltf.extensionsUsed, *self.gltf.extensionsRequired])
        return {name: MAPPING.get(name, NOT_USED) for name in used}

    @property
    def outside(self) -> tuple[str, ...]:
        """URIs of the existing files beside the document that have its buffers and images, each once."""
        uris = dict.fromkeys(part.uri for part in (*self.gltf.buffers, *self.gltf.images) if part.uri is not None)
        return tuple(uri for uri in uris if not uri.startswith("data:") and self.size_of(uri))

    def note(self, message: str, place: str) -> None:
        """Add the note `message` for the user about `place`, a path in the JSON such as ``nodes[2]``.

        Equal messages become one note with several paths.
        """
        self.notes.setdefault(message, {})[place] = None

    def view(self, index: int) -> memoryview:
        """Return the bytes of buffer view `index`. Raises `Malformed` if the data is missing or too short."""
        view = self.gltf.bufferViews[index]
        begin, length = int(view.byteOffset or 0), int(view.byteLength)
        data = self._buffer(view.buffer)
        if begin + length > len(data):
            message = f"reaches to byte {begin + length} of buffer {view.buffer}, which has {len(data)}"
            raise Malformed((f"bufferViews[{index}]", message))
        return data[begin : begin + length]

    def _buffer(self, index: int) -> memoryview:
        if index not in self._buffers:
            buffer = self.gltf.buffers[index]
            place = f"buffers[{index}]"
            if buffer.uri is not None:
                data = memoryview(self.resource(buffer.uri, f"{place}.uri"))
            elif index == 0 and self.binary is not None:
                data = self.binary
            else:
                raise Malformed((place, "has no 'uri', and the file has no binary chunk for it"))
            if len(data) < buffer.byteLength:
                raise Malformed((place, f"declares {buffer.byteLength} bytes, but there are only {len(data)}"))
            self._buffers[index] = data[: int(buffer.byteLength)]
        return self._buffers[index]

    def resource(self, uri: str, place: str) -> bytes:
        """Return the content of `uri`, which is a data URI or the name of a file beside the document.

        Raises `Malformed` if the content cannot be read. `place` is the path in the JSON that the error names.
        """
        if uri.startswith("data:"):
            return _decoded(uri, place)
        name = self.relative(uri, place)
        try:
            return self.locate(name).read_bytes()
        except OSError as error:
            raise Malformed((place, f"{shortened(uri, 60)} cannot be read: {error.strerror or error}")) from error
        except ValueError as error:
            raise Malformed((place, str(error))) from error

    def size_of(self, uri: str) -> int:
        """Return the size in bytes of the file `uri` beside the document, or 0 if the file is not found."""
        try:
            return self.locate(self.relative(uri, "")).stat().st_size
        except (OSError, ValueError):
            return 0

    def relative(self, uri: str, place: str) -> str:
        """Return the file name that `uri` encodes, relative to the folder of the document.

        Raises `Malformed` if the file is neither in this folder nor below. `place` is the path in the JSON that the
        error names.
        """
        name = unquote(uri)
        path = PurePosixPath(name)
        if ":" in name.split("/")[0] or "\0" in name:
            raise Malformed((place, f"expected a file beside this one or a data URI, found {shortened(uri, 60)}"))
        if not name or path.is_absolute() or PureWindowsPath(name).is_absolute() or ".." in PureWindowsPath(name).parts:
            raise Malformed((place, f"only files in this folder or below it are read, not {shortened(uri, 60)}"))
        return str(path)


def _decoded(uri: str, place: str) -> bytes:
    """Return the data of a data URI. As in browsers, base64 may have white space, and its padding may be missing."""
    header, comma, data = uri.partition(",")
    if not comma:
        raise Malformed((place, "a data URI needs a comma before its data"))
    if not header.lower().endswith(";base64"):
        return unquote_to_bytes(data)
    letters = "".join(unquote(data).split()).rstrip("=")
    try:
        return base64.b64decode(letters + "=" * (-len(letters) % 4), validate=True)
    except (binascii.Error, ValueError) as error:
        raise Malformed((place, f"the data URI is not valid base64: {error}")) from error


def parse(name: str, content: bytes, locate: Callable[[str], Path]) -> Document:
    """Check the glTF file `name` and return it as a `Document`.

    `content` has the bytes of the ``.gltf`` or ``.glb`` file. `locate` maps a relative file name to a path. Raises
    `Malformed` if the file is not valid.
    """
    text, binary, unread = _chunks(content)
    checked, above, twice = _checked(text)
    document = Document(checked, typed(checked), name, locate, binary, len(content))
    for message in unread:
        document.note(message, "")
    for place in above:
        document.note("a factor above 1 counts as 1", place)
    for key in twice:
        document.note(f"an object of the JSON has {shortened(key, 60)} more than once: the last counts", "")
    return document


def _chunks(content: bytes) -> tuple[bytes, memoryview | None, list[str]]:
    """Return the JSON and the binary chunk of a file, and notes on parts of it that are not read.

    A file that does not begin as a GLB is all JSON.
    """
    if not content.startswith(MAGIC):
        return content, None, []
    if len(content) < 20:
        raise Malformed(("", "the file ends within its GLB header"))
    version, length = struct.unpack_from("<II", content, 4)
    if version != 2:
        raise Malformed(("", f"expected GLB version 2, found {version}"))
    if length > len(content):
        raise Malformed(("", f"the GLB header declares {length} bytes, but the file has {len(content)}: it was cut"))
    chunks: dict[int, memoryview] = {}
    unread: list[str] = []
    position, number = 12, 0
    while position + 8 <= length:
        size, kind = struct.unpack_from("<II", content, position)
        if position + 8 + size > length:
            raise Malformed(("", f"chunk {number} declares {size} bytes and reaches beyond the end of the file"))
        if kind in chunks or kind not in (JSON_CHUNK, BINARY_CHUNK):
            unread.append(f"chunk {number} of the GLB file is not used: {content[position + 4 : position + 8]!r}")
        chunks.setdefault(kind, memoryview(content)[position + 8 : position + 8 + size])
        position, number = position + 8 + size, number + 1
    if JSON_CHUNK not in chunks:
        raise Malformed(("", "the GLB file has no JSON chunk"))
    if position < len(content):
        unread.append(f"{len(content) - position} bytes behind the last chunk of the GLB file are not used")
    text = bytes(chunks[JSON_CHUNK]).rstrip(b"\0")  # some writers pad with zeros instead of blanks
    return text, chunks.get(BINARY_CHUNK), unread


def _checked(text: bytes) -> tuple[dict[str, Any], list[str], list[str]]:
    """Return the JSON object in `text`, which follows the schema and requires nothing that cannot be read.

    Also returns the places of factors that were above 1, and the keys that an object has more than once.
    """
    twice: list[str] = []

    def made(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        result = dict(pairs)
        if len(result) < len(pairs):
            twice.extend(key for key, count in Counter(key for key, _ in pairs).items() if count > 1)
        return result

    try:
        document = json.loads(text.decode("utf-8-sig"), object_pairs_hook=made)
    except UnicodeDecodeError as error:
        raise Malformed(("", f"not UTF-8 text (byte {error.start} of the JSON)")) from error
    except json.JSONDecodeError as error:
        place = f"line {error.lineno}, column {error.colno} of the JSON"
        raise Malformed((place, f"not well-formed: {error.msg}")) from error
    except RecursionError as error:
        raise Malformed(("", "not well-formed JSON: nested too deep")) from error
    except ValueError as error:  # int() limits the number of digits
        raise Malformed(("", "a number has more digits than can be read")) from error
    if not isinstance(document, dict):
        raise Malformed(("", f"expected a JSON object, found {shortened(document, 40)}"))
    above = capped(document)
    problems = [problem for problem, _ in zip(_problems(document), range(MOST_PROBLEMS), strict=False)]
    if problems:
        raise Malformed(*problems)
    return document, above, twice


def _problems(document: Mapping[str, Any]) -> Problems:
    """Yield the problems of a file. A file of another version has no other problems: its structure is unknown."""
    yield from list(_version(document)) or list(DOCUMENT(document, "", document)) or _unreadable(document)


def _version(document: Mapping[str, Any]) -> Problems:
    asset = document.get("asset")
    version = asset.get("minVersion", asset.get("version")) if isinstance(asset, Mapping) else None
    if isinstance(version, str) and version.split(".")[0] != "2":
        yield "asset.version", f"expected glTF 2.0, found {shortened(version, 20)}"


def _unreadable(document: Mapping[str, Any]) -> Problems:
    """Yield required extensions that are not supported, and meshes in compressed forms that are not read.

    An image in such a form is found where a material uses it.
    """
    for i, name in enumerate(document.get("extensionsRequired", [])):
        if name not in MAPPING and name != BASIS:
            hint = f": {UNREADABLE[name]}" if name in UNREADABLE else suggestion(name, MAPPING)
            yield f"extensionsRequired[{i}]", f"the extension {shortened(name, 60)} is not supported{hint}"
    required = document.get("extensionsRequired", [])
    for place, name in _compressed(document):
        if name not in required:
            yield place, f"the data is stored by {name}, which is not supported: {UNREADABLE[name]}"


def _compressed(document: Mapping[str, Any]) -> Problems:
    """Yield place and extension of meshes that exist in a compressed form only."""
    for m, mesh in enumerate(document.get("meshes", [])):
        for p, primitive in enumerate(mesh["primitives"]):
            draco = "KHR_draco_mesh_compression" in primitive.get("extensions", {})
            indices = [*primitive["attributes"].values()]
            if draco and all("bufferView" not in document["accessors"][i] for i in indices):
                yield f"meshes[{m}].primitives[{p}]", "KHR_draco_mesh_compression"
