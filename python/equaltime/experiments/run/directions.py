"""Ray directions on a surface, drawn uniformly and from the surface's BSDF, with their weights.

The surface is in the middle of a scene's picture. Directions are in the surface's local frame, z along the normal. BSDF
directions are samples of the C++ core, and the core's BSDF gives the weights of uniform directions.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from equaltime._core import parts
from equaltime.experiments.run.folder import read_arrays, replacing
from equaltime.scene import Scene
from equaltime.scene.motion import center, pose

__all__ = ["Rays", "read_directions", "sample_directions", "write_directions"]

Floats = NDArray[np.float64]

WO = np.array([np.sin(np.radians(45.0)), 0.0, np.cos(np.radians(45.0))])
"""Direction towards the viewer in the surface's frame (z along the normal), 45 degrees from the normal."""
SAMPLES = 4096
DRAWN = 120
"""Number of rays that the picture shows; `Rays.effective` is computed from all `SAMPLES` rays."""


@dataclass(frozen=True, eq=False)
class Rays:
    """Ray directions that one technique, ``uniform`` or ``bsdf``, draws on one surface, with weights, for a picture."""

    wi: Floats
    """Unit vectors of the rays, (DRAWN, 3), in the surface's frame: z is along the normal."""
    weight: Floats
    """Weight of each direction under a white sky (DRAWN,): BSDF times cosine over density, mean of RGB."""
    effective: float
    """Effective share of the samples under a white sky, E[w]² / E[w²]: 1 if all weights are equal. NaN for a mirror."""


def sample_directions(scene: Scene) -> dict[str, Rays] | None:
    """Return rays that uniform and BSDF sampling draw on the surface in the middle of the picture, by technique.

    Techniques are named ``uniform`` and ``bsdf``. Returns None if there is no surface or if it scatters no light.
    """
    middle = _in_the_middle(scene)
    if middle is None:
        return None
    random = np.random.default_rng(1)
    wo = np.broadcast_to(WO, (SAMPLES, 3))
    try:
        drawn = parts.sample_bsdf(middle.core, 0, wo, random.random((SAMPLES, 3)))
    except ValueError:  # the core has no BSDF for a surface that absorbs everything
        return None
    carried = np.where(drawn["valid"], drawn["weight"].mean(axis=1), 0.0)
    if drawn["delta"].any():
        rays = Rays(drawn["wi"][:DRAWN], carried[:DRAWN], float("nan"))
        return {"uniform": rays, "bsdf": rays}  # with a discrete BSDF both techniques choose from the same directions
    wi, density = _uniform(random, whole=bool((drawn["wi"][:, 2] < 0.0).any()))
    uniform = _light(middle, wi) / density
    # second moment of uniform samples, estimated from BSDF samples: few uniform samples would hit a narrow lobe
    moment = float(np.mean(carried * np.where(drawn["valid"], _light(middle, drawn["wi"]), 0.0)) / density)
    albedo = float(carried.mean())
    if albedo == 0.0:
        return None
    return {
        "uniform": Rays(wi[:DRAWN], uniform[:DRAWN], albedo**2 / moment),
        "bsdf": Rays(drawn["wi"][:DRAWN], carried[:DRAWN], albedo**2 / float(np.square(carried).mean())),
    }


def write_directions(path: Path, names: Sequence[str], scenes: Sequence[Scene]) -> None:
    """Sample ray directions on every scene, and write all directions to an ``.npz`` file.

    ``names`` are the names of ``scenes``, in the same order.
    """
    found = {name: sample_directions(scene) for name, scene in zip(names, scenes, strict=True)}
    known = {name: rays for name, rays in found.items() if rays is not None}
    ways = [rays[way] for rays in known.values() for way in ("uniform", "bsdf")]
    with replacing(path) as file:
        np.savez_compressed(
            file,
            names=np.array(list(known), dtype=np.str_),
            wi=np.array([way.wi for way in ways]).reshape(-1, 2, DRAWN, 3),
            weight=np.array([way.weight for way in ways]).reshape(-1, 2, DRAWN),
            effective=np.array([way.effective for way in ways]).reshape(-1, 2),
        )


def read_directions(path: Path) -> Mapping[str, Mapping[str, Rays]]:
    """Read ray directions from an ``.npz`` file, and return the rays by name of the scene and then by technique.

    `write_directions` writes the file. Raises `ImageError` if the file cannot be read.
    """
    names, wi, weight, effective = read_arrays(path, ("names", "wi", "weight", "effective"))
    return {
        str(name): {
            way: Rays(wi[i, j], weight[i, j], float(effective[i, j])) for j, way in enumerate(("uniform", "bsdf"))
        }
        for i, name in enumerate(names)
    }


def _light(scene: Scene, wi: Floats) -> Floats:
    """Return BSDF times cosine, mean of RGB, for directions (N, 3)."""
    value: Floats = parts.eval_bsdf(scene.core, 0, np.broadcast_to(WO, wi.shape), wi)["f"].mean(axis=1)
    return value


def _uniform(random: np.random.Generator, whole: bool) -> tuple[Floats, float]:
    """Return uniform directions over the hemisphere or the whole sphere, and their density per steradian."""
    z = random.random(SAMPLES)
    phi = 2.0 * np.pi * random.random(SAMPLES)
    z = 2.0 * z - 1.0 if whole else z
    r = np.sqrt(1.0 - z**2)
    return np.stack([r * np.cos(phi), r * np.sin(phi), z], axis=1), (0.25 if whole else 0.5) / np.pi


def _in_the_middle(scene: Scene) -> Scene | None:
    """Return a scene with only the shape in the middle of the picture; None if no shape with a BSDF is there."""
    to_world = pose(scene.model.sensor.to_world, center(scene.model.sensor))
    hit = scene.core.intersect(to_world[None, :3, 3], to_world[None, :3, 2])
    number = int(hit["shape"][0])
    shapes = scene.model.shapes[number : number + 1] if np.isfinite(hit["t"][0]) else ()
    if not shapes or getattr(shapes[0], "bsdf", None) is None:
        return None
    model = scene.model.model_copy(update={"shapes": shapes, "emitters": ()})
    return Scene(model, None, scene.assets)
