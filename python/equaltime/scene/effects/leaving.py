"""Leaves effects (features such as lens or media) out of a scene: a simpler stand-in replaces each effect.

The image is then biased, and the result of the render names the effects that were left out.

Bitmaps and checkerboards become their means. Normal and bump maps are dropped. Masks become opaque, the environment
black, a thin lens a pinhole, and media a vacuum. Moving objects stand where they are at the centre of the shutter's
time. Hidden emitters become visible. Long paths are cut (`Strategy.truncate`). All other effects have no stand-in.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any, Final

import numpy as np
from pydantic import ValidationError

from equaltime.errors import EffectError
from equaltime.scene import Scene
from equaltime.scene.assets import Assets
from equaltime.scene.core import constant
from equaltime.scene.effects.kinds import KINDS
from equaltime.scene.model import (
    Bitmap,
    BumpMap,
    Checkerboard,
    IntegratorPlugin,
    Mask,
    Medium,
    NormalMap,
    Perspective,
    Plugin,
    SceneModel,
    Spot,
    TexturePlugin,
    ThinLens,
)
from equaltime.scene.motion import moves, still
from equaltime.strategy import Strategy
from equaltime.words import suggestion

__all__ = ["LUMINANCE", "SHORTEST", "can_leave_out", "leave_out", "parse_names"]

SHORTEST: Final = 2
"""Longest path, in segments, for ``long_paths`` without a depth: only emitted and direct light remain."""
LUMINANCE: Final = (0.212671, 0.715160, 0.072169)
"""Weights of red, green and blue in a colour's luminance."""
KEPT: Final = ((NormalMap, "normalmap"), (BumpMap, "texture"), (Mask, "opacity"))
"""Texture parameters, as (plugin, field), that belong to another effect: leaving out textures keeps them."""
NUMBERS: Final = frozenset(
    {"alpha", "alpha_u", "alpha_v", "weight", "roughness", "anisotropic", "metallic", "spec_trans", "spec_tint"}
    | {"sheen", "sheen_tint", "flatness", "clearcoat", "clearcoat_gloss"}
)
"""Parameters that are one number and not a colour: the mean of a texture must be a number, too."""

Change = Callable[[Plugin], Plugin]


def parse_names(names: Iterable[str]) -> dict[str, int | None]:
    """Parse names of effects to leave out: return a dictionary from each name to a depth, or to None.

    ``long_paths=K`` gives the depth K in segments, and ``long_paths`` alone gives `SHORTEST`. All other effects give
    None. Raises `EffectError` for an unknown effect, or for an effect that cannot be left out.
    """
    read: dict[str, int | None] = {}
    for text in names:
        name, equals, depth = text.partition("=")
        known = [kind.name for kind in KINDS.values() if kind.instead]
        if name not in KINDS:
            raise EffectError(f"unknown effect '{name}'{suggestion(name, KINDS)}")
        if name not in known:
            raise EffectError(f"the effect '{name}' cannot be left out; expected one of {', '.join(known)}")
        if equals and not (name == "long_paths" and depth.isascii() and depth.isdigit() and 0 < int(depth) < 2**31):
            raise EffectError(f"'{text}': expected the name alone, or long_paths=K with a depth K of at least 1")
        read[name] = int(depth) if equals else SHORTEST if name == "long_paths" else None
    return read


def leave_out(scene: Scene, strategy: Strategy, names: Iterable[str]) -> tuple[Scene, Strategy]:
    """Return a scene and a strategy without the effects in `names`, such as ``textures`` or ``long_paths=4``.

    If the scene does not change, the same scene object is returned.

    Raises
    ------
    EffectError
        If an effect does not exist or cannot be left out.
    """
    model = scene.model
    for name, depth in parse_names(names).items():
        if name == "long_paths":
            assert depth is not None
            if -1 < scene.max_depth <= depth:
                continue  # no path is longer
            shortest = min(depth, strategy.truncate or depth)
            strategy = Strategy.model_validate(strategy.model_dump() | {"truncate": shortest})
        else:
            model = STEPS[name](model, scene.assets)
    return (scene if model is scene.model else scene.replaced(model)), strategy


def can_leave_out(scene: Scene, strategy: Strategy, name: str) -> bool:
    """Tell whether leaving out the effect `name` would change this scene or strategy; if not, the effect is not used.

    Raises `EffectError` for an unknown effect, or for an effect that cannot be left out of any scene.
    """
    other, shorter = leave_out(scene, strategy, (name,))
    return other is not scene or shorter != strategy


