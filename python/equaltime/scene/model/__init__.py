"""The scene as validated, frozen values in Mitsuba 3's words: one class per plugin, one module per family."""

from __future__ import annotations

from equaltime.scene.model.base import NOT_YET, Kind, Plugin
from equaltime.scene.model.bsdfs import Bsdf, Conductor, Dielectric, Diffuse, RoughConductor, TwoSided
from equaltime.scene.model.emitters import Area, Constant, EnvMap, FreeEmitter, Point
from equaltime.scene.model.films import Box, Filter, Gaussian, HdrFilm, Tent
from equaltime.scene.model.integrators import Direct, Integrator, Path
from equaltime.scene.model.scene import SceneModel
from equaltime.scene.model.sensors import (
    MOST_SAMPLES,
    Independent,
    LdSampler,
    MultiJitter,
    Orthogonal,
    Perspective,
    Sampler,
    Stratified,
)
from equaltime.scene.model.shapes import Cube, Disk, MeshFile, Obj, Ply, Rectangle, Shape, Sphere
from equaltime.scene.model.values import Color, Matrix, Spectrum, as_array, linear_scale, mirrors

__all__ = [
    "MOST_SAMPLES",
    "NOT_YET",
    "PLUGINS",
    "Area",
    "Box",
    "Bsdf",
    "Color",
    "Conductor",
    "Constant",
    "Cube",
    "Dielectric",
    "Diffuse",
    "Direct",
    "Disk",
    "EnvMap",
    "Filter",
    "FreeEmitter",
    "Gaussian",
    "HdrFilm",
    "Independent",
    "Integrator",
    "Kind",
    "LdSampler",
    "Matrix",
    "MeshFile",
    "MultiJitter",
    "Obj",
    "Orthogonal",
    "Path",
    "Perspective",
    "Plugin",
    "Ply",
    "Point",
    "Rectangle",
    "RoughConductor",
    "Sampler",
    "SceneModel",
    "Shape",
    "Spectrum",
    "Sphere",
    "Stratified",
    "Tent",
    "TwoSided",
    "as_array",
    "linear_scale",
    "mirrors",
]

PLUGINS: dict[str, type[Plugin]] = {
    plugin.model_fields["type"].default: plugin
    for plugin in (
        *(Diffuse, Conductor, RoughConductor, Dielectric, TwoSided),
        *(Rectangle, Disk, Cube, Sphere, Ply, Obj),
        *(Area, Point, Constant, EnvMap),
        *(Perspective, HdrFilm, Box, Tent, Gaussian),
        *(Independent, Stratified, MultiJitter, Orthogonal, LdSampler),
        *(Path, Direct),
    )
}
"""The supported plugins by their type."""
