"""The estimator: paths from the camera, traced together, with light and BSDF sampling combined.

Each row of the arrays is a path. A step extends all paths by one surface; paths that end are dropped.
"""

from __future__ import annotations

import time as clock
from dataclasses import dataclass
from typing import Final

import numpy as np

from equaltime.crosscheck import scattering
from equaltime.crosscheck.camera import Camera, camera_of, filter_offsets
from equaltime.crosscheck.lights import Lights
from equaltime.crosscheck.vectors import Array, Frames, Index, Mask, dot
from equaltime.crosscheck.world import Hits, World
from equaltime.errors import RenderError
from equaltime.film.error import PixelStatistics
from equaltime.rendering.result import Result, Stats, make_result
from equaltime.rendering.session import origin_of
from equaltime.revision import revision
from equaltime.scene import Scene, geometry
from equaltime.scene import model as m
from equaltime.scene.model import Bsdf, SceneModel, Sensor
from equaltime.scene.motion import at_time, moves, still

__all__ = ["Tracer", "check", "render", "render_result"]

PATHS_AT_ONCE = 1 << 16
OCCLUDER = 1.0 - 1e-9
"""Share of a shadow ray's length in which a hit occludes; a hit beyond it is the light itself."""
NEGLIGIBLE = 1e-12
"""Throughput at which paths without a depth limit end, too small to be visible in an image."""
ENDLESS = 100_000
TRACED: Final = (
    *(m.SceneModel, m.Perspective, m.HdrFilm, m.Box, m.Tent, m.Gaussian, m.Independent, m.Stratified, m.MultiJitter),
    *(m.Orthogonal, m.LdSampler, m.Path, m.Direct, m.Moment, m.Rectangle, m.Disk, m.Cube, m.Sphere, m.Ply, m.Obj),
    *(m.Diffuse, m.Conductor, m.RoughConductor, m.Dielectric, m.ThinDielectric, m.RoughDielectric, m.Plastic),
    *(m.RoughPlastic, m.Principled, m.TwoSided, m.Area, m.Point, m.Constant, m.EnvMap),
)


