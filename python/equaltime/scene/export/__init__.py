"""Export of scenes: as a dictionary, as TOML, or as XML for Mitsuba 3.

`plain` converts a scene model to nested dictionaries with Mitsuba's names. `toml_writer` and `xml_writer` convert such
a dictionary to text. `portable` writes the contents of a glTF file as separate files. `files` names files and writes
new files. `convert` combines all steps.
"""

from __future__ import annotations

from equaltime.scene.export.convert import FORMATS, convert
from equaltime.scene.export.plain import PlainWriter, scene_dict, with_transforms

__all__ = ["FORMATS", "PlainWriter", "convert", "scene_dict", "with_transforms"]
