"""Names for two types of the core (the renderer in C++): its scene, and the `equaltime._core.SceneBuilder` for it."""

from __future__ import annotations

from equaltime._core import Scene as CoreScene
from equaltime._core import SceneBuilder as Builder

__all__ = ["Builder", "CoreScene"]
