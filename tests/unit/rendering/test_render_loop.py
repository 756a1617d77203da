"""The loop of passes, over a renderer and a clock that the test controls."""

from collections.abc import Iterator
from itertools import islice, pairwise, takewhile
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from equaltime.film.error import PixelStatistics, image_error, pixel_statistics
from equaltime.film.unseen import Unseen, stated_error
from equaltime.rendering.budget import Limits
from equaltime.rendering.passes import Passes, Progress, pass_end
from equaltime.statistics.intervals import Interval

from .fake_renderer import PIXELS, FakeRenderer


def run(renderer: FakeRenderer, spp: int | None = None, seconds: float | None = None, **options: Any) -> str:
    return Passes(renderer, PIXELS, Limits(spp, seconds), clock=renderer.clock, **options).run()


def schedule(pixels: int) -> Iterator[int]:
    samples = 0
    while True:
        samples = pass_end(samples, pixels)
        yield samples


def test_passes_double_and_then_grow_by_a_quarter() -> None:
    assert list(islice(schedule(PIXELS), 14)) == [2, 4, 8, 16, 20, 24, 28, 32, 40, 48, 56, 64, 80, 96]


def test_the_first_passes_of_a_large_image_are_even() -> None:
    assert list(islice(schedule(2**16), 6)) == [2, 4, 8, 12, 16, 20]
    assert list(islice(schedule(2**18), 9)) == [2, 4, 6, 8, 10, 12, 14, 16, 20]


def test_passes_of_several_processes_quadruple_unless_time_limits_them() -> None:
    pixels = 3840 * 2160
    ends = [0]
    while ends[-1] < 1024:
        ends.append(pass_end(ends[-1], pixels, breadth=10, timed=False))
    assert ends == [0, 2, 8, 32, 128, 512, 2048]
    assert pass_end(20, pixels, breadth=10, timed=False) == 20 + 48
    assert pass_end(20, pixels) < pass_end(20, pixels, breadth=10) <= 24


def test_the_last_pass_ends_at_the_sample_count() -> None:
    renderer = FakeRenderer()
    run(renderer, spp=100)
    assert renderer.targets == [*takewhile(lambda end: end < 100, schedule(PIXELS)), 100]


def test_passes_of_a_large_image_stay_short() -> None:
    steps = {b - a for a, b in pairwise(takewhile(lambda end: end < 256, schedule(2**19)))}
    assert steps == {2, 4}


@pytest.mark.parametrize("pixels", [1, 1000, 2**19, 2**28])
def test_replicates_grow_alike_in_every_pass(pixels: int) -> None:
    assert all(samples % 2 == 0 for samples in islice(schedule(pixels), 40))
    assert all((pass_end(samples, pixels) - samples) % 2 == 0 for samples in range(200))


def test_a_single_sample_is_one_pass() -> None:
    renderer = FakeRenderer()
    run(renderer, spp=1)
    assert renderer.targets == [1]


def test_a_render_ends_at_its_sample_count() -> None:
    renderer = FakeRenderer()
    assert run(renderer, spp=20) == "spp"
    assert renderer.done == 20
    assert renderer.targets[-2:] == [16, 20]


def test_a_time_limit_ends_a_pass_part_way() -> None:
    renderer = FakeRenderer()
    assert run(renderer, seconds=0.023) == "time"
    assert renderer.done == 23


def test_a_time_limit_that_falls_between_passes_starts_no_further_pass() -> None:
    renderer = FakeRenderer()
    assert run(renderer, seconds=0.016) == "time"
    assert renderer.targets[-1] in (16, 20)
    assert renderer.done == 16


class Heedless(FakeRenderer):
    """Knows of no time limit; only between passes is there a clock."""

    def advance(self, samples: int, seconds: float | None = None, *others: Any) -> bool:
        return super().advance(samples, None, *others)


