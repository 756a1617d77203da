"""Within `twosided` the back of a surface is as its front, for every BSDF that lets no light through."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import equaltime as et
from equaltime.scene.model import LEAVES

PARAMETERS: dict[str, dict[str, Any]] = {
    **{type: {"alpha": 0.3} for type in ("roughplastic", "pplastic", "roughconductor")},
    "principled": {"metallic": 0.3, "sheen": 0.5, "clearcoat": 0.5},
}
"""Parameters that are not the default, by type."""
OPAQUE = [leaf.title for leaf in (plugin() for plugin in LEAVES) if not leaf.transmits]
BSDFS: dict[str, dict[str, Any]] = {
    **{type: {"type": type, **PARAMETERS.get(type, {})} for type in OPAQUE},
    "principled, masked": {"type": "mask", "opacity": 0.7, "bsdf": {"type": "principled"}},
}


def seen(bsdf: dict[str, Any], flip_normals: bool) -> tuple[float, float]:
    """Return the mean of an image of a tile in a sky that is brighter on the right, and its standard error."""
    wrapped = {"type": "twosided", "bsdf": bsdf}
    if bsdf["type"] == "mask":
        wrapped = {**bsdf, "bsdf": {"type": "twosided", "bsdf": bsdf["bsdf"]}}
    film = {"type": "hdrfilm", "width": 8, "height": 8, "rfilter": {"type": "box"}}
    lamp = {"type": "sphere", "center": [3, 1, 2], "radius": 1.0, "emitter": {"type": "area", "radiance": 5.0}}
    tile = {
        "type": "rectangle",
        "to_world": [{"rotate": {"axis": [0, 1, 0], "angle": 20}}],
        "flip_normals": flip_normals,
    }
    camera = {"type": "perspective", "fov": 15.0, "to_world": [{"look_at": {"origin": [0, 0, 4], "target": [0, 0, 0]}}]}
    parts = {"sensor": camera | {"film": film}, "lamp": lamp, "sky": {"type": "constant", "radiance": 0.2}}
    result = et.render({"type": "scene", **parts, "tile": tile | {"bsdf": wrapped}}, spp=128, strategy="mis")
    return float(result.image.mean()), float(np.sqrt((result.standard_error**2).mean() / result.image[..., 0].size))


@pytest.mark.parametrize("name", BSDFS)
def test_the_back_is_as_the_front(name: str) -> None:
    """To 6 standard errors, of which a back that is black is hundreds away."""
    (front, error), (back, other) = (seen(BSDFS[name], flip_normals) for flip_normals in (False, True))
    assert abs(front - back) < 6 * float(np.hypot(error, other)) + 1e-6
    assert front > 20 * error
