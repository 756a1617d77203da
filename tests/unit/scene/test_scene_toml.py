"""Scenes in TOML, equaltime's own spelling."""

from pathlib import Path

import numpy as np
import pytest

from equaltime import SceneError
from equaltime.scene import Scene, load
from equaltime.scene import model as m

SENSOR = '[sensor]\ntype = "perspective"\n'


def read(folder: Path, text: str, **defines: object) -> Scene:
    file = folder / "scene.toml"
    file.write_text(text)
    return load(file, **defines)


def problems(folder: Path, text: str, **defines: object) -> list[str]:
    with pytest.raises(SceneError) as error:
        read(folder, text, **defines)
    return [str(problem).removeprefix(f"{folder}/") for problem in error.value.problems]


# -- what can be written ---------------------------------------------------------------------------------------------


def test_tables_are_objects_and_strings_are_references(tmp_path: Path) -> None:
    loaded = read(
        tmp_path,
        """
        [integrator]
        type = "path"
        max_depth = 8

        [sensor]
        type = "perspective"
        fov = 40
        to_world = [{ look_at = { origin = [0, 0, 5], target = [0, 0, 0], up = [0, 1, 0] } }]
        film = { type = "hdrfilm", width = 20, height = 10 }
        [sensor.sampler]
        type = "independent"
        sample_count = 32

        [red]
        type = "diffuse"
        reflectance = [0.5, 0.1, 0.1]

        [floor]
        type = "rectangle"
        to_world = [{ rotate = { axis = [1, 0, 0], angle = -90 } }, { translate = [0, -1, 0] }]
        bsdf = "red"
        emitter = { type = "area", radiance = 2 }

        [[balls]]
        type = "sphere"
        [[balls]]
        type = "sphere"
        radius = 2
        """,
    )
    floor, *balls = loaded.model.shapes
    assert floor.bsdf == m.Diffuse(id="red", reflectance=(0.5, 0.1, 0.1))
    assert floor.emitter == m.Area(radiance=(2, 2, 2))
    assert np.array(floor.to_world) == pytest.approx(
        np.array([[1, 0, 0, 0], [0, 0, 1, -1], [0, -1, 0, 0], [0, 0, 0, 1]])
    )
    assert balls == [m.Sphere(), m.Sphere(radius=2)]
    assert (loaded.max_depth, loaded.spp, loaded.size) == (8, 32, (20, 10))


def test_a_scene_may_say_that_it_is_one(tmp_path: Path) -> None:
    assert read(tmp_path, 'type = "scene"\n' + SENSOR).model == read(tmp_path, SENSOR).model


# -- variables -------------------------------------------------------------------------------------------------------

WIDTH = SENSOR + 'film = { type = "hdrfilm", width = "$width" }\n[default]\nwidth = 64\n'


def test_a_variable_keeps_the_type_of_its_value(tmp_path: Path) -> None:
    assert read(tmp_path, WIDTH).size[0] == 64
    assert read(tmp_path, WIDTH, width=32).size[0] == 32
    assert read(tmp_path, WIDTH, width="16").size[0] == 16


def test_a_variable_may_be_a_list_or_stand_within_a_string(tmp_path: Path) -> None:
    text = SENSOR + '[default]\ncolor = [0.1, 0.2, 0.3]\nname = "red"\n'
    text += '[dark-red]\ntype = "diffuse"\nreflectance = "$color"\n[s]\ntype = "sphere"\nbsdf = "dark-$name"\n'
    assert read(tmp_path, text).model.shapes[0].bsdf == m.Diffuse(id="dark-red", reflectance=(0.1, 0.2, 0.3))
    white = m.Diffuse(id="dark-red", reflectance=(1.0, 1.0, 1.0))
    assert read(tmp_path, text, color="#ffffff").model.shapes[0].bsdf == white
    assert read(tmp_path, text, color="[0.5, 0.5, 0.5]").model.shapes[0].bsdf == m.Diffuse(id="dark-red")


