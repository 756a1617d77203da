"""The node hierarchy of a glTF file, with the transform of each node to world space."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from equaltime.scene.gltf.accessors import floats
from equaltime.scene.gltf.animations import NO_TURN, Clip
from equaltime.scene.gltf.document import Document, Malformed

__all__ = ["STANDING", "Placed", "copies", "placed", "product", "rigid"]

Array = NDArray[np.float64]

THINNEST: Final = 1e-8
"""Scale that replaces 0 along one axis, as a fraction of the largest scale, so that flat meshes have normals."""

STANDING: Final[Array] = np.eye(4)
"""Transform of a scene whose y axis is up, as the format says."""


@dataclass(frozen=True, slots=True, eq=False)
class Placed:
    """A node of a glTF file, with its transform to world space, or with several transforms if it moves."""

    index: int
    node: Any
    to_world: Array
    """Transform (4, 4) of column vectors from the node to world space."""
    moving: tuple[Array, ...] = ()
    """Transforms to world space at the times of the animation, in order; empty if the node does not move."""


def placed(
    document: Document,
    scene: int | None,
    clip: Clip | None = None,
    hidden: bool = False,
    root: Array = STANDING,
) -> Iterator[Placed]:
    """Iterate over the nodes of a scene in `document`, with their transforms to world space.

    Each node comes before its children. `scene` is the index of the scene in the file; if it is None, the roots are all
    nodes without a parent. `clip` is the animation that moves nodes, if any; `Placed.to_world` is then the transform at
    the first of its times. Hidden nodes are left out, unless `hidden` is true. `root` (4, 4) turns the whole scene.
    Raises `Malformed` if the hierarchy is not valid, for example if a node has two parents.
    """
    nodes = document.gltf.nodes
    roots = _roots(document, scene, _parents(nodes))
    times = (0.0,) if clip is None else clip.times
    waiting = [(i, np.tile(root, (len(times), 1, 1))) for i in dict.fromkeys(reversed(roots))]
    while waiting:
        index, around = waiting.pop()
        node = nodes[index]
        if not hidden and (node.extensions or {}).get("KHR_node_visibility", {}).get("visible", True) is False:
            continue  # its children are not visible either
        if node.rotation and not any(node.rotation):
            document.note(NO_TURN, f"nodes[{index}]")
        to_world = product(around, np.array([_local(node, clip, index, time) for time in times]))
        still = (to_world == to_world[0]).all()
        yield Placed(index, node, to_world[0], () if still else tuple(to_world))
        waiting.extend((child, to_world) for child in reversed(node.children or []))


def _roots(document: Document, scene: int | None, parents: dict[int, int]) -> list[int]:
    """Return the roots of a scene; a node that is listed but hangs below another root is noted."""
    free = [i for i in range(len(document.gltf.nodes)) if i not in parents]
    listed = dict.fromkeys(free if scene is None else document.gltf.scenes[scene].nodes)
    nested: dict[int, bool] = {}  # whether a listed node is an ancestor
    waiting = [(node, False) for node in free]
    while waiting:
        node, below = waiting.pop()
        nested[node] = below
        waiting.extend((child, below or node in listed) for child in document.gltf.nodes[node].children or [])
    for node in range(len(document.gltf.nodes)):
        if node not in nested:
            raise Malformed((f"nodes[{node}]", "the node is, or hangs below, its own descendant"))
    place = f"scenes[{scene}].nodes"
    for node in listed:
        if node in parents and not nested[node]:
            raise Malformed((place, f"node {node} is no root: it is a child of node {parents[node]}"))
    roots = [node for node in listed if not nested[node]]
    if len(roots) < len(listed):
        document.note("lists nodes that are children of others: they are no roots", place)
    return roots


def _parents(nodes: list[Any]) -> dict[int, int]:
    """Return the parent of each node that has one."""
    parents: dict[int, int] = {}
    for i, node in enumerate(nodes):
        if len(node.children or []) != len({*(node.children or [])}):
            raise Malformed((f"nodes[{i}].children", "a node is listed more than once"))
        for child in node.children or []:
            if parents.setdefault(child, i) != i:
                raise Malformed((f"nodes[{i}].children", f"node {child} already has a parent, node {parents[child]}"))
    return parents


def _local(node: Any, clip: Clip | None, index: int, time: float) -> Array:
    """Return the transform of a node relative to its parent, at a time."""
    animated = {} if clip is None else clip.fields(index, time)
    if node.matrix and animated.keys() <= {"weights"}:
        return _thickened(np.array(node.matrix, dtype=np.float64).reshape(4, 4, order="F"))
    translation = animated.get("translation", node.translation or (0, 0, 0))
    rotation = animated.get("rotation", node.rotation or (0, 0, 0, 1))
    scale = animated.get("scale", node.scale or (1, 1, 1))
    composed: Array = _composed(np.array([translation]), np.array([rotation]), np.array([scale]))[0]
    return composed


def _thickened(matrix: Array) -> Array:
    """Return the transform (4, 4); where it flattens exactly one axis, that axis gets a scale above 0."""
    columns = matrix[:3, :3].T
    flat = np.flatnonzero(~columns.any(axis=1))
    if len(flat) != 1:
        return matrix
    with np.errstate(over="ignore", invalid="ignore"):  # too large numbers are refused later
        across = np.cross(columns[flat[0] - 2], columns[flat[0] - 1])
        matrix[:3, flat[0]] = THINNEST * np.abs(columns).max() * _unit(across, np.zeros(3))
    return matrix


def _composed(translations: Array, rotations: Array, scales: Array) -> Array:
    """Return the transforms (N, 4, 4) that scale, then rotate by unit quaternions (x, y, z, w), then translate.

    A scale of 0 along exactly one axis becomes `THINNEST` times the largest scale.
    """
    flat = (scales == 0.0) & ((scales == 0.0).sum(axis=1, keepdims=True) == 1)
    scales = np.where(flat, THINNEST * np.abs(scales).max(axis=1, keepdims=True, initial=0.0), scales)
    rotations = rotations.astype(np.float64)
    lengths = np.linalg.norm(rotations, axis=1, keepdims=True)
    rotations = np.divide(rotations, lengths, out=np.tile([0.0, 0.0, 0.0, 1.0], (len(rotations), 1)), where=lengths > 0)
    x, y, z, w = rotations.T
    linear = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    result = np.tile(np.eye(4), (len(rotations), 1, 1))
    result[:, :3, :3] = np.moveaxis(linear, 2, 0) * scales[:, None, :]
    result[:, :3, 3] = translations
    return result


def product(a: Array, b: Array) -> Array:
    """Return the matrix product of `a` and `b`, with the same rounding on every machine.

    BLAS is not used, because its rounding depends on the machine. Overflow gives infinities, which later checks refuse.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        product: Array = (a[..., :, :, None] * b[..., None, :, :]).sum(axis=-2)
    return product


