"""What is done so far is saved on time, however long a pass takes, and is taken up with the same bits."""

from __future__ import annotations

from itertools import pairwise, takewhile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import equaltime as et
from equaltime.errors import ImageError
from equaltime.rendering.budget import Limits
from equaltime.rendering.passes import Passes, Saving, pass_end
from equaltime.rendering.render_file import read_film, read_picture

from .fake_renderer import PIXELS, FakeRenderer

EVERY = 0.05
SCENE = Path(__file__).parents[3] / "scenes" / "cornell-box.toml"


class Saved:
    """Saves of a render by a clock that the test controls: when they were begun, and how many samples they have."""

    def __init__(self, renderer: FakeRenderer, takes: float = 0.002) -> None:
        self.renderer, self.takes = renderer, takes
        self.times, self.samples = [0.0], [0]

    def __call__(self) -> None:
        self.times.append(self.renderer.now)
        self.samples.append(self.renderer.done)
        self.renderer.now += self.takes

    @property
    def ages(self) -> list[float]:
        """How old what was saved was at most, save by save."""
        return [b - a for a, b in pairwise([*self.times, self.renderer.now])]


def run(renderer: FakeRenderer, limits: Limits, every: float = EVERY, takes: float = 0.002) -> tuple[Passes, Saved]:
    saved = Saved(renderer, takes)
    passes = Passes(renderer, PIXELS, limits, clock=renderer.clock)
    passes.saving = Saving(saved, every, takes)
    passes.run()
    return passes, saved


class Deaf(FakeRenderer):
    """Pauses nowhere."""

    def advance(self, *limits: Any) -> bool:
        return super().advance(*limits[:3])


def test_what_is_saved_is_at_most_an_interval_and_a_sample_old_however_long_a_pass() -> None:
    renderer = FakeRenderer()
    _, saved = run(renderer, Limits(spp=2048))
    assert max(saved.ages) <= EVERY + 1.5 * renderer.seconds_a_sample
    assert len(saved.ages) == pytest.approx(renderer.now / EVERY, rel=0.05), "no more often than asked for"
    deaf = Deaf()
    _, saved = run(deaf, Limits(spp=2048))
    assert max(saved.ages) > 4 * EVERY, "the twin: between passes alone"


def test_pauses_leave_the_schedule_of_passes_as_it_is() -> None:
    renderer = FakeRenderer()
    run(renderer, Limits(spp=512))
    ends = [a for a, b in pairwise([*renderer.targets, 0]) if a != b]
    steps = [0, *ends]
    assert ends == [*takewhile(lambda end: end < 512, _schedule()), 512]
    assert len(renderer.targets) > len(ends)
    assert all(pass_end(a, PIXELS) == b for a, b in pairwise(steps[:-1]))


def _schedule() -> Any:
    samples = 0
    while True:
        yield (samples := pass_end(samples, PIXELS))


def test_the_time_of_pauses_is_no_time_of_passes() -> None:
    renderer = FakeRenderer()
    passes, saved = run(renderer, Limits(spp=512), takes=0.02)
    assert passes.saving is not None
    assert passes.saving.seconds == pytest.approx(0.02 * (len(saved.times) - 1))
    assert passes.rendering == pytest.approx(0.512)


def test_saving_takes_half_of_the_time_at_most() -> None:
    renderer = FakeRenderer()
    _, saved = run(renderer, Limits(spp=512), every=1e-9, takes=0.03)
    assert len(saved.times) - 1 == pytest.approx(0.512 / 0.03, abs=1.5)


def test_nothing_is_saved_where_the_time_limit_would_be_overrun() -> None:
    renderer = FakeRenderer()
    passes, saved = run(renderer, Limits(seconds=0.5), every=0.07, takes=0.03)
    assert passes.stopped_by == "time"
    assert renderer.now == pytest.approx(0.5)
    assert saved.times[-1] + 0.06 <= 0.5


