"""What cannot be rendered is refused by name and place, or replaced on request, with a list of what was done."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

import equaltime as et
from equaltime.cli import main
from equaltime.scene import model as m
from equaltime.scene.substitutes import MITSUBA, OLD, SUBSTITUTES

BALL: dict[str, Any] = {"type": "sphere"}


def scene(**parts: Any) -> dict[str, Any]:
    film = {"type": "hdrfilm", "width": 8, "height": 6}
    return {"type": "scene", "sensor": {"type": "perspective", "film": film}, "light": {"type": "constant"}} | parts


def surface(**bsdf: Any) -> dict[str, Any]:
    return scene(ball=BALL | {"bsdf": bsdf})


CASES = {
    "measured": (
        surface(type="measured", filename="x.bsdf"),
        "ball.bsdf: the bsdf 'measured' is replaced by 'diffuse'",
    ),
    "hair": (surface(type="hair", eumelanin=0.3), "ball.bsdf: the bsdf 'hair' is replaced by 'roughplastic'"),
    "phong": (surface(type="phong", exponent=30), "ball.bsdf: the bsdf 'phong' is replaced by 'roughplastic'"),
    "polarizer": (surface(type="polarizer"), "ball.bsdf: the bsdf 'polarizer' is replaced by 'null'"),
    "coating": (
        surface(type="coating", inner={"type": "plastic"}),
        "ball.bsdf: the bsdf 'coating' is replaced by the 'plastic' in it",
    ),
    "disneybsdf": (
        surface(type="disneybsdf", baseColor=0.2),
        "ball.bsdf: the bsdf 'disneybsdf' is replaced by 'principled'",
    ),
    "sunsky": (scene(light={"type": "sunsky"}), "light: the emitter 'sunsky' is replaced by 'constant'"),
    "projector": (scene(beam={"type": "projector"}), "beam: the emitter 'projector' is replaced by 'spot'"),
    "bsplinecurve": (scene(fur={"type": "bsplinecurve"}), "fur: the shape 'bsplinecurve' is left out"),
    "prb": (scene(how={"type": "prb", "max_depth": 4}), "how: the integrator 'prb' is replaced by 'path'"),
    "prb_projective": (
        scene(how={"type": "prb_projective"}),
        "how: the integrator 'prb_projective' is replaced by 'path'",
    ),
    "volprim_rf_basic": (
        scene(how={"type": "volprim_rf_basic"}),
        "how: the integrator 'volprim_rf_basic' is replaced by 'path'",
    ),
    "direct_projective": (
        scene(how={"type": "direct_projective"}),
        "how: the integrator 'direct_projective' is replaced by 'direct'",
    ),
    "heterogeneous": (
        scene(ball=BALL | {"interior": {"type": "heterogeneous"}}),
        "ball.interior: the medium 'heterogeneous' is left out",
    ),
    "volume": (
        surface(type="diffuse", reflectance={"type": "volume"}),
        "ball.bsdf.reflectance: the texture 'volume' is replaced by 'uniform'",
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_what_cannot_be_rendered_is_refused_or_replaced(name: str) -> None:
    description, done = CASES[name]
    with pytest.raises(et.SceneError) as error:
        et.load_dict(description)
    (problem,) = error.value.problems
    assert problem.place == done.split(": ")[0]
    assert f"'{name}'" in problem.message
    assert "--substitute replaces it" in problem.message or "unknown plugin" in problem.message
    loaded = et.load_dict(description, substitute=True)
    assert [str(substitution) for substitution in loaded.substitutions] == [done]
    assert done in loaded.warnings


def test_an_integrator_goes_on_hiding_emitters() -> None:
    for name in ("ptracer", "direct_projective"):
        loaded = et.load_dict(scene(how={"type": name, "hide_emitters": True}), substitute=True)
        assert loaded.model.integrator.hides_emitters


def test_parameters_that_mean_the_same_are_kept() -> None:
    disney = surface(type="disneybsdf", baseColor=[0.1, 0.2, 0.3], roughness=0.3, specularTint=0.5, eta=1.4)
    (ball,) = et.load_dict(disney, substitute=True).model.shapes
    kept = m.Principled(base_color=(0.1, 0.2, 0.3), roughness=0.3, spec_tint=0.5, eta=1.4)
    assert ball.bsdf == kept  # type: ignore[union-attr]


def test_a_mixture_keeps_its_weights() -> None:
    mixture = surface(type="mixturebsdf", weights="0.25, 0.75", a={"type": "diffuse"}, b={"type": "plastic"})
    (ball,) = et.load_dict(mixture, substitute=True).model.shapes
    assert ball.bsdf == m.BlendBsdf(weight=0.75, bsdf=(m.Diffuse(), m.Plastic()))  # type: ignore[union-attr]


@pytest.mark.parametrize(
    ("aovs", "kept"),
    [
        ("a:depth, b:position", "a:depth, b:position"),
        ("a:depth, b:boundary_test, c:position", "a:depth, c:position"),
        ("b:boundary_test", None),
    ],
)
def test_outputs_that_can_be_written_are_kept(aovs: str, kept: str | None) -> None:
    integrator = {"type": "aov", "aovs": aovs, "inner": {"type": "path", "max_depth": 3}}
    loaded = et.load_dict(scene(how=integrator), substitute=True)
    assert loaded.max_depth == 3
    assert getattr(loaded.model.integrator, "aovs", None) == kept
    assert bool(loaded.substitutions) == (kept != aovs)
    assert loaded.core.shapes == 0


def test_references_to_what_is_left_out_are_left_out_too() -> None:
    for name in ({"type": "ref", "id": "fog"}, "fog"):
        description = scene(fog={"type": "heterogeneous"}, ball=BALL | {"exterior": name})
        (ball,) = et.load_dict(description, substitute=True).model.shapes
        assert ball == m.Sphere(id="ball")


def test_where_nothing_needs_a_substitute_nothing_changes() -> None:
    description = surface(type="diffuse", reflectance=0.3)
    loaded = et.load_dict(description, substitute=True)
    assert loaded.substitutions == ()
    assert loaded.model == et.load_dict(description).model


def test_a_misspelt_name_is_no_reason_to_substitute() -> None:
    with pytest.raises(et.SceneError, match="did you mean 'diffuse'"):
        et.load_dict(surface(type="difuse"), substitute=True)


def test_what_is_done_can_be_asked_for_and_is_told_on_the_command_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "scene.toml"
    film = "film = {type = 'hdrfilm', width = 4, height = 4}"
    shape = "[ball]\ntype = 'sphere'\ncenter = [0, 0, 4]\n"
    file.write_text(f"[sensor]\ntype = 'perspective'\n{film}\n[sky]\ntype = 'sunsky'\n{shape}")
    output = str(tmp_path / "out.exr")
    assert main(["render", str(file), "-o", output, "--spp", "2"]) == 2
    assert "the emitter 'sunsky' is known to Mitsuba 3" in capsys.readouterr().err
    assert main(["render", str(file), "-o", output, "--spp", "2", "--substitute", "--json"]) == 0
    told = capsys.readouterr()
    done = f"{file}:4: sky: the emitter 'sunsky' is replaced by 'constant'"
    assert told.err == f"warning: {done}\n"
    assert json.loads(told.out)["substitutions"] == [done]
    assert main(["info", str(file), "--substitute"]) == 0


def test_substitutes_are_for_plugins_that_are_known_and_make_plugins_that_are_supported() -> None:
    names = {name for steps in SUBSTITUTES.values() for name in steps}
    unknown = {name for name in names if not any(name in known for known in (*MITSUBA.values(), *OLD.values()))}
    assert all(name.startswith("disney") for name in unknown)