def test_a_variable_may_stand_within_a_transform(tmp_path: Path) -> None:
    text = SENSOR + '[default]\nsize = 3\nplace = [1, 2, 0]\n[s]\ntype = "sphere"\n'
    text += 'to_world = [{ scale = "$size" }, { translate = "$place" }]\n'
    moved = [[2.0, 0.0, 0.0, 1.0], [0.0, 2.0, 0.0, 2.0], [0.0, 0.0, 2.0, 0.0], [0.0, 0.0, 0.0, 1.0]]
    assert np.array(read(tmp_path, text, size=2).model.shapes[0].to_world).tolist() == moved
    whole = SENSOR + '[default]\nsteps = [{ translate = [1, 2, 0] }]\n[s]\ntype = "sphere"\nto_world = "$steps"\n'
    assert np.array(read(tmp_path, whole).model.shapes[0].to_world)[:3, 3].tolist() == [1.0, 2.0, 0.0]


def test_an_integrator_may_be_a_variable(tmp_path: Path) -> None:
    text = SENSOR + '[integrator]\ntype = "$integrator"\n[default]\nintegrator = "guided"\n'
    assert read(tmp_path, text, integrator="path").model.integrator == m.Path(id="integrator")
    assert problems(tmp_path, text) == [
        "scene.toml:3: integrator: unknown integrator 'guided', the value of $integrator; "
        "choose one with -D integrator=path"
    ]


def test_a_definition_that_nothing_uses_is_an_error(tmp_path: Path) -> None:
    assert problems(tmp_path, WIDTH, widht=3) == [
        "scene.toml: nothing in the scene uses the definition 'widht'; did you mean 'width'?"
    ]
    assert problems(tmp_path, WIDTH, sensor=3) == [
        "scene.toml: nothing in the scene uses the definition 'sensor': [sensor] is a block of the file, to be edited "
        "there"
    ]


def test_a_variable_without_a_value_is_an_error(tmp_path: Path) -> None:
    assert problems(tmp_path, SENSOR + 'fov = "$fov"\n[a]\ntype = "$a"\n[b]\ntype = "sphere"\nradius = "$r"\n') == [
        "scene.toml:3: sensor.fov: the variable $fov has no value: give it one with -D fov=...",
        "scene.toml:4: a: the variable $a has no value: give it one with -D a=...",
        "scene.toml:8: b.radius: the variable $r has no value: give it one with -D r=...",
    ]


# -- what is wrong ---------------------------------------------------------------------------------------------------


def test_mistakes_have_line_and_key_path_and_come_in_order(tmp_path: Path) -> None:
    text = """\
size = 3
[sensor]
type = "perspective"
fov = "wide"
[sensor.film]
type = "hdrfilm"
width = 0

[[balls]]
type = "sphere"
[[balls]]
type = "sphere"
bsdf = "red"
radius = -1
[mesh]
type = "ply"
filename = "missing.ply"
to_world = [
    { translate = [0, 0, 0] },
    { rotate = 30 },
]
[material]
type = "twosided"
bsdf = { type = "diffuse", reflectence = 0.5 }
"""
    assert problems(tmp_path, text) == [
        "scene.toml:1: size: unknown parameter 'size' of the scene; expected an object with a 'type'",
        "scene.toml:4: sensor.fov: expected a number, found 'wide'",
        "scene.toml:7: sensor.film.width: must be more than 0, found 0",
        "scene.toml:13: balls[1].bsdf: no object has the name 'red'; expected one of 'material', 'mesh', 'sensor'",
        "scene.toml:14: balls[1].radius: must be more than 0, found -1",
        f"scene.toml:17: mesh.filename: no such file: {tmp_path}/missing.ply",
        "scene.toml:18: mesh.to_world: rotate: expected a table with angle, axis",
        "scene.toml:24: material.bsdf.reflectence: unknown parameter 'reflectence' of 'diffuse'; "
        "did you mean 'reflectance'?",
    ]


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("[sensor", "scene.toml:1: not well-formed TOML: Expected ']'"),
        ('[sensor]\ntype = "perspective"\nfov = 3 4\n', "scene.toml:3: not well-formed TOML: Expected newline"),
        ("a = 1\na = 2\n", "scene.toml:2: not well-formed TOML: Cannot overwrite a value"),
        ("a = " + "[" * 5000, "scene.toml: not well-formed TOML: nested too deep"),
        ("", "scene.toml: the scene has no sensor; expected one of type 'perspective'"),
        ("default = 3\n" + SENSOR, "scene.toml:1: default: 'default' must be a table of variables"),
        (
            'type = "sphere"\n' + SENSOR,
            "scene.toml:1: type: the type of the whole file is 'scene', if any, not 'sphere'",
        ),
        (SENSOR + "[a]\nb = 1\n", "scene.toml:3: a: an object needs a 'type' with the name of a plugin, found none"),
        (
            SENSOR + "film = 2024-01-01\n",
            "scene.toml:3: sensor.film: expected plain data, found an object of type date",
        ),
    ],
)
def test_a_file_that_is_no_scene_is_refused(tmp_path: Path, text: str, problem: str) -> None:
    (found,) = problems(tmp_path, text)
    assert found.startswith(problem)


