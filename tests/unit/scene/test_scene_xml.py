"""Scenes in Mitsuba 3's XML."""

from pathlib import Path

import numpy as np
import pytest

from equaltime import SceneError
from equaltime.scene import Scene, load
from equaltime.scene import model as m

SENSOR = '<sensor type="perspective"/>'


def read(folder: Path, body: str, version: str = "3.0.0", **defines: object) -> Scene:
    file = folder / "scene.xml"
    file.write_text(f'<scene version="{version}">\n{body}\n</scene>\n')
    return load(file, **defines)


def problems(folder: Path, body: str, **defines: object) -> list[str]:
    with pytest.raises(SceneError) as error:
        read(folder, body, **defines)
    return [str(problem).removeprefix(f"{folder}/") for problem in error.value.problems]


def shape(folder: Path, body: str) -> m.Shape:
    return read(folder, f'{SENSOR}<shape type="sphere">{body}</shape>').model.shapes[0]


# -- what can be written ---------------------------------------------------------------------------------------------


def test_elements_become_the_same_model_as_a_dictionary(tmp_path: Path) -> None:
    loaded = read(
        tmp_path,
        """
        <integrator type="path"><integer name="max_depth" value="7"/></integrator>
        <sensor type="perspective">
            <float name="fov" value="35"/>
            <string name="fov_axis" value="smaller"/>
            <sampler type="multijitter"><integer name="sample_count" value="16"/></sampler>
            <film type="hdrfilm"><integer name="width" value="20"/><integer name="height" value="10"/>
                <rfilter type="tent"><float name="radius" value="2"/></rfilter></film>
        </sensor>
        <bsdf type="twosided" id="wall">
            <bsdf type="diffuse"><rgb name="reflectance" value="0.1, 0.2 0.3"/></bsdf>
        </bsdf>
        <shape type="sphere" id="lamp">
            <point name="center" x="1" y="2" z="3"/>
            <float name="radius" value="0.5"/>
            <boolean name="flip_normals" value="True"/>
            <ref id="wall"/>
            <emitter type="area"><rgb name="radiance" value="#ffffff"/></emitter>
        </shape>
        """,
    )
    assert loaded.model.sensor == m.Perspective(
        fov=35.0,
        fov_axis="smaller",
        film=m.HdrFilm(width=20, height=10, rfilter=m.Tent(radius=2)),
        sampler=m.MultiJitter(sample_count=16),
    )
    assert loaded.model.shapes == (
        m.Sphere(
            id="lamp",
            center=(1, 2, 3),
            radius=0.5,
            flip_normals=True,
            bsdf=m.TwoSided(id="wall", bsdf=(m.Diffuse(reflectance=(0.1, 0.2, 0.3)),)),
            emitter=m.Area(radiance=(1, 1, 1)),
        ),
    )
    assert (loaded.max_depth, loaded.spp, loaded.size) == (7, 16, (20, 10))


@pytest.mark.parametrize("text", ['value="1 2 3"', 'value="1,2,3"', 'value=" 1.0, 2.0 ,3.0 "', 'x="1" y="2" z="3"'])
def test_a_point_can_be_written_in_two_ways(tmp_path: Path, text: str) -> None:
    assert shape(tmp_path, f'<point name="center" {text}/>') == m.Sphere(center=(1, 2, 3))


def test_a_constant_spectrum_is_grey_where_it_reflects_and_equal_energy_where_it_shines(tmp_path: Path) -> None:
    body = '<bsdf type="diffuse"><spectrum name="reflectance" value="0.5"/></bsdf>'
    body += '<emitter type="area"><spectrum name="radiance" value="2"/></emitter>'
    loaded = shape(tmp_path, body)
    assert isinstance(loaded.bsdf, m.Diffuse)
    assert loaded.bsdf.reflectance == (0.5, 0.5, 0.5)
    assert loaded.emitter is not None
    assert loaded.emitter.radiance == pytest.approx((2.409588, 1.896582, 1.817832), abs=1e-5)


def test_the_steps_of_a_transform_are_applied_in_order(tmp_path: Path) -> None:
    steps = """
        <matrix value="0 1 0 0  1 0 0 0  0 0 1 0  0 0 0 1"/><scale value="2"/><rotate z="1" angle="90"/>
        <rotate value="0, 1, 0" angle="0"/><scale x="1"/><translate x="1" z="3"/><matrix value="1 0 0 0 1 0 0 0 1"/>
    """
    loaded = shape(tmp_path, f'<transform name="to_world">{steps}</transform>')
    expected = np.array([[-2, 0, 0, 1], [0, 2, 0, 0], [0, 0, 2, 3], [0, 0, 0, 1]])
    assert np.array(loaded.to_world) == pytest.approx(expected, abs=1e-15)


