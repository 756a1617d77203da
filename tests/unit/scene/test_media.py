"""Media in scene files: what they may be given, who sees them, and what is folded away."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

import equaltime as et
from equaltime.errors import RenderError, SceneError
from equaltime.pricing import derive
from equaltime.scene.export import convert
from equaltime.scene.export.plain import mitsuba_dict
from equaltime.scene.model import Homogeneous

Dict = dict[str, Any]
VOLPATH: Dict = {"type": "volpath", "max_depth": 5}


def ball(inside: Dict | None = None, integrator: Dict = VOLPATH, lamp: Dict | None = None, **sensor: Any) -> et.Scene:
    film = {"type": "hdrfilm", "width": 4, "height": 4, "rfilter": {"type": "box"}}
    shape = {"type": "sphere", "center": [0, 0, 4], "bsdf": {"type": "null"}}
    return et.load_dict(
        {
            "type": "scene",
            "integrator": integrator,
            "sensor": {"type": "perspective", "fov": 10.0, "film": film, **sensor},
            "sky": {"type": "constant", "radiance": 1.0},
            "ball": shape | ({} if inside is None else {"interior": inside}),
            **({} if lamp is None else {"lamp": lamp}),
        }
    )


def fog(**parameters: Any) -> Dict:
    return {"type": "homogeneous", **parameters}


def test_a_medium_of_the_older_kind_is_the_sum_of_its_parts() -> None:
    medium = Homogeneous(sigma_s=[1.0, 0.5, 0.0], sigma_a=[1.0, 1.5, 0.0], scale=2.0)  # type: ignore[call-arg]
    assert medium == Homogeneous(sigma_t=(2.0, 2.0, 0.0), albedo=(0.5, 0.25, 0.0), scale=2.0)
    with pytest.raises(SceneError, match="'sigma_t' and 'albedo', or 'sigma_s' and 'sigma_a', not some of both"):
        ball(fog(sigma_s=1.0, sigma_t=2.0))
    with pytest.raises(SceneError, match=r"ball\.interior\.sigma_t: must not be negative"):
        ball(fog(sigma_t=[1.0, -1.0, 0.0]))


def test_only_volumetric_integrators_see_media_and_others_are_told_of() -> None:
    seen, unseen = ball(fog()), ball(fog(), {"type": "path", "max_depth": 5})
    assert seen.core.effects()["media"]
    assert not seen.warnings
    assert not unseen.core.effects()["media"]
    assert unseen.warnings == (
        "the integrator 'path' does not see the media of the scene, here as in Mitsuba; 'volpath' does",
    )
    inside = ball(fog(), {"type": "moment", "inner": VOLPATH})
    assert inside.core.effects()["media"]


@pytest.mark.parametrize("medium", [None, fog(scale=0.0), fog(sigma_t=0.0)])
def test_a_medium_without_density_calls_for_nothing(medium: Dict | None) -> None:
    scene = ball(medium)
    assert not scene.core.effects()["media"]
    assert "media" not in derive(scene)
    assert (et.render(scene, spp=2).image == 1.0).all()


def test_a_medium_is_named_with_its_place_as_a_reason() -> None:
    (reason,) = derive(ball(fog()))["media"]
    assert str(reason) == "ball.interior: medium 'homogeneous'"


@pytest.mark.filterwarnings("ignore:the picture is black")
def test_the_medium_of_the_camera_is_where_paths_begin() -> None:
    assert ball(None, medium=fog()).core.effects()["media"]
    assert (et.render(ball(None, medium=fog()), spp=2).image == 0.0).all(), "no sky is seen through fog without end"


def test_equal_media_are_one_however_they_are_called() -> None:
    scene = ball(fog(phase={"type": "isotropic"}), medium=fog(phase={"type": "hg", "g": 0.0}))
    assert scene.model.sensor.medium != scene.model.shapes[0].interior  # type: ignore[union-attr]
    assert Homogeneous().phase.title == "isotropic"
    assert scene.core.effects()["media"]


def even(value: Any, **more: Any) -> Dict:
    return {"type": "constvolume", "value": value, **more}


@pytest.mark.parametrize(
    ("volume", "value"),
    [
        (even(0.5), 0.5),
        (even({"type": "rgb", "value": [0.1, 0.2, 0.3]}), [0.1, 0.2, 0.3]),
        (even({"type": "uniform", "value": 0.25}), 0.25),
        (even(0.5, to_world=[{"scale": 3}]), 0.5),
        ({"type": "constvolume"}, 1.0),
    ],
)
def test_a_volume_of_one_value_is_that_value(volume: Dict, value: Any) -> None:
    medium = ball(fog(albedo=volume, sigma_t=volume)).model.shapes[0].interior  # type: ignore[union-attr]
    assert medium == ball(fog(albedo=value, sigma_t=value)).model.shapes[0].interior  # type: ignore[union-attr]


def test_a_volume_stands_in_media_alone_and_one_of_a_grid_is_refused_by_name() -> None:
    bsdf = {"type": "diffuse", "reflectance": even(0.5)}
    with pytest.raises(SceneError, match=r"it\.bsdf\.reflectance: 'diffuse' cannot contain a volume \('constvolume'\)"):
        et.load_dict({"type": "scene", "sensor": {"type": "perspective"}, "it": {"type": "cube", "bsdf": bsdf}})
    with pytest.raises(
        SceneError, match=r"ball\.interior\.albedo: the volume 'gridvolume' is known to Mitsuba 3 but not"
    ):
        ball(fog(albedo={"type": "gridvolume", "filename": "smoke.vol"}))
    with pytest.raises(SceneError, match=r"ball\.interior\.albedo: must lie in \[0, 1\]"):
        ball(fog(albedo=even(2.0)))
    with pytest.raises(
        SceneError, match=r"ball\.interior\.sigma_t\.values: unknown parameter 'values' of 'constvolume'"
    ):
        ball(fog(sigma_t={"type": "constvolume", "values": 2.0}))


def test_volumes_are_read_from_xml(tmp_path: Path) -> None:
    text = (
        '<scene version="3.0.0"><sensor type="perspective"/><integrator type="volpath"/><shape type="sphere">'
        '<bsdf type="null"/><medium type="homogeneous" name="interior">'
        '<volume type="constvolume" name="albedo"><rgb name="value" value="0.1 0.2 0.3"/></volume>'
        '<volume type="constvolume" name="sigma_t"><float name="value" value="2"/></volume>'
        '<phase type="blendphase"><volume type="constvolume" name="weight"><float name="value" value="0.25"/></volume>'
        '<phase type="hg"/><phase type="rayleigh"/></phase></medium></shape></scene>'
    )
    (tmp_path / "scene.xml").write_text(text)
    medium = et.load(tmp_path / "scene.xml").model.shapes[0].interior  # type: ignore[union-attr]
    assert (medium.albedo, medium.sigma_t, medium.phase.weight) == ((0.1, 0.2, 0.3), (2.0, 2.0, 2.0), 0.25)


AIR: Dict = {"type": "rayleigh"}
DUST: Dict = {"type": "hg", "g": 0.7}


def blend(weight: Any, first: Dict = AIR, second: Dict = DUST) -> Dict:
    return {"type": "blendphase", "weight": weight, "first": first, "second": second}


def pixels(phase: Dict) -> Any:
    lamp = {"type": "point", "position": [1.0, 0.5, 2.5], "intensity": 3.0}
    scene = ball(fog(phase=phase, albedo=1.0), {"type": "volpath", "max_depth": 3}, lamp=lamp)
    return et.render(scene, spp=16, seed=3).image


@pytest.mark.parametrize(
    ("phase", "same"),
    [
        (blend(0.0, DUST, AIR), DUST),
        (blend(1.0, AIR, DUST), DUST),
        (blend(0.3, DUST, DUST), DUST),
        (blend(0.5, blend(0.0, DUST), blend(0.25, DUST, DUST)), DUST),
        (blend(0.5, {"type": "isotropic"}, {"type": "hg", "g": 0.0}), {"type": "isotropic"}),
    ],
)
def test_a_blend_of_one_law_is_that_law(phase: Dict, same: Dict) -> None:
    assert not ball(fog(phase=phase)).core.effects()["phase_blends"]
    assert "phase_blends" not in derive(ball(fog(phase=phase)))
    assert (pixels(phase) == pixels(same)).all()


def test_a_blend_in_a_blend_is_one_of_all() -> None:
    assert ball(fog(phase=blend(0.5))).core.effects()["phase_blends"]
    assert [str(reason) for reason in derive(ball(fog(phase=AIR)))["phase_blends"]] == [
        "ball.interior.phase: phase 'rayleigh'"
    ]
    nested = pixels(blend(0.5, blend(0.5, AIR, DUST), AIR))
    assert (nested == pixels(blend(0.25, AIR, DUST))).all()
    assert (nested != pixels(blend(0.3, AIR, DUST))).any(), "the twin"


def test_too_many_laws_and_weights_that_are_none_are_refused_by_place() -> None:
    many: Dict = AIR
    for i in range(8):
        many = blend(0.5, many, {"type": "hg", "g": 0.1 * i})
    with pytest.raises(SceneError, match=r"ball\.interior: a blend of more than 8 phase functions"):
        _ = ball(fog(phase=many)).core
    with pytest.raises(SceneError, match=r"ball\.interior\.phase\.weight: must lie in \[0, 1\]; found 1\.5"):
        ball(fog(phase=blend(1.5)))
    with pytest.raises(SceneError, match=r"'blendphase' needs 'weight'"):
        ball(fog(phase={"type": "blendphase", "first": AIR, "second": DUST}))
    with pytest.raises(SceneError, match=r"ball\.interior\.phase"):
        ball(fog(phase={"type": "blendphase", "weight": 0.5, "first": AIR}))


@pytest.mark.parametrize("suffix", [".toml", ".xml"])
def test_blends_are_written_and_read_again(suffix: str, tmp_path: Path) -> None:
    scene = ball(fog(phase=blend(0.25, blend(0.5, DUST, AIR), {"type": "isotropic"})))
    convert(scene.model, scene.assets, tmp_path / f"scene{suffix}")
    again = et.load(tmp_path / f"scene{suffix}")
    assert mitsuba_dict(again.model, again.assets) == mitsuba_dict(scene.model, scene.assets)


def test_a_replay_tells_what_a_medium_leaves_and_where_it_scatters() -> None:
    scene, scattered = ball(fog(sigma_t=[1.0, 2.0, 3.0], albedo=0.9)), 0
    for sample in range(20):
        path = et.replay(scene, pixel=(1, 2), sample=sample, seed=5)
        assert path.sum == path.radiance
        particles = [vertex for vertex in path.vertices if vertex["particle"] is not None]
        scattered += len(particles)
        for vertex in particles:
            assert vertex["surface"] is None
            assert vertex["left"] != vertex["throughput"]
            assert (vertex["scattering"] or {"bsdf": "isotropic"})["bsdf"] == "isotropic"
            assert sum((a - b) ** 2 for a, b in zip(vertex["particle"], (0, 0, 4), strict=True)) <= 1.0
    assert scattered > 5


def test_the_cross_check_refuses_media_by_name() -> None:
    from equaltime.crosscheck.tracer import check

    with pytest.raises(RenderError, match="the cross-check cannot trace 'homogeneous', 'isotropic', 'null'"):
        check(ball(fog()).model)
