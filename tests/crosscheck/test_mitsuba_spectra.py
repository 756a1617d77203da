"""Spectra, metals and old files mean to equaltime what they mean to Mitsuba 3's RGB mode."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from equaltime.scene import load
from equaltime.scene import model as m
from equaltime.scene.spectrum_values import parse_spectrum, read_spectrum

mi = pytest.importorskip("mitsuba")
pytestmark = pytest.mark.usefixtures("scalar_mitsuba")

ROUNDING = 3e-6
"""Single precision over a sum of a thousand terms."""


def theirs(parent: str, parameter: str, value: str) -> Any:
    kind, plugin = parent.split()
    spectrum = f'<spectrum name="{parameter}" value="{value}"/>'
    parts = mi.traverse(mi.load_string(f'<{kind} version="3.0.0" type="{plugin}">{spectrum}</{kind}>'))
    return np.array(parts[f"{parameter}.value"]).ravel()


CURVES = ["400:0.1, 500:0.2, 600:0.9, 700:0.3", "360:0.5, 830:0.5", "500:0.3 510:0.9", "300:1, 400:0.2, 900:0.4"]


@pytest.mark.parametrize("curve", CURVES)
def test_a_curve_is_the_same_colour(curve: str) -> None:
    spectrum = parse_spectrum(curve)
    assert isinstance(spectrum, m.SpectralCurve)
    assert spectrum.emission == pytest.approx(theirs("emitter area", "radiance", curve), rel=ROUNDING, abs=ROUNDING)
    assert spectrum.reflectance == pytest.approx(theirs("bsdf conductor", "eta", curve), rel=ROUNDING, abs=ROUNDING)
    shifted = parse_spectrum(curve.replace("500", "503"))
    if "500" in curve:  # the power twin: three nanometres beside would be seen
        assert shifted.emission != pytest.approx(spectrum.emission, rel=ROUNDING, abs=ROUNDING)  # type: ignore[union-attr]


@pytest.mark.parametrize("name", sorted(m.METALS))
def test_a_metal_is_the_integral_of_its_measured_curves(name: str) -> None:
    folder = Path(mi.__file__).parent / "data" / "ior"
    for part, known in zip(("eta", "k"), m.METALS[name], strict=True):
        curve = read_spectrum(folder / f"{name}.{part}.spd")
        assert known == pytest.approx(curve.emission, rel=1e-5, abs=1e-9)
    parts = mi.traverse(mi.load_dict({"type": "conductor", "material": name}))
    assert np.array(parts["eta.value"]).ravel() == pytest.approx(m.METALS[name].eta, rel=1e-5, abs=1e-9)


OLD = """<scene version="0.5.0"><sensor type="perspective"><float name="fov" value="45"/><transform name="toWorld">
<lookat origin="0, 1, 4" target="0, 0, 0" up="0, 1, 0"/></transform></sensor>
<shape type="rectangle"><bsdf type="diffuse"><texture name="reflectance" type="checkerboard"><float name="uscale"
value="3"/><float name="voffset" value="0.25"/></texture></bsdf></shape></scene>"""


def test_an_old_file_is_upgraded_as_mitsuba_does(tmp_path: Path) -> None:
    (tmp_path / "old.xml").write_text(OLD)
    ours, loaded = load(tmp_path / "old.xml").model, mi.load_file(str(tmp_path / "old.xml"))
    other = mi.traverse(loaded)
    (shape,) = ours.shapes
    assert isinstance(shape, m.Rectangle)
    assert isinstance(shape.bsdf, m.Diffuse)
    assert isinstance(shape.bsdf.reflectance, m.Checkerboard)
    (name,) = (name for name in other.keys() if name.endswith("to_uv"))  # noqa: SIM118  # no mapping
    assert np.array(other[name].matrix).reshape(3, 3)[:2] == pytest.approx(np.array(shape.bsdf.reflectance.uv_rows))
    matrix = np.array(loaded.sensors()[0].world_transform().matrix).reshape(4, 4)
    assert matrix == pytest.approx(np.array(ours.sensor.to_world), abs=1e-6)
