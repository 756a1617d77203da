"""Makes small glTF files for tests."""

import base64
import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

import equaltime as et
from equaltime.scene.geometry import MeshSurface

COMPONENTS = {"i1": 5120, "u1": 5121, "i2": 5122, "u2": 5123, "u4": 5125, "f4": 5126}
TYPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}
SQUARE = [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]
TRIANGLE = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]


class Builder:
    """A glTF document being made: arrays go in, the JSON stands in `json`."""

    def __init__(self) -> None:
        self.binary = b""
        self.json: dict[str, Any] = {
            "asset": {"version": "2.0"},
            "accessors": [],
            "bufferViews": [],
            "meshes": [],
            "nodes": [],
            "materials": [],
        }

    def add(self, what: str, value: dict[str, Any]) -> int:
        """Append `value` to the list `what` and return its index."""
        self.json.setdefault(what, []).append(value)
        return len(self.json[what]) - 1

    def view(self, data: bytes, **more: Any) -> int:
        """Add a buffer view with these bytes."""
        self.binary += b"\0" * (-len(self.binary) % 4)
        begin = len(self.binary)
        self.binary += data
        return self.add("bufferViews", {"buffer": 0, "byteOffset": begin, "byteLength": len(data), **more})

    def accessor(self, values: ArrayLike, dtype: str = "f4", **more: Any) -> int:
        """Add an accessor to an array (N,) or (N, components)."""
        array = np.ascontiguousarray(values, dtype="<" + dtype)
        width = 1 if array.ndim == 1 else array.shape[1]
        fields = {"componentType": COMPONENTS[dtype], "count": len(array), "type": TYPES.get(width)}
        return self.add("accessors", {"bufferView": self.view(array.tobytes()), **fields, **more})

    def mesh(self, positions: ArrayLike = TRIANGLE, indices: ArrayLike | None = None, **primitive: Any) -> int:
        """Add a mesh of one primitive; keywords in capitals are attributes (arrays or accessors)."""
        attributes = {name: value for name, value in primitive.items() if name.isupper() or name[-1].isdigit()}
        rest = {name: value for name, value in primitive.items() if name not in attributes}
        attributes = {n: v if isinstance(v, int) else self.accessor(v) for n, v in attributes.items()}
        attributes.setdefault("POSITION", self.accessor(positions))
        if indices is not None:
            rest["indices"] = self.accessor(indices, "u2")
        return self.add("meshes", {"primitives": [{"attributes": attributes, **rest}]})

    def node(self, **fields: Any) -> int:
        """Add a node."""
        return self.add("nodes", fields)

    def image(self, pixels: NDArray[Any], folder: Path) -> int:
        """Add an image in the buffer, and a texture of it; return the texture."""
        source = self.add("images", {"bufferView": self.view(encoded(pixels, folder)), "mimeType": "image/png"})
        return self.add("textures", {"source": source})

    def document(self) -> dict[str, Any]:
        """Return the JSON with the buffer's length, without empty lists."""
        buffers = [{"byteLength": len(self.binary)}] if self.binary else []
        return {name: value for name, value in {**self.json, "buffers": buffers}.items() if value != []}

    def gltf(self, path: Path) -> Path:
        """Write a .gltf file with its buffer as a data URI."""
        document = self.document()
        for buffer in document.get("buffers", []):
            buffer["uri"] = "data:application/octet-stream;base64," + base64.b64encode(self.binary).decode()
        path.write_text(json.dumps(document))
        return path

    def glb(self, path: Path) -> Path:
        """Write a .glb file."""
        path.write_bytes(glb(json.dumps(self.document()).encode(), self.binary))
        return path


def glb(text: bytes, binary: bytes | None) -> bytes:
    """Return the bytes of a GLB file with these chunks."""
    chunks = chunk(b"JSON", text, b" ") + (b"" if binary is None else chunk(b"BIN\0", binary, b"\0"))
    return b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks


def chunk(kind: bytes, data: bytes, filler: bytes) -> bytes:
    data += filler * (-len(data) % 4)
    return struct.pack("<I", len(data)) + kind + data


def encoded(pixels: NDArray[Any], folder: Path, kind: str = "png") -> bytes:
    """Return the bytes of an image file of pixels (H, W, channels), whose colours are not multiplied by their opacity.

    They are uint8 or uint16.
    """
    import OpenImageIO as oiio  # noqa: N813

    path = folder / f"made-for-a-test.{kind}"
    spec = oiio.ImageSpec(pixels.shape[1], pixels.shape[0], pixels.shape[2], pixels.dtype.name)
    spec.attribute("oiio:UnassociatedAlpha", 1)
    output = oiio.ImageOutput.create(str(path))
    assert output.open(str(path), spec)
    assert output.write_image(np.ascontiguousarray(pixels))
    output.close()
    content = path.read_bytes()
    path.unlink()
    return content


def one_triangle(**material: Any) -> Builder:
    """Return a document of one triangle under one node, with a material if any is given."""
    builder = Builder()
    if material:
        builder.node(mesh=builder.mesh(material=builder.add("materials", material)))
    else:
        builder.node(mesh=builder.mesh())
    return builder


def surfaces(builder: Builder, folder: Path) -> list[MeshSurface]:
    found = list(et.load(builder.glb(folder / "a.glb")).surfaces())
    assert all(isinstance(surface, MeshSurface) for surface in found)
    return found  # type: ignore[return-value]