def test_a_limit_that_is_looked_at_between_passes_only_would_be_overrun() -> None:
    """The twin."""
    renderer = Heedless()
    run(renderer, seconds=0.2)
    assert renderer.now > 1.02 * 0.2


def test_the_limit_that_is_met_first_ends_the_render() -> None:
    assert run(FakeRenderer(), spp=10, seconds=1.0) == "spp"
    assert run(FakeRenderer(), spp=1000, seconds=0.01) == "time"


def test_ctrl_c_keeps_what_is_finished() -> None:
    renderer = FakeRenderer(interrupt_at=0.012)
    assert run(renderer, spp=100) == "interrupt"
    assert renderer.done == 11


def test_a_non_finite_sample_ends_the_render_after_its_pass() -> None:
    renderer = FakeRenderer(bad_sample=33)
    assert run(renderer, spp=100) == "nonfinite"
    assert renderer.done == 40


def test_progress_counts_up_to_the_target() -> None:
    seen: list[Progress] = []
    run(FakeRenderer(), spp=64, progress=seen.append)
    assert [progress.samples for progress in seen] == [*takewhile(lambda end: end < 64, schedule(PIXELS)), 64]
    assert seen[-1].fraction == 1.0
    assert seen[-1].time_left == 0.0
    assert all(progress.target == 64 for progress in seen)


def test_progress_is_reported_within_a_long_pass() -> None:
    seen: list[Progress] = []
    run(FakeRenderer(), spp=2048, progress=seen.append)
    gaps = [b.seconds - a.seconds for a, b in pairwise(seen)]
    assert max(gaps) <= 0.102


def test_the_time_left_follows_from_the_samples_done() -> None:
    seen: list[Progress] = []
    run(FakeRenderer(), spp=4096, progress=seen.append)
    assert all(abs(p.seconds + p.time_left - 4.096) < 1e-6 for p in seen if p.time_left is not None)


def test_the_time_left_is_right_again_a_pass_after_the_load_has_changed() -> None:
    seen: list[Progress] = []
    renderer = FakeRenderer()

    def look(progress: Progress) -> None:
        seen.append(progress)
        if progress.samples == 256:
            renderer.seconds_a_sample = 0.004

    run(renderer, spp=4096, progress=look)
    after = next(number for number, progress in enumerate(seen) if progress.samples > 256)
    assert (seen[after - 1].time_left or 0.0) < 0.5 * (renderer.now - seen[after - 1].seconds)
    assert all(p.time_left == pytest.approx(renderer.now - p.seconds) for p in seen[after:])


def test_the_time_left_takes_no_speed_from_the_rest_of_a_pass() -> None:
    seen: list[Progress] = []
    renderer = FakeRenderer()
    renderer.done = 62  # an earlier render was cut short in its pass from 56 to 64
    run(renderer, spp=256, progress=seen.append, samples=56, begun=True)
    assert seen[0].time_left is None
    assert [p.seconds + p.time_left for p in seen if p.time_left is not None] == pytest.approx(
        [0.194] * (len(seen) - 1)
    )


def test_the_time_left_of_a_time_limit_is_what_the_clock_says() -> None:
    seen: list[Progress] = []
    run(FakeRenderer(), seconds=0.5, progress=seen.append)
    assert all(p.time_left == pytest.approx(0.5 - p.seconds) for p in seen)
    assert all(p.fraction == pytest.approx(p.seconds / 0.5) for p in seen)


def test_progress_shows_the_error_so_far() -> None:
    seen: list[Progress] = []
    run(FakeRenderer(), spp=64, progress=seen.append)
    assert seen[0].error is not None
    assert seen[0].error.known


class Hiding(Unseen):
    """A part of error² that no sample has seen."""

    def __call__(self, pixels: PixelStatistics, level: float) -> float:
        return 9.0


def test_progress_shows_the_error_that_the_render_states() -> None:
    seen: list[Progress] = []
    hiding = Hiding(lambda pixels: np.zeros((len(pixels), 3)))
    run(renderer := FakeRenderer(), spp=64, progress=seen.append, hidden=hiding)
    pixels, shown = pixel_statistics(renderer.moments), seen[0].error
    assert shown == stated_error(pixels, hiding)
    assert shown.high > 3.0 > image_error(pixels).high


