"""Renders whose samples other processes take: the bits, the order of units, pauses and time limits."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest

import equaltime as et
from equaltime.errors import RenderError
from equaltime.rendering.core import make_renderer
from equaltime.rendering.spread import SpreadRenderer, spread_renderer, windows
from equaltime.rendering.units import Recipe, Rendered, Unit, add_samples, second_place
from equaltime.strategy import Strategy

SCENE = et.load("cornell-box").with_(size=(100, 70))
ONE_NET = et.load("cornell-box").with_(size=(300, 260))


class FakeTeam:
    """Renders units here, the last submitted first, in so many threads."""

    def __init__(self, scene: et.Scene, size: int = 2, wrong: Callable[[int], bool] = lambda n: False) -> None:
        self.scene, self.size, self.wrong = scene, size, wrong
        self.pool = ThreadPoolExecutor(size)
        self.units: list[Unit] = []
        self.done: list[tuple[Unit, Rendered]] = []
        self.given_back: list[Any] = []

    def begin(self) -> None: ...

    def check(self) -> bool:
        return False

    def submit(self, unit: Unit) -> Future[Rendered]:
        self.units.append(unit)
        if self.wrong(len(self.units)):
            failed: Future[Rendered] = Future()
            failed.set_exception(OSError("gone"))
            return failed
        return self.pool.submit(add_samples, self.scene, unit, 1)

    def failure(self, error: Exception) -> RenderError:
        return RenderError(f"lost: {error}")

    def keep(self, unit: Unit, rendered: Rendered) -> None:
        self.done.append((unit, rendered))

    def kept(self, recipe: Recipe) -> Sequence[Any]:
        return self.given_back

    def saved(self) -> None: ...


class Kept:
    """A unit that an earlier team rendered."""

    def __init__(self, unit: Unit, rendered: Rendered) -> None:
        self.window, self.begin, self.end, self.rendered = unit.window, unit.begin, unit.end, rendered
        self.reads = 0

    def read(self) -> Rendered:
        self.reads += 1
        return self.rendered


def spread(scene: et.Scene, team: FakeTeam, strategy: str = "best", seed: int = 3) -> SpreadRenderer:
    return spread_renderer(scene, Strategy.parse(strategy), seed, 1, team, "ignore")


def alone(scene: et.Scene, samples: int, strategy: str = "best", seed: int = 3) -> Any:
    renderer = make_renderer(scene, Strategy.parse(strategy), seed, 1)
    renderer.advance(samples)
    return renderer


def same(a: Any, b: Any) -> bool:
    parts = [(each.moments.tobytes(), each.second_moments.tobytes(), each.counters, each.position) for each in (a, b)]
    return bool(parts[0] == parts[1])


@pytest.mark.parametrize("strategy", ["best", "best,adaptive=none", "best,roulette=efficiency", "mis,sampler=sobol"])
@pytest.mark.parametrize("scene", [SCENE, ONE_NET], ids=["two nets", "one net"])
def test_a_film_that_others_sample_has_the_bits_of_one_that_is_sampled_here(scene: et.Scene, strategy: str) -> None:
    team = FakeTeam(scene)
    renderer = spread(scene, team, strategy)
    for samples in (2, 8, 12):
        assert renderer.advance(samples)
    assert len(team.units) > 6
    assert same(renderer, alone(scene, 12, strategy))
    assert not same(renderer, alone(scene, 12, strategy, seed=4)), "the twin"


def test_even_and_uneven_counts_are_decided_as_here() -> None:
    team = FakeTeam(ONE_NET)
    renderer = spread(ONE_NET, team)
    renderer.advance(24)
    here = alone(ONE_NET, 24)
    assert renderer.counts == here.counts == "error"  # type: ignore[attr-defined]
    np.testing.assert_array_equal(renderer.moments["count"], here.moments["count"])


def test_a_pause_loses_nothing_and_the_film_can_be_saved_in_it() -> None:
    team = FakeTeam(SCENE)
    renderer, pauses = spread(SCENE, team), 0
    while not renderer.advance(16, pause=0.0):
        pauses += 1
        done, target, block = renderer.position
        assert (target > done, block) == (True, 5 * 7)
    assert pauses > 2
    assert same(renderer, alone(SCENE, 16))
    assert len(team.units) == len(team.done), "no unit was rendered twice"


def test_a_time_limit_ends_a_pass_between_units_and_the_next_call_goes_on() -> None:
    renderer = spread(SCENE, FakeTeam(SCENE))
    assert not renderer.advance(64, seconds=0.0)
    assert renderer.position[0] == 0
    assert renderer.advance(64)
    assert same(renderer, alone(SCENE, 64))


def test_a_poll_that_says_stop_ends_the_call() -> None:
    renderer = spread(SCENE, FakeTeam(SCENE))
    assert not renderer.advance(64, poll=lambda: False)
    assert renderer.advance(64)
    assert same(renderer, alone(SCENE, 64))


def test_a_unit_that_is_lost_ends_the_render_and_finished_ones_stay() -> None:
    team = FakeTeam(SCENE, wrong=lambda n: n == 5)
    renderer = spread(SCENE, team)
    with pytest.raises(RenderError, match="lost: gone"):
        renderer.advance(16)
    assert len(team.done) >= 1
    renderer.advance(16)
    assert same(renderer, alone(SCENE, 16))


def test_kept_units_are_taken_instead_of_rendered_ones() -> None:
    first = FakeTeam(SCENE, wrong=lambda n: n > 6)
    with pytest.raises(RenderError):
        spread(SCENE, first).advance(16)
    second = FakeTeam(SCENE)
    second.given_back = [Kept(unit, rendered) for unit, rendered in first.done]
    renderer = spread(SCENE, second)
    renderer.advance(16)
    assert same(renderer, alone(SCENE, 16))
    assert [kept.reads for kept in second.given_back] == [1] * len(first.done)
    rendered_again = {(unit.window, unit.begin, unit.end) for unit in second.units}
    assert not {(kept.window, kept.begin, kept.end) for kept in second.given_back} & rendered_again


def test_a_kept_unit_with_other_counts_is_not_taken() -> None:
    first = FakeTeam(SCENE)
    spread(SCENE, first, "best,adaptive=none").advance(4)
    unit, rendered = first.done[0]
    damaged = rendered.moments.copy()
    damaged["count"] += 1
    second = FakeTeam(SCENE)
    second.given_back = [Kept(unit, Rendered(**{**rendered.__dict__, "moments": damaged}))]
    renderer = spread(SCENE, second, "best,adaptive=none")
    renderer.advance(4)
    assert same(renderer, alone(SCENE, 4, "best,adaptive=none"))


def test_a_unit_whose_moments_have_other_counts_is_refused() -> None:
    team = FakeTeam(SCENE)
    spread(SCENE, team, "best,adaptive=none").advance(4)
    unit = team.units[0]
    wrong = Unit(unit.recipe, unit.window, 2, 4, unit.moments, unit.second, None)
    with pytest.raises(ValueError, match="sample counts"):
        add_samples(SCENE, wrong, 1)
    odd = Unit(unit.recipe, (1, 0, 17, 16), 0, 4, unit.moments, unit.second, None)
    with pytest.raises(ValueError, match="whole blocks"):
        add_samples(SCENE, odd, 1)


@pytest.mark.parametrize("parts", [1, 3, 8, 1000])
def test_windows_cover_the_missing_blocks_once(parts: int) -> None:
    missing = np.random.default_rng(1).random((9, 13)) < 0.7
    missing[:4, :6] = True
    height, width = 9 * 16 - 5, 13 * 16 - 3
    covered = np.zeros((height, width), int)
    for x0, y0, x1, y1 in windows(missing, height, width, parts):
        assert (x1 - x0) * (y1 - y0) <= 2**16
        covered[y0:y1, x0:x1] += 1
    np.testing.assert_array_equal(covered, np.kron(missing, np.ones((16, 16), int))[:height, :width])


@pytest.mark.parametrize("pixels", [1, 2, 4, 8, 16, 32])
def test_the_place_of_second_nets_is_where_the_core_has_them(pixels: int) -> None:
    film = make_renderer(ONE_NET, Strategy.parse("best,adaptive=none"), 0, 1, second_net=pixels)
    _, rows, columns = second_place((16, 32, 48, 64), pixels)
    inside = np.zeros(film.second_pixels.shape, bool)
    inside[rows, columns] = True
    y, x = np.divmod(film.second_pixels, 300)
    expected = (film.second_pixels >= 0) & (x >= 16) & (x < 48) & (y >= 32) & (y < 64)
    np.testing.assert_array_equal(inside & (film.second_pixels >= 0), expected)