def test_look_at_places_the_camera(tmp_path: Path) -> None:
    camera = '<lookat origin="1, 2, 3" target="1, 2, 4" up="0, 1, 0"/>'
    loaded = read(tmp_path, f'<sensor type="perspective"><transform name="to_world">{camera}</transform></sensor>')
    assert loaded.model.sensor.to_world == ((1, 0, 0, 1), (0, 1, 0, 2), (0, 0, 1, 3), (0, 0, 0, 1))


def test_comments_and_a_declaration_do_no_harm(tmp_path: Path) -> None:
    file = tmp_path / "scene.xml"
    file.write_text(
        f'<?xml version="1.0" encoding="utf-8"?>\n<!-- hi -->\n<scene version="3.5.0">{SENSOR}<!-- -->\n</scene>'
    )
    assert load(file).model == m.SceneModel(sensor=m.Perspective())


# -- variables -------------------------------------------------------------------------------------------------------

DEPTH = (
    '<default name="depth" value="3"/><integrator type="path"><integer name="max_depth" value="$depth"/></integrator>'
)


def test_a_variable_has_its_default_unless_it_is_defined(tmp_path: Path) -> None:
    assert read(tmp_path, SENSOR + DEPTH).max_depth == 3
    assert read(tmp_path, SENSOR + DEPTH, depth=5).max_depth == 5
    assert read(tmp_path, SENSOR + DEPTH, depth="6").max_depth == 6


def test_a_variable_needs_no_default_and_may_be_part_of_a_value(tmp_path: Path) -> None:
    body = '<shape type="sphere" id="$a-$b\\$"><point name="center" value="$a 0 $b"/></shape>'
    loaded = read(tmp_path, SENSOR + body, a=1, b=2.5).model.shapes[0]
    assert loaded == m.Sphere(id="1-2.5$", center=(1, 0, 2.5))


def test_a_definition_that_nothing_uses_is_an_error_with_the_nearest_name(tmp_path: Path) -> None:
    assert problems(tmp_path, SENSOR + DEPTH, dept=5) == [
        "scene.xml: nothing in the scene uses the definition 'dept'; did you mean 'depth'?"
    ]


def test_a_variable_without_a_value_is_an_error(tmp_path: Path) -> None:
    assert problems(tmp_path, f'{SENSOR}\n{DEPTH}\n<shape type="$dept"/>') == [
        "scene.xml:4: the variable $dept has no value: give it one with -D dept=..., or did you mean $depth?"
    ]


def test_an_unknown_integrator_from_a_variable_says_how_to_choose_another(tmp_path: Path) -> None:
    body = f'{SENSOR}<default name="which" value="path_guiding_integrator"/>\n<integrator type="$which"/>'
    assert problems(tmp_path, body) == [
        "scene.xml:3: unknown integrator 'path_guiding_integrator', the value of $which; choose one with -D which=path"
    ]
    assert "'stokes', the value of $which, is known to Mitsuba 3" in problems(tmp_path, body, which="stokes")[0]
    assert read(tmp_path, body, which="volpath").max_depth == -1


# -- what is wrong ---------------------------------------------------------------------------------------------------


