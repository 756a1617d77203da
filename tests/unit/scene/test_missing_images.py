"""Images that a scene names and that are missing: told once each, or replaced on request."""

from __future__ import annotations

from pathlib import Path

import pytest

import equaltime as et
from equaltime.cli import main
from equaltime.scene import model as m

HALL = """<scene version="3.0.0">
<sensor type="perspective"><film type="hdrfilm"><integer name="width" value="8"/></film></sensor>
<emitter type="envmap"><string name="filename" value="sky.exr"/></emitter>
<bsdf type="diffuse" id="wood"><texture type="bitmap" name="reflectance" id="grain">
<string name="filename" value="wood.png"/></texture></bsdf>
<texture type="bitmap" id="leaf"><string name="filename" value="leaf.png"/></texture>
<shape type="sphere"><ref id="wood"/></shape>
<shape type="rectangle"><bsdf type="mask"><ref name="opacity" id="leaf"/><ref id="wood"/></bsdf></shape>
<shape type="sphere"><bsdf type="normalmap"><texture name="normalmap" type="bitmap"><boolean name="raw" value="true"/>
<string name="filename" value="relief.png"/></texture><bsdf type="plastic">
<texture type="bitmap" name="diffuse_reflectance"><string name="filename" value="wood.png"/></texture>
</bsdf></bsdf></shape>
<emitter type="spot"><float name="intensity" value="3"/><texture type="bitmap" name="texture">
<string name="filename" value="slide.png"/></texture></emitter>
<shape type="sphere"><bsdf type="principled"><texture type="bitmap" name="base_color">
<string name="filename" value="wood.png"/></texture></bsdf></shape>
</scene>
"""


@pytest.fixture
def hall(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    Path("scene.xml").write_text(HALL)
    return Path("scene.xml")


def test_each_missing_image_is_told_once(hall: Path) -> None:
    with pytest.raises(et.SceneError) as error:
        et.load(hall)
    assert [str(problem) for problem in error.value.problems] == [
        "scene.xml:3: no such file: sky.exr; --substitute replaces it",
        "scene.xml:5: no such file: wood.png (and 2 more places); --substitute replaces it",
        "scene.xml:6: no such file: leaf.png; --substitute replaces it",
        "scene.xml:10: no such file: relief.png; --substitute replaces it",
        "scene.xml:14: no such file: slide.png; --substitute replaces it",
    ]


def test_missing_images_are_replaced_on_request(hall: Path) -> None:
    scene = et.load(hall, substitute=True)
    assert [str(done) for done in scene.substitutions] == [
        "scene.xml:3: the emitter 'envmap' of the missing image 'sky.exr' is replaced by 'constant'",
        "scene.xml:8: the bsdf 'mask' of the missing image 'leaf.png' is replaced by the 'diffuse' in it",
        "scene.xml:9: the bsdf 'normalmap' of the missing image 'relief.png' is replaced by the 'plastic' in it",
        "scene.xml:13: the emitter 'spot' of the missing image 'slide.png' is replaced by one without an image",
        "scene.xml:5: the missing image 'wood.png' is replaced by a grey of 0.5, here and in 2 more places",
        "scene.xml:6: the missing image 'leaf.png' is replaced by a grey of 0.5",
    ]
    surfaces = [shape.bsdf for shape in scene.model.shapes if isinstance(shape, m.Solid)]
    wood, plastic = m.Diffuse(reflectance=0.5), m.Plastic(diffuse_reflectance=0.5)
    assert surfaces == [wood.replace(id="wood"), wood, plastic, m.Principled(base_color=0.5)]
    sky, spot = scene.model.emitters
    assert sky == m.Constant(radiance=1.0)
    assert isinstance(spot, m.Spot)
    assert (spot.texture, spot.intensity) == (None, (3.0, 3.0, 3.0))


def test_a_mesh_that_is_missing_stays_an_error(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "scene.toml"
    file.write_text('a = { type = "ply", filename = "a.ply" }\nb = { type = "ply", filename = "a.ply" }\n')
    assert main(["render", str(file), "-o", str(tmp_path / "a.png"), "--substitute"]) == 2
    missing = f"no such file: {tmp_path / 'a.ply'} (and 1 more place)"
    assert capsys.readouterr().err == f"error: {file}:1: a.filename: {missing}\n"


def test_a_surface_that_contains_itself_is_refused(hall: Path) -> None:
    hall.write_text(HALL.replace('<bsdf type="mask">', '<bsdf type="mask" id="loop"><ref id="loop"/>'))
    with pytest.raises(et.SceneError, match="the object contains itself"):
        et.load(hall, substitute=True)
