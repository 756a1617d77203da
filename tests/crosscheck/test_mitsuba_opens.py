"""Mitsuba's own reader opens saved renders: it sees the image, bit for bit, and nothing of the parts behind it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import equaltime as et
from equaltime.rendering.render_file import read_picture

mi = pytest.importorskip("mitsuba")
pytestmark = pytest.mark.usefixtures("scalar_mitsuba")


@pytest.mark.parametrize("small", [False, True])
def test_mitsuba_opens_a_saved_render(tmp_path: Path, small: bool) -> None:
    scene = et.load_dict({"type": "scene", "sensor": {"type": "perspective"}, "sky": {"type": "constant"}})
    et.render(scene.with_(size=(9, 7)), spp=4, threads=1).save(tmp_path / "a.exr", small)
    found = np.array(mi.Bitmap(str(tmp_path / "a.exr")), np.float32)
    np.testing.assert_array_equal(found, read_picture(tmp_path / "a.exr").image)
