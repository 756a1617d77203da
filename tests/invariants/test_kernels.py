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
    also = (*scene.core.effects(), "forks")
    derived, full = (_core.Renderer(scene.core, settings, seed=3, threads=1, also=names) for names in ((), also))
    assert derived.kernel != full.kernel
    for renderer in (derived, full):
        renderer.advance(6)
    assert same_bits(derived.moments, full.moments)


def test_an_effect_that_is_none_is_refused() -> None:
    scene = et.load(GLASS)
    with pytest.raises(ValueError, match='no effect is called "lenses"'):
        _core.Renderer(scene.core, _core.Settings(), also=["lenses"])
