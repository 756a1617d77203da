"""Converts the meshes of glTF nodes to shapes of the scene tree."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from equaltime.scene.gltf.animations import Clip
from equaltime.scene.gltf.document import Document, Malformed
from equaltime.scene.gltf.ids import Ids
from equaltime.scene.gltf.materials import GltfMaterials, Variant
from equaltime.scene.gltf.nodes import STANDING, Placed, copies, placed
from equaltime.scene.gltf.primitives import NAMES, TRIANGLES, Source, box, color, mirrored_uvs, triangles
from equaltime.scene.gltf.textures import MIRRORED
from equaltime.scene.model import Animation, Deformation, mirrors
from equaltime.scene.motion import animation
from equaltime.scene.studio import are_grounds
from equaltime.scene.tree import Object, Place, Ref, add, plant

__all__ = ["Asked", "GltfShapes"]

Array = NDArray[np.float64]

FLATTEST: Final = 1e-12
MANY_INDICES: Final = 100_000
"""Smallest total number of indices in the second and further copies of a mesh for which its copies become instances."""


@dataclass(frozen=True, slots=True)
class _Part:
    """A primitive, or a part of one."""

    suffix: str
    """Text after the primitive's name in the file."""
    variant: Variant
    """Variant of its material, if its node does not mirror."""


@dataclass(frozen=True, slots=True, eq=False)
class _Copy:
    """A mesh placed in the world."""

    mesh: int
    to_world: Array
    bent: int | None = None
    """The node that deforms the mesh, by a skin or by weights of its own, if any."""
    moving: tuple[Array, ...] = ()
    """`to_world` at each time of a clip, if the mesh moves."""
    poses: tuple[float, ...] = ()
    """Times at which the deformation is evaluated; empty for the deformation in the file."""
    name: str | None = None
    """Name of the node or of the mesh in the file."""


@dataclass(frozen=True, slots=True, eq=False)
class Asked:
    """Changes to all meshes of a file that the user asks for, with the option ``-D``."""

    root: Array = field(default_factory=lambda: STANDING)
    """Transform (4, 4) that turns the whole scene."""
    face_normals: bool = False
    """Make all faces flat, also where the file has normals."""
    crease_angle: float | None = None
    """Angle between faces, in degrees, above which edges of meshes without normals are hard. None: all edges are hard,
    as the format says."""


