"""What Mitsuba reads in XML although it is odd, and what it makes of it."""

from pathlib import Path

import pytest

from equaltime.scene import load

from .test_scene_xml import SENSOR, problems, read, shape


def test_a_roughness_of_nothing_is_the_smallest_as_in_mitsuba(tmp_path: Path) -> None:
    rough = '<bsdf type="{}"><string name="distribution" value="GGX"/><float name="alpha" value="{}"/></bsdf>'
    for kind in ("roughconductor", "roughdielectric", "roughplastic"):
        bsdf = shape(tmp_path, rough.format(kind, 0)).bsdf
        assert bsdf.alpha == 1e-4
        assert bsdf.distribution == "ggx"
        found = problems(tmp_path, f'{SENSOR}<shape type="sphere">{rough.format(kind, -1)}</shape>')
        assert "alpha: must not be negative" in found[0]


def test_a_colour_that_stands_for_a_number_is_its_mean_as_in_mitsuba(tmp_path: Path) -> None:
    inner = '<rgb name="opacity" value="0.2 0.3 0.7"/><bsdf type="diffuse"/>'
    assert shape(tmp_path, f'<bsdf type="mask">{inner}</bsdf>').bsdf.opacity == pytest.approx(0.4)
    rough = '<bsdf type="principled"><rgb name="roughness" value="0.3 0.3 0.3"/></bsdf>'
    assert shape(tmp_path, rough).bsdf.roughness == 0.3


def test_words_without_effect_are_read(tmp_path: Path) -> None:
    sky = '<emitter type="constant"><transform name="to_world"><rotate y="1" angle="30"/></transform></emitter>'
    loaded = read(tmp_path, f'<integrator type="path"><float name="timeout" value="9"/></integrator>{SENSOR}{sky}')
    assert not loaded.warnings
    switches = ("allow_thread_reordering", "embree_use_robust_intersections")
    switched = "".join(f'<boolean name="{name}" value="true"/>' for name in switches)
    walk = '<integrator type="volpathmis"><boolean name="use_spectral_mis" value="false"/></integrator>'
    assert not read(tmp_path, switched + walk + SENSOR + sky).warnings
    wrong = problems(tmp_path, f'<float name="allow_thread_reordering" value="1"/>{SENSOR}')
    assert "unknown parameter 'allow_thread_reordering' of the scene" in wrong[0]


def test_the_axis_of_the_field_of_view_may_be_written_large(tmp_path: Path) -> None:
    words = '<string name="fov_axis" value="Smaller"/><float name="fov" value="50"/>'
    assert read(tmp_path, f'<sensor type="perspective">{words}</sensor>').model.sensor.fov_axis == "smaller"


def test_a_variable_may_run_into_the_word_that_follows(tmp_path: Path) -> None:
    """The longest name that is known is meant."""
    defaults = '<default name="di" value="no"/><default name="dir" value="ball_"/><default name="one" value="1"/>'
    body = f'{defaults}<shape type="sphere" id="$dirwood"><float name="radius" value="$one5"/></shape>'
    (found,) = read(tmp_path, SENSOR + body).model.shapes
    assert found.id == "ball_wood"
    assert found.radius == 15.0


def test_text_means_nothing_and_is_told_of_as_is_a_document_type_that_declares_nothing(tmp_path: Path) -> None:
    file = tmp_path / "scene.xml"
    file.write_text(f'<!DOCTYPE scene SYSTEM "s.dtd">\n<scene version="3.0.0">{SENSOR}<shape type="cube"/>&gt;</scene>')
    loaded = load(file)
    assert len(loaded.model.shapes) == 1
    assert [warning.removeprefix(f"{tmp_path}/") for warning in loaded.warnings] == [
        "scene.xml:2: the text '>' is ignored: values belong in attributes"
    ]


def test_what_cannot_be_rendered_does_no_harm_where_nothing_refers_to_it(tmp_path: Path) -> None:
    hair = '<bsdf type="twosided" id="a"><bsdf type="hair"/></bsdf><bsdf type="diffuse" id="b"/>'
    loaded = read(tmp_path, f'{SENSOR}{hair}<shape type="cube"><ref id="b"/></shape>')
    assert any("nothing refers to 'hair', which is known to Mitsuba 3" in warning for warning in loaded.warnings)
    for reference in ('<ref id="a"/>', '<bsdf type="mask"><ref id="a"/></bsdf>'):
        found = problems(tmp_path, f'{SENSOR}{hair}<shape type="cube">{reference}</shape>')
        assert any("the bsdf 'hair' is known to Mitsuba 3 but not supported" in problem for problem in found)
    found = problems(tmp_path, f'{SENSOR}{hair}<alias id="a" as="c"/><shape type="cube"><ref id="c"/></shape>')
    assert any("'hair'" in problem for problem in found)
    assert "unknown bsdf 'hiar'" in str(problems(tmp_path, f'{SENSOR}<bsdf type="hiar" id="a"/>'))