def copies(document: Document, at: Placed) -> list[Array]:
    """Return the transforms (T, 4, 4) to world space of each copy of the mesh of the node `at`.

    There is one transform for each time of the animation, or one if the node does not move. A node has one copy, or as
    many as EXT_mesh_gpu_instancing makes. Raises `Malformed` if the extension's data is not valid.
    """
    moves = np.stack(at.moving or (at.to_world,))
    extension = (at.node.extensions or {}).get("EXT_mesh_gpu_instancing")
    if extension is None:
        return [moves]
    attributes = extension["attributes"]
    parts = {"TRANSLATION": ("VEC3", (0, 0, 0)), "ROTATION": ("VEC4", (0, 0, 0, 1)), "SCALE": ("VEC3", (1, 1, 1))}
    given = {name: floats(document, attributes[name], kind) for name, (kind, _) in parts.items() if name in attributes}
    place = f"nodes[{at.index}].extensions.EXT_mesh_gpu_instancing"
    counts = {len(values) for values in given.values()}
    if len(counts) != 1:
        found = "none" if not counts else " and ".join(map(str, sorted(counts)))
        raise Malformed((place, f"expected TRANSLATION, ROTATION or SCALE of one length, found {found}"))
    (count,) = counts
    translations, rotations, scales = (
        given.get(name, np.tile(np.array([default], dtype=np.float64), (count, 1)))
        for name, (_, default) in parts.items()
    )
    if not all(np.isfinite(values).all() for values in (translations, rotations, scales)):
        raise Malformed((place, "a transform is not finite"))
    if not rotations.any(axis=1).all():
        document.note(NO_TURN, place)
    return list(product(moves, _composed(translations, rotations, scales)[:, None]))


def rigid(to_world: Array) -> Array:
    """Return the transform `to_world` (4, 4) without scale, shear and reflection, for cameras and lights.

    The direction of the z axis is kept. The y axis becomes perpendicular to z, and x is the cross product of y and z.
    """
    result = np.eye(4)
    result[:3, 3] = to_world[:3, 3]
    z = _unit(to_world[:3, 2], np.array([0.0, 0.0, 1.0]))
    y = to_world[:3, 1] - z * (to_world[:3, 1] @ z)
    spare = np.eye(3)[np.abs(z).argmin()]
    y = _unit(y, _unit(spare - z * (spare @ z), spare))
    result[:3, :3] = np.column_stack([np.cross(y, z), y, z])
    return result


def _unit(vector: Array, fallback: Array) -> Array:
    length = float(np.linalg.norm(vector))
    return vector / length if length > 0.0 and np.isfinite(length) else fallback