IN_THE_SCENE = [
    ("<blob/>", "unknown element <blob>; expected one of"),
    ("<lookAt/>", "<lookAt> belongs in a <transform>"),
    ('<srgb name="x" value="1"/>', "unknown element <srgb>; did you mean 'rgb'?"),
    ('<alias id="x" as="y"/>', "no object has the name 'x'"),
    ('<path value="nowhere"/>', "no such folder: "),
    ('<sahpe type="sphere"/>', "unknown element <sahpe>; did you mean 'shape'?"),
    ('<include filename="x.xml"/>', "cannot be read: No such file or directory: "),
    ('<include filename="scene.xml"/>', "files include each other more than 15 deep"),
    ('<shape type="shpere"/>', "unknown shape 'shpere'; did you mean 'sphere'?"),
    ('<shape type="diffuse"/>', "'diffuse' is a bsdf, not a shape"),
    ('<shape type="sdfgrid"/>', "the shape 'sdfgrid' is known to Mitsuba 3 but not supported by equaltime yet"),
    ('<emitter type="spott"/>', "unknown emitter 'spott'; did you mean 'spot'?"),
    ("<shape/>", "<shape> needs the attribute 'type'"),
    ('<shape type="sphere" nam="x"/>', "unknown attribute 'nam' of <shape>; did you mean 'name'?"),
    ('<scale value="2"/>', "<scale> belongs in a <transform>"),
    ('<bsdf type="diffuse" id="x"/><bsdf type="diffuse" id="x"/>', "the name 'x' is already taken (at "),
    ("&lol;", "not well-formed XML: undefined entity"),
    ("<shape <", "not well-formed XML: not well-formed (invalid token)"),
    ("<shape></bsdf>", "not well-formed XML: mismatched tag"),
    ("<bsdf>" * 5000, "elements are nested more than 64 deep"),
]
IN_A_SPHERE = [
    ('<float value="1"/>', "<float> needs the attribute 'name'"),
    ('<float name="radius" value="1 2"/>', "radius: expected a number, found '1 2'"),
    ('<float name="radius" value="1_0"/>', "radius: expected a number, found '1_0'"),
    ('<float name="radius" value="nan"/>', "radius: expected a finite number, found 'nan'"),
    ('<float name="radius" value="1"/><float name="radius" value="2"/>', "'radius' is given more than once"),
    ('<float name="radius" value="1"><rgb name="y" value="1"/></float>', "<rgb> cannot stand inside <float>"),
    (
        '<transform name="to_world"><scale value="2"><scale value="2"/></scale></transform>',
        "<scale> cannot stand inside <scale>",
    ),
    ('<ref id="x"><rgb name="y" value="1"/></ref>', "<rgb> cannot stand inside <ref>"),
    ('<default name="a" value="1"><rgb name="y" value="1"/></default>', "<rgb> cannot stand inside <default>"),
    ('<string name="radius" value="1"/>', "radius: expected a number, found '1'"),
    ('<float name="radus" value="1"/>', "unknown parameter 'radus' of 'sphere'; did you mean 'radius'?"),
    ('<boolean name="flip_normals" value="1"/>', "flip_normals: expected 'true' or 'false', found '1'"),
    ('<point name="center" x="1" y="2"/>', "center: needs 'value' or 'x', 'y' and 'z'; 'z' is missing"),
    ('<point name="center" x="1" value="2"/>', "center: give either 'value' or 'x', 'y' and 'z'"),
    ('<point name="center" value="1 2"/>', "center: expected one number or three, found 2 in '1 2'"),
    ('<ref id="red"/>', "no object has the name 'red'"),
    ('<film type="hdrfilm"/>', "'sphere' cannot contain a film ('hdrfilm')"),
]
IN_A_DIFFUSE = [
    ('<rgb name="reflectance" value="#ff00"/>', "reflectance: expected '#' and six hexadecimal digits of a colour"),
    ('<rgb name="reflectance" value="0.1 0.2"/>', "reflectance: expected one number or three, found 2"),
    ('<spectrum name="reflectance" value="400:1, 700"/>', "reflectance: expected pairs wavelength:value, found '700'"),
    ('<spectrum name="reflectance" value="400:1, 700:x"/>', "reflectance: expected a finite number, found 'x'"),
    ('<spectrum name="reflectance" value="700:1, 400:0"/>', "reflectance: the wavelengths of a spectrum must increase"),
    ('<spectrum name="reflectance" value="400:1"/>', "reflectance: a spectrum needs at least two wavelengths"),
    ('<spectrum name="reflectance" value="1 2 3"/>', "reflectance: expected one number, found 3; use <rgb>"),
    ('<spectrum type="irregular" name="reflectance"/>', "'irregular' needs 'wavelengths'"),
    (
        '<spectrum type="blackbody" name="reflectance"><float name="temperature" value="0"/></spectrum>',
        "temperature: must be more than 0, found 0",
    ),
    ('<texture type="volume" name="reflectance"/>', "the texture 'volume' is known to Mitsuba 3"),
    ('<texture type="bitmap" name="reflectance"/>', "'bitmap' needs 'filename'"),
    (
        '<texture type="checkerboard" name="reflectanse"/>',
        "'diffuse' cannot contain a texture ('checkerboard') as 'reflectanse'; did you mean 'reflectance'?",
    ),
    (
        '<texture type="checkerboard"/>',
        "'diffuse' cannot contain a texture ('checkerboard') without a name; expected 'reflectance'",
    ),
]
IN_A_PATH = [
    ('<float name="max_depth" value="5"/>', "max_depth: expected an integer, found 5.0"),
    ('<integer name="max_depth" value="5.5"/>', "max_depth: expected an integer, found '5.5'"),
    ('<integer name="max_depth" value="-2"/>', "max_depth: must be at least -1, found -2"),
]
IN_A_TRANSFORM = [
    ('<lookAt origin="0 0 0"/>', "<lookAt> needs the attribute 'target'"),
    ('<lookat origin="0 0 0" target="0 0"/>', "<lookat>: expected three numbers, found 2 in '0 0'"),
    ('<rotate x="1"/>', "<rotate> needs the attribute 'angle'"),
    ('<rotate angle="30"/>', "<rotate>: the axis of a rotation must have a direction"),
    ('<matrix value="1 2"/>', "<matrix>: a matrix needs 9 or 16 numbers, found 2"),
    ('<scale value="0"/>', "to_world: the transform is singular"),
    ('<scale value="1e999"/>', "<scale>: expected a finite number, found '1e999'"),
    ('<scale value="1e300"/><scale value="1e300"/>', "to_world: expected a finite number, found inf"),
    ('<lookat origin="1e308 0 0" target="-1e308 0 0"/>', "to_world: expected a finite number, found nan"),
]
WRAPPERS = {
    "{}": IN_THE_SCENE,
    '<shape type="sphere">{}</shape>': IN_A_SPHERE,
    '<bsdf type="diffuse">{}</bsdf>': IN_A_DIFFUSE,
    '<integrator type="path">{}</integrator>': IN_A_PATH,
    '<shape type="disk"><transform name="to_world">{}</transform></shape>': IN_A_TRANSFORM,
}


