"""A scene's fingerprint: equal for scenes with the same image, however they are named or spelt."""

from __future__ import annotations

import hashlib
import json

from equaltime.scene.assets import Assets
from equaltime.scene.model import Animation, Deformation, Plugin, SceneModel, mesh_files
from equaltime.scene.motion import in_shutters

__all__ = ["digest"]

VERSION = "equaltime scene 1"
"""Version of the digest; change it when the same content must get another digest."""


def digest(model: SceneModel, assets: Assets) -> str:
    """Return the SHA-256 of everything that can change the image: parameters and the contents of files.

    Names, places of files, output formats and sampling hints do not count. The order of shapes and emitters counts,
    because the bits of an image depend on it.
    """
    content = json.dumps([VERSION, _canonical(in_shutters(model), assets)], sort_keys=True, allow_nan=False)
    return hashlib.sha256(content.encode()).hexdigest()


def _canonical(value: object, assets: Assets) -> object:
    if isinstance(value, Plugin):
        fields = {name: getattr(value, name) for name in type(value).model_fields if name not in {"id", *value.hints}}
        if isinstance(filename := fields.get("filename"), str | Deformation):
            fields["filename"] = _contents(filename, assets)
        return {name: _canonical(field, assets) for name, field in fields.items()}
    if isinstance(value, Animation):
        return {"times": value.times, "matrices": value.matrices}
    if isinstance(value, tuple):
        return [_canonical(item, assets) for item in value]
    return value


def _contents(filename: str | Deformation, assets: Assets) -> object:
    """Return the SHA-256 of a file's content.

    For an animation whose files differ, return its times, the SHA-256 of each file, and the time at which it is held.
    """
    sums = [assets.sha256(name) for name in mesh_files(filename)]
    if not isinstance(filename, Deformation) or len(set(sums)) == 1:
        return sums[0]
    return {"times": filename.times, "files": sums, "held": filename.held}
