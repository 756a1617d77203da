"""The meshes of glTF nodes as shapes of the scene tree."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from equaltime.scene.gltf.document import Document, Malformed
from equaltime.scene.gltf.materials import Materials, Variant
from equaltime.scene.gltf.meshes import Source, box
from equaltime.scene.gltf.nodes import Placed, instances
from equaltime.scene.gltf.plant import add, plant
from equaltime.scene.gltf.primitives import NAMES, TRIANGLES, color, mirrored_uvs, triangles
from equaltime.scene.model import mirrors
from equaltime.scene.tree import Object, Place, Reference

__all__ = ["Shapes"]

Array = NDArray[np.float64]

FLATTEST: Final = 1e-12


@dataclass(frozen=True, slots=True)
class _Part:
    """A primitive, or some of it."""

    suffix: str
    """After its name in the file."""
    variant: Variant
    """Of its material, as long as its node mirrors nothing."""


class Shapes:
    """Makes the shapes of a document, and remembers where they stand."""

    def __init__(self, document: Document, place: Place, materials: Materials) -> None:
        self._document = document
        self._place = place
        self._materials = materials
        self._seen: list[tuple[Source, Array]] = []
        self._parts: dict[tuple[int, int], list[_Part]] = {}

    def of(self, at: Placed) -> Iterator[Object]:
        """Yield the shapes that the mesh of a node makes: one for each primitive and instance."""
        skinned = at.node.skin is not None
        made = None if skinned else instances(self._document, at)
        copies = made if made is not None else [np.eye(4) if skinned else at.to_world]
        for p, primitive in enumerate(self._document.gltf.meshes[at.node.mesh].primitives):
            place = self._place.key("meshes").key(at.node.mesh).key("primitives").key(p)
            if primitive.mode not in TRIANGLES:
                self._document.note(f"{NAMES[primitive.mode]} are not drawn", place.path)
                continue
            source = Source("nodes", at.index, p) if skinned else Source("meshes", at.node.mesh, p)
            for to_world in copies:
                if _is_flat(to_world):
                    self._document.note("what is scaled to nothing is left out", f"nodes[{at.index}]")
                    continue
                self._seen.append((source, to_world))
                for part in self._split(at.node.mesh, p):
                    yield self._shape(f"{source}{part.suffix}", part.variant, primitive, to_world, place)

    def corners(self) -> Array:
        """Return the corners (N, 3) of boxes around all shapes in the world."""
        boxes = {source: box(self._document, source) for source in dict.fromkeys(source for source, _ in self._seen)}
        standing = [
            corners @ to_world[:3, :3].T + to_world[:3, 3]
            for source, to_world in self._seen
            if (corners := boxes[source]) is not None
        ]
        return np.concatenate(standing) if standing else np.zeros((0, 3))

    def _split(self, mesh: int, p: int) -> list[_Part]:
        """Return what becomes one shape each of a primitive: two parts if only some of it mirrors its normal map."""
        if (mesh, p) not in self._parts:
            self._parts[mesh, p] = list(self._split_now(mesh, p))
        return self._parts[mesh, p]

    def _split_now(self, mesh: int, p: int) -> Iterator[_Part]:
        primitive = self._document.gltf.meshes[mesh].primitives[p]
        seen, mirrored, colors = self._materials.look(primitive.material), np.zeros(1, np.bool_), None
        try:
            colors = color(self._document, primitive)
            if "normal" in seen.slots:
                mirrored = mirrored_uvs(triangles(self._document, mesh, p, seen.uv_set))
        except Malformed:  # told where the mesh itself is read
            pass
        colored = colors is not None and bool((colors[:, :3] != 1.0).any())
        if mirrored.any() and not mirrored.all():
            yield _Part("/unmirrored", Variant(colored, False))
            yield _Part("/mirrored", Variant(colored, True))
        else:
            yield _Part("", Variant(colored, bool(mirrored.any())))

    def _shape(self, name: str, variant: Variant, primitive: Any, to_world: Array, place: Place) -> Object:
        flat = vars(primitive.attributes).get("NORMAL") is None
        turned = mirrors(to_world)
        result = plant(
            "shape",
            "gltf",
            place,
            filename=f"{self._document.name}#{name}",
            to_world=None if np.array_equal(to_world, np.eye(4)) else to_world,
            face_normals=flat or None,
            flip_normals=(flat and turned) or None,
            emitter=self._materials.emitter(primitive.material),
        )
        bsdf = self._materials.bsdf(primitive.material, Variant(variant.colored, variant.mirrored != turned))
        add(result, "bsdf", Reference(place, bsdf))
        return result


def _is_flat(to_world: Array) -> bool:
    """Tell whether a transform takes a dimension away, as `Transform` of the model refuses."""
    linear = to_world[:3, :3]
    lengths = np.linalg.norm(linear, axis=0)
    return not lengths.all() or abs(float(np.linalg.det(linear / lengths))) < FLATTEST
