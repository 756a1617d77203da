"""Scenes as Python dictionaries, in the spelling of `mitsuba.load_dict`."""

from contextlib import suppress
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from equaltime import SceneError
from equaltime.scene import load_dict
from equaltime.scene import model as m


def scene(**objects: Any) -> dict[str, Any]:
    return {"type": "scene", "sensor": {"type": "perspective"}, **objects}


def shape(**parameters: Any) -> Any:
    return load_dict(scene(it={"type": "sphere", **parameters})).model.shapes[0]


def problems(description: dict[str, Any]) -> list[str]:
    with pytest.raises(SceneError) as error:
        load_dict(description)
    return [str(problem) for problem in error.value.problems]


# -- what can be written ---------------------------------------------------------------------------------------------


def test_the_smallest_scene_is_a_camera_that_sees_nothing() -> None:
    loaded = load_dict(scene())
    assert loaded.model == m.SceneModel(sensor=m.Perspective(id="sensor"))
    assert (loaded.source, loaded.spp, loaded.max_depth, loaded.size) == (None, None, -1, (768, 576))


def test_parameters_and_nested_objects_arrive() -> None:
    loaded = load_dict(
        scene(
            integrator={"type": "path", "max_depth": 8},
            ball={
                "type": "sphere",
                "center": [1, 2, 3],
                "radius": 2,
                "any name": {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.1, 0.2, 0.3]}},
                "light": {"type": "area", "radiance": {"type": "rgb", "value": 4.0}},
            },
            sky={"type": "constant", "radiance": 0.5},
            lamp={"type": "point", "position": [0, 1, 0], "intensity": 3},
        )
    )
    (ball,) = loaded.model.shapes
    assert ball == m.Sphere(
        id="ball",
        center=(1, 2, 3),
        radius=2,
        bsdf=m.Diffuse(reflectance=(0.1, 0.2, 0.3)),
        emitter=m.Area(radiance=4),
    )
    assert [emitter.type for emitter in loaded.model.emitters] == ["constant", "point"]
    assert loaded.max_depth == 8


def test_a_reference_names_an_object_that_may_come_later() -> None:
    one = {"type": "sphere", "bsdf": {"type": "ref", "id": "red"}}
    two = {"type": "sphere", "bsdf": "red"}
    loaded = load_dict(scene(one=one, two=two, red={"type": "diffuse", "reflectance": 0.25}))
    first, second = (it.bsdf for it in loaded.model.shapes)
    assert first is second
    assert first == m.Diffuse(id="red", reflectance=0.25)


def test_an_object_can_be_referred_to_by_its_id_too() -> None:
    material = {"type": "diffuse", "id": "grey"}
    loaded = load_dict(scene(a={"type": "sphere", "bsdf": material}, b={"type": "sphere", "bsdf": "grey"}))
    assert loaded.model.shapes[1].bsdf is loaded.model.shapes[0].bsdf


def test_a_list_of_objects_is_that_many_objects() -> None:
    loaded = load_dict(scene(balls=[{"type": "sphere", "radius": r} for r in (1, 2, 3)]))
    assert [ball.radius for ball in loaded.model.shapes] == [1, 2, 3]


@pytest.mark.parametrize("nested", [["a", "b"], [{"type": "ref", "id": "a"}, {"type": "conductor"}]])
def test_two_sides_take_a_list(nested: list[object]) -> None:
    both = {"type": "twosided", "bsdf": nested}
    loaded = load_dict(scene(a={"type": "diffuse"}, b={"type": "conductor"}, s={"type": "disk", "bsdf": both}))
    bsdf = loaded.model.shapes[0].bsdf
    assert isinstance(bsdf, m.TwoSided)
    assert [side.type for side in bsdf.bsdf] == ["diffuse", "conductor"]


def test_the_two_sides_keep_their_order_under_any_names() -> None:
    both = {"type": "twosided", "z": {"type": "diffuse"}, "a": {"type": "conductor"}}
    bsdf = shape(bsdf=both).bsdf
    assert [side.type for side in bsdf.bsdf] == ["diffuse", "conductor"]


