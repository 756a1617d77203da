"""``equaltime schema``."""

from __future__ import annotations

from equaltime.scene.schema import scene_schema
from equaltime.strict_json import json_text

__all__ = ["schema"]


def schema() -> int:
    """Print a JSON schema of scene files, for editors.

    The schema describes every plugin and its parameters, so that an editor completes and checks scene files.

    For instance: `equaltime schema > scene.schema.json`, and on the first line of a scene `#:schema scene.schema.json`
    """
    print(json_text(scene_schema(), indent=1))
    return 0
