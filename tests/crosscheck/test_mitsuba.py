"""equaltime against Mitsuba 3's path integrator, by the protocol of `agreement`.

Both read the same scene, the shipped XML files (with a box filter in place of the tent) or one dictionary, and render
it with 64 seeds. All comparisons together, the slow ones included, have a false-alarm rate of 0.1 %.

An image by Mitsuba is worth no more than 0.2 % where gaps or edges are small against the scene's extent from the
origin, because Mitsuba moves the origins of its rays: `test_mitsuba_offsets`. The scenes here have no such gaps.

Needs the extra `peers`. Mitsuba's LLVM variant is several times faster than its scalar one, which serves without
libllvm, at half the size.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import equaltime as et

mi = pytest.importorskip("mitsuba")

try:
    mi.set_variant("llvm_ad_rgb")
except ImportError:
    mi.set_variant("scalar_rgb")

from equaltime.statistics.agreement import LEVEL, Agreement, BlockMeans, compare, share  # noqa: E402

from . import feature_scenes, material_scenes, media_scenes, surface_scenes  # noqa: E402
from .feature_scenes import OTHER_RULE, lights  # noqa: E402

FOLDER = Path(__file__).parents[2] / "scenes" / "mitsuba"
WIDTH = 256 if mi.variant() == "llvm_ad_rgb" else 128
SHIPPED = {"cornell-box": (WIDTH, WIDTH), "veach-mis": (WIDTH, WIDTH * 9 // 16)}
SCENES = feature_scenes.SCENES | material_scenes.MATERIALS | media_scenes.MEDIA | surface_scenes.SURFACES
EVERYDAY = feature_scenes.EVERYDAY + material_scenes.EVERYDAY_MATERIALS + media_scenes.EVERYDAY_MEDIA
SEEDS = 64
EACH = share(LEVEL, 2 * len(SHIPPED) + len(SCENES))


def agreement(ours: et.Scene, theirs: Any, spp: int, block: int) -> Agreement:
    sides = (
        (et.render(ours, spp=spp, seed=seed).image for seed in range(SEEDS)),
        _mitsuba_images(theirs, spp),
    )
    return compare(*(BlockMeans.of_seeds(images, block) for images in sides))


def _mitsuba_images(scene: Any, spp: int) -> Iterator[NDArray[np.float32]]:
    for seed in range(SEEDS):
        yield np.array(mi.render(scene, seed=seed, spp=spp))


def boxed(name: str, folder: Path) -> Path:
    """Write a shipped scene with a box filter and return its place."""
    text = (FOLDER / name / "scene.xml").read_text()
    assert text.count('<rfilter type="tent" />') == 1
    copy = folder / f"{name}.xml"
    copy.write_text(text.replace('<rfilter type="tent" />', '<rfilter type="box" />'))
    return copy


def shipped(path: Path, size: tuple[int, int]) -> tuple[et.Scene, Any]:
    """Return a scene of XML as both read it, at its own path length."""
    defines: dict[str, Any] = {"integrator": "path", "resx": size[0], "resy": size[1]}
    ours = et.load(path, **defines)
    theirs = mi.load_file(str(path), **defines)
    assert f"max_depth = {ours.max_depth}" in str(theirs.integrator())
    return ours, theirs


@pytest.mark.parametrize("name", SHIPPED)
def test_the_shipped_scenes_agree_when_they_are_small(name: str, tmp_path: Path) -> None:
    width, height = SHIPPED[name]
    found = agreement(*shipped(boxed(name, tmp_path), (width // 4, height // 4)), spp=16, block=4)
    assert found.p > EACH, str(found)


@pytest.mark.slow
@pytest.mark.parametrize("name", SHIPPED)
def test_the_shipped_scenes_agree(name: str, tmp_path: Path) -> None:
    found = agreement(*shipped(boxed(name, tmp_path), SHIPPED[name]), spp=32, block=8)
    print(name, found)
    assert found.p > EACH, str(found)


def marked(name: str) -> Any:
    marks = [] if name in EVERYDAY else [pytest.mark.slow]
    if name in OTHER_RULE:
        marks.append(pytest.mark.xfail(reason="Mitsuba takes the shading normal's word for the side of a direction"))
    return pytest.param(name, marks=marks)


@pytest.mark.parametrize("name", [marked(name) for name in SCENES])
def test_the_feature_agrees(name: str, tmp_path: Path) -> None:
    description = SCENES[name](tmp_path)
    found = agreement(et.load_dict(description), mi.load_dict(description), spp=16, block=4)
    print(name, found)
    assert found.p > EACH, str(found)


def test_white_walls_two_percent_brighter_are_found(tmp_path: Path) -> None:
    """The power twin: a comparison of this size tells 0.725 from 0.74."""
    path = boxed("cornell-box", tmp_path)
    _, theirs = shipped(path, (64, 64))
    text = path.read_text()
    assert text.count("0.725, 0.71, 0.68") > 1
    path.write_text(text.replace("0.725, 0.71, 0.68", "0.74, 0.724, 0.694"))
    ours, _ = shipped(path, (64, 64))
    assert agreement(ours, theirs, spp=4, block=4).p < EACH


def test_a_light_turned_over_on_one_side_only_is_found() -> None:
    ours, theirs = et.load_dict(lights("disk", flip_normals=True)), mi.load_dict(lights("disk"))
    assert agreement(ours, theirs, spp=4, block=4).p < EACH