class GltfShapes:
    """Converter of a document's meshes to shapes. It also keeps the transform of each shape, for bounding boxes.

    Parameters
    ----------
    document
        The glTF file.
    place
        Position of the glTF file in the scene's description, for messages.
    materials
        Converter of the file's materials.
    ids
        Maker of the ids of all objects in the scene.
    clip
        Animation that deforms meshes while the shutter is open; None if there is none.
    asked
        The user's changes to all meshes.
    """

    def __init__(
        self,
        document: Document,
        place: Place,
        materials: GltfMaterials,
        ids: Ids,
        clip: Clip | None = None,
        asked: Asked | None = None,
    ) -> None:
        self._clip = clip
        self._asked = asked or Asked()
        self._ids = ids
        self._document = document
        self._place = place
        self._materials = materials
        self._seen: list[tuple[Source, Array, str | None]] = []  # with the names of their shapes
        self._parts: dict[tuple[int, int], list[_Part]] = {}
        self._groups: dict[tuple[int, bool], Object] = {}

    def of(self, nodes: list[Placed]) -> list[Object]:
        """Return the shapes of all `nodes`: one shape for each primitive of each copy of a mesh.

        A primitive becomes two shapes if its normal map appears mirrored on some but not all of its triangles. Many
        copies of a large mesh become instances of one shape group instead. Shape groups come first in the list.
        """
        copies = [copy for at in nodes if at.node.mesh is not None for copy in self._copies(at)]
        counts = Counter(copy.mesh for copy in copies if copy.bent is None)
        grouped = {mesh for mesh, count in counts.items() if self._is_worth_a_group(mesh, count)}
        made: list[Object] = []
        for copy in copies:
            if copy.bent is None and copy.mesh in grouped:
                made.append(self._instance(copy))
            else:
                made.extend(self._shapes(copy, mirrors(copy.to_world)))
        return [*self._groups.values(), *made]

    def corners(self) -> Array:
        """Return the corners (N, 3), in world space, of the bounding boxes of all shapes made so far.

        Each box has eight corners.
        """
        standing = [corners for _, corners in self._boxes()]
        return np.concatenate(standing) if standing else np.zeros((0, 3))

    def grounds(self) -> list[str | None]:
        """Return the names of the shapes made so far that are grounds: flat, below all else and far wider."""
        names, boxes = [name for name, _ in self._boxes()], [corners for _, corners in self._boxes()]
        return [name for name, ground in zip(names, are_grounds(boxes), strict=True) if ground]

    def _boxes(self) -> Iterator[tuple[str | None, Array]]:
        """Yield name and corners (8, 3), in world space, of each bounding box of the shapes made so far."""
        boxes = {source: box(self._document, source) for source in dict.fromkeys(source for source, *_ in self._seen)}
        for source, to_world, name in self._seen:
            if (corners := boxes[source]) is not None:
                yield name, corners @ to_world[:3, :3].T + to_world[:3, 3]

    def reach(self, nodes: Iterable[Placed]) -> Array:
        """Return the corners (N, 3), in world space, of the boxes of all meshes at all times of an animation.

        `nodes` are the nodes with their transforms at these times. The box of a mesh with a skin is the box of its pose
        in the file. Use the corners to place a camera that sees the whole motion.
        """
        found = [np.zeros((0, 3))]
        for at in nodes:
            if at.node.mesh is None:
                continue
            skinned = at.node.skin is not None
            moves = np.array([self._asked.root] if skinned else copies(self._document, at)).reshape(-1, 4, 4)
            for p, _ in self._drawn(at.node.mesh):
                source = Source("nodes", at.index, p) if skinned else Source("meshes", at.node.mesh, p)
                corners = box(self._document, source)
                if corners is not None:
                    found.append((corners @ np.swapaxes(moves[:, :3, :3], 1, 2) + moves[:, None, :3, 3]).reshape(-1, 3))
        return np.concatenate(found)

    def _split(self, mesh: int, p: int) -> list[_Part]:
        """Return the parts of a primitive that become a shape each: two if only a part mirrors its normal map."""
        if (mesh, p) not in self._parts:
            self._parts[mesh, p] = list(self._split_now(mesh, p))
        return self._parts[mesh, p]

    def _split_now(self, mesh: int, p: int) -> Iterator[_Part]:
        primitive = self._document.gltf.meshes[mesh].primitives[p]
        seen, mirrored, colors = self._materials.look(primitive.material), np.zeros(1, np.bool_), np.ones((1, 4))
        try:
            given = color(self._document, primitive, [], "")
            colors = colors if given is None else given
            if "normal" in seen.slots:
                mirrored = mirrored_uvs(triangles(self._document, mesh, p, seen.uv_set))
        except Malformed:  # reported where the mesh itself is read
            pass
        colored = bool((colors[:, :3] != 1.0).any())
        faded = "alpha" in seen.slots and bool((colors[:, 3] != 1.0).any())
        if mirrored.any() and not mirrored.all():
            yield _Part("/unmirrored", Variant(colored, faded, False))
            yield _Part("/mirrored", Variant(colored, faded, True))
        else:
            yield _Part("", Variant(colored, faded, bool(mirrored.any())))

    def _copies(self, at: Placed) -> Iterator[_Copy]:
        """Yield the copies of a node's mesh, except copies without volume."""
        name = at.node.name or self._document.gltf.meshes[at.node.mesh].name
        if at.node.skin is not None:
            yield _Copy(at.node.mesh, self._asked.root, at.index, poses=self._bending(at), name=name)
            return
        poses = self._bending(at)
        bent = at.index if poses or at.node.weights else None
        for moves in copies(self._document, at):
            moving = tuple(moves) if len(moves) > 1 else ()
            if len({mirrors(to_world) for to_world in moves}) > 1 or any(map(_is_flat, moving)):
                place = f"nodes[{at.index}]"
                self._document.note("meshes that become mirrored or scaled to nothing do not move", place)
                moving = ()
            if _is_flat(moves[0]):
                self._document.note("meshes scaled to nothing are left out", f"nodes[{at.index}]")
            else:
                yield _Copy(at.node.mesh, moves[0], bent, moving, poses, name)

    def _bending(self, at: Placed) -> tuple[float, ...]:
        """Return when to evaluate a node's deformation: one time if it stays, none if it is as in the file."""
        if self._clip is None:
            return ()
        skin = None if at.node.skin is None else self._document.gltf.skins[at.node.skin]
        joints: tuple[float, ...] = () if skin is None else self._clip.times[:1]
        if skin is not None and not self._restless.isdisjoint(skin.joints):
            joints = self._clip.even
        return max(joints, self._clip.morphing(at.index), key=len)

    @cached_property
    def _restless(self) -> frozenset[int]:
        """The nodes that move, in any scene of the file."""
        return frozenset(at.index for at in placed(self._document, None, self._clip, hidden=True) if at.moving)

    def _drawn(self, mesh: int) -> Iterator[tuple[int, Any]]:
        """Yield the primitives of a mesh that have a surface, with their numbers."""
        for p, primitive in enumerate(self._document.gltf.meshes[mesh].primitives):
            if primitive.mode in TRIANGLES:
                yield p, primitive
            else:
                self._document.note(f"{NAMES[primitive.mode]} are not drawn", self._place_of(mesh, p).path)

    def _place_of(self, mesh: int, p: int) -> Place:
        return self._place.key("meshes").key(mesh).key("primitives").key(p)

    def _is_worth_a_group(self, mesh: int, count: int) -> bool:
        """Tell whether to make copies of a mesh instances: slower to hit, but without memory; emitters cannot be."""
        drawn = list(self._drawn(mesh))
        if count < 2 or not drawn or any(self._materials.shines(primitive.material) for _, primitive in drawn):
            return False
        accessors = self._document.gltf.accessors
        lists = [p.attributes.POSITION if p.indices is None else p.indices for _, p in drawn]
        points = sum(int(accessors[i].count) for i in lists if i is not None)
        return (count - 1) * points >= MANY_INDICES

    def _instance(self, copy: _Copy) -> Object:
        """Return an instance of the mesh's group; mirrored copies with normal maps have a group of their own."""
        drawn = list(self._drawn(copy.mesh))
        bumpy = any("normal" in self._materials.look(primitive.material).slots for _, primitive in drawn)
        turned = bumpy and mirrors(copy.to_world)
        place = self._place.key("meshes").key(copy.mesh)
        if (copy.mesh, turned) not in self._groups:
            name = self._document.gltf.meshes[copy.mesh].name
            id_ = self._ids.take(f"{name or f'mesh_{copy.mesh}'}_group" + (MIRRORED if turned else ""))
            group = plant("shape", "shapegroup", place, id_)
            for shape in self._shapes(_Copy(copy.mesh, np.eye(4), name=name), turned, seen=False):
                add(group, None, shape)
            self._groups[copy.mesh, turned] = group
        result = plant("shape", "instance", place, self._id(copy), to_world=self._where(copy))
        add(result, "shapegroup", Ref(place, str(self._groups[copy.mesh, turned].id)))
        self._seen += [(Source("meshes", copy.mesh, p), copy.to_world, result.id) for p, _ in drawn]
        return result

    def _shapes(self, copy: _Copy, turned: bool, seen: bool = True) -> Iterator[Object]:
        """Yield the shapes of a copy; in a mirrored copy (`turned`), textures are seen the other way round."""
        for p, primitive in self._drawn(copy.mesh):
            source = Source("meshes", copy.mesh, p) if copy.bent is None else Source("nodes", copy.bent, p)
            made = list[Object]()
            for part in self._split(copy.mesh, p):
                variant = replace(part.variant, mirrored=part.variant.mirrored != turned)
                place = self._place_of(copy.mesh, p)
                made.append(self._shape(f"{source}{part.suffix}", primitive, variant, copy, place))
            if seen:
                self._seen.append((source, copy.to_world, made[0].id))
            yield from made

    def _where(self, copy: _Copy) -> Array | Animation:
        times = () if self._clip is None else self._clip.times
        return animation(list(zip(times, copy.moving, strict=True))) if copy.moving else copy.to_world

    def _filename(self, name: str, primitive: Any, copy: _Copy, place: Place) -> str | Deformation:
        """Return the name of a primitive, or its names at several times."""
        if self._clip is None or not copy.poses:
            return f"{self._document.name}#{name}"
        at = f"{self._document.name}#/animations/{self._clip.number}/"
        names = tuple(f"{at}{time!r}{name}" for time in copy.poses)
        if len(names) > 1 and self._materials.shines(primitive.material):
            self._document.note("emitting meshes do not deform: the first pose is kept", place.path)
        elif len(names) > 1:
            return Deformation(copy.poses, names)
        return names[0]

    def _id(self, copy: _Copy) -> str | None:
        return self._ids.take(copy.name) if copy.name else None

    def _shape(self, name: str, primitive: Any, variant: Variant, copy: _Copy, place: Place) -> Object:
        filename, crease = self._filename(name, primitive, copy, place), self._asked.crease_angle
        bare = vars(primitive.attributes).get("NORMAL") is None
        flat = self._asked.face_normals or (bare and (crease is None or not isinstance(filename, str)))
        result = plant(
            "shape",
            "gltf",
            place,
            self._id(copy),
            filename=filename,
            to_world=None if not copy.moving and np.array_equal(copy.to_world, np.eye(4)) else self._where(copy),
            face_normals=flat or None,
            crease_angle=crease if bare and not flat else None,
            flip_normals=(flat and mirrors(copy.to_world)) or None,
            emitter=self._materials.emitter(primitive.material, variant),
        )
        add(result, "bsdf", Ref(place, self._materials.bsdf(primitive.material, variant)))
        if (medium := self._materials.medium(primitive.material)) is not None:
            add(result, "interior", Ref(place, medium))
        return result


def _is_flat(to_world: Array) -> bool:
    """Tell whether a transform flattens a dimension, which `Transform` of the model refuses."""
    linear = to_world[:3, :3]
    lengths = np.linalg.norm(linear, axis=0)
    return not lengths.all() or abs(float(np.linalg.det(linear / lengths))) < FLATTEST