def render(scene: Scene, spp: int, seed: int = 0, size: tuple[int, int] | None = None) -> tuple[Array, Array]:
    """Render a scene with `spp` samples per pixel by the cross-check, a slow second renderer, to test the C++ core.

    Parameters
    ----------
    scene
        A loaded scene.
    spp
        Samples per pixel, all independent.
    seed
        Seed of all random numbers. The image follows from the seed, the scene, `spp` and `size`.
    size
        Width and height in pixels; by default the scene's own.

    Returns
    -------
    mean, variance
        Two (H, W, 3) arrays: radiance per pixel of the crop window, and the estimated variance of that mean (NaN for a
        single sample). Both are unbiased. If the scene moves, all pixels share the times of their samples, so that
        their errors are correlated.

    Raises
    ------
    RenderError
        If a path does not end, or a sample is not finite.
    """
    scene = scene if size is None else scene.with_(size=size)
    moving = any(moves(node, scene.model.sensor) for node in (*scene.model.shapes, scene.model.sensor))
    tracer = Tracer(scene.replaced(still(scene.model)))
    rng = np.random.Generator(np.random.Philox(seed))
    pixels = tracer.camera.pixels()
    mean, squares, done = np.zeros((len(pixels), 3)), np.zeros((len(pixels), 3)), 0
    while done < spp:
        count = 1 if moving else min(spp - done, max(1, PATHS_AT_ONCE // len(pixels)))
        if moving:  # brute force: a new still scene for each sample
            tracer = Tracer(scene.replaced(at_time(scene.model, _any_time(scene.model.sensor, rng))))
        radiance = tracer.sample(np.tile(pixels, (count, 1)), rng).reshape(count, len(pixels), 3)
        for one in radiance:  # Welford's algorithm for mean and squared deviations
            done += 1
            change = one - mean
            mean += change / done
            squares += change * (one - mean)
    shape = (*tracer.film_shape, 3)
    variance = squares / (spp * (spp - 1)) if spp > 1 else np.full_like(squares, np.nan)
    return mean.reshape(shape), variance.reshape(shape)


def render_result(scene: Scene, spp: int, seed: int) -> Result:
    """Render a scene by the cross-check with ``spp`` samples per pixel; return the image with its error."""
    begin = clock.perf_counter()
    mean, variance = render(scene, spp=spp, seed=seed)
    seconds = clock.perf_counter() - begin
    samples = np.full(mean.shape[:2], spp, np.int64)
    pixels = PixelStatistics(mean, variance, samples, degrees=float(max(spp - 1, 1)))
    stats = Stats(
        phases={**scene.timings, "render": seconds},
        paths=samples.size * spp,
        rays=0,
        shadow_rays=0,
        kernel="crosscheck",
        threads=1,
        revisions=(revision(),),
    )
    return make_result(pixels, stats, "spp", origin_of(scene, "crosscheck", False, seed, spp, "embreex"))


def _any_time(sensor: Sensor, rng: np.random.Generator) -> float:
    return sensor.shutter_open + rng.random() * (sensor.shutter_close - sensor.shutter_open)


def check(model: SceneModel) -> None:
    """Raise RenderError if the cross-check cannot trace the scene `model`.

    The error names all plugins and settings of the scene that the cross-check lacks.
    """
    unknown = {f"'{node.title}'" for node in model.nodes() if not isinstance(node, TRACED)}
    unknown |= {"'priority'" for shape in model.shapes if getattr(shape, "priority", None) is not None}
    unknown |= {"'hide_emitters'"} if model.integrator.hides_emitters else set()
    unknown |= {"'max_depth' of 0"} if model.integrator.max_depth == 0 else set()
    if unknown:
        raise RenderError(f"the cross-check cannot trace {', '.join(sorted(unknown))}")


@dataclass(slots=True, eq=False)
class _Rays:
    """Current segments of the paths: rays to the next surface."""

    path: Index
    """Indices of the paths (n,)."""
    origin: Array
    direction: Array
    start: Index
    """Patches that the rays leave (n,); -1 for none."""
    beta: Array
    """Throughput (n, 3): the product of all weights so far."""
    pdf: Array
    """Density of the direction per solid angle (n,); infinite if light sampling could not have found the direction."""

    def keep(self, rows: Mask) -> _Rays:
        return _Rays(*(getattr(self, name)[rows] for name in self.__slots__))


class Tracer:
    """A scene prepared for tracing paths: camera, surfaces, lights and BSDFs."""

    def __init__(self, scene: Scene) -> None:
        model = scene.model
        check(model)
        surfaces = tuple(geometry.surfaces(model, scene.assets))
        self.camera = Camera(camera_of(model))
        self.world = World(model, scene.assets)
        self.film_shape = model.sensor.film.crop[3], model.sensor.film.crop[2]
        self._filter = model.sensor.film.rfilter
        self._lights = Lights(model, surfaces, self.world, scene.assets)
        self._max_depth = scene.max_depth
        sides = [(surface.sides.front, surface.sides.back) for surface in surfaces]
        self._bsdfs = list(dict.fromkeys(bsdf for pair in sides for bsdf in pair if bsdf is not None))
        number = {bsdf: index for index, bsdf in enumerate(self._bsdfs)}
        self._bsdf_of = np.array([[-1 if b is None else number[b] for b in pair] for pair in sides]).reshape(-1, 2)

    def sample(self, pixels: Array, rng: np.random.Generator) -> Array:
        """Trace one path per row of `pixels`, and return the radiance of each (N, 3).

        `pixels` (N, 2) are the upper left corners of pixels; a pixel may occur in several rows.
        """
        radiance = np.zeros((len(pixels), 3))
        rays, far = self._camera_rays(pixels, rng)
        depth = 0
        while rays.path.size:
            depth += 1
            t, patch = self.world.intersect(rays.origin, rays.direction, rays.start)
            if depth == 1:
                t, patch = np.where(t <= far, t, np.inf), np.where(t <= far, patch, -1)
            missed = patch < 0
            radiance[rays.path[missed]] += self._from_environment(rays.keep(missed))
            rays = rays.keep(~missed)
            hits = self.world.hits(rays.origin, rays.direction, t[~missed], patch[~missed])
            radiance[rays.path] += self._from_surfaces(rays, hits)
            if depth == self._max_depth:
                break
            if depth > ENDLESS:
                raise RenderError(f"a path is longer than {ENDLESS} surfaces: give the scene a max_depth")
            rays = self._scatter(rays, hits, radiance, rng)
        if not np.isfinite(radiance).all():
            raise RenderError("the cross-check made a sample that is not finite")
        return radiance

    def _camera_rays(self, pixels: Array, rng: np.random.Generator) -> tuple[_Rays, Array]:
        """Return rays from the near plane, and the distances (N,) from there to the far plane."""
        n = len(pixels)
        directions, near, far = self.camera.rays(pixels + 0.5 + filter_offsets(self._filter, n, rng))
        origins = self.camera.origin + near[:, None] * directions
        rays = _Rays(np.arange(n), origins, directions, np.full(n, -1), np.ones((n, 3)), np.full(n, np.inf))
        return rays, far - near

    def _from_environment(self, rays: _Rays) -> Array:
        if self._lights.environment is None:
            return np.zeros_like(rays.beta)
        found = self._lights.environment.radiance(rays.direction)
        return rays.beta * found * _share(rays.pdf, self._lights.environment_pdf(rays.direction))

    def _from_surfaces(self, rays: _Rays, hits: Hits) -> Array:
        found = self._lights.emitted(hits, rays.direction)
        return rays.beta * found * _share(rays.pdf, self._lights.surface_pdf(hits, rays.direction))

    def _scatter(self, rays: _Rays, hits: Hits, radiance: Array, rng: np.random.Generator) -> _Rays:
        """Add direct light at the hits to `radiance`, and return the rays that continue from the hits."""
        front = dot(hits.normal, rays.direction) < 0.0
        bsdf = self._bsdf_of[self.world.shape[hits.patch], np.where(front, 0, 1)]
        following: list[_Rays] = []
        for number, model in enumerate(self._bsdfs):
            rows = bsdf == number
            if rows.any():
                here = _Place.at(rays.keep(rows), hits, rows, front[rows])
                if not scattering.is_single(model):
                    radiance[here.rays.path] += self._direct(here, model, rng)
                following.append(self._continue(here, model, rng))
        if not following:
            return rays.keep(np.zeros(len(front), np.bool_))
        return _Rays(*(np.concatenate([getattr(f, name) for f in following]) for name in _Rays.__slots__))

    def _direct(self, here: _Place, model: Bsdf, rng: np.random.Generator) -> Array:
        """Return the contribution (n, 3) of one randomly chosen light to each path."""
        light = self._lights.sample(here.point, rng)
        wi = here.frames.to_local(light.wi)
        value, pdf = scattering.evaluate(model, here.wo, wi, here.front)
        value *= here.same_side(light.wi, wi)[:, None]
        seen = np.flatnonzero(value.any(axis=1) & light.radiance.any(axis=1))
        t, _ = self.world.intersect(here.point[seen], light.wi[seen], here.patch[seen])
        seen = seen[t >= OCCLUDER * light.distance[seen]]
        added = np.zeros_like(value)
        share = 1.0 / (light.pdf + pdf * (1.0 - light.single))  # the balance heuristic's weight over the density
        added[seen] = (here.rays.beta * value * light.radiance * share[:, None])[seen]
        return added

    def _continue(self, here: _Place, model: Bsdf, rng: np.random.Generator) -> _Rays:
        scattered = scattering.sample(model, here.wo, here.front, rng)
        wi = here.frames.to_world(scattered.wi)
        beta = here.rays.beta * scattered.weight * here.same_side(wi, scattered.wi)[:, None]
        least = NEGLIGIBLE if self._max_depth < 0 else 0.0
        following = _Rays(here.rays.path, here.point, wi, here.patch, beta, scattered.pdf)
        return following.keep(beta.max(axis=1, initial=0.0) > least)


@dataclass(frozen=True, slots=True, eq=False)
class _Place:
    """Vertices of paths on surfaces with one BSDF. Normals and frames are on the viewer's side."""

    rays: _Rays
    point: Array
    patch: Index
    normal: Array
    frames: Frames
    wo: Array
    """Local directions to the viewer (n, 3)."""
    front: Mask

    @classmethod
    def at(cls, rays: _Rays, hits: Hits, rows: Mask, front: Mask) -> _Place:
        side = np.where(front, 1.0, -1.0)[:, None]
        frames = Frames.from_normals(side * hits.shading[rows], hits.tangent[rows])
        wo = frames.to_local(-rays.direction)
        lit = wo[:, 2] > 0.0  # the surface is black if its shading normal faces away from the viewer
        rays = rays.keep(lit)
        frames = Frames(frames.s[lit], frames.t[lit], frames.n[lit])
        normal = (side * hits.normal[rows])[lit]
        return cls(rays, hits.point[rows][lit], hits.patch[rows][lit], normal, frames, wo[lit], front[lit])

    def same_side(self, world: Array, local: Array) -> Mask:
        """Tell whether directions are on the same side of the geometric and the shading normal (N,)."""
        same: Mask = (dot(self.normal, world) > 0.0) == (local[:, 2] > 0.0)
        return same


def _share(pdf: Array, other: Array) -> Array:
    """Return the balance heuristic's weight (N, 1) of directions drawn with density `pdf` rather than `other`."""
    with np.errstate(divide="ignore"):
        weight: Array = 1.0 / (1.0 + other / pdf)
    return weight[:, None]
