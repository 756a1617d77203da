"""The readers of OBJ and PLY files, written in C++. Each reader raises ValueError with the position in the file.

``read_obj_by_material`` reads a file once, and returns a dict from each material that has faces to the material's mesh.
The keys are the materials' names in bytes, in the order of their first faces. ``obj_name`` extracts the name from a
statement without its first word, such as ``usemtl``. The rule is the same in OBJ files and in MTL files.
"""

from __future__ import annotations

from equaltime._core import MeshData, obj_name, read_obj, read_obj_by_material, read_ply

__all__ = ["MeshData", "obj_name", "read_obj", "read_obj_by_material", "read_ply"]
