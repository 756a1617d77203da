"""Images that a scene names and that are missing: told once each, or replaced on request."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import equaltime as et
from equaltime.cli import main
from equaltime.scene import model as m

from .gltf_files import SQUARE, Builder, encoded

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


PNG = b"\x89PNG, damaged"
BASIS: dict[str, Any] = {"extensions": {"KHR_texture_basisu": {"source": 0}}}


def square(image: dict[str, Any], texture: dict[str, Any] | None = None, **more: Any) -> Builder:
    """Return a square whose material has one image for everything, with a factor for each use."""
    builder, use = Builder(), {"index": 0}
    uvs = [[0, 0], [1, 0], [1, 1], [0, 1]]
    mesh = builder.mesh(SQUARE, [0, 1, 2, 0, 2, 3], TEXCOORD_0=uvs, material=0, **more)
    builder.node(mesh=mesh)
    factors = {"baseColorFactor": [1.0, 0.5, 0.25, 0.75], "metallicFactor": 0.25, "roughnessFactor": 0.5}
    surface = {"baseColorTexture": use, "metallicRoughnessTexture": use, **factors}
    light = {"emissiveTexture": use, "emissiveFactor": [0.5, 1, 1], "alphaMode": "BLEND"}
    builder.add("materials", {"pbrMetallicRoughness": surface, "normalTexture": use, "occlusionTexture": use, **light})
    builder.json |= {"images": [image], "textures": [texture or {"source": 0}]}
    if texture is BASIS:
        builder.json |= {"extensionsUsed": ["KHR_texture_basisu"], "extensionsRequired": ["KHR_texture_basisu"]}
    return builder


def lost(builder: Builder, file: Path) -> et.Scene:
    """Write a file, see that it is refused once and with advice, and return the scene with substitutes."""
    written = builder.glb(file) if file.suffix == ".glb" else builder.gltf(file)
    with pytest.raises(et.SceneError) as error:
        et.load(written)
    (problem,) = map(str, error.value.problems)
    assert problem.startswith(f"{file}: materials[0]: ")
    assert problem.endswith("; --substitute replaces it")
    return et.load(written, substitute=True)


@pytest.mark.parametrize("name", ["model.gltf", "model.glb"])
@pytest.mark.parametrize(
    ("image", "texture", "told"),
    [
        ({"uri": "gone%20%C3%A4.png"}, None, "missing image 'gone%20%C3%A4.png'"),
        ({"uri": "data:image/png;base64,AAAA"}, None, "unreadable image 'images[0]'"),
        (None, None, "unreadable image 'images[0]'"),
        (None, BASIS, "unreadable image 'textures[0]'"),
    ],
)
def test_lost_images_of_gltf_leave_the_factors(
    name: str, image: dict[str, Any] | None, texture: dict[str, Any] | None, told: str, tmp_path: Path
) -> None:
    builder = square(image or {}, texture)
    if image is None:
        builder.json["images"] = [{"bufferView": builder.view(PNG), "mimeType": "image/png"}]
    scene = lost(builder, tmp_path / name)
    place = f"{tmp_path / name}: materials[0]"
    assert [str(done) for done in scene.substitutions] == [
        f"{place}: the bsdf 'normalmap' of the {told} is replaced by the 'principled' in it",
        f"{place}: the {told} is replaced by the factor alone",
        f"{place}: the {told} is replaced by a grey of 0.5 times the factor",
    ]
    (shape,) = scene.model.shapes
    assert isinstance(shape, m.Gltf)
    assert isinstance(shape.bsdf, m.Mask)
    assert shape.bsdf.opacity == 0.75
    inner = shape.bsdf.bsdf
    assert isinstance(inner, m.Principled)
    assert (inner.base_color, inner.metallic, inner.roughness) == ((0.5, 0.25, 0.125), 0.25, 0.5)
    assert isinstance(shape.emitter, m.Area)
    assert shape.emitter.radiance == (0.375, 0.75, 0.75)


def test_vertex_colors_are_multiplied_by_the_factor_of_a_lost_image(tmp_path: Path) -> None:
    scene = lost(square({"uri": "gone.png"}, COLOR_0=[[1, 0, 0, 0.5]] * 4), tmp_path / "model.gltf")
    (shape,) = scene.model.shapes
    assert isinstance(shape, m.Gltf)
    assert isinstance(shape.bsdf, m.Mask)
    grey, color = (0.75,) * 3, (0.5, 0.25, 0.125)
    assert shape.bsdf.opacity == m.MeshAttribute(name="vertex_alpha", times=m.Checkerboard(color0=grey, color1=grey))
    assert isinstance(shape.bsdf.bsdf, m.Principled)
    assert shape.bsdf.bsdf.base_color == m.MeshAttribute(
        name="vertex_color", times=m.Checkerboard(color0=color, color1=color)
    )


def test_an_image_whose_numbers_cannot_be_used_has_no_substitute(tmp_path: Path) -> None:
    """Factors that overflow are an error of the material, which no substitute hides."""
    builder = square({})
    pixels = np.full((2, 2, 3), 255, np.uint8)
    builder.json["images"] = [{"bufferView": builder.view(encoded(pixels, tmp_path)), "mimeType": "image/png"}]
    strength = {"KHR_materials_emissive_strength": {"emissiveStrength": 3e38}}
    builder.json["materials"][0] |= {"emissiveFactor": [2, 2, 2], "extensions": strength, "alphaMode": "OPAQUE"}
    file = builder.gltf(tmp_path / "model.gltf")
    with pytest.raises(et.SceneError) as error:
        et.load(file, substitute=True)
    assert str(error.value).endswith("materials[0]: a texel of its radiance is not finite")


def test_a_texture_of_basis_that_nothing_uses_is_no_error(tmp_path: Path) -> None:
    builder = square({"uri": "gone.ktx2"}, BASIS)
    builder.json["materials"] = [{}]
    assert et.load(builder.gltf(tmp_path / "model.gltf")).substitutions == ()


def test_a_buffer_that_is_missing_stays_one_error(tmp_path: Path) -> None:
    file = square({"uri": "gone.png"}).gltf(tmp_path / "model.gltf")
    content = json.loads(file.read_text())
    content["buffers"][0]["uri"] = "gone.bin"
    file.write_text(json.dumps(content))
    with pytest.raises(et.SceneError) as error:
        et.load(file, substitute=True)
    (problem,) = map(str, error.value.problems)
    missing = f"buffers[0].uri: no such file: {tmp_path / 'gone.bin'}"
    assert problem == f"{file}: meshes[0].primitives[0]: {missing}"


def test_a_scene_with_lost_images_of_gltf_is_converted_to_one_that_needs_no_substitutes(tmp_path: Path) -> None:
    file = square({"uri": "gone.png"}).gltf(tmp_path / "model.gltf")
    assert main(["convert", str(file), str(tmp_path / "scene.toml"), "--substitute"]) == 0
    assert et.load(tmp_path / "scene.toml").substitutions == ()
