"""What an XML scene takes from elsewhere: included files, folders to look in, other names, old words."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from equaltime import SceneError
from equaltime.scene import Scene, load
from equaltime.scene import model as m

SENSOR = '<sensor type="perspective"/>'


def read(folder: Path, body: str, version: str = "3.0.0", **defines: object) -> Scene:
    file = folder / "scene.xml"
    file.write_text(f'<scene version="{version}">\n{SENSOR}{body}\n</scene>\n')
    return load(file, **defines)


def shape(folder: Path, body: str, version: str = "3.0.0") -> m.Shape:
    return read(folder, f'<shape type="sphere">{body}</shape>', version).model.shapes[0]


def bsdf(folder: Path, body: str, version: str = "0.6.0") -> m.Bsdf:
    found = shape(folder, body, version)
    assert isinstance(found, m.Sphere)
    assert found.bsdf is not None
    return found.bsdf


# -- other files -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "text",
    [
        b'<scene version="3.0.0">\n<!-- ------ Camera -- 1 ------ -->\n<sensor type="perspective"/></scene>',
        b'\n \n<?xml version="1.0"?>\n<scene version="3.0.0"><sensor type="perspective"/></scene>',
        b'<scene version="3.0.0"><sensor type="perspective" id="caf\xe9"/></scene>',
        b'<?xml version="1.0" encoding="utf-8"?><scene version="3.0.0"><sensor type="perspective" id="\xe9"/></scene>',
        b'<scene version="3.0.0"><default name="x" value="a & b &amp; &#65;"/>\n<sensor type="perspective"/></scene>',
    ],
)
def test_what_mitsuba_reads_though_it_is_no_xml_is_read_and_told(text: bytes, tmp_path: Path) -> None:
    (tmp_path / "scene.xml").write_bytes(text)
    scene = load(tmp_path / "scene.xml")
    assert isinstance(scene.model.sensor, m.Perspective)
    assert any("it is read nevertheless, as Mitsuba does" in warning for warning in scene.warnings)


def test_a_mistake_in_a_file_that_is_no_xml_has_its_own_line(tmp_path: Path) -> None:
    text = '\n<?xml version="1.0"?>\n<scene version="3.0.0">\n<!-- a -- b\n-->\n<shape type="shpere"/></scene>'
    (tmp_path / "scene.xml").write_text(text)
    with pytest.raises(SceneError, match=r"scene\.xml:6: .*did you mean 'sphere'"):
        load(tmp_path / "scene.xml")


def test_of_a_file_that_is_no_xml_at_all_the_place_is_told_where_mitsuba_would_stop(tmp_path: Path) -> None:
    (tmp_path / "scene.xml").write_text('<scene version="3.0.0">\n<!-- -- -->\n<shape>\n</bsdf></scene>')
    with pytest.raises(SceneError, match=r"scene\.xml:4: not well-formed XML: mismatched tag"):
        load(tmp_path / "scene.xml")


def test_comments_that_do_not_end_take_no_time(tmp_path: Path) -> None:
    (tmp_path / "scene.xml").write_text('<scene version="3.0.0">' + "<!-- -- " * 100_000)
    with pytest.raises(SceneError, match="not well-formed XML"):
        load(tmp_path / "scene.xml")


def test_an_included_scene_adds_its_objects_and_shares_variables(tmp_path: Path) -> None:
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "balls.xml").write_text(
        '<scene version="3.0.0"><default name="size" value="1"/><shape type="sphere" id="ball">'
        '<float name="radius" value="$size"/><ref id="red"/></shape></scene>'
    )
    body = '<default name="size" value="3"/><bsdf type="null" id="red"/><include filename="parts/balls.xml"/>'
    for defines, radius in (({}, 3.0), ({"size": 5}, 5.0)):
        assert read(tmp_path, body, **defines).model.shapes == (
            m.Sphere(id="ball", radius=radius, bsdf=m.Null(id="red")),
        )


def test_a_file_is_included_from_beside_the_file_that_names_it_as_in_mitsuba(tmp_path: Path) -> None:
    """Files beside the scene, in a folder of <path> and in the folder of an earlier <include> have the same name."""
    for folder, value in ((".", 0.1), ("parts", 0.2), ("parts/more", 0.3)):
        (tmp_path / folder).mkdir(exist_ok=True)
        grey = f'<bsdf type="diffuse" id="grey"><float name="reflectance" value="{value}"/></bsdf>'
        (tmp_path / folder / "grey.xml").write_text(f'<scene version="3.0.0">{grey}</scene>')
        (tmp_path / folder / "by.xml").write_text('<scene version="3.0.0"><include filename="grey.xml"/></scene>')
    (tmp_path / "parts" / "far.xml").write_text('<scene version="3.0.0"><include filename="parts/grey.xml"/></scene>')
    for body, value in (
        ('<include filename="parts/by.xml"/>', 0.2),
        ('<include filename="parts/more/by.xml"/>', 0.3),
        ('<path value="parts/more"/><include filename="grey.xml"/>', 0.1),
        ('<path value="parts/more"/><include filename="parts/by.xml"/>', 0.2),
        ('<include filename="parts/far.xml"/>', 0.2),
    ):
        assert shape(tmp_path, f'<ref id="grey"/></shape>{body}<shape type="cube">').bsdf.reflectance == (value,) * 3


def test_an_included_object_stands_where_it_is_included(tmp_path: Path) -> None:
    (tmp_path / "red.xml").write_text('<bsdf type="diffuse" version="3.0.0"><rgb name="reflectance" value="1"/></bsdf>')
    assert shape(tmp_path, '<include filename="red.xml"/>').bsdf == m.Diffuse(reflectance=1)  # type: ignore[union-attr]


def test_each_file_is_upgraded_by_its_own_version(tmp_path: Path) -> None:
    (tmp_path / "old.xml").write_text('<bsdf type="plastic" version="0.5.0"><float name="intIOR" value="2"/></bsdf>')
    assert shape(tmp_path, '<include filename="old.xml"/>').bsdf == m.Plastic(int_ior=2)  # type: ignore[union-attr]


def test_a_mistake_in_an_included_file_is_told_with_its_own_line(tmp_path: Path) -> None:
    (tmp_path / "part.xml").write_text('<scene version="3.0.0">\n\n<shape type="spere"/></scene>')
    with pytest.raises(SceneError, match=r"part\.xml:3: unknown shape 'spere'; did you mean 'sphere'\?"):
        read(tmp_path, '<include filename="part.xml"/>')


def test_files_are_looked_for_in_the_folders_that_the_scene_names(tmp_path: Path) -> None:
    (tmp_path / "data").mkdir()
    (tmp_path / "data" / "grey.spd").write_bytes(b"\xef\xbb\xbf# grey\r\n360 0.5\r830\t0.5  # end\n")
    body = '<path value="data"/><shape type="sphere"><bsdf type="diffuse">{}</bsdf></shape>'
    (found,) = read(tmp_path, body.format('<spectrum name="reflectance" filename="grey.spd"/>')).model.shapes
    assert found.bsdf.reflectance == pytest.approx((0.5, 0.5, 0.5), abs=1e-3)  # type: ignore[union-attr]


def test_names_written_on_windows_are_found(tmp_path: Path) -> None:
    (tmp_path / "data").mkdir()
    (tmp_path / "data" / "grey.spd").write_bytes(b"\xef\xbb\xbf360 0.5\n830 0.5")
    assert bsdf(tmp_path, r'<bsdf type="diffuse"><spectrum name="reflectance" filename="data\grey.spd"/></bsdf>')


def test_an_object_may_have_another_name(tmp_path: Path) -> None:
    (ball,) = read(
        tmp_path,
        '<bsdf type="null" id="red"/><alias id="red" as="blue"/><shape type="sphere"><ref id="blue"/></shape>',
    ).model.shapes
    assert ball.bsdf == m.Null(id="red")  # type: ignore[union-attr]


# -- spectra ---------------------------------------------------------------------------------------------------------


def test_a_spectrum_is_a_colour_of_light_or_of_a_surface(tmp_path: Path) -> None:
    pairs = "400:0.1, 500:0.2 600 : 0.9, 700:0.3"
    surface = bsdf(tmp_path, f'<bsdf type="diffuse"><spectrum name="reflectance" value="{pairs}"/></bsdf>')
    assert surface.reflectance == pytest.approx((0.935472, 0.498117, 0.100384), rel=1e-5)  # type: ignore[union-attr]
    lamp = shape(tmp_path, f'<emitter type="area"><spectrum name="radiance" value="{pairs}"/></emitter>')
    assert lamp.emitter.radiance == pytest.approx((1.069472, 0.481563, 0.083441), rel=1e-5)  # type: ignore[union-attr]


def test_a_black_body_is_reddish_when_cool_and_blueish_when_hot(tmp_path: Path) -> None:
    def light(kelvins: float) -> tuple[float, float, float]:
        body = f'<spectrum type="blackbody" name="radiance"><float name="temperature" value="{kelvins}"/></spectrum>'
        return shape(tmp_path, f'<emitter type="area">{body}</emitter>').emitter.radiance  # type: ignore[union-attr,return-value]

    (red, _, blue), (red_hot, _, blue_hot) = light(2800), light(12000)
    assert red > 4 * blue
    assert blue_hot > red_hot
    white = np.array(light(6504)) / light(6504)[1]
    assert white == pytest.approx((1, 1, 1), abs=0.1)  # the colour of D65 is nearly that of such a body


def test_plain_spectra_of_emission_are_as_they_are(tmp_path: Path) -> None:
    for spectrum, expected in (
        ('<spectrum name="radiance" type="uniform"><float name="value" value="2"/></spectrum>', (2, 2, 2)),
        ('<spectrum name="radiance" type="d65"><float name="scale" value="2"/></spectrum>', (2, 2, 2)),
        ('<spectrum name="radiance" type="srgb"><rgb name="color" value="1 2 3"/></spectrum>', (1, 2, 3)),
        ('<spectrum name="radiance" type="rawconstant"><vector name="value" value="1 2 3"/></spectrum>', (1, 2, 3)),
    ):
        emitter = shape(tmp_path, f'<emitter type="area">{spectrum}</emitter>').emitter  # type: ignore[union-attr]
        assert emitter == m.Area(radiance=expected)


# -- old versions ----------------------------------------------------------------------------------------------------


def test_words_of_old_versions_are_brought_up_to_date(tmp_path: Path) -> None:
    assert bsdf(
        tmp_path,
        '<bsdf type="roughplastic"><rgb name="diffuseReflectance" value="0.1 0.2 0.3"/><float name="intIOR" value="2"/>'
        '<string name="extIOR" value="water"/><float name="alpha" value="0.2"/></bsdf>',
    ) == m.RoughPlastic(diffuse_reflectance=(0.1, 0.2, 0.3), int_ior=2, ext_ior="water", alpha=0.2)
    diffuse = '<bsdf type="diffuse"><rgb name="diffuseReflectance" value="0.1"/></bsdf>'
    assert bsdf(tmp_path, diffuse) == m.Diffuse(reflectance=0.1)


def test_scale_and_offset_of_texture_coordinates_become_a_transform(tmp_path: Path) -> None:
    found = bsdf(
        tmp_path,
        '<bsdf type="diffuse"><texture type="checkerboard" name="reflectance"><float name="uscale" value="8"/>'
        '<float name="vscale" value="4"/><float name="uoffset" value="0.5"/></texture></bsdf>',
    )
    assert isinstance(found, m.Diffuse)
    assert isinstance(found.reflectance, m.Checkerboard)
    assert found.reflectance.uv_rows == ((8.0, 0.0, 4.0), (0.0, 4.0, 0.0))


def test_an_old_camera_is_read(tmp_path: Path) -> None:
    (tmp_path / "scene.xml").write_text(
        '<scene version="0.4.0"><sensor type="perspective"><string name="fovAxis" value="smaller"/><float name="fov" '
        'value="28"/><float name="nearClip" value="10"/><float name="shutterOpen" value="0"/><transform name="toWorld">'
        '<lookAt origin="0, 2, 15" target="0, -2, 2.5" up="0, 1, 0"/></transform><sampler type="sobol"><integer '
        'name="sampleCount" value="16"/><integer name="dimension" value="1"/></sampler><film type="ldrfilm">'
        '<float name="gamma" value="2.2"/><integer name="width" value="32"/></film></sensor></scene>'
    )
    loaded = load(tmp_path / "scene.xml")
    assert loaded.spp == 16
    assert loaded.model.sensor.near_clip == 10
    assert np.array(loaded.model.sensor.to_world)[:3, 3].tolist() == [0, 2, 15]
    assert [note.rsplit("scene.xml:1: ", 1)[1] for note in loaded.warnings] == [
        "'dimension' of 'sobol' is left out: it has no meaning any more",
        "'sobol' is read as 'ldsampler'",
        "'gamma' of 'ldrfilm' is left out: it has no meaning any more",
        "'ldrfilm' is read as 'hdrfilm'",
    ]


def test_the_index_of_a_metal_is_taken_relative_to_what_is_around_it(tmp_path: Path) -> None:
    body = '<bsdf type="conductor"><float name="extEta" value="2"/>{}</bsdf>'
    given = bsdf(tmp_path, body.format('<rgb name="eta" value="1 2 3"/><spectrum name="k" value="4"/>'))
    assert given == m.Conductor(eta=(0.5, 1.0, 1.5), k=2.0)
    named = bsdf(tmp_path, body.format('<string name="material" value="Au"/>'))
    assert isinstance(named, m.Conductor)
    assert np.array(named.ior) == pytest.approx(np.array(m.METALS["Au"]) / 2)


def test_old_colours_are_decoded(tmp_path: Path) -> None:
    grey = bsdf(tmp_path, '<bsdf type="diffuse"><srgb name="reflectance" value="#ff8000"/></bsdf>')
    assert grey.reflectance == pytest.approx((1.0, 0.2158605, 0.0))  # type: ignore[union-attr]
    raw = bsdf(
        tmp_path,
        '<bsdf type="diffuse"><texture type="checkerboard" name="reflectance"/></bsdf>',
    )
    assert raw == m.Diffuse(reflectance=m.Checkerboard())


def test_old_words_in_a_new_file_are_mistakes(tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=r"unknown parameter 'intIOR' of 'plastic'; did you mean 'int_ior'\?"):
        bsdf(tmp_path, '<bsdf type="plastic"><float name="intIOR" value="2"/></bsdf>', "3.0.0")
