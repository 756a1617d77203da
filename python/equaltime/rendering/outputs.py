"""Outputs of a scene beside the image: first hits, alpha, cost in rays and time, light by path length.

First hits (`first_hits`) are distance, position, normals, colour, shape and texture coordinates, and derivatives of
them, as Mitsuba's integrators ``aov`` and ``depth`` ask for. A pixel's value is the mean over a grid of points on the
pixel, whatever the reconstruction filter. Rays go through the middle of a lens. Points whose rays hit no surface count
as 0.

The other outputs are specific to this renderer, under the names that ``aov`` gives them:

``alpha``           opacity of a pixel, in [0, 1]: the share of its paths that meet something. The environment and
                    emitters that the scene hides do not count; masks and null BSDFs count for the light they stop.
                    A film with alpha asks for it too; its channel is ``A``
``rays``            rays that a sample of the pixel takes, averaged over some samples; the same in each run
``time_from_rays``  seconds that the pixel took, of all threads: the render's time in proportion to the counted rays.
                    It is measured by a clock, so no two runs agree
``bounces``         the image by the length of the paths, in segments: ``NAME.1.R`` is emitted light seen directly,
                    ``NAME.2.R`` direct light; the last has all longer paths. Their sum is the image

These are made after the render, by separate paths: ``bounces`` costs about as much as the image.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Final

import numpy as np
from numpy.typing import NDArray

from equaltime.machine import worker_threads
from equaltime.rendering.core import alpha, make_renderer, split_light
from equaltime.scene import Scene
from equaltime.scene.model import OUTPUTS, OWN_OUTPUTS, Aov, Depth, Orthographic, Perspective, Spherical
from equaltime.scene.motion import center, pose
from equaltime.strategy import Strategy

__all__ = ["asked_for", "first_hits", "outputs"]

Array = NDArray[np.float64]
Planes = dict[str, NDArray[np.float32]]
COUNTED: Final = 16
"""Largest number of samples per pixel for which rays are counted, for the outputs ``rays`` and ``time_from_rays``."""
SIDE: Final = 2
"""Number of camera rays along each side of a pixel, in the grid whose first hits are averaged."""
BLOCK: Final = 1 << 16
"""Number of pixels whose camera rays are in memory at once."""
FOUND: Final = {
    **{"albedo": "albedo", "depth": "t", "position": "p", "uv": "uv", "geo_normal": "n", "sh_normal": "shading_normal"},
    **{"shape_index": "shape", "prim_index": "primitive", "dp_du": "dp_du", "dp_dv": "dp_dv"},
    **{"duv_dx": "duv_dx", "duv_dy": "duv_dy"},
}
STEPS: Final = {"duv_dx": (1.0, 0.0), "duv_dy": (0.0, 1.0)}
"""Neighbour whose difference gives each derivative of the texture coordinates, as an offset (x, y) in pixels."""


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
    scene
        The user's scene.
    rendered
        Scene that was rendered: without the effects (features such as media) that were left out.
    strategy, seed
        Strategy and seed of the render.
    threads
        Number of threads; 0 is one for each processor.
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


def asked_for(scene: Scene) -> tuple[tuple[str, str], ...]:
    """Return the outputs beside the image that the scene asks for, as pairs (name, kind): ("distance", "depth").

    If the film asks for alpha, the last pair is ("", "alpha").
    """
    integrator = scene.model.integrator
    channels = integrator.channels if isinstance(integrator, Aov | Depth) else ()
    return (*channels, ("", "alpha")) if scene.model.sensor.film.has_alpha else channels


def first_hits(
    scene: Scene, asked: tuple[tuple[str, str], ...] | None = None, threads: int = 0
) -> dict[str, NDArray[np.float32]]:
    """Return images of the surfaces that camera rays hit first: depth, position, normal, albedo and the like.

    The images are arrays (H, W) by the full names of their channels, such as ``distance.T``. ``asked`` holds pairs
    (name, kind) of outputs; None stands for the outputs that the scene asks for. Kinds that need more than the first
    hit are ignored. ``threads`` is the number of threads; 0 is one for each processor.
    """
    outputs = tuple(pair for pair in (asked_for(scene) if asked is None else asked) if pair[1] in OUTPUTS)
    if not outputs:
        return {}
    _, _, width, height = scene.model.sensor.film.crop
    names = [f"{name}.{letter}" for name, kind in outputs for letter in OUTPUTS[kind]]
    pixels = np.concatenate([_means(scene, outputs, corners, threads) for corners in _corners(scene)])
    return dict(zip(names, np.moveaxis(pixels.reshape(height, width, -1), -1, 0).astype(np.float32), strict=True))


def _corners(scene: Scene) -> Iterator[Array]:
    """Iterate over the upper left corners of the pixels of the crop window, row by row, in blocks (N, 2)."""
    x, y, width, height = scene.model.sensor.film.crop
    for start in range(0, width * height, BLOCK):
        index = np.arange(start, min(start + BLOCK, width * height))
        yield np.stack([x + index % width, y + index // width], axis=1).astype(np.float64)


def _means(scene: Scene, outputs: tuple[tuple[str, str], ...], corners: Array, threads: int) -> Array:
    """Return the mean of each channel over the points of each pixel (N, channels)."""
    kinds = {kind for _, kind in outputs}
    needed = {"shape", "t", "front"} | {FOUND[kind] for kind in kinds - set(STEPS)}
    needed |= {"p", "n", "dp_du", "dp_dv"} if kinds & set(STEPS) else set()
    sums: Array = np.zeros((len(corners), sum(len(OUTPUTS[kind]) for _, kind in outputs)))
    for i in range(SIDE * SIDE):
        places = corners + (np.array([i % SIDE, i // SIDE]) + 0.5) / SIDE
        origins, directions, reach = _first_rays(scene, places)
        hits = scene.core.intersect(origins, directions, only=needed, threads=worker_threads(threads))
        hits |= {
            name: _uv_step(hits, *_first_rays(scene, places + step)[:2])
            for name, step in STEPS.items()
            if name in kinds
        }
        seen = (hits["shape"] >= 0) & (hits["t"] <= reach)
        side = np.where(hits["front"], 1.0, -1.0)[:, None]  # normals are on the front side
        hits |= {name: side * hits[name] for name in ("n", "shading_normal") if name in hits}
        columns = [np.asarray(hits[FOUND[kind]], dtype=np.float64).reshape(len(corners), -1) for _, kind in outputs]
        sums[seen] += np.concatenate(columns, axis=1)[seen]
    return sums / SIDE**2


def _uv_step(hits: Mapping[str, Array], origins: Array, directions: Array) -> Array:
    """Return the offsets (N, 2) in texture coordinates where other rays meet the tangent planes of `hits`; else 0."""
    p, n, du, dv = (hits[name] for name in ("p", "n", "dp_du", "dp_dv"))

    def dot(a: Array, b: Array) -> Array:
        return np.asarray((a * b).sum(axis=1))

    with np.errstate(divide="ignore", invalid="ignore"):
        step = origins + (dot(n, p - origins) / dot(n, directions))[:, None] * directions - p
        uu, uv, vv, u, v = dot(du, du), dot(du, dv), dot(dv, dv), dot(du, step), dot(dv, step)
        solved = np.stack([vv * u - uv * v, uu * v - uv * u], axis=1) / (uu * vv - uv * uv)[:, None]
    return np.where(np.isfinite(solved), solved, 0.0)


def _first_rays(scene: Scene, places: Array) -> tuple[Array, Array, Array]:
    """Return origins, directions and lengths of the rays through `places` (N, 2), in pixels of the whole film.

    Origins are on the near plane, where Mitsuba's distances begin.
    """
    sensor = scene.model.sensor
    width, height = sensor.film.size
    offset = (0.0, 0.0)
    if isinstance(sensor, Perspective):
        offset = (sensor.principal_point_offset_x, sensor.principal_point_offset_y)
    if isinstance(sensor, Spherical):
        return _all_around(sensor, places / (width, height))
    x, y = (1.0 - 2.0 * (places / (width, height) + offset)).T
    y *= height / width
    to_world, near = pose(sensor.to_world, center(sensor)), sensor.near_clip or 0.0
    if isinstance(sensor, Orthographic):
        origins = np.stack([x, y, np.full_like(x, near)], axis=1)
        directions = np.broadcast_to([0.0, 0.0, 1.0], origins.shape)
    else:
        half = math.tan(math.radians(sensor.x_fov) / 2.0)
        directions = np.stack([half * x, half * y, np.ones_like(x)], axis=1)
        origins = near * directions
    linear = to_world[:3, :3].T
    directions = directions @ linear
    reach = ((sensor.far_clip or math.inf) - near) * np.sqrt((directions**2).sum(axis=1))
    return origins @ linear + to_world[:3, 3], directions, reach


def _all_around(sensor: Spherical, places: Array) -> tuple[Array, Array, Array]:
    """Return the rays of a camera that looks everywhere, as `_first_rays` does; `places` are in [0, 1) of the film."""
    phi, theta = 2.0 * np.pi * places[:, 0], np.pi * places[:, 1]
    local = np.stack([np.sin(phi) * np.sin(theta), np.cos(theta), -np.cos(phi) * np.sin(theta)], axis=1)
    to_world, near = pose(sensor.to_world, center(sensor)), sensor.near_clip or 0.0
    directions = local @ to_world[:3, :3].T
    reach = np.full(len(places), (sensor.far_clip or math.inf) - near)
    return near * directions + to_world[:3, 3], directions, reach