@pytest.mark.parametrize("value", [0.5, np.float32(0.5), np.float64(0.5), np.array(0.5), np.full(3, 0.5)])
def test_numbers_may_come_from_numpy(value: object) -> None:
    assert shape(bsdf={"type": "diffuse", "reflectance": value}).bsdf.reflectance == (0.5, 0.5, 0.5)
    assert shape(center=np.array([1, 2, 3])).center == (1.0, 2.0, 3.0)
    assert shape(radius=np.int64(2)).radius == 2.0


@pytest.mark.parametrize("kind", ["rgb", "spectrum", "uniform"])
def test_a_grey_colour_may_be_any_kind_of_constant(kind: str) -> None:
    assert shape(bsdf={"type": "diffuse", "reflectance": {"type": kind, "value": 0.25}}).bsdf.reflectance[1] == 0.25


def test_transforms_may_be_arrays_lists_objects_with_a_matrix_or_steps() -> None:
    matrix = np.diag([2.0, 2.0, 2.0, 1.0])
    for value in (matrix, matrix.tolist(), SimpleNamespace(matrix=matrix), [{"scale": 2}], {"scale": 2}):
        assert shape(to_world=value).to_world == m.Sphere(to_world=matrix).to_world


def test_objects_that_nothing_uses_are_checked_and_left_out() -> None:
    assert load_dict(scene(spare={"type": "diffuse"})).model == load_dict(scene()).model
    assert problems(scene(spare={"type": "diffuse", "reflectance": 2})) == [
        "spare.reflectance: must lie in [0, 1]: a surface cannot reflect more than it receives; found 2"
    ]


# -- what is wrong ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("description", "problem"),
    [
        ({}, "expected a dictionary with 'type': 'scene', found None"),
        ({"type": "sphere"}, "expected a dictionary with 'type': 'scene', found 'sphere'"),
        ({"type": "scene"}, "the scene has no sensor; expected one of type 'perspective'"),
        (scene(a={"type": "path"}, b={"type": "path"}), "b: the scene has another integrator (at a)"),
        (scene(a={"type": "constant"}, b={"type": "constant"}), "b: a scene can have only one environment (the first"),
        (
            scene(a={"type": "disk", "id": "x"}, b={"type": "disk", "id": "x"}),
            "b: the name 'x' is already taken (at a)",
        ),
    ],
)
def test_a_scene_that_is_none_is_refused(description: dict[str, Any], problem: str) -> None:
    (found,) = problems(description)
    assert found.startswith(problem)


