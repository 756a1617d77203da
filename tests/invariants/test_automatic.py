"""What a strategy leaves to the render follows from the scene and from counts: whether paths are split is the same for
every thread, seed and crop, stands in the record, and is taken from there by a render that is taken up."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import equaltime as et
from equaltime import _core
from equaltime.rendering.core import core_settings, make_renderer
from equaltime.rendering.decision import Decision
from equaltime.rendering.render_file import read_record

from .shipped import same_bits

SCENES = Path(__file__).parents[2] / "scenes"
AUTOMATIC = et.Strategy.parse("best,roulette=automatic,adaptive=none")
SPLITTING = et.Strategy.parse("best,roulette=efficiency,adaptive=none")
PLAIN = et.Strategy.parse("best,roulette=throughput,adaptive=none")


@pytest.fixture(scope="module")
def room() -> et.Scene:
    """Return a scene in which splitting pays, at the smallest size for which that is asked."""
    return et.load(SCENES / "cornell-box.toml").with_(size=(256, 256), max_depth=9)


@pytest.fixture(scope="module")
def hills() -> et.Scene:
    """Return a scene in which splitting does not pay."""
    return et.load(SCENES / "terrain/terrain.toml").with_(size=(256, 256), max_depth=9)


def rendered(scene: et.Scene, strategy: et.Strategy, seed: int = 1, threads: int = 1, spp: int = 1) -> _core.Renderer:
    renderer = make_renderer(scene, strategy, seed, threads)
    renderer.advance(spp)
    return renderer


def test_paths_are_split_where_a_pilot_says_that_it_pays_and_nowhere_else(room: et.Scene, hills: et.Scene) -> None:
    for scene, roulette, same in ((room, "efficiency", SPLITTING), (hills, "throughput", PLAIN)):
        decided, fixed = rendered(scene, AUTOMATIC), rendered(scene, same)
        assert decided.decision is not None
        assert decided.decision["roulette"] == roulette
        assert same_bits(decided.moments, fixed.moments)
        assert decided.kernel == fixed.kernel


def test_the_edges_of_lamps_count_although_they_are_noise_in_few_pixels() -> None:
    """They make most of the noise of Veach's plates, which copies leave alone; without them 0.48 would be foretold."""
    plates = et.load(SCENES / "veach-mis.toml").with_(size=(342, 192), max_depth=9)
    decision = rendered(plates, AUTOMATIC).decision
    assert decision is not None
    assert decision["roulette"] == "throughput"
    assert decision["splitting"] > 1.0


def test_a_gain_that_kernels_that_fork_would_eat_is_taken_with_the_lattice() -> None:
    """There copies leave 0.92 of what the pilot tells, and a ray takes 1.1 times as long."""
    opening = et.load(SCENES / "experiments/opening.toml").with_(size=(256, 256))
    decision = rendered(opening, AUTOMATIC).decision
    assert decision is not None
    assert decision["roulette"] == "efficiency"
    assert 1.1 * 0.92 * decision["splitting"] < 1.0 < 1.1 * decision["splitting"]


def test_the_rays_of_the_pilot_are_counted(hills: et.Scene) -> None:
    decided, plain = rendered(hills, AUTOMATIC), rendered(hills, PLAIN)
    both = [sum(r.counters[name] for name in ("rays", "shadow_rays")) for r in (decided, plain)]
    assert decided.decision is not None
    assert both[0] - both[1] == decided.decision["rays"]
    assert 0 < decided.decision["rays"] < 0.015 * 64 * both[1], "about 1 % of 64 samples a pixel"


def test_the_decision_depends_on_neither_threads_nor_seed_nor_crop(room: et.Scene) -> None:
    one = rendered(room, AUTOMATIC).decision
    assert rendered(room, AUTOMATIC, seed=7, threads=3).decision == one
    part = et.load(SCENES / "cornell-box.toml").with_(size=(256, 256), max_depth=9, crop=(9, 30, 12, 10))
    cropped = rendered(part, AUTOMATIC)
    assert cropped.decision == one
    assert same_bits(cropped.moments, rendered(room, AUTOMATIC).moments[:, 30:40, 9:21])


def test_replay_goes_by_what_was_decided(room: et.Scene) -> None:
    paths = [_core.replay(room.core, core_settings(room, s), 5, 100, 200, 3) for s in (AUTOMATIC, SPLITTING, PLAIN)]
    assert paths[0]["radiance"] == paths[1]["radiance"]
    assert len(paths[0]["vertices"]) == len(paths[1]["vertices"]) != len(paths[2]["vertices"])


