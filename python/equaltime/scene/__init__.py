"""Scenes: one validated model with Mitsuba 3's names, read from a Python dict, Mitsuba XML or TOML.

A scene is loaded in five steps. A reader turns the file into a `tree` of located nodes. `resolve` finds references and
makes the `model`, a frozen and fully checked value. `assets` reads the meshes and images that the model names.
`geometry` places its shapes in the world. `compile` hands everything to the core. All problems of a file are found
before the first error is raised, and each problem has its place.
"""

from __future__ import annotations

from equaltime.scene.geometry import Surface, surface, surfaces
from equaltime.scene.model import SceneModel
from equaltime.scene.scene import Scene, load, load_dict, load_file

__all__ = ["Scene", "SceneModel", "Surface", "load", "load_dict", "load_file", "surface", "surfaces"]
