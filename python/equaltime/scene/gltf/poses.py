"""Poses of a glTF file: transforms of nodes, weights of morph targets, and meshes deformed by skins.

A pose is either stored in the file, or taken from an animation at one time. A skin deforms a mesh by the transforms of
the pose's nodes, the joints of the skin.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from equaltime.scene.gltf.accessors import floats, integers
from equaltime.scene.gltf.animations import Clip, played
from equaltime.scene.gltf.document import Document, Malformed
from equaltime.scene.gltf.nodes import placed, product

__all__ = ["Pose", "at_time", "skinned"]

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Pose:
    """Pose of a glTF file at one moment, to deform meshes: transforms of nodes and weights of morph targets."""

    document: Document
    clip: Clip | None = None
    """Animation at a single time; None for the pose stored in the file."""

    @cached_property
    def worlds(self) -> dict[int, Array]:
        """Transforms (4, 4) from each node to world space, by the index of the node."""
        return {at.index: at.to_world for at in placed(self.document, None, self.clip, hidden=True)}

    def weights(self, mesh: int, node: int | None) -> Any:
        """Return the weights of the morph targets of mesh `mesh`, as placed by node `node`: one number per target.

        Animated weights take precedence over the node's weights, and the node's weights over the weights of the mesh.
        """
        nodes = self.document.gltf.nodes
        own = None if node is None else nodes[node].weights
        if node is not None and self.clip is not None:
            own = self.clip.fields(node, self.clip.times[0]).get("weights", own)
        return (self.document.gltf.meshes[mesh].weights or ()) if own is None else own


def at_time(document: Document, animation: int, time: float) -> Pose:
    """Return the pose of `document` that its animation number `animation` gives at `time`, in seconds.

    Raises `Malformed` if the animation does not exist or the time is not finite.
    """
    if animation >= len(document.gltf.animations) or not math.isfinite(time):
        raise Malformed((f"animations[{animation}]", f"there is no such animation, or no time {time}"))
    return Pose(document, played(document, animation, (time, time)))


@np.errstate(over="ignore", invalid="ignore")  # non-finite values are reported with the mesh
def skinned(
    pose: Pose, node: int, primitive: Any, vertices: Array, normals: Array | None, warnings: list[str]
) -> tuple[Array, Any]:
    """Return `vertices` (N, 3) and `normals` (N, 3) of `primitive` in world space, deformed by the skin of node `node`.

    `pose` gives the transforms of the skin's joints. If `normals` is None, the returned normals are None, too. The
    transform of the node itself has no effect, as the specification says. Changed weights are reported in `warnings`.
    Raises `Malformed` if the data of the skin is not valid.
    """
    document = pose.document
    joints, weights = _influences(document, primitive, len(vertices), f"nodes[{node}]", warnings)
    bones = _bones(pose, document.gltf.nodes[node].skin)
    if joints.max(initial=0) >= len(bones):
        raise Malformed((f"nodes[{node}].skin", f"a vertex names joint {joints.max()}, but there are {len(bones)}"))
    blended = np.zeros((len(vertices), 4, 4))
    for i in range(joints.shape[1]):
        blended += weights[:, i, None, None] * bones[joints[:, i]]
    moved = (blended[:, :3, :3] * vertices[:, None, :]).sum(axis=2) + blended[:, :3, 3]
    if normals is None:
        return moved, None
    return moved, (_cofactors(blended[:, :3, :3]) * normals[:, None, :]).sum(axis=2)


def _influences(
    document: Document, primitive: Any, count: int, place: str, warnings: list[str]
) -> tuple[NDArray[np.uint32], Array]:
    """Return the joints (N, 4k) of each vertex and their weights, which sum to 1.

    The first joint carries a vertex whose weights have no sum above 0, and `warnings` gets their number.
    """
    attributes = vars(primitive.attributes)
    joints: list[NDArray[np.uint32]] = []
    weights: list[Array] = []
    while (given := attributes.get(f"JOINTS_{len(joints)}")) is not None:
        shares = attributes.get(f"WEIGHTS_{len(joints)}")
        if shares is None:
            raise Malformed((place, f"the mesh has JOINTS_{len(joints)} without WEIGHTS_{len(joints)}"))
        joints.append(integers(document, given, "VEC4"))
        weights.append(floats(document, shares, "VEC4"))
    if not joints or {*map(len, joints), *map(len, weights)} != {count}:
        raise Malformed((place, "the mesh of a skin needs JOINTS_0 and WEIGHTS_0 for each of its vertices"))
    shared = np.concatenate(weights, axis=1)
    total = shared.sum(axis=1)
    wrong = ~(np.isfinite(total) & (total > 0.0))
    if wrong.any():
        warnings.append(f"{place}: {wrong.sum()} vertices have no weights of joints: their first joint carries them")
        shared[wrong], total[wrong] = np.eye(shared.shape[1])[0], 1.0
    return np.concatenate(joints, axis=1), shared / total[:, None]


def _bones(pose: Pose, index: int) -> Array:
    """Return the transform of each joint of a skin (J, 4, 4), from the mesh as modelled to the world."""
    document = pose.document
    skin = document.gltf.skins[index]
    standing = np.array([pose.worlds[joint] for joint in skin.joints]).reshape(-1, 4, 4)
    if skin.inverseBindMatrices is None:
        return standing
    columns = floats(document, skin.inverseBindMatrices, "MAT4")
    if len(columns) < len(standing):
        message = f"{len(columns)} inverse bind matrices for {len(standing)} joints"
        raise Malformed((f"skins[{index}].inverseBindMatrices", message))
    return product(standing, columns[: len(standing)].reshape(-1, 4, 4).transpose(0, 2, 1))


def _cofactors(matrices: Array) -> Array:
    """Return the cofactors (N, 3, 3), which transform normals, up to length, as the matrices transform surfaces."""
    a, b, c = np.moveaxis(matrices, 2, 0)  # columns
    return np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=2)
