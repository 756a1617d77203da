"""Parts of the core (the renderer in C++) that scenes need, and the error for plugins that the core cannot use.

The readers of OBJ and PLY files raise ValueError with the position in the file. ``read_obj_by_material`` reads a file
once, and returns a dict from each material that has faces to the material's mesh. The keys are the materials' names in
bytes, in the order of their first faces. ``obj_name`` extracts the name from a statement without its first word, such
as ``usemtl``. The rule is the same in OBJ files and in MTL files.
"""

from __future__ import annotations

from typing import Final, TypeVar

from equaltime._core import (
    MeshData,
    SceneBuilder,
    bsdf_models,
    obj_name,
    phase_functions,
    read_obj,
    read_obj_by_material,
    read_ply,
)
from equaltime._core import Scene as CoreScene
from equaltime.scene.model import Plugin, Texture, TexturePlugin

__all__ = [
    "BSDF_MODELS",
    "PHASE_FUNCTIONS",
    "SMOOTHING",
    "CoreScene",
    "MeshData",
    "SceneBuilder",
    "Unsupported",
    "constant",
    "obj_name",
    "read_obj",
    "read_obj_by_material",
    "read_ply",
]

T = TypeVar("T")

BSDF_MODELS: Final = bsdf_models()
"""BSDFs of the core, by ``type``: their parameters, those that textures may give, and the effect that needs them."""

PHASE_FUNCTIONS: Final = phase_functions()
"""Phase functions of the core, by name: the effect that needs them."""

SMOOTHING: Final = "faces without vn are smooth"
"""Part of the warning of the OBJ reader about smoothing groups, which it does not use."""


class Unsupported(ValueError):
    """Raised for the plugin `node`, which the core (the renderer in C++) cannot use yet.

    The caller adds the file and line of the plugin.
    """

    def __init__(self, node: Plugin, what: str = "") -> None:
        self.node = node
        super().__init__(what or f"the {node.kind} '{node.title}' is not supported yet")


def constant(value: Texture | T) -> T:
    """Return `value`, for a parameter that must be constant in the core; raises `Unsupported` for a texture."""
    if isinstance(value, TexturePlugin):
        raise Unsupported(value)
    return value
