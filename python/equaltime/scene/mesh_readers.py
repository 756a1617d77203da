"""The readers of OBJ and PLY files, written in C++. Each reader raises ValueError with the place in the file.

``read_obj_by_material`` reads a file once and returns the mesh of each material that has faces. Its keys are the
materials' names in bytes, in the order of their first faces. ``obj_name`` extracts the name from the rest of a
statement such as ``usemtl``; the rule is the same in OBJ files and their libraries.
"""

from __future__ import annotations

from equaltime._core import MeshData, obj_name, read_obj, read_obj_by_material, read_ply

__all__ = ["MeshData", "obj_name", "read_obj", "read_obj_by_material", "read_ply"]
