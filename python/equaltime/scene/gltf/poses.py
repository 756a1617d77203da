"""Poses of a glTF file: transforms of nodes and weights of morph targets.

A pose is either stored in the file, or taken from an animation at one time.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from equaltime.scene.gltf.animations import Clip, played
from equaltime.scene.gltf.document import Document, Malformed
from equaltime.scene.gltf.nodes import placed

__all__ = ["Pose", "at_time"]


@dataclass(frozen=True, eq=False)
class Pose:
    """Pose of a glTF file at one moment: the transforms of its nodes and the weights of its morph targets."""

    document: Document
    clip: Clip | None = None
    """Animation at a single time; None for the pose stored in the file."""

    @cached_property
    def worlds(self) -> dict[int, NDArray[np.float64]]:
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
    """Return the pose of animation `animation` at `time`, in seconds.

    Raises `Malformed` if the animation does not exist or the time is not finite.
    """
    if animation >= len(document.gltf.animations) or not math.isfinite(time):
        raise Malformed((f"animations[{animation}]", f"there is no such animation, or no time {time}"))
    return Pose(document, played(document, animation, (time, time)))
