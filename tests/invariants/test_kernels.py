"""Which kernel renders a scene changes no bit: the one for all effects makes the image of the one that was derived."""

from pathlib import Path

import pytest

import equaltime as et
from equaltime import _core

from .shipped import FILES, FOLDER, same_bits

GLASS = Path(__file__).parents[1] / "golden" / "glass.toml"


@pytest.mark.parametrize("path", [*(FOLDER / file for file in FILES), GLASS], ids=lambda path: path.stem)
def test_the_kernel_for_all_effects_makes_the_bits_of_the_derived_one(path: Path) -> None:
    scene = et.load(path).with_(size=(24, 16))
    settings = _core.Settings(max_depth=scene.max_depth, lights="tree")
    also = (*scene.core.effects(), "splitting")
    derived, full = (_core.Renderer(scene.core, settings, seed=3, threads=1, also=names) for names in ((), also))
    assert derived.kernel != full.kernel
    for renderer in (derived, full):
        renderer.advance(6)
    assert same_bits(derived.moments, full.moments)


def test_kernels_agree_on_what_thin_glass_lets_pass_of_a_light_that_no_ray_meets() -> None:
    """With masks alone, with media too, and with all effects; the image is another where light is stopped by glass."""
    core, stopped = (behind_glass(kind).core for kind in ("volpath", "path"))
    settings = _core.Settings(max_depth=4)
    sets = ((), ("media",), (*core.effects(), "splitting"))
    renderers = [_core.Renderer(core, settings, seed=3, threads=1, also=names) for names in sets]
    renderers.append(_core.Renderer(stopped, settings, seed=3, threads=1))
    for renderer in renderers:
        renderer.advance(6)
    derived, *others, opaque = renderers
    assert len({renderer.kernel for renderer in (derived, *others)}) == 3
    assert all(same_bits(derived.moments, renderer.moments) for renderer in others)
    assert not same_bits(derived.moments, opaque.moments)


def behind_glass(integrator: str) -> et.Scene:
    """Return a floor below a lamp and a bulb, with coloured panes between, bare and half masked."""
    glass = {"type": "thindielectric", "specular_transmittance": {"type": "rgb", "value": [0.9, 0.8, 0.7]}}
    places = [[{"rotate": {"axis": [1, 2, 0], "angle": 20 * i}}, {"translate": [0, 0, i]}] for i in (1, 2)]
    panes = zip(places, (glass, {"type": "mask", "opacity": 0.5, "bsdf": glass}), strict=True)
    film = {"type": "hdrfilm", "width": 24, "height": 16}
    view = [{"look_at": {"origin": [0, -4, 2], "target": [0, 0, 0], "up": [0, 0, 1]}}]
    down = [{"rotate": {"axis": [1, 0, 0], "angle": 180}}, {"translate": [0, 0, 4]}]
    return et.load_dict(
        {
            "type": "scene",
            "integrator": {"type": integrator, "max_depth": 4},
            "sensor": {"type": "perspective", "to_world": view, "film": film},
            "floor": {"type": "rectangle", "to_world": [{"scale": 3}]},
            "lamp": {"type": "rectangle", "to_world": down, "emitter": {"type": "area"}},
            "bulb": {"type": "point", "position": [0.5, 0, 3], "intensity": 9.0},
            **{f"pane{i}": {"type": "rectangle", "to_world": to, "bsdf": bsdf} for i, (to, bsdf) in enumerate(panes)},
        }
    )


def test_an_effect_that_is_none_is_refused() -> None:
    scene = et.load(GLASS)
    with pytest.raises(ValueError, match='no effect is called "lenses"'):
        _core.Renderer(scene.core, _core.Settings(), also=["lenses"])
