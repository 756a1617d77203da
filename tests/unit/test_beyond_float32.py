"""Images that float32 cannot hold are refused; errors of very bright and very dark images are the same."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import equaltime as et
from equaltime.error_estimate import PixelStatistics, image_error
from equaltime.machine import memory_bytes


def _scene(radiance: float) -> et.Scene:
    emitter = {"type": "constant", "radiance": {"type": "rgb", "value": [radiance] * 3}}
    film = {"type": "hdrfilm", "width": 4, "height": 4}
    return et.load_dict({"type": "scene", "sensor": {"type": "perspective", "film": film}, "emitter": emitter})


@pytest.mark.parametrize("radiance", [3.5e38, 1e155, 1e200])
def test_an_image_that_float32_cannot_hold_is_an_error_with_its_pixel(radiance: float) -> None:
    with pytest.raises(et.RenderError, match=r"pixel 0,0 is .*, more than an image of float32 can hold"):
        et.render(_scene(radiance), spp=2, threads=1)


@pytest.mark.parametrize("exponent", [-400, 400])
def test_the_error_does_not_depend_on_how_bright_the_image_is(exponent: int) -> None:
    random = np.random.default_rng(3)
    mean, samples = random.uniform(0.5, 1.5, (16, 16, 3)), np.full((16, 16), 8, np.int64)
    pixels = PixelStatistics(mean, 0.01 * mean, samples, 1.0)
    scale = 2.0**exponent
    scaled = replace(pixels, mean=mean * scale, variance=pixels.variance * scale * scale)
    found, plain = image_error(scaled), image_error(pixels)
    assert [found.value, found.low, found.high] == pytest.approx([plain.value, plain.low, plain.high], rel=1e-12)


@pytest.mark.parametrize("name", ["memory.max", "memory/memory.limit_in_bytes"])
def test_the_memory_of_a_container_counts(tmp_path: Path, name: str) -> None:
    machine = memory_bytes(tmp_path)
    file = tmp_path / name
    file.parent.mkdir(exist_ok=True)
    file.write_text("max\n")
    assert memory_bytes(tmp_path) == machine
    file.write_text("1000000\n")
    assert memory_bytes(tmp_path) == 1_000_000