@pytest.mark.parametrize(
    ("wrong", "problem"),
    [
        ({}, ": an object needs a 'type' with the name of a plugin, found none"),
        ({"type": 3}, ": an object needs a 'type' with the name of a plugin, found 3"),
        (3, ": unknown parameter 'a' of the scene; expected an object with a 'type'"),
        ({"type": "spere"}, ": unknown plugin 'spere'; did you mean 'sphere'?"),
        ({"type": "sdfgrid"}, ": the shape 'sdfgrid' is known to Mitsuba 3 but not supported by equaltime yet"),
        ({"type": "area"}, ": an 'area' emitter needs a shape"),
        ({"type": "ply"}, ": 'ply' needs 'filename'"),
        ({"type": "ply", "filename": "no.ply"}, ".filename: no such file: "),
        ({"type": "obj", "filename": "."}, ".filename: is no file: "),
        ({"type": "envmap", "filename": "no.exr"}, ".filename: no such file: "),
        ({"type": "twosided"}, ": 'twosided' needs 'bsdf'"),
        ({"type": "twosided", "bsdf": "a"}, ": the object contains itself: 'a' -> 'a'"),
        ({"type": "twosided", "bsdf": {"type": "dielectric"}}, ": 'twosided' cannot contain 'dielectric', which lets "),
        (
            {"type": "twosided", "b": {"type": "mask", "bsdf": {"type": "diffuse"}}},
            ": 'twosided' cannot contain 'mask', which lets ",
        ),
        ({"type": "blendbsdf", "bsdf": {"type": "diffuse"}, "weight": 0.5}, ".bsdf: "),
        (
            {"type": "shapegroup", "shapes": 1, "b": {"type": "sphere"}},
            ".shapes: 'shapes' takes objects, or their names, found 1",
        ),
        ({"type": "principled", "eta": 1.5, "specular": 0.5}, ": give either eta or specular, not both"),
        ({"type": "conductor", "material": "Au", "k": 1}, ": give either material or eta and k (found material and k)"),
        (
            {"type": "spot", "cutoff_angle": 100, "texture": {"type": "checkerboard"}},
            ": cutoff_angle (100) of a spot with a texture must not exceed 90",
        ),
        (
            {"type": "checkerboard", "to_uv": [{"translate": [1e17, 0, 0]}]},
            ": to_uv moves the texture by 1e+17: more than ",
        ),
        (
            {"type": "spot", "to_world": [{"scale": [1, 2, 1]}]},
            ": to_world of a spot light must scale all directions alike, without shear",
        ),
        ({"type": "aov", "aovs": "d:deep"}, ": 'deep' cannot be written beside the image"),
        (
            {"type": "disk", "to_world": [{"scal": 2}]},
            ".to_world: unknown transform step 'scal'; did you mean 'scale'?",
        ),
        ({"type": "disk", "to_world": np.zeros((4, 4))}, ".to_world: the last row of a transform must be 0 0 0 1"),
    ],
)
def test_a_mistake_is_told_with_its_key(wrong: object, problem: str) -> None:
    (found,) = problems(scene(a=wrong))
    assert found.startswith(f"a{problem}")


@pytest.mark.parametrize(
    ("key", "value", "problem"),
    [
        ("raduis", 1, "unknown parameter 'raduis' of 'sphere'; did you mean 'radius'?"),
        ("exterior", 1, "expected an object of type 'homogeneous', found 1"),
        ("radius", "1", "expected a number, found '1'"),
        ("radius", -1, "must be more than 0, found -1"),
        ("radius", object(), "expected plain data, found an object of type object"),
        ("center", [1, float("nan"), 3], "expected a finite number, found nan"),
        ("center", [1, 2], "expected three numbers; found (1, 2)"),
        ("bsdf", "red", "no object has the name 'red'; expected one of 'a', 'sensor'"),
        ("bsdf", {"type": "ref"}, "a reference has a 'type' and an 'id' that is a string"),
        ("emitter", {"type": "point"}, "expected an object of type 'area', found 'point'"),
        ("x", {"type": "path"}, "'sphere' cannot contain an integrator ('path')"),
        ("fog", {"type": "heterogeneous"}, "the medium 'heterogeneous' is known to Mitsuba 3"),
    ],
)
def test_a_mistake_inside_an_object_is_told_with_its_key_path(key: str, value: object, problem: str) -> None:
    (found,) = problems(scene(a={"type": "sphere", key: value}))
    assert found.startswith(f"a.{key}: {problem}")


def test_a_shape_has_one_material() -> None:
    assert problems(scene(a={"type": "sphere", "x": {"type": "diffuse"}, "y": {"type": "conductor"}})) == [
        "a.y: 'sphere' can have only one bsdf; 'conductor' is another"
    ]


@pytest.mark.parametrize(
    ("reflectance", "problem"),
    [
        ({"type": "volume"}, "the texture 'volume' is known to Mitsuba 3 but not supported"),
        ({"type": "spectrum", "value": [(700, 0.1), (400, 0.2)]}, "the wavelengths of a spectrum must increase"),
        ({"type": "spectrum", "value": [700, 400]}, "expected pairs wavelength:value, found 700"),
        ({"type": "spectrum", "filename": "x.spd"}, f"{Path('x.spd').absolute()}: cannot be read: No such file"),
        ({"type": "rgb"}, "'rgb' needs a 'value', found none"),
        ([0.1, 0.2], "expected a colour: one number or three, or sRGB such as '#20c040'; found (0.1, 0.2)"),
        ("#20c04", "expected '#' and six hexadecimal digits of a colour, such as #20c040, found '#20c04'"),
        ("#20c0400f", "expected '#' and six hexadecimal digits of a colour"),
        ("blue", "no object has the name 'blue'; expected a number, a colour, or the name of a texture"),
    ],
)
def test_a_colour_that_is_none_is_refused(reflectance: object, problem: str) -> None:
    (found,) = problems(scene(a={"type": "diffuse", "reflectance": reflectance}))
    assert found.startswith(f"a.reflectance: {problem}")


