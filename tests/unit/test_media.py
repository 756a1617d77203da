"""Media in scene files: what they may be given, who sees them, and what is folded away."""

from __future__ import annotations

from typing import Any

import pytest

import equaltime as et
from equaltime.effects import derive
from equaltime.errors import RenderError, SceneError
from equaltime.scene.model import Homogeneous, Isotropic

Dict = dict[str, Any]
VOLPATH: Dict = {"type": "volpath", "max_depth": 5}


def ball(inside: Dict | None = None, integrator: Dict = VOLPATH, **sensor: Any) -> et.Scene:
    film = {"type": "hdrfilm", "width": 4, "height": 4, "rfilter": {"type": "box"}}
    shape = {"type": "sphere", "center": [0, 0, 4], "bsdf": {"type": "null"}}
    return et.load_dict(
        {
            "type": "scene",
            "integrator": integrator,
            "sensor": {"type": "perspective", "fov": 10.0, "film": film, **sensor},
            "sky": {"type": "constant", "radiance": 1.0},
            "ball": shape | ({} if inside is None else {"interior": inside}),
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


def test_the_medium_of_the_camera_is_where_paths_begin() -> None:
    assert ball(None, medium=fog()).core.effects()["media"]
    assert (et.render(ball(None, medium=fog()), spp=2).image == 0.0).all(), "no sky is seen through fog without end"


def test_equal_media_are_one_however_they_are_called() -> None:
    scene = ball(fog(phase={"type": "isotropic"}), medium=fog(phase={"type": "hg", "g": 0.0}))
    assert scene.model.sensor.medium != scene.model.shapes[0].interior  # type: ignore[union-attr]
    assert Homogeneous().phase == Isotropic()
    assert scene.core.effects()["media"]


def test_a_replay_tells_what_a_medium_leaves_and_where_it_scatters() -> None:
    scene, scattered = ball(fog(sigma_t=[1.0, 2.0, 3.0], albedo=0.9)), 0
    for sample in range(20):
        path = et.replay(scene, (1, 2), sample, seed=5)
        assert path.sum == path.radiance
        particles = [vertex for vertex in path.vertices if vertex["particle"] is not None]
        scattered += len(particles)
        for vertex in particles:
            assert vertex["surface"] is None
            assert vertex["left"] != vertex["throughput"]
            assert (vertex["scattering"] or {"bsdf": "phase"})["bsdf"] == "phase"
            assert sum((a - b) ** 2 for a, b in zip(vertex["particle"], (0, 0, 4), strict=True)) <= 1.0
    assert scattered > 5


def test_the_cross_check_refuses_media_by_name() -> None:
    from equaltime.crosscheck.refusal import check

    with pytest.raises(RenderError, match="the cross-check cannot trace 'homogeneous', 'isotropic', 'null'"):
        check(ball(fog()).model)
