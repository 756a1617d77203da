"""The type of the core's scene builder; see `equaltime._core.SceneBuilder` for its calls."""

from __future__ import annotations

from equaltime._core import Scene as CoreScene
from equaltime._core import SceneBuilder as Builder

__all__ = ["Builder", "CoreScene"]
