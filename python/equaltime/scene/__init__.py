"""Scenes: one validated model with Mitsuba 3's names, read from a Python dict, Mitsuba XML, TOML, glTF or a mesh file.

A scene is loaded in five steps. A reader turns the file into a `tree` of nodes, each with its file and line. `resolve`
follows references and makes the `model`, an immutable and fully checked value. `assets` reads the meshes and images
that the model names. `geometry` puts the model's shapes into world space. `compile` hands everything to the core, the
renderer in C++. All problems of a file are collected before an error is raised, each with file and line.
"""

from __future__ import annotations

from equaltime.scene.geometry import Surface, surface, surfaces
from equaltime.scene.model import SceneModel
from equaltime.scene.scene import Scene, load, load_dict, load_file

__all__ = ["Scene", "SceneModel", "Surface", "load", "load_dict", "load_file", "surface", "surfaces"]
