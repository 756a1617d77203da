"""How the nodes of a glTF file stand and its meshes are bent: as the file has them, or at a time of an animation."""

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
    """One moment of a file."""

    document: Document
    clip: Clip | None = None
    """An animation of one time; None: all stands as in the file."""

    @cached_property
    def worlds(self) -> dict[int, NDArray[np.float64]]:
        """Where each node is (4, 4)."""
        return {at.index: at.to_world for at in placed(self.document, None, self.clip, hidden=True)}

    def weights(self, mesh: int, node: int | None) -> Any:
        """Return the weights of the morph targets of a mesh, in a node that may have its own."""
        nodes = self.document.gltf.nodes
        own = None if node is None else nodes[node].weights
        if node is not None and self.clip is not None:
            own = self.clip.fields(node, self.clip.times[0]).get("weights", own)
        return (self.document.gltf.meshes[mesh].weights or ()) if own is None else own


def at_time(document: Document, animation: int, time: float) -> Pose:
    """Return the pose at a time, in seconds, of an animation; raises `Malformed` if there is none."""
    if animation >= len(document.gltf.animations) or not math.isfinite(time):
        raise Malformed((f"animations[{animation}]", f"there is no such animation, or no time {time}"))
    return Pose(document, played(document, animation, (time, time)))
