"""Lists the image and mesh files that a scene names."""

from __future__ import annotations

from pathlib import Path

from equaltime.scene.model import Bitmap, EnvMap, MeshFile, mesh_files
from equaltime.scene.scene import Scene

__all__ = ["named_files"]


def named_files(scene: Scene) -> tuple[Path, ...]:
    """Return the paths of all images and meshes that the scene names, sorted, each once."""
    named = {node.filename for node in scene.model.nodes() if isinstance(node, Bitmap | EnvMap | MeshFile)}
    return tuple(sorted({scene.assets.path(name) for filename in named for name in mesh_files(filename)}))