class _Rewriter:
    """Applies a change to every node, innermost first; shared nodes stay shared."""

    def __init__(self, change: Change) -> None:
        self._change = change
        self._done: dict[int, tuple[Plugin, Plugin]] = {}

    def __call__(self, node: Plugin) -> Plugin:
        if id(node) not in self._done:
            changes: dict[str, Any] = {}
            for name in type(node).model_fields:
                value = getattr(node, name)
                new = tuple(map(self._item, value)) if isinstance(value, tuple) else self._item(value)
                same = all(map(lambda a, b: a is b, new, value)) if isinstance(value, tuple) else new is value
                if not same:
                    changes[name] = new
            self._done[id(node)] = node, self._change(node.replace(**changes) if changes else node)
        return self._done[id(node)][1]

    def _item(self, value: Any) -> Any:
        return self(value) if isinstance(value, Plugin) else value


def _everywhere(change: Change) -> Callable[[SceneModel, Assets], SceneModel]:
    def step(model: SceneModel, _: Assets) -> SceneModel:
        return _rewritten(model, change)

    return step


def _rewritten(model: SceneModel, change: Change) -> SceneModel:
    changed = _Rewriter(change)(model)
    assert isinstance(changed, SceneModel)
    return changed


def _without_textures(model: SceneModel, assets: Assets) -> SceneModel:
    def flat(node: Plugin) -> Plugin:
        changes = {
            name: _mean(value, assets, name in NUMBERS)
            for name in type(node).model_fields
            if isinstance(value := getattr(node, name), Bitmap | Checkerboard)
            and not any(isinstance(node, kind) and name == field for kind, field in KEPT)
        }
        if not changes or isinstance(node, TexturePlugin):
            return node
        if isinstance(node, Spot):
            slide = changes["texture"]
            return node.replace(
                texture=None, intensity=tuple(a * b for a, b in zip(node.intensity, slide, strict=True))
            )
        try:
            return node.replace(**changes)
        except ValidationError:  # a mean outside the range of the constant
            return node.replace(**{name: _within_bounds(value) for name, value in changes.items()})

    return _rewritten(model, flat)


def _mean(texture: Bitmap | Checkerboard, assets: Assets, number: bool) -> Any:
    """Return the mean of a texture in linear sRGB: a colour, or the one number that the core would use."""
    if isinstance(texture, Checkerboard):
        colors = [constant(color) for color in (texture.color0, texture.color1)]
        color = np.mean(np.asarray(colors, np.float64), axis=0)
        return float(color.mean()) if number else tuple(color.tolist())
    image = assets.texture(texture)
    texels = image.texels.astype(np.float64)
    if image.texels.dtype == np.uint8:
        texels /= 255.0
        if image.srgb and not texture.raw:
            texels = np.where(texels <= 0.04045, texels / 12.92, ((texels + 0.055) / 1.055) ** 2.4)
    color = np.broadcast_to(texels.mean(axis=(0, 1)), 3)
    return float(color @ LUMINANCE) if number else tuple(color.tolist())


def _within_bounds(value: Any) -> Any:
    clipped = np.clip(value, 1e-4, 1.0)
    return float(clipped) if np.ndim(value) == 0 else tuple(clipped.tolist())


def _without_bends(node: Plugin) -> Plugin:
    return node.bsdf if isinstance(node, NormalMap | BumpMap) else node


def _without_masks(node: Plugin) -> Plugin:
    return node.bsdf if isinstance(node, Mask) else node


def _without_environment(model: SceneModel, _: Assets) -> SceneModel:
    kept = tuple(emitter for emitter in model.emitters if not emitter.surrounds)
    return model if len(kept) == len(model.emitters) else model.replace(emitters=kept)


def _without_lens(model: SceneModel, _: Assets) -> SceneModel:
    sensor = model.sensor
    if not isinstance(sensor, ThinLens):
        return model
    known = sensor.model_fields_set & Perspective.model_fields.keys() - {"type"}
    given = {name: getattr(sensor, name) for name in known}
    return model.replace(sensor=Perspective(**given))


def _without_media(node: Plugin) -> Plugin:
    places = [name for name in type(node).model_fields if isinstance(getattr(node, name), Medium)]
    return node.replace(**dict.fromkeys(places)) if places else node


def _without_motion(model: SceneModel, _: Assets) -> SceneModel:
    anything = any(moves(node, model.sensor) for node in (*model.shapes, model.sensor))
    return still(model) if anything else model


def _without_hiding(node: Plugin) -> Plugin:
    hides = isinstance(node, IntegratorPlugin) and node.hide_emitters
    return node.replace(hide_emitters=False) if hides else node


STEPS: Final[Mapping[str, Callable[[SceneModel, Assets], SceneModel]]] = {
    "environment": _without_environment,
    "lens": _without_lens,
    "textures": _without_textures,
    "normal_maps": _everywhere(_without_bends),
    "masks": _everywhere(_without_masks),
    "media": _everywhere(_without_media),
    "motion": _without_motion,
    "hidden_emitters": _everywhere(_without_hiding),
}