@pytest.mark.parametrize(
    ("body", "problem"),
    [(wrapper.format(body), problem) for wrapper, cases in WRAPPERS.items() for body, problem in cases],
)
def test_a_mistake_is_told_with_its_line(tmp_path: Path, body: str, problem: str) -> None:
    found = problems(tmp_path, f"{SENSOR}\n\n{body}")
    assert any(line.startswith(f"scene.xml:4: {problem}") for line in found), found


def test_a_doctype_is_refused_before_any_entity_can_do_harm(tmp_path: Path) -> None:
    file = tmp_path / "scene.xml"
    file.write_text(
        '<?xml version="1.0"?>\n<!DOCTYPE scene [<!ENTITY a SYSTEM "file:///etc/passwd">]>\n'
        '<scene version="3.0.0">&a;</scene>'
    )
    with pytest.raises(SceneError, match=r"scene.xml:2: declarations of elements and entities are not allowed"):
        load(file)


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("", "no element found"),
        ("<scene/>", "<scene> has no version"),
        ('<scene version="x"/>', "<scene> has version 'x', expected one such as 3.0.0"),
        ('<shape version="3.0.0" type="sphere"/>', "expected the element <scene>, found <shape>"),
        ('<scene version="3.0.0"/>', "the scene has no sensor"),
        ("\x00\x01\x02", "not well-formed"),
    ],
)
def test_a_file_that_is_no_scene_is_refused(tmp_path: Path, text: str, problem: str) -> None:
    file = tmp_path / "scene.xml"
    file.write_text(text)
    with pytest.raises(SceneError, match=problem):
        load(file)


def test_mistakes_are_told_together_and_in_the_order_of_their_lines(tmp_path: Path) -> None:
    body = """<integrator type="path"><integer name="max_depth" value="many"/></integrator>
        <sensor type="perspective"><float name="fov" value="200"/></sensor>
        <shape type="obj"><string name="filename" value="missing.obj"/></shape>
        <shape type="sphere"><ref id="read"/></shape>
        <bsdf type="diffuse" id="red"><rgb name="reflectance" value="2"/></bsdf>"""
    assert problems(tmp_path, body) == [
        "scene.xml:2: max_depth: expected an integer, found 'many'",
        "scene.xml:3: fov: must be less than 180, found 200.0",
        f"scene.xml:4: no such file: {tmp_path}/missing.obj",
        "scene.xml:5: no object has the name 'read'; did you mean 'red'?",
        "scene.xml:6: reflectance: must lie in [0, 1]: a surface cannot reflect more than it receives; "
        "found (2.0, 2.0, 2.0)",
    ]
