"""Refusal of scenes that the cross-check cannot trace; the error names the plugins, before the first ray."""

from __future__ import annotations

from typing import Final, TypeVar

from equaltime.errors import RenderError
from equaltime.scene import model as m
from equaltime.scene.model import Perspective, SceneModel, Texture, TexturePlugin

__all__ = ["camera_of", "check", "constant"]

T = TypeVar("T")

TRACED: Final = (
    *(m.SceneModel, m.Perspective, m.HdrFilm, m.Box, m.Tent, m.Gaussian, m.Independent, m.Stratified, m.MultiJitter),
    *(m.Orthogonal, m.LdSampler, m.Path, m.Direct, m.Moment, m.Rectangle, m.Disk, m.Cube, m.Sphere, m.Ply, m.Obj),
    *(m.Diffuse, m.Conductor, m.RoughConductor, m.Dielectric, m.ThinDielectric, m.RoughDielectric, m.Plastic),
    *(m.RoughPlastic, m.Principled, m.TwoSided, m.Area, m.Point, m.Constant, m.EnvMap),
)


def check(model: SceneModel) -> None:
    """Raise RenderError if the cross-check cannot trace the scene `model`.

    The error names all plugins and settings that the cross-check lacks.
    """
    unknown = {f"'{node.title}'" for node in model.nodes() if not isinstance(node, TRACED)}
    unknown |= {"'priority'" for shape in model.shapes if getattr(shape, "priority", None) is not None}
    unknown |= {"'hide_emitters'"} if model.integrator.hides_emitters else set()
    unknown |= {"'max_depth' of 0"} if model.integrator.max_depth == 0 else set()
    if unknown:
        raise RenderError(f"the cross-check cannot trace {', '.join(sorted(unknown))}")


def camera_of(model: SceneModel) -> Perspective:
    """Return the scene's pinhole camera; raises RenderError for any other sensor."""
    if not isinstance(model.sensor, Perspective):
        raise RenderError(f"the cross-check cannot trace '{model.sensor.type}'")
    return model.sensor


def constant(value: Texture | T) -> T:
    """Return `value` unchanged, with the type of a constant; `check` has refused textures before."""
    assert not isinstance(value, TexturePlugin), "textures are refused before"
    return value
