"""Files as renderers and exporters of Mitsuba 0.6's time wrote them: each word is read, or refused by its name."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import OpenImageIO
import pytest

from equaltime.errors import SceneError
from equaltime.scene import Scene, load, model

FILM = """
    <film type="ldrfilm"><integer name="width" value="32"/><integer name="height" value="18"/>
      <string name="fileFormat" value="png"/><string name="pixelFormat" value="rgb"/><float name="gamma" value="2.2"/>
      <boolean name="banner" value="false"/><rfilter type="tent"/></film>"""
SENSOR = """
  <integrator type="path"><integer name="maxDepth" value="65"/><boolean name="strictNormals" value="true"/></integrator>
  <sensor type="perspective"><float name="fov" value="35"/>
    <transform name="toWorld"><lookAt origin="0, 1, 5" target="0, 0, 0" up="0, 1, 0"/></transform>
    <sampler type="sobol"><integer name="sampleCount" value="64"/></sampler>{film}</sensor>"""
WOOD = '<string name="filename" value="wood.png"/>'
HEIGHTS = f'<texture type="bitmap">{WOOD}</texture>'


def read(folder: Path, body: str, film: str = FILM, integrator: str = "path", *, substitute: bool = False) -> Scene:
    wood = OpenImageIO.ImageBuf(np.random.default_rng(1).random((4, 4, 3)).astype(np.float32))
    assert wood.write(str(folder / "wood.png"), "uint8")
    head = SENSOR.format(film=film).replace('type="path"', f'type="{integrator}"')
    (folder / "scene.xml").write_text(f'<?xml version="1.0"?>\n<scene version="0.5.0">{head}\n{body}\n</scene>')
    return load(folder / "scene.xml", substitute=substitute)


def of_square(folder: Path, bsdf: str) -> model.Bsdf | None:
    shape = read(folder, f'<shape type="rectangle">{bsdf}</shape>').model.shapes[0]
    assert isinstance(shape, model.Rectangle)
    return shape.bsdf


@pytest.mark.parametrize("film", ["ldrfilm", "mfilm", "tiledhdrfilm"])
def test_films_that_are_gone_are_read_as_an_image(film: str, tmp_path: Path) -> None:
    formats = {"ldrfilm": "jpeg", "mfilm": "matlab"}
    text = FILM.replace("ldrfilm", film).replace('value="png"', f'value="{formats.get(film, "openexr")}"')
    loaded = read(tmp_path, "", text.replace('value="rgb"', 'value="luminanceAlpha"'))
    assert loaded.size == (32, 18)
    assert loaded.model.sensor.film.pixel_format == "luminance_alpha"
    assert any(note.endswith(f"'{film}' is read as 'hdrfilm'") for note in loaded.warnings)


def test_a_box_is_a_pixel_wide(tmp_path: Path) -> None:
    box = '<rfilter type="box"><float name="radius" value="{}"/></rfilter>'
    loaded = read(tmp_path, "", FILM.replace('<rfilter type="tent"/>', box.format(0.5)))
    assert loaded.model.sensor.film.rfilter == model.Box()
    with pytest.raises(SceneError, match=r"scene\.xml:9: unknown parameter 'radius' of 'box'"):
        read(tmp_path, "", FILM.replace('<rfilter type="tent"/>', box.format(2)))


def test_a_plastic_of_an_exporter_is_what_it_says(tmp_path: Path) -> None:
    body = """
  <bsdf type="twosided" id="Floor"><bsdf type="roughplastic"><rgb name="diffuseReflectance" value="0.5, 0.4, 0.3"/>
    <float name="alpha" value="0.1"/><float name="intIOR" value="1.5"/><float name="extIOR" value="1"/>
    <string name="distribution" value="ggx"/><boolean name="nonlinear" value="true"/></bsdf></bsdf>
  <shape type="rectangle"><ref id="Floor"/></shape>"""
    shape = read(tmp_path, body).model.shapes[0]
    assert isinstance(shape, model.Rectangle)
    assert isinstance(shape.bsdf, model.TwoSided)
    color = (0.5, 0.4, 0.3)
    assert shape.bsdf.bsdf[0] == model.RoughPlastic(
        diffuse_reflectance=color, alpha=0.1, int_ior=1.5, ext_ior=1.0, distribution="ggx", nonlinear=True
    )


def test_a_texture_may_wrap_each_axis_the_same_way(tmp_path: Path) -> None:
    both = '<string name="wrapModeU" value="mirror"/><string name="wrapModeV" value="mirror"/>'
    texture = f'<bsdf type="diffuse"><texture name="reflectance" type="bitmap">{WOOD}{both}</texture></bsdf>'
    found = of_square(tmp_path, texture)
    assert isinstance(found, model.Diffuse)
    assert isinstance(found.reflectance, model.Bitmap)
    assert found.reflectance.wrap_mode == "mirror"
    with pytest.raises(SceneError, match=r"scene\.xml:10: unknown parameter 'wrap_mode_u' of 'bitmap'"):
        of_square(tmp_path, texture.replace("mirror", "clamp", 1))


def test_what_bends_normals_may_have_any_name_and_a_factor(tmp_path: Path) -> None:
    scaled = f'<texture name="map" type="scale"><float name="scale" value="0.02"/>{HEIGHTS}</texture>'
    bump = of_square(tmp_path, f'<bsdf type="bumpmap">{scaled}<bsdf type="diffuse"/></bsdf>')
    assert isinstance(bump, model.BumpMap)
    assert isinstance(bump.texture, model.Bitmap)
    assert bump.scale == 0.02
    normals = f'<texture name="normals" type="bitmap"><float name="gamma" value="1"/>{WOOD}</texture>'
    bent = of_square(tmp_path, f'<bsdf type="normalmap">{normals}<bsdf type="diffuse"/></bsdf>')
    assert isinstance(bent, model.NormalMap)
    assert isinstance(bent.normalmap, model.Bitmap)
    assert bent.normalmap.raw


def test_words_that_never_touched_the_image_are_left_out(tmp_path: Path) -> None:
    (tmp_path / "m.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    color = '<bsdf type="diffuse"><rgb name="reflectance" value="0.5 0.4 0.3" intent="reflectance"/></bsdf>'
    mesh = '<string name="filename" value="m.obj"/><boolean name="collapse" value="true"/>'
    sky = f'{WOOD}<boolean name="cache" value="false"/>'
    body = f'<shape type="obj">{mesh}{color}</shape><emitter type="envmap">{sky}</emitter>'
    loaded = read(tmp_path, body)
    for word in ("'collapse' of 'obj'", "'cache' of 'envmap'"):
        assert any(f"{word} is left out: it has no meaning any more" in note for note in loaded.warnings)
    assert loaded.model.shapes[0].bsdf == model.Diffuse(reflectance=(0.5, 0.4, 0.3))  # type: ignore[union-attr]


def test_vertex_colours_are_an_attribute(tmp_path: Path) -> None:
    found = of_square(tmp_path, '<bsdf type="diffuse"><texture name="reflectance" type="vertexcolors"/></bsdf>')
    assert found == model.Diffuse(reflectance=model.MeshAttribute(name="vertex_color"))


@pytest.mark.parametrize("integrator", ["bdpt", "pssmlt", "ao", "photonmapper"])
def test_an_integrator_of_old_is_refused_by_name_and_replaced_on_request(integrator: str, tmp_path: Path) -> None:
    told = (
        rf"scene\.xml:3: the integrator '{integrator}' is one of Mitsuba 0\.6, .* do not have; --substitute replaces it"
    )
    with pytest.raises(SceneError, match=told):
        read(tmp_path, "", integrator=integrator)
    loaded = read(tmp_path, "", integrator=integrator, substitute=True)
    assert loaded.model.integrator.type == "path"
    assert loaded.max_depth == 65


def test_a_rough_diffuse_surface_is_read_as_it_was_written(tmp_path: Path) -> None:
    flag = '<boolean name="useFastApprox" value="true"/>'
    for name in ("reflectance", "diffuseReflectance"):
        bsdf = f'<bsdf type="roughdiffuse"><rgb name="{name}" value="0.3"/><float name="alpha" value="0"/>{flag}</bsdf>'
        grey = (0.3, 0.3, 0.3)
        assert of_square(tmp_path, bsdf) == model.RoughDiffuse(reflectance=grey, alpha=0.0, use_fast_approx=True)
    alpha = HEIGHTS.replace("<texture", '<texture name="alpha"')
    textured = of_square(tmp_path, f'<bsdf type="roughdiffuse">{alpha}</bsdf>')
    assert textured == model.RoughDiffuse(alpha=model.Bitmap(filename="wood.png"))


def test_hair_and_walls_of_old_are_refused_by_name_and_replaced_on_request(tmp_path: Path) -> None:
    hair = '<shape type="hair"><string name="filename" value="h.hair"/><float name="radius" value="0.01"/></shape>'
    wall = '<shape type="disk"><bsdf type="hk"><rgb name="reflectance" value="0.3"/></bsdf></shape>'
    with pytest.raises(SceneError) as error:
        read(tmp_path, hair + wall)
    for what in ("shape 'hair'", "bsdf 'hk'"):
        assert f"the {what} is one of Mitsuba 0.6" in str(error.value)
    (shape,) = read(tmp_path, hair + wall, substitute=True).model.shapes
    assert shape.bsdf == model.Diffuse(reflectance=(0.3, 0.3, 0.3))  # type: ignore[union-attr]


def test_parameters_that_mitsuba_3_has_no_more_are_refused_by_name_or_left_out_on_request(tmp_path: Path) -> None:
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    body = (
        '<shape type="obj"><string name="filename" value="a.obj"/><float name="maxSmoothAngle" value="30"/>'
        f'<bsdf type="diffuse"><texture type="bitmap" name="reflectance">{WOOD}<string name="channel" value="r"/>'
        '<float name="gamma" value="2.2"/></texture></bsdf></shape>'
    )
    with pytest.raises(SceneError) as refused:
        read(tmp_path, body)
    words = "is one of Mitsuba 0.6, which Mitsuba 3 and equaltime do not have; --substitute leaves it out"
    named = ("'channel' of 'bitmap'", "'gamma' of 'bitmap'", "'max_smooth_angle' of 'obj'")
    assert sorted(problem.message for problem in refused.value.problems) == [f"{name} {words}" for name in named]
    loaded = read(tmp_path, body, substitute=True)
    assert sorted(done.what for done in loaded.substitutions) == [f"parameter {name}" for name in named]


def test_three_samples_of_a_spectrum_are_a_colour(tmp_path: Path) -> None:
    found = of_square(tmp_path, '<bsdf type="diffuse"><spectrum name="reflectance" value="0.25, 0.5 0.75"/></bsdf>')
    assert isinstance(found, model.Diffuse)
    assert found.reflectance == (0.25, 0.5, 0.75)
