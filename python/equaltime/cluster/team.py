"""Parts that the teams of all engines share: the scene as text, and units that are kept in a folder."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from equaltime.cluster.kept import KeptUnits
from equaltime.cluster.scene_text import SceneText
from equaltime.rendering.team import KeptUnit
from equaltime.rendering.units import Recipe, Rendered, Unit
from equaltime.scene import Scene

__all__ = ["CONNECT_SECONDS", "SceneTeam"]

CONNECT_SECONDS = 20
"""Seconds that a scheduler may take to answer before a render fails."""


class SceneTeam:
    """Base class of teams of processes for one scene.

    ``keep`` is the folder for finished units (windows of the film with some samples) until the render is saved; None
    keeps none.
    """

    def __init__(self, scene: Scene, keep: Path | None) -> None:
        """Write ``scene`` as text; raise SceneError if one of its files is missing or has changed."""
        self.scene = SceneText.of(scene)
        self._kept = None if keep is None else KeptUnits(keep, scene.digest)

    @property
    def way_on(self) -> str:
        """End of an error that tells how the render goes on."""
        return ", then repeat the render" + " with --resume" * (self._kept is not None)

    def keep(self, unit: Unit, rendered: Rendered) -> None:
        """Save a rendered unit (window of the film, some samples) in the folder for finished units, if there is one."""
        if self._kept is not None:
            self._kept.keep(unit, rendered)

    def kept(self, recipe: Recipe) -> Sequence[KeptUnit]:
        """Return the units (windows of the film with some samples) that an unfinished run of the same render saved.

        ``recipe`` identifies the render.
        """
        return () if self._kept is None else self._kept.of(recipe)

    def saved(self) -> None:
        """Delete all saved units (windows of the film), since a file of the whole render now contains their samples."""
        if self._kept is not None:
            self._kept.forget()
