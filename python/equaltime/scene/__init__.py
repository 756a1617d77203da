"""Scenes: one validated model in Mitsuba 3's words, with three spellings (Python dict, Mitsuba XML, TOML).

The way of a scene: a reader turns a file into a `tree` of located nodes; `resolve` finds references and makes the
`model`, a frozen value in which everything is checked; `assets` reads the meshes and images that it names; `geometry`
places its shapes in the world; `compile` hands all of it to the core. Every problem of a file is found before the
first error is raised, and each says where it is.
"""

from __future__ import annotations

from equaltime.scene.geometry import Surface, surface, surfaces
from equaltime.scene.model import SceneModel
from equaltime.scene.scene import Scene, load, load_dict, load_file

__all__ = ["Scene", "SceneModel", "Surface", "load", "load_dict", "load_file", "surface", "surfaces"]