def test_a_file_that_is_no_text_is_refused(tmp_path: Path) -> None:
    (tmp_path / "scene.toml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(SceneError, match="not UTF-8 text"):
        load(tmp_path / "scene.toml")


def test_the_rows_of_a_matrix_are_not_taken_for_table_headers(tmp_path: Path) -> None:
    text = SENSOR + "to_world = [\n  [1, 0, 0, 0],\n  [0, 1, 0, 0],\n  [0, 0, 1, 0],\n  [0, 0, 0, 1]\n]\nfov = 0\n"
    assert problems(tmp_path, text) == ["scene.toml:9: sensor.fov: must be more than 0, found 0"]


# -- other files -----------------------------------------------------------------------------------------------------


def test_a_file_takes_objects_from_others_and_shares_its_variables(tmp_path: Path) -> None:
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "grey.spd").write_text("360 0.5\n830 0.5\n")
    (tmp_path / "parts" / "materials.toml").write_text(
        'default.shine = 0.1\n[metal]\ntype = "roughconductor"\nalpha = "$shine"\n'
        '[wall]\ntype = "diffuse"\nreflectance = {type = "spectrum", filename = "grey.spd"}\n'
    )
    file = tmp_path / "scene.toml"
    file.write_text(
        'include = "parts/materials.toml"\ndefault.shine = 0.3\nalias.gold = "metal"\nsensor.type = "perspective"\n'
        '[ball]\ntype = "sphere"\nbsdf = "gold"\n[floor]\ntype = "disk"\nbsdf = "wall"\n'
    )
    for defines, alpha in (({}, 0.3), ({"shine": 0.7}, 0.7)):
        ball, floor = load(file, **defines).model.shapes
        assert ball.bsdf == m.RoughConductor(id="metal", alpha=alpha)  # type: ignore[union-attr]
        assert floor.bsdf.reflectance == pytest.approx((0.5, 0.5, 0.5), abs=1e-3)  # type: ignore[union-attr]


def test_a_file_is_included_from_beside_the_file_that_names_it(tmp_path: Path) -> None:
    (tmp_path / "parts").mkdir()
    for folder, value in ((tmp_path, 0.1), (tmp_path / "parts", 0.2)):
        (folder / "grey.toml").write_text(f'grey = {{type = "diffuse", reflectance = {value}}}\n')
    (tmp_path / "parts" / "all.toml").write_text('include = "grey.toml"\n')
    file = tmp_path / "scene.toml"
    file.write_text('include = "parts/all.toml"\nsensor.type = "perspective"\n[ball]\ntype = "sphere"\nbsdf = "grey"\n')
    assert load(file).model.shapes[0].bsdf == m.Diffuse(id="grey", reflectance=0.2)


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ('include = "none.toml"', "scene.toml:1: include: cannot be read: No such file or directory: "),
        ('\ninclude = ["scene.toml"]', "scene.toml:2: include: files include each other more than 15 deep"),
        ('path = "nowhere"', "scene.toml:1: path: no such folder: "),
        ('alias.a = "b"', "scene.toml:1: alias.a: no object has the name 'b'"),
        ("include = 3", "scene.toml:1: include: unknown parameter 'include' of the scene"),
        ('include = "$what"', "scene.toml:1: include: the variable $what has no value"),
    ],
)
def test_a_mistake_about_other_files_is_told_with_its_line(tmp_path: Path, text: str, problem: str) -> None:
    (tmp_path / "scene.toml").write_text(f'{text}\n[sensor]\ntype = "perspective"\n')
    with pytest.raises(SceneError) as error:
        load(tmp_path / "scene.toml")
    assert any(str(line).removeprefix(f"{tmp_path}/").startswith(problem) for line in error.value.problems)


