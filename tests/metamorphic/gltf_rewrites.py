"""Ways to write one glTF document: other layouts of its arrays, other containers, other JSON of the same meaning."""

from __future__ import annotations

import base64
import json
import random
import struct
from copy import deepcopy
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ..unit.scene.gltf_files import COMPONENTS, TYPES, chunk, encoded

Array = NDArray[Any]
Json = dict[str, Any]

WHOLE: Final = ("i1", "u1", "i2", "u2")
"""Types of positions that are whole numbers, with KHR_mesh_quantization."""
FRACTIONS: Final = ("u1", "u2")
"""Types of normalized numbers; 0 and 1 are the same in all of them."""


def arrays(seed: int) -> dict[str, Array]:
    """Return the attributes and indices of a mesh whose numbers every layout holds."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(3, 9))
    normals = np.eye(3)[rng.integers(0, 3, count)] * rng.choice([-1, 1], (count, 1))
    return {
        "POSITION": rng.integers(0, 100, (count, 3)).astype(np.float32),
        "NORMAL": normals.astype(np.float32),
        "TEXCOORD_0": rng.integers(0, 2, (count, 2)).astype(np.float32),
        "COLOR_0": rng.integers(0, 2, (count, 4)).astype(np.float32),
        "indices": np.vstack([[0, 1, 2], rng.integers(0, count, (6, 3))]).ravel().astype(np.uint32),
    }


@dataclass
class Writer:
    """Writes one document in a way that is drawn from `random`; without it, in the plainest way."""

    chance: random.Random | None
    buffers: list[bytearray] = field(default_factory=lambda: [bytearray()])
    json: Json = field(default_factory=dict)

    def maybe(self, share: float = 0.5) -> bool:
        """Tell whether to do something that changes no meaning."""
        return self.chance is not None and self.chance.random() < share

    def view(self, data: bytes, stride: int | None = None) -> int:
        """Add a buffer view to some buffer, after some bytes that mean nothing."""
        if self.maybe(0.2):
            self.buffers.append(bytearray())
        number = self.chance.randrange(len(self.buffers)) if self.chance else 0
        buffer = self.buffers[number]
        buffer += b"\xab" * (-len(buffer) % 4 + 4 * self.maybe())
        view = {"buffer": number, "byteOffset": len(buffer), "byteLength": len(data)}
        buffer += data
        return self._add("bufferViews", view | ({} if stride is None else {"byteStride": stride}))

    def _add(self, name: str, value: Json) -> int:
        self.json.setdefault(name, []).append(value)
        return len(self.json[name]) - 1

    def accessor(self, name: str, values: Array) -> int:
        """Add an array in some type, layout and sparsity."""
        values, more = self._typed(name, values)
        sparse = self.maybe(0.3)
        stored = values.copy()
        if sparse:
            changed = np.flatnonzero(np.random.default_rng(len(values)).random(len(values)) < 0.5)
            stored[changed] = 0
            more["sparse"] = self._sparse(values, changed)
        place: Json = {} if sparse and not stored.any() and self.maybe() else self._placed(name, stored)
        width = 1 if values.ndim == 1 else values.shape[1]
        kind = {"componentType": COMPONENTS[values.dtype.str[1:]], "count": len(values), "type": TYPES[width]}
        if self.maybe(0.3):
            more["max"] = [1e30] * width  # which nobody needs
        return self._add("accessors", {**place, **kind, **more})

    def _typed(self, name: str, values: Array) -> tuple[Array, Json]:
        if name == "indices":
            return values.astype(self.chance.choice(("<u1", "<u2", "<u4")) if self.chance else "<u4"), {}
        if name == "POSITION" and self.maybe(0.4):
            self.json.setdefault("extensionsUsed", ["KHR_mesh_quantization"])
            return values.astype("<" + self._one_of(WHOLE)), {}
        if name in ("TEXCOORD_0", "COLOR_0") and self.maybe():
            kind = self._one_of(FRACTIONS)
            return (values * np.iinfo(kind).max).astype("<" + kind), {"normalized": True}
        if name == "COLOR_0" and values.shape[1] == 4 and (values[:, 3] == 1.0).all() and self.maybe():
            return values[:, :3].astype("<f4"), {}
        return values.astype("<f4"), {}

    def _one_of(self, kinds: tuple[str, ...]) -> str:
        assert self.chance is not None
        return self.chance.choice(kinds)

    def _placed(self, name: str, values: Array) -> Json:
        """Put an array into a view: packed, or with a stride, after an offset."""
        rows = values.reshape(len(values), -1)
        size = rows.shape[1] * rows.itemsize
        offset, stride = 4 * self.maybe() * 2, None
        if name != "indices" and (size % 4 or self.maybe()):
            stride = size + -size % 4 + 4 * (self.chance.randrange(4) if self.chance else 0)
        step = stride or size
        data = bytearray(b"\xcd" * (offset + step * (len(rows) - 1) + size))
        for i, row in enumerate(rows):
            data[offset + i * step : offset + i * step + size] = row.tobytes()
        place: Json = {"bufferView": self.view(bytes(data), stride)}
        return place | ({"byteOffset": offset} if offset or self.maybe() else {})

    def _sparse(self, values: Array, changed: Array) -> Json:
        if not len(changed):
            changed = np.array([0])
        kind = self._one_of(("u1", "u2", "u4"))
        return {
            "count": len(changed),
            "indices": {
                "bufferView": self.view(changed.astype("<" + kind).tobytes()),
                "componentType": COMPONENTS[kind],
            },
            "values": {"bufferView": self.view(np.ascontiguousarray(values[changed]).tobytes())},
        }

    def document(self, mesh: dict[str, Array], pixels: Array, folder: Path) -> Json:
        """Return the JSON of the mesh under one node, with a texture."""
        made = {name: self.accessor(name, values) for name, values in mesh.items()}
        primitive: Json = {"indices": made.pop("indices"), "attributes": made, "material": 0}
        node: Json = {"mesh": 0, "translation": [1, 2, 3], "scale": [2, 4, 8]}
        if self.maybe():
            node = {"mesh": 0, "matrix": [2, 0, 0, 0, 0, 4, 0, 0, 0, 0, 8, 0, 1, 2, 3, 1]}
        pbr: Json = {"baseColorTexture": {"index": 0}, "metallicFactor": 0.0}
        material: Json = {"pbrMetallicRoughness": pbr, "alphaMode": "BLEND"}
        image = encoded(pixels, folder)
        source: Json = {"bufferView": self.view(image), "mimeType": "image/png"}
        if self.maybe():
            source = {"uri": "data:image/png;base64," + base64.b64encode(image).decode()}
        self.json |= {"asset": {"version": "2.0"}, "meshes": [{"primitives": [primitive]}], "nodes": [node]}
        self.json |= {"materials": [material], "textures": [{"source": 0}], "images": [source]}
        self.json |= {"scenes": [{"nodes": [0]}]}
        if self.chance is not None:
            self._spell_out(primitive, node, pbr, material)
        return self.json

    def _spell_out(self, primitive: Json, node: Json, pbr: Json, material: Json) -> None:
        """Add what is so by default, and what means nothing."""
        defaults = [(primitive, "mode", 4), (pbr, "roughnessFactor", 1.0), (pbr, "baseColorFactor", [1, 1, 1, 1])]
        defaults += [(material, "doubleSided", False), (material, "alphaCutoff", 0.5), (self.json, "scene", 0)]
        defaults += [(pbr["baseColorTexture"], "texCoord", 0), (node, "name", "a name"), (node, "extras", {"a": [1]})]
        for part, name, value in defaults:
            if self.maybe(0.3):
                part[name] = value
        if self.maybe(0.3):
            self.json["nodes"].append({"children": [0], "rotation": [0, 0, 0, 1]})
            self.json["scenes"] = [{"nodes": [1]}]
        if self.maybe(0.3):
            spare = self.accessor("POSITION", np.zeros((2, 3), np.float32))
            primitive["attributes"]["_SPARE"] = spare
        if self.maybe(0.3):
            self.json["samplers"] = [{"magFilter": 9729, "minFilter": 9987, "wrapS": 10497, "wrapT": 10497}]
            self.json["textures"][0]["sampler"] = 0

    def write(self, folder: Path) -> Path:
        """Write the document as one of the containers and return the path."""
        document = deepcopy(self.json)
        binary = self.maybe()
        document["buffers"] = [{"byteLength": len(buffer)} for buffer in self.buffers]
        for i, buffer in enumerate(self.buffers):
            buffer += b"" if buffer else b"\0"
            document["buffers"][i]["byteLength"] = len(buffer)
            if i > 0 or not binary:
                document["buffers"][i]["uri"] = self._uri(folder, i, bytes(buffer))
        text = self._text(document)
        if not binary:
            mark = b"\xef\xbb\xbf" if self.maybe(0.2) else b""
            (folder / "a.gltf").write_bytes(mark + text)
            return folder / "a.gltf"
        chunks = chunk(b"JSON", text, b"\0" if self.maybe() else b" ") + chunk(b"BIN\0", bytes(self.buffers[0]), b"\0")
        chunks += chunk(b"XTRA", b"mean", b"\0") if self.maybe(0.2) else b""
        behind = b"behind" if self.maybe(0.2) else b""
        (folder / "a.glb").write_bytes(b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks + behind)
        return folder / "a.glb"

    def _uri(self, folder: Path, number: int, data: bytes) -> str:
        if self.maybe():
            (folder / f"part {number}.bin").write_bytes(data + b"more" * self.maybe())
            return f"part%20{number}.bin"
        return "data:application/octet-stream;base64," + base64.b64encode(data).decode()

    def _text(self, document: Json) -> bytes:
        if self.chance is None:
            return json.dumps(document).encode()
        indent = self.chance.choice([None, 1, "\t"])
        return json.dumps(_shuffled(document, self.chance), indent=indent, ensure_ascii=self.maybe()).encode()


def _shuffled(value: Any, chance: random.Random) -> Any:
    """Return the same JSON with the keys of its objects in another order."""
    if isinstance(value, list):
        return [_shuffled(entry, chance) for entry in value]
    if not isinstance(value, dict):
        return value
    keys = list(value)
    chance.shuffle(keys)
    return {key: _shuffled(value[key], chance) for key in keys}