def test_small_pictures_and_other_techniques_have_no_pilot() -> None:
    box = et.load(SCENES / "cornell-box.toml")
    for scene, words in ((box.with_(size=(255, 255)), "best"), (box.with_(size=(256, 256)), "best,technique=mixture")):
        decided = rendered(scene, et.Strategy.parse(f"{words},roulette=automatic,adaptive=none"), spp=0)
        assert decided.advance(1)
        assert decided.decision == {"roulette": "throughput", "splitting": None, "rays": 0}


def test_a_render_that_is_taken_up_keeps_what_was_decided(room: et.Scene, tmp_path: Path) -> None:
    saved = tmp_path / "part.exr"
    first = et.render(room, spp=2, strategy=AUTOMATIC)
    assert first.decision.roulette == "efficiency"
    assert first.decision.splitting is not None
    assert "split" in str(first.decision)
    first.save(saved)
    assert Decision.from_dict(read_record(saved)["decision"]) == first.decision
    resumed = et.render(room, spp=4, strategy=AUTOMATIC, resume=saved)
    whole = et.render(room, spp=4, strategy=AUTOMATIC)
    assert resumed.decision == whole.decision == first.decision
    assert (resumed.image == whole.image).all()
    assert resumed.stats.rays == whole.stats.rays, "the pilot is counted once"
    replace(first, decision=replace(first.decision, roulette="throughput")).save(tmp_path / "other.exr")
    other = et.render(room, spp=4, strategy=AUTOMATIC, resume=tmp_path / "other.exr")
    assert (other.image != whole.image).any(), "the twin: the record decides"


def test_even_counts_are_those_of_a_render_that_does_not_adapt(tmp_path: Path) -> None:
    """A ball under an even sky: nothing to gain. An odd number of samples is kept."""
    sky = et.load_dict(
        {
            "type": "scene",
            "sensor": {"type": "perspective", "film": {"type": "hdrfilm", "width": 40, "height": 40}},
            "ball": {"type": "sphere", "center": [0, 0, 4], "radius": 3},
            "sky": {"type": "constant"},
        }
    )
    adaptive = et.render(sky, spp=21, strategy="best,adaptive=error")
    assert adaptive.decision.counts == "even"
    assert (adaptive.samples == 21).all()
    even = et.render(sky, spp=21, strategy="best,adaptive=none")
    assert (adaptive.image == even.image).all()
    et.render(sky, spp=9, strategy="best,adaptive=error").save(tmp_path / "part.exr")
    resumed = et.render(sky, spp=21, strategy="best,adaptive=error", resume=tmp_path / "part.exr")
    assert (resumed.image == even.image).all()
    assert resumed.decision == adaptive.decision


def under_a_lamp() -> et.Scene:
    """Return a small patch of a floor under a lamp: all pixels are alike, and all paths end at their second ray."""
    towards_floor = {"look_at": {"origin": [0, 0, 2], "target": [0, 0, 0], "up": [0, 1, 0]}}
    film = {"type": "hdrfilm", "width": 512, "height": 512, "rfilter": {"type": "box"}}
    return et.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "path", "max_depth": 2},
            "sensor": {"type": "perspective", "fov": 0.5, "to_world": [towards_floor], "film": film},
            "floor": {"type": "rectangle", "bsdf": {"type": "diffuse"}},
            "lamp": {
                "type": "rectangle",
                "to_world": [{"rotate": {"axis": [0, 1, 0], "angle": 90}}, {"translate": [-1, 0, 1]}],
                "emitter": {"type": "area", "radiance": 1.0},
            },
        }
    )


def test_the_gain_of_splitting_is_that_of_the_closed_form() -> None:
    """A ray to the floor, and one from there that may meet the lamp: n copies leave 1/n of the variance for 1 + n rays.

    16 copies, the most, make 17/32 of the variance times rays. The pilot's 4096 pixels extrapolate from four copies,
    with a standard deviation of 0.14 in the logarithm: false alarms 1 in 15,787 (4 sigma, two-sided). Where a lamp is
    aimed at and rays from the floor bring nothing, copies cost rays alone, and none are made.
    """
    found = {}
    for technique in ("bsdf", "light"):
        words = f"{technique},sampler=independent,roulette=efficiency,roulette_depth=5"
        renderer = rendered(under_a_lamp(), et.Strategy.parse(words))
        assert renderer.decision is not None
        found[technique] = renderer.decision["splitting"]
    assert abs(math.log(found["bsdf"] / (17.0 / 32.0))) < 0.56
    assert found["light"] == 1.0, "the twin"


def test_a_choice_that_was_made_is_not_overridden(room: et.Scene) -> None:
    split = et.render(room, spp=1, strategy=SPLITTING)
    assert split.decision == Decision()
    assert np.isfinite(split.image).all()