def test_that_saving_fails_is_told_again_only_after_it_went_well() -> None:
    disk_is_full, told = iter([True, True, False, False, True]), list[str]()

    def save() -> None:
        if next(disk_is_full):
            raise ImageError("no room")

    saving = Saving(save, EVERY, 0.0, told.append)
    counts = []
    for _ in range(5):
        saving.run(lambda: 0.0)
        counts.append(len(told))
    assert counts == [1, 1, 1, 1, 2]
    assert told[0] == "no room"


def test_a_pass_in_which_a_sample_went_wrong_is_finished_and_not_saved() -> None:
    renderer = FakeRenderer(bad_sample=600)
    passes, saved = run(renderer, Limits(spp=2048))
    assert passes.stopped_by == "nonfinite"
    assert renderer.done == 640
    assert saved.samples[-1] <= 600


def test_ctrl_c_in_a_pause_keeps_what_is_finished() -> None:
    renderer = FakeRenderer()

    def interrupt() -> None:
        raise KeyboardInterrupt

    passes = Passes(renderer, PIXELS, Limits(spp=2048), clock=renderer.clock)
    passes.saving = Saving(interrupt, EVERY, 0.0)
    assert passes.run() == "interrupt"
    assert renderer.done == 50


@pytest.fixture(scope="module")
def scene() -> et.Scene:
    return et.load(SCENE).with_(size=(72, 56), max_depth=4)


@pytest.fixture
def within(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> list[Path]:
    """Return a list of files that fills while something renders and saves as often as it can: one of each pass."""
    files: dict[int, Path] = {}
    listed: list[Path] = []
    save = et.Result.save

    def keep(self: et.Result, path: Any, **_: Any) -> tuple[Path, ...]:
        assert self.position is not None
        done, _, next_block = self.position
        if self.stopped_by != "unfinished":
            return save(self, path)
        if not next_block or done in files:
            return ()
        files[done] = tmp_path / f"{done}.exr"
        listed.append(files[done])
        return save(self, files[done])

    monkeypatch.setattr(et.Result, "save", keep)
    monkeypatch.setattr(Saving, "left", lambda *_: 0.0)
    return listed


LIMITS: list[dict[str, Any]] = [
    {"spp": 20},
    {"spp": 20, "strategy": "best,sampler=independent"},
    {"spp": 20, "strategy": "best,adaptive=error"},
    {"error": 0.25},
    {"error": 0.25, "strategy": "best,adaptive=error"},
]


@pytest.mark.parametrize("options", LIMITS, ids=str)
def test_what_was_saved_within_a_pass_is_taken_up_with_the_same_bits(
    scene: et.Scene, within: list[Path], options: dict[str, Any], tmp_path: Path
) -> None:
    whole = et.render(scene, **options)
    saving = et.render(scene, threads=2, checkpoint=tmp_path / "a.exr", **options)
    assert whole.moments is not None
    assert saving.moments is not None
    assert saving.moments.tobytes() == whole.moments.tobytes()
    assert saving.looks == whole.looks
    assert len(within) >= 4
    for file in within:
        taken_up = et.render(scene, resume=file, **options)
        assert taken_up.moments is not None
        assert taken_up.moments.tobytes() == whole.moments.tobytes(), file.name
        assert (taken_up.looks, taken_up.stats.paths) == (whole.looks, whole.stats.paths)


def test_a_file_saved_within_a_pass_says_which_samples_it_has_and_can_be_merged(
    scene: et.Scene, within: list[Path], tmp_path: Path
) -> None:
    et.render(scene, spp=4, threads=2, checkpoint=tmp_path / "a.exr")
    part = read_film(within[0]).moments
    assert part is not None
    counts = part["count"].sum(axis=0)
    record = read_picture(within[0]).record
    assert record["samples"] == {"first": 0, "min": 0, "max": 2}
    assert record["stopped_by"] == "unfinished"
    assert set(np.unique(counts)) == {0, 2}
    other = et.render(scene, spp=6, seed=1)
    other.save(tmp_path / "b.exr")
    merged = et.merge([within[0], tmp_path / "b.exr"])
    np.testing.assert_array_equal(merged.samples, counts + 6)
    np.testing.assert_array_equal(merged.image[counts == 0], other.image[counts == 0])
