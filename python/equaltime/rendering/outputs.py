"""Outputs of a scene beside the image: first hits, alpha, cost in rays and time, light by path length.

First hits come from `first_hits`. The other outputs are specific to this renderer, under the names that ``aov`` gives
them:

``alpha``           opacity of a pixel, in [0, 1]: the share of its paths that meet something. The environment and
                    emitters that the scene hides do not count; masks and null BSDFs count for the light they stop.
                    A film with alpha asks for it too; its channel is ``A``
``rays``            rays that a sample of the pixel takes, averaged over some samples; the same in each run
``time_from_rays``  seconds that the pixel took, of all threads: the render's time in proportion to the counted rays.
                    It is measured by a clock, so no two runs agree
``bounces``         the image by the length of the paths, in segments: ``NAME.1.R`` is emitted light seen directly,
                    ``NAME.2.R`` direct light; the last has all longer paths. Their sum is the image

They are made after the render, by separate paths: ``bounces`` costs about as much as the image.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import numpy as np
from numpy.typing import NDArray

from equaltime.rendering.core import alpha, make_renderer, split_light
from equaltime.rendering.first_hits import asked_for, first_hits
from equaltime.scene import Scene
from equaltime.scene.model import OUTPUTS, OWN_OUTPUTS
from equaltime.strategy import Strategy

__all__ = ["outputs"]

Planes = dict[str, NDArray[np.float32]]
COUNTED: Final = 16
"""Most samples per pixel for counting rays."""


def outputs(
    scene: Scene,
    rendered: Scene,
    strategy: Strategy,
    seed: int,
    threads: int,
    samples: int,
    seconds: float,
    asked: tuple[tuple[str, str], ...] | None = None,
) -> Planes:
    """Return the outputs beside the image that ``scene`` asks for: arrays (H, W) by the full names of their channels.

    Parameters
    ----------
    rendered
        Scene without the effects that were left out.
    samples
        Samples per pixel of the render.
    seconds
        Seconds that all threads of the render worked, added up.
    asked
        Pairs (name, kind) of the outputs to make; None for all that the scene asks for.
    """
    asked = asked_for(scene) if asked is None else asked
    kinds = {kind for _, kind in asked}
    seen = first_hits(scene, asked, threads)
    counts = kinds & {"rays", "time_from_rays"}
    rays = _rays(rendered, strategy, seed, threads, min(samples, COUNTED)) if counts else None
    bounces = _bounces(rendered, strategy, seed, threads, samples) if "bounces" in kinds else {}
    opaque = alpha(rendered, strategy, seed, threads, samples) if "alpha" in kinds else None
    found: Planes = {}
    for name, kind in asked:
        if kind in OUTPUTS:
            found |= {f"{name}.{letter}": seen[f"{name}.{letter}"] for letter in OUTPUTS[kind]}
        elif kind == "bounces":
            found |= {f"{name}.{ending}": plane for ending, plane in bounces.items()}
        elif kind == "alpha" and opaque is not None:
            found[f"{name}.A".lstrip(".")] = opaque
        elif rays is not None:
            share = 1.0 if kind == "rays" else seconds / rays.sum()
            found[f"{name}.{OWN_OUTPUTS[kind]}"] = (share * rays).astype(np.float32)
    return found


def _rays(scene: Scene, strategy: Strategy, seed: int, threads: int, samples: int) -> NDArray[np.float64]:
    """Return the number of rays that a sample of each pixel takes (H, W)."""
    plain = strategy.model_copy(update={"adaptive": "none"})  # the same number of samples in each pixel
    renderer = make_renderer(scene, plain, seed, threads, pixel_rays=True)
    renderer.advance(samples)
    return renderer.pixel_rays.astype(np.float64) / samples


def _bounces(
    scene: Scene, strategy: Strategy, seed: int, threads: int, samples: int
) -> Mapping[str, NDArray[np.float32]]:
    """Return the light of paths of each length, up to the longest possible, by the endings of their channels."""
    _, parts = split_light(scene, strategy, seed, threads, samples, only_lengths=True)
    lengths = np.moveaxis(parts, 2, 0)
    longest = len(lengths) if scene.max_depth == -1 else min(scene.max_depth, len(lengths))
    return {
        f"{number}.{letter}": part[..., channel]
        for number, part in enumerate(lengths[:longest], 1)
        for channel, letter in enumerate("RGB")
    }
