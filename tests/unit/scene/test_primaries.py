"""Images whose header names other primaries than those of sRGB."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import OpenImageIO as oiio  # noqa: N813
import pytest

from equaltime.scene import load_dict
from equaltime.scene.picture_colors import CIE_XYZ, REC709, to_srgb

ACESCG = (0.713, 0.293, 0.165, 0.83, 0.128, 0.044, 0.32168, 0.33767)
REC2020 = (0.708, 0.292, 0.17, 0.797, 0.131, 0.046, 0.3127, 0.329)


def write(path: Path, chromaticities: tuple[float, ...] | None, color: tuple[float, ...]) -> None:
    spec = oiio.ImageSpec(4, 4, 3, "float")
    if chromaticities is not None:
        spec.attribute("chromaticities", "float[8]", chromaticities)
    output = oiio.ImageOutput.create(str(path))
    assert output.open(str(path), spec)
    assert output.write_image(np.full((4, 4, 3), color, np.float32))
    output.close()


def test_equal_primaries_change_nothing() -> None:
    assert to_srgb(REC709) is None
    assert to_srgb([float(np.float32(c)) for c in REC709]) is None


def test_rec_2020_in_srgb_is_the_matrix_that_bt_2087_gives() -> None:
    expected = [[1.6605, -0.5876, -0.0728], [-0.1246, 1.1329, -0.0083], [-0.0182, -0.1006, 1.1187]]
    assert to_srgb(REC2020) == pytest.approx(np.array(expected), abs=6e-5)


def test_xyz_is_the_matrix_of_srgb() -> None:
    """IEC 61966-2-1, to its four digits."""
    expected = [[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]]
    assert to_srgb(CIE_XYZ) == pytest.approx(np.array(expected), abs=4e-4)


@pytest.mark.parametrize("wrong", [(0.0,) * 8, (0.3, 0.3) * 4, (np.nan, *REC709[1:]), (*REC709[:7], 0.0)])
def test_what_are_no_primaries_are_refused(wrong: tuple[float, ...], tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="impossible chromaticities"):
        to_srgb(wrong)


def test_textures_and_skies_are_converted(tmp_path: Path) -> None:
    color, path = (0.2, 0.5, 0.3), tmp_path / "image.exr"
    for chromaticities in (None, REC709, ACESCG):
        write(path, chromaticities, color)
        matrix = None if chromaticities is None else to_srgb(chromaticities)
        expected = color if matrix is None else matrix @ np.array(color)
        texture = {"type": "bitmap", "filename": str(path)}
        scene = load_dict(
            {
                "type": "scene",
                "sensor": {"type": "perspective"},
                "sky": {"type": "envmap", "filename": str(path)},
                "wall": {"type": "rectangle", "bsdf": {"type": "diffuse", "reflectance": texture}},
            }
        )
        sky, bitmap = scene.model.emitters[0], scene.model.shapes[0].bsdf.reflectance  # type: ignore[union-attr]
        assert scene.assets.image(sky)[0, 0] == pytest.approx(np.array(expected), abs=2.0**-22)  # type: ignore[arg-type]
        assert scene.assets.texture(bitmap).texels[0, 0] == pytest.approx(np.array(expected), abs=2.0**-22)  # type: ignore[arg-type]
