"""Limits on the amount of data in a glTF file, relative to the size of the file.

Data that is used several times counts several times.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Final

from equaltime.scene.gltf.document import Document, Malformed

__all__ = ["check_extent", "check_texels"]

FREE_ELEMENTS: Final = 1 << 19
USES_OF_A_BYTE: Final = 16
"""Limit on the accessor elements that all primitives use: `FREE_ELEMENTS` plus this number per byte of the file."""
ZEROS_OF_A_BYTE: Final = 8
"""Limit on the elements of accessors without a buffer view: `FREE_ELEMENTS` plus this number per byte of the file. Such
elements take no bytes of the file. Sparse morph targets have one element for each vertex."""
FREE_COPIES: Final = 1024
FREE_TEXELS: Final = 1 << 24
TEXELS_OF_A_BYTE: Final = 64
"""Limit on the texels of repeated uses of images: `FREE_TEXELS` plus this number per byte of the file."""
BYTES_OF_A_COPY: Final = 4
"""Bytes of the file that each copy by EXT_mesh_gpu_instancing must have, beyond `FREE_COPIES` copies. The smallest
attribute of a copy, a rotation of four bytes, has this size."""


def check_extent(document: Document) -> None:
    """Raise `Malformed` if `document` uses more elements of accessors, or copies of nodes, than its size allows.

    An element counts once for each primitive that uses it. A copy of a node is an instance made by the extension
    EXT_mesh_gpu_instancing. The limits are in proportion to the size of the file.
    """
    size = _bytes(document)
    elements = zeros = copies = 0
    for place, index in _of_primitives(document.gltf):
        accessor = document.gltf.accessors[index]
        count, free = int(accessor.count), accessor.bufferView is None
        elements += count if free else min(count, size)  # too short data is reported where it is read
        zeros += count if free else 0
        _check(elements, FREE_ELEMENTS + USES_OF_A_BYTE * size, "elements that primitives use", place)
        _check(zeros, FREE_ELEMENTS + ZEROS_OF_A_BYTE * size, "elements without data that primitives use", place)
    for place, index in _of_copies(document.gltf):
        copies += int(document.gltf.accessors[index].count)
        _check(copies, FREE_COPIES + size // BYTES_OF_A_COPY, "copies of nodes", place)


def check_texels(document: Document, image: int, use: str, count: int) -> None:
    """Record in `document` that the parameter `use` needs `count` texels of image `image`.

    Raises `Malformed` if the repeated uses of images, recorded so far, exceed the limit for the file's size.
    """
    document.uses.setdefault(image, {})[use] = count
    shared = sum((len(uses) - 1) * max(uses.values()) for uses in document.uses.values())
    _check(shared, FREE_TEXELS + TEXELS_OF_A_BYTE * _bytes(document), "texels of images that are used again", use)


def _check(found: int, most: int, what: str, place: str) -> None:
    if found > most:
        raise Malformed((place, f"{found} {what} in all; the limit for a file of this size is {most}"))


def _bytes(document: Document) -> int:
    """Return the size in bytes of the file and of the files that it names, as far as they exist."""
    return document.size + sum(map(document.size_of, document.outside))


def _of_primitives(gltf: Any) -> Iterator[tuple[str, int]]:
    """Yield the accessors that primitives use, once for each use, with the place of the primitive."""
    for number, mesh in enumerate(gltf.meshes):
        for p, primitive in enumerate(mesh.primitives):
            place = f"meshes[{number}].primitives[{p}]"
            given = [vars(primitive.attributes), *map(vars, primitive.targets or ()), {"indices": primitive.indices}]
            yield from ((place, index) for part in given for index in part.values() if isinstance(index, int))


def _of_copies(gltf: Any) -> Iterator[tuple[str, int]]:
    """Yield one accessor for each node that is instanced, with the place of the node."""
    for number, node in enumerate(gltf.nodes):
        extension = (node.extensions or {}).get("EXT_mesh_gpu_instancing")
        if extension is not None:
            yield from ((f"nodes[{number}]", index) for index in list(extension["attributes"].values())[:1])