@pytest.mark.parametrize(
    ("colour", "linear"),
    [
        ("#20c040", (0.014444, 0.527115, 0.051269)),
        ("#2c4", (0.015996, 0.603827, 0.057805)),
        ({"type": "rgb", "value": "#808080"}, (0.215861,) * 3),
        ({"type": "srgb", "color": "#FF0000"}, (1.0, 0.0, 0.0)),
    ],
)
def test_a_colour_may_be_encoded_srgb_in_hexadecimal_digits(colour: object, linear: tuple[float, ...]) -> None:
    ball = shape(bsdf={"type": "diffuse", "reflectance": colour}, interior={"type": "homogeneous", "sigma_t": colour})
    assert ball.bsdf.reflectance == pytest.approx(linear, abs=1e-6)
    assert ball.interior.sigma_t == pytest.approx(linear, abs=1e-6)
    (lamp,) = load_dict(scene(lamp={"type": "point", "intensity": colour})).model.emitters
    assert isinstance(lamp, m.Point)
    assert lamp.intensity == pytest.approx(linear, abs=1e-6)


def test_an_object_whose_name_looks_like_a_colour_is_meant() -> None:
    ball = {"type": "sphere", "bsdf": {"type": "diffuse", "reflectance": "#fff"}}
    found: Any = load_dict(scene(board={"type": "checkerboard", "id": "#fff"}, ball=ball)).model.shapes[0]
    assert isinstance(found.bsdf.reflectance, m.Checkerboard)


def test_all_mistakes_are_told_together() -> None:
    found = problems(
        {
            "type": "scene",
            "integrator": {"type": "path", "max_dept": 3},
            "sensor": {"type": "perspective", "fov": 500, "film": {"type": "hdrfilm", "width": 0}},
            "ball": {"type": "sphere", "radius": 0, "bsdf": {"type": "diffuse", "reflectance": "blue"}},
            "mesh": {"type": "obj", "filename": "missing.obj"},
            "fog": {"type": "heterogeneous"},
        }
    )
    assert [line.split(": ")[0] for line in found] == [
        "integrator.max_dept",
        "sensor.film.width",
        "sensor.fov",
        "ball.bsdf.reflectance",
        "ball.radius",
        "fog",
        "mesh.filename",
    ]


def test_a_dictionary_that_contains_itself_is_refused() -> None:
    loop: dict[str, Any] = {"type": "twosided"}
    loop["bsdf"] = loop
    assert any("nested more than" in problem for problem in problems(scene(loop=loop)))


WORDS = (
    "type id ref scene sphere diffuse twosided area perspective hdrfilm path rgb value bsdf emitter radius to_world "
    "ply reflectance film width sensor spectrum a $x . mask blendbsdf weight opacity checkerboard shapegroup shapes "
    "irregular wavelengths values measured sunsky aov aovs homogeneous interior"
)
words = st.sampled_from(["", *WORDS.split()])
values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | words,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(words, inner, max_size=5),
    max_leaves=25,
)


@given(st.dictionaries(words, values, max_size=8))
def test_no_dictionary_makes_anything_but_a_scene_or_a_scene_error(content: dict[str, Any]) -> None:
    for substitute in (False, True):
        with suppress(SceneError):
            load_dict({**content, "type": "scene"}, substitute=substitute)


def test_of_several_sensors_the_first_is_used() -> None:
    loaded = load_dict(scene(a={"type": "orthographic"}))
    assert loaded.model.sensor.type == "perspective"
    assert loaded.warnings == ("sensor: of 2 sensors the first is used",)
