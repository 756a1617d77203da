"""The readers of mesh files, which are C++: OBJ and PLY. Each raises ValueError with the place in its file.

``read_obj_by_material`` goes through a file once and returns the mesh of each material that has faces, by its name in
bytes, in the order of their first faces. ``obj_name`` is the name in the rest of a statement such as ``usemtl``: one
rule for the OBJ file and for its libraries.
"""

from __future__ import annotations

from equaltime._core import MeshData, obj_name, read_obj, read_obj_by_material, read_ply

__all__ = ["MeshData", "obj_name", "read_obj", "read_obj_by_material", "read_ply"]