def test_a_progress_callback_can_stop_the_render() -> None:
    def stop(progress: Progress) -> None:
        if progress.samples >= 8:
            raise KeyboardInterrupt

    renderer = FakeRenderer()
    assert run(renderer, spp=1024, progress=stop) == "interrupt"
    assert renderer.done == 8


def test_an_error_in_the_progress_callback_is_not_hidden() -> None:
    def fail(progress: Progress) -> None:
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        run(FakeRenderer(), spp=8, progress=fail)


class SlowStatistics(FakeRenderer):
    """Statistics cost 0.3 ms of the clock, so that the estimate's share can be seen."""

    estimates, cost = 0, 0.0003

    @property
    def moments(self) -> NDArray[Any]:
        self.estimates += 1
        self.now += self.cost
        return super().moments


def test_the_error_so_far_costs_nothing_when_nobody_asks() -> None:
    renderer = SlowStatistics()
    run(renderer, spp=512)
    assert renderer.estimates == 0


def test_the_error_so_far_costs_three_parts_in_a_thousand_of_the_time_at_most() -> None:
    renderer = SlowStatistics()
    run(renderer, spp=8192, progress=lambda progress: None)
    assert renderer.estimates >= 3
    assert (renderer.estimates - 1) * 0.0003 <= 0.003 * renderer.now


def test_looking_at_the_error_overruns_no_time_limit() -> None:
    done, renderer = FakeRenderer(), SlowStatistics()
    done.advance(8)
    seen = image_error(pixel_statistics(done.moments))
    renderer.cost = 0.02
    passes = Passes(renderer, PIXELS, Limits(seconds=0.1, error=0.9 * seen.high), clock=renderer.clock)
    assert passes.run() == "time"
    assert [look.samples for look in passes.looks.made] == [8, 12]
    assert renderer.now == pytest.approx(0.1)


def test_an_error_is_not_shown_once_the_samples_have_doubled_since() -> None:
    seen: list[Progress] = []
    run(SlowStatistics(), spp=64, progress=seen.append)
    assert seen[0].error is not None
    stale = next(progress for progress in seen if progress.samples >= 2 * seen[0].samples)
    assert stale.error is None


def test_the_end_that_is_foretold_is_a_look_and_moves_on_once_the_error_is_still_too_large() -> None:
    """A render stops at a look alone: what is left was 0 s as soon as the count foretold had passed."""
    renderer = FakeRenderer()
    passes = Passes(renderer, PIXELS, Limits(error=0.02), clock=renderer.clock, samples=64)

    def foretold(believed: float, samples: int) -> int | None:
        passes.looks.look(Interval(0.8 * believed, 0.7 * believed, believed), samples)
        passes.samples = samples
        return passes.samples_for(0.02)

    assert foretold(0.021, 64) == 96
    passes.samples = 95
    assert passes.samples_for(0.02) == 96
    passes.samples = 96  # whose look comes next
    assert passes.samples_for(0.02) == 96
    assert foretold(0.0205, 96) == 128
    assert foretold(0.08, 128) == 128 * 16  # after a look with at most 0.024
    passes.looks.made = ()
    assert foretold(0.0195, 64) == 96  # two looks in a row must agree


@pytest.mark.parametrize(("brightest", "known"), [(0.0, True), (1e3, False)])
def test_no_time_left_is_told_while_a_bright_path_widens_the_limit(brightest: float, known: bool) -> None:
    renderer = FakeRenderer()
    renderer.done = 64
    passes = Passes(renderer, PIXELS, Limits(error=0.02), clock=renderer.clock, samples=64)
    passes.looks.look(Interval(0.03, 0.02, 0.2), 64, brightest)
    assert (passes.samples_for(0.02) is not None) == known
