"""Finds the properties of a glTF file that are not used, and notes them for the user.

Properties that do not affect the picture are not noted. The schema lists the properties that are read. A walk through
the file along the schema finds all other properties. The walk also collects all indices, and so finds items of lists
that no index refers to.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any, Final

from equaltime.scene.gltf.document import Document
from equaltime.scene.gltf.primitives import TRIANGLES
from equaltime.scene.gltf.rules import Index, walk
from equaltime.scene.gltf.schema import DOCUMENT
from equaltime.scene.gltf.surfaces import look
from equaltime.words import shortened

__all__ = ["check_account"]

DESCRIPTIONS: Final = frozenset(
    {
        *("name", "asset.generator", "asset.copyright", "accessors[].min", "accessors[].max", "bufferViews[].target"),
        *("skins[].skeleton", "images[].mimeType", "samplers[].minFilter"),
    }
)
"""Properties that do not affect the picture. One is minFilter, because the samples of a pixel average its texels."""
USED: Final = frozenset({"POSITION", "NORMAL", "COLOR_0"})
"""Vertex attributes that are used with every material."""
COPIED: Final = frozenset({"TRANSLATION", "ROTATION", "SCALE"})
MORPHED: Final = frozenset({"POSITION", "NORMAL"})
LISTS: Final = (
    *("nodes", "meshes", "materials", "textures", "images", "samplers", "skins", "cameras", "accessors"),
    *("bufferViews", "buffers"),
)
"""Lists of the file whose items are referred to by index."""


def check_account(document: Document) -> None:
    """Add notes for the user to `document` on everything in the file that is not used.

    These are properties, vertex attributes, and items of lists that no index refers to. Unused properties of the same
    name share one note.
    """
    referred: set[tuple[str, int]] = set()
    for rule, value, place in walk(DOCUMENT, document.json):
        if rule is None:
            _note(document, value, place)
        elif isinstance(rule, Index):
            referred.add((rule.path[-1], value))
    for name, place in _attributes(document):
        document.note(f"the attribute {name} is not used", place)
    _note_missing(document)
    _note_weights(document)
    _note_spare(document, referred)


def _note(document: Document, value: Any, place: str) -> None:
    parent, _, name = place.rpartition(".")
    kind = re.sub(r"\[\d+\]", "[]", place)
    if name == "extras":
        document.note("extras are not used", parent)
    elif name == "extensions" and isinstance(value, Mapping):
        for extension in value:
            _note_extension(document, extension, parent)
    elif re.fullmatch(r"(?:.*\.)?extensions", parent):
        _note_extension(document, name, parent.removesuffix("extensions").removesuffix("."))
    elif name not in DESCRIPTIONS and kind not in DESCRIPTIONS:
        document.note(f"{shortened(kind, 100)[1:-1]} is not used", parent)


def _note_extension(document: Document, name: str, place: str) -> None:
    document.note(f"the extension {shortened(name, 60)} is not used", place)


def _attributes(document: Document) -> Iterator[tuple[str, str]]:
    """Yield the attributes of primitives and of copies that are not used, with the places of primitives or nodes."""
    gltf = document.gltf
    skinned = {node.mesh for node in gltf.nodes if node.skin is not None}
    for m, mesh in enumerate(gltf.meshes):
        for p, primitive in enumerate(mesh.primitives):
            seen = look(None if primitive.material is None else gltf.materials[primitive.material])
            used = {*USED, f"TEXCOORD_{seen.uv_set}"}
            place = f"meshes[{m}].primitives[{p}]"
            for name in _given(primitive.attributes):
                if name not in used and not (m in skinned and name.startswith(("JOINTS_", "WEIGHTS_"))):
                    yield name, place
            for target in primitive.targets or ():
                yield from ((f"{name} of morph targets", place) for name in _given(target) if name not in MORPHED)
    for n, node in enumerate(gltf.nodes):
        copied = (node.extensions or {}).get("EXT_mesh_gpu_instancing", {"attributes": {}})
        yield from ((f"{name} of copies", f"nodes[{n}]") for name in copied["attributes"] if name not in COPIED)


def _note_missing(document: Document) -> None:
    """Note the primitives without the texture coordinates that the textures of their materials use."""
    gltf = document.gltf
    for m, mesh in enumerate(gltf.meshes):
        for p, primitive in enumerate(mesh.primitives):
            seen = look(None if primitive.material is None else gltf.materials[primitive.material])
            name = f"TEXCOORD_{seen.uv_set}"
            drawn = primitive.mode in TRIANGLES
            if drawn and seen.textured and name not in _given(primitive.attributes):
                message = f"the textures of the material need {name}, which is missing: all vertices get (0, 0)"
                document.note(message, f"meshes[{m}].primitives[{p}]")


def _note_weights(document: Document) -> None:
    """Note the meshes and nodes that do not have one weight for each morph target."""
    gltf = document.gltf
    given = [(f"meshes[{i}].weights", mesh, mesh.weights) for i, mesh in enumerate(gltf.meshes)]
    placed = [(i, node) for i, node in enumerate(gltf.nodes) if node.mesh is not None]
    given += [(f"nodes[{i}].weights", gltf.meshes[node.mesh], node.weights) for i, node in placed]
    for place, mesh, weights in given:
        targets = max((len(primitive.targets or ()) for primitive in mesh.primitives), default=0)
        if weights and len(weights) != targets:
            rest = "the last are not used" if len(weights) > targets else "the others are 0"
            document.note(f"expected a weight for each of {targets} morph targets, found {len(weights)}: {rest}", place)


def _given(attributes: Any) -> list[str]:
    return [name for name, index in vars(attributes).items() if index is not None]


def _note_spare(document: Document, referred: set[tuple[str, int]]) -> None:
    """Note the parts that nothing refers to; without scenes in the file, all nodes are shown."""
    for name in LISTS:
        if name == "nodes" and not document.gltf.scenes:
            continue
        for i in range(len(document.json.get(name, ()))):
            if (name, i) not in referred:
                document.note(f"some {name} are not used: nothing refers to them", f"{name}[{i}]")
