"""Rendered units that are kept in files beside OUT.exr until a saved film has them.

A render that is killed between two checkpoints loses nothing that is finished: when it is resumed, it takes these units
instead of rendering them again. A file holds one unit; its name tells the render, the sample counts and the window.
"""

from __future__ import annotations

import hashlib
import json
import re
import shutil
import zipfile
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from equaltime.errors import ImageError
from equaltime.files import replacing
from equaltime.rendering.units import Recipe, Rendered, Unit, Window
from equaltime.strict_json import json_text

__all__ = ["KeptUnits"]

_NAME = re.compile(r"([0-9a-f]{16})_(\d+)_(\d+)_(\d+)_(\d+)_(\d+)_(\d+)\.npz")
_ARRAYS = ("moments", "second", "pixel_rays")
_FACTS = ("counters", "nonfinite", "faulty", "seconds", "core_seconds", "threads", "process")


@dataclass(frozen=True)
class _KeptUnit:
    path: Path
    window: Window
    begin: int
    end: int

    def read(self) -> Rendered | None:
        """Return the unit; None if its file is damaged."""
        try:
            with self.path.open("rb") as file, np.load(file, allow_pickle=False) as found:
                facts: dict[str, Any] = json.loads(str(found["facts"]))
                arrays: dict[str, Any] = {name: found[name] if name in found.files else None for name in _ARRAYS}
        except (OSError, EOFError, ValueError, KeyError, zipfile.BadZipFile):
            return None
        facts |= {name: tuple(map(tuple, facts[name])) for name in ("nonfinite", "faulty")}
        return Rendered(**arrays, **facts)


class KeptUnits:
    """Folder of finished units of one scene's renders, so that a killed render does not lose them.

    A unit is a window of the film with its samples between two counts. The folder exists only while there are units in
    it.
    """

    def __init__(self, folder: Path, digest: str) -> None:
        """Use ``folder`` for the units of the scene whose content has the SHA-256 ``digest``."""
        self._folder, self._digest = folder, digest

    def keep(self, unit: Unit, rendered: Rendered) -> None:
        """Write ``unit`` with its pixels and their samples, ``rendered``, to a file in the folder.

        Raises ImageError if the file cannot be written.
        """
        numbers = "_".join(map(str, (unit.begin, unit.end, *unit.window)))
        arrays: dict[str, Any] = {name: getattr(rendered, name) for name in _ARRAYS}
        facts = json_text({name: getattr(rendered, name) for name in _FACTS})
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
            with replacing(self._folder / f"{self._key(unit.recipe)}_{numbers}.npz") as part, part.open("wb") as file:
                np.savez(file, facts=facts, **{name: array for name, array in arrays.items() if array is not None})
        except OSError as error:
            raise ImageError(f"{self._folder}: finished units cannot be kept: {error.strerror or error}") from error

    def of(self, recipe: Recipe) -> list[_KeptUnit]:
        """Return the units (windows of the film with some samples) in the folder that belong to one render.

        ``recipe`` identifies the render: strategy, seed and build.
        """
        key, found = self._key(recipe), []
        for path in sorted(self._folder.glob("*.npz")):
            if (name := _NAME.fullmatch(path.name)) and name[1] == key:
                begin, end, x0, y0, x1, y1 = map(int, name.groups()[1:])
                found.append(_KeptUnit(path, (x0, y0, x1, y1), begin, end))
        return found

    def forget(self) -> None:
        """Delete the folder with all its units, once a file of the whole render contains their samples."""
        shutil.rmtree(self._folder, ignore_errors=True)

    def _key(self, recipe: Recipe) -> str:
        text = json_text([self._digest, asdict(recipe)], sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:16]
