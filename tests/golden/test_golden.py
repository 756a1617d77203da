"""Renders against golden images: expected values by block z-tests, no percent tolerance.

All scenes together have a false-alarm rate of 0.1 %, for any seeds; these are fixed. On failure the folder of the test
gets `error.exr`, what the render has too much, and `p.exr`, the p-value of each block alone.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import OpenImageIO
import pytest
from numpy.typing import ArrayLike
from scipy import stats

import equaltime as et
from equaltime.statistics.agreement import LEVEL, Agreement, BlockMeans, compare, share

from .golden import SCENES, Golden, load_scene

RENDERS, SPP, BLOCK = 64, 4, 8
EACH = share(LEVEL, len(SCENES))


def judged(golden: Golden, scene: et.Scene, folder: Path, spp: int = SPP) -> Agreement:
    """Compare renders of `scene` with its golden image; if they differ, write the images that show where."""
    images = [et.render(scene, spp=spp, seed=seed).image for seed in range(RENDERS)]
    assert golden.relative_error < 0.3 * Golden.of(images).relative_error
    renders = BlockMeans.of_seeds(images, BLOCK)
    found = compare(renders, BlockMeans.of_pixels(golden.mean, golden.variance, BLOCK, golden.degrees))
    if found.p < EACH:
        write(folder / "error.exr", np.mean(images, axis=0, dtype=np.float64) - golden.mean)
        p = 2.0 * stats.norm.sf(np.abs(np.nan_to_num(found.z)))
        write(folder / "p.exr", p.repeat(BLOCK, axis=0).repeat(BLOCK, axis=1))
    return found


def write(path: Path, image: ArrayLike) -> None:
    buffer = OpenImageIO.ImageBuf(np.ascontiguousarray(image, dtype=np.float32))
    assert buffer.write(str(path)), buffer.geterror()


@pytest.mark.parametrize("name", SCENES)
def test_the_render_has_the_golden_image_as_its_expectation(name: str, tmp_path: Path) -> None:
    found = judged(Golden.load(name), load_scene(name), tmp_path)
    print(found)
    assert found.p > EACH, f"{found}\nsee error.exr and p.exr in {tmp_path}"


@pytest.mark.parametrize("name", SCENES)
def test_two_percent_less_reflectance_is_found_and_shown(name: str, tmp_path: Path) -> None:
    """The power twin, with half the samples."""
    found = judged(Golden.load(name), load_scene(name, albedo=0.98), tmp_path, SPP // 2)
    print(found)
    assert found.p < EACH
    for file in ("error.exr", "p.exr"):
        assert OpenImageIO.ImageBuf(str(tmp_path / file)).spec().width == load_scene(name).size[0]


@pytest.mark.parametrize("name", SCENES)
def test_the_golden_image_fits_the_scene_and_is_small(name: str) -> None:
    golden, (width, height) = Golden.load(name), load_scene(name).size
    assert golden.mean.shape == golden.variance.shape == (height, width, 3)
    assert (Path(__file__).parent / f"{name}.npz").stat().st_size <= 100_000