def test_the_plane_of_a_texture_is_moved_by_steps_of_two_numbers(tmp_path: Path) -> None:
    file = tmp_path / "scene.toml"
    file.write_text(
        'sensor.type = "perspective"\n[floor]\ntype = "disk"\nbsdf.type = "diffuse"\n[floor.bsdf.reflectance]\n'
        'type = "checkerboard"\nto_uv = [{scale = [2, 3]}, {translate = [0.5, 0]}]\n'
    )
    (floor,) = load(file).model.shapes
    assert floor.bsdf.reflectance.uv_rows == ((2, 0, 0.5), (0, 3, 0))  # type: ignore[union-attr]


USED = SENSOR + '[ball]\n{}\n[shape]\ntype = "sphere"\nbsdf = "ball"\n'
"""A surface in a block of its own, which only its use shows to be a surface."""


@pytest.mark.parametrize(
    ("type", "hint"),
    [
        ("roughmetal", "did you mean 'roughconductor'?"),
        ("roughglass", "did you mean 'roughdielectric'?"),
        ("Mirror", "did you mean 'conductor'?"),
        ("rough", "did you mean one of 'roughconductor', 'roughdielectric', 'roughdiffuse', 'roughplastic'?"),
        ("difuse", "did you mean 'diffuse'?"),
    ],
)
def test_an_unknown_surface_is_answered_by_surfaces_like_it(type: str, hint: str, tmp_path: Path) -> None:
    (problem,) = problems(tmp_path, USED.format(f'type = "{type}"'))
    assert problem == f"scene.toml:3: ball: unknown bsdf '{type}'; {hint}"


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        (USED.format('type = "xyz"'), "bsdf"),
        (SENSOR + '[ball]\ntype = "sphere"\nbsdf = { type = "xyz" }\n', "bsdf"),
        (SENSOR + '[ball]\ntype = "sphere"\nemitter = { type = "xyz" }\n', "emitter"),
    ],
)
def test_a_type_like_no_other_is_answered_by_all_that_its_place_takes(text: str, kind: str, tmp_path: Path) -> None:
    (problem,) = problems(tmp_path, text)
    _, said, listed = problem.partition(f"unknown {kind} 'xyz'; expected one of ")
    assert said
    assert listed == ", ".join(repr(name) for name in sorted(m.PLUGINS) if m.PLUGINS[name].kind == kind)


@pytest.mark.parametrize(
    ("surface", "name", "hint"),
    [
        ("roughconductor", "rougness", "did you mean 'alpha', the square of the roughness?"),
        ("roughplastic", "roughness", "did you mean 'alpha', the square of the roughness?"),
        ("principled", "alpha", "did you mean 'roughness', the square root of alpha?"),
        ("principled", "reflectance", "did you mean 'base_color'?"),
        ("diffuse", "base_color", "did you mean 'reflectance'?"),
        ("plastic", "base_color", "did you mean 'diffuse_reflectance'?"),
        ("dielectric", "eta", "did you mean 'int_ior'?"),
        ("diffuse", "reflectanse", "did you mean 'reflectance'?"),
        ("diffuse", "roughness", "expected one of 'id', 'reflectance'"),
    ],
)
def test_a_parameter_of_another_surface_is_answered_by_its_equal(
    surface: str, name: str, hint: str, tmp_path: Path
) -> None:
    (problem,) = problems(tmp_path, USED.format(f'type = "{surface}"\n{name} = 0.5'))
    assert problem.endswith(f"unknown parameter '{name}' of '{surface}'; {hint}")
