"""Work of one process of a cluster: `render_unit`, and the probe that tells whether the process makes the same bits."""

from __future__ import annotations

import hashlib
import json

import numpy as np

from equaltime.cluster.scene_text import SceneText, scene_of
from equaltime.errors import RenderError
from equaltime.film.moments import DTYPE
from equaltime.rendering.core import REPLICATES, build_info
from equaltime.rendering.units import BLOCK, Recipe, Rendered, Unit, add_samples
from equaltime.scene import Scene
from equaltime.strict_json import json_text

__all__ = ["bits", "probe_unit", "render_unit"]

_PROBE = "best,roulette=throughput,adaptive=none"
_NAMES = {"embree_isa": "instructions of Embree", "target": "instructions of the core"}


def render_unit(scene: SceneText | str, unit: Unit, threads: int = 0) -> Rendered:
    """Render a unit (a window of the film, some samples) in this process, and return it with its samples.

    Parameters
    ----------
    scene
        Text of the scene, which is loaded at the first call; or the digest of a scene that was loaded here before.
    unit
        A window of the film, its moments (count, mean, deviation of each pixel's samples) so far, and the sample counts
        at the unit's begin and end.
    threads
        Number of threads; 0 is one for each processor.

    Returns
    -------
    Rendered
        The window's moments with the samples added; their bits do not depend on the process.

    Raises
    ------
    RenderError
        If the process would give other bits, does not have the scene, or if its files have other contents here.
    SceneError
        If the scene or a file cannot be read.
    """
    if unlike := _differences(json.loads(unit.recipe.build)):
        raise RenderError(f"a process of the cluster gives other bits ({unlike})")
    return add_samples(scene_of(scene) if isinstance(scene, str) else scene.load(), unit, threads)


def probe_unit(scene: Scene) -> Unit:
    """Return a small unit of ``scene``, whose result shows whether another process gives the same bits as this one.

    The unit is the first two samples of each pixel in one block in the middle of the film.
    """
    _, _, width, height = scene.model.sensor.film.crop
    x0, y0 = (side // 2 // BLOCK * BLOCK for side in (width, height))
    x1, y1 = min(x0 + BLOCK, width), min(y0 + BLOCK, height)
    recipe = Recipe(_PROBE, 0, REPLICATES, 0, False, "ignore", json_text(build_info(), sort_keys=True))
    nothing = np.zeros((REPLICATES, y1 - y0, x1 - x0), DTYPE)
    return Unit(recipe, (x0, y0, x1, y1), 0, 2, nothing, nothing[:, :0, :0], None)


def bits(rendered: Rendered) -> str:
    """Return the SHA-256 of rendered pixels (counts, means, deviations), to compare the bits of two processes."""
    return hashlib.sha256(rendered.moments.tobytes()).hexdigest()


def _differences(there: dict[str, str]) -> str:
    """Return what this process has otherwise than the build and processor ``there``; empty if nothing."""
    here = build_info()
    names = [name for name in here if here[name] != there.get(name)]
    return "; ".join(f"{_NAMES.get(name, name)}: {here[name]}, not {there.get(name)}" for name in names)
