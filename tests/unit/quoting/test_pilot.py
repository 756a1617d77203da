"""Pilots of renders: how much they take, what they tell of renders that others began, and why they tell nothing."""

import copy
import time
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import Any

import pytest

import equaltime as et
from equaltime.cli import main
from equaltime.quoting import pilot
from equaltime.quoting.law import Law, Processors, from_start, without_start
from equaltime.quoting.pilot import Pilot
from equaltime.quoting.probe import Probe
from equaltime.rendering.budget import Limits
from equaltime.rendering.job import Job
from equaltime.rendering.saved import SavedRender
from equaltime.rendering.session import Session
from equaltime.strategy import Strategy

SCENE = Path(__file__).parents[3] / "scenes" / "cornell-box.toml"
DARK = {"type": "scene", "sensor": {"type": "perspective"}, "ball": {"type": "sphere"}}


@pytest.fixture(scope="module")
def scene() -> et.Scene:
    return et.load(SCENE).with_(size=(28, 28))


@pytest.mark.parametrize("target", [{"time": 1e6}, {"error": 1e-4}])
def test_a_pilot_of_long_work_ends_after_its_time(
    scene: et.Scene, monkeypatch: pytest.MonkeyPatch, target: dict[str, float]
) -> None:
    monkeypatch.setattr(pilot, "USUAL_SECONDS", 1e-6)
    assert et.quote(scene, why=False, **target).law.samples <= 8
    monkeypatch.setattr(pilot, "USUAL_SECONDS", 0.2)
    assert et.quote(scene, why=False, **target).law.samples > 8


def test_a_pilot_too_short_for_uneven_counts_makes_no_probe(scene: et.Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pilot.Pilot, "_is_slow", True)
    even = et.quote(scene, why=False, error=0.1, strategy="best,adaptive=none")
    uneven = et.quote(scene, why=False, error=0.1)
    assert even.law.samples > 2
    assert uneven.law.samples == 2


def test_an_error_beyond_all_samples_is_refused_at_once(scene: et.Scene) -> None:
    with pytest.raises(et.RenderError, match=r"beyond reach: it takes .* samples a pixel or more, and 4294967296 are"):
        et.quote(scene, error=1e-8)


def test_what_is_done_already_is_quoted_as_it_is_known(scene: et.Scene) -> None:
    """The pilot has all four samples that the render will have, and the image's own interval."""
    quotes: list[et.Quote] = []
    result = et.render(
        scene, spp=4, error=0.02, observer=et.Observer.of(quoted=quotes.append), strategy="best,adaptive=none"
    )
    assert quotes[0].error.value == pytest.approx(result.error.value)
    assert quotes[0].error.high == pytest.approx(result.error.high)
    assert quotes[0].error.low < 0.9 * quotes[0].error.value


def test_any_of_several_limits_may_end_a_render_first(scene: et.Scene) -> None:
    alone, together = list[et.Quote](), list[et.Quote]()
    et.render(scene, error=0.05, observer=et.Observer.of(quoted=alone.append))
    most = round(alone[0].spp.value)
    et.render(scene, error=0.05, spp=most, observer=et.Observer.of(quoted=together.append))
    assert together[0].spp.low < together[0].spp.high <= most
    assert together[0].seconds.low < together[0].seconds.high


def resumed_quote(scene: et.Scene, begun: Path, **limits: float) -> tuple[et.Quote, et.Result]:
    quotes: list[et.Quote] = []
    result = et.render(
        scene, resume=begun, observer=et.Observer.of(quoted=quotes.append), strategy="best,adaptive=none", **limits
    )  # type: ignore[arg-type]
    return quotes[0], result


def test_a_render_that_is_taken_up_is_quoted(scene: et.Scene, tmp_path: Path) -> None:
    begun = tmp_path / "begun.exr"
    first = et.render(scene, spp=64, strategy="best,adaptive=none")
    first.save(begun)
    quote, result = resumed_quote(scene, begun, error=0.1)
    assert quote.spp.low <= result.spp <= quote.spp.high
    assert quote.error.low <= result.error.value <= quote.error.high
    quote, result = resumed_quote(scene, begun, time=0.2)
    assert quote.seconds == et.Interval(0.2, 0.2, 0.2)
    assert quote.spp.low > 64.0


def test_the_seconds_quoted_are_those_of_this_run(scene: et.Scene, tmp_path: Path) -> None:
    et.render(scene, spp=256, strategy="best,adaptive=none").save(tmp_path / "begun.exr")
    quote, _ = resumed_quote(scene, tmp_path / "begun.exr", spp=320, time=1e3)
    even = (320 - 256) * quote.law.seconds_per_sample
    assert quote.seconds.value == pytest.approx(from_start(even, quote.law.seconds_lost))


@pytest.mark.parametrize("strategy", ["best,adaptive=none", "best,adaptive=error"])
def test_the_rest_of_a_pass_that_was_cut_short_is_not_timed(
    scene: et.Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, strategy: str
) -> None:
    """Else a pass that was almost over would make samples seem many times faster than they are."""
    monkeypatch.setattr(Processors, "had_since", lambda *_: 1.0)  # the quote's correction for a busy machine
    job = Job(scene=scene.with_(size=(96, 96)), strategy=Strategy.parse(strategy))
    first = Session(job)
    while not first.passes.begun:  # cut between two passes
        first.passes.limits = Limits(seconds=0.2)
        first.passes.run()
    begun = first.result("time")
    begun.save(tmp_path / "begun.exr")
    session = Session(replace(job, resumed=SavedRender.read(tmp_path / "begun.exr")))
    had = session.samples_begun
    assert session.passes.samples < had
    assert had == pytest.approx(begun.spp, rel=0.1)
    watch, seconds, quotes = Pilot(session, Limits(seconds=1.0)), dict[int, float](), list[et.Quote | None]()
    session.passes.limits = Limits(seconds=1e3)
    for samples in islice(session.passes, 2):
        seconds[samples] = session.passes.rendering
        quotes.append(watch.pass_ended())
    assert quotes[0] is None
    assert quotes[1] is not None
    law, ((n, before), (m, after)) = quotes[1].law, seconds.items()
    even = without_start(after, law.seconds_lost) - without_start(before, law.seconds_lost)
    assert law.seconds_per_sample == pytest.approx(even / (m - n), rel=0.05)
    assert quotes[1].spp.value == pytest.approx(had + 1.0 / law.seconds_per_sample, rel=0.1)


def reasons(scene: et.Scene, **options: float) -> list[str]:
    found: list[str] = []
    et.render(scene, observer=et.Observer.of(unquoted=found.append), **options)  # type: ignore[arg-type]
    return found


@pytest.mark.filterwarnings("ignore:the picture is black")
def test_a_render_without_a_quote_says_why(scene: et.Scene) -> None:
    dark = et.load_dict(copy.deepcopy(DARK)).with_(size=(8, 8))
    assert reasons(dark, spp=16, error=0.05) == ["the pilot saw no noise: the image is surely black"]
    assert reasons(scene, spp=4, time=100.0) == ["the render ended before a pilot could tell anything"]
    assert reasons(scene, spp=4) == []
    assert reasons(scene, spp=16, error=0.2) == []


def test_the_reason_is_printed_in_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    output = str(tmp_path / "a.exr")
    assert main(["render", str(SCENE), "-o", output, "--size", "1x1", "--error", "5%", "--time", "200ms"]) == 0
    printed = capsys.readouterr().out.splitlines()
    assert printed[0].startswith("No prediction: the pilot saw no light, or too little")


def test_no_error_is_measured_for_which_no_time_is_left(scene: et.Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    session = Session(Job(scene=scene, strategy=Strategy(), limits=Limits(seconds=0.3)))
    watched = Pilot(session, Limits(seconds=0.3), probes=False)
    measure, measured = session.error, list[float]()

    def slow(*, lasting: bool) -> et.Estimate:
        measured.append(session.passes.seconds)
        time.sleep(0.2)
        return measure(lasting)

    monkeypatch.setattr(session, "error", slow)
    for _ in session.passes:
        watched.pass_ended()
    assert len(measured) == 1


def first_quote(session: Session, watched: Pilot) -> et.Quote:
    return next(quote for quote in (watched.pass_ended() for _ in session.passes) if quote is not None)


@pytest.mark.parametrize("has_time", [True, False])
def test_no_pixels_are_probed_for_which_no_time_is_left(
    scene: et.Scene, monkeypatch: pytest.MonkeyPatch, has_time: bool
) -> None:
    limits, begun = Limits(seconds=100.0, error=0.03), list[int]()
    session = Session(Job(scene=scene, strategy=Strategy(), limits=limits))
    watched, probe = Pilot(session, limits), Probe.of

    def noted(session: Session, samples: int, draws: int) -> Probe:
        begun.append(draws)
        return probe(session, samples, draws)

    monkeypatch.setattr(Probe, "of", noted)
    monkeypatch.setattr(session.passes, "has_time_for", lambda seconds: has_time or seconds == watched._estimating)
    first_quote(session, watched)
    assert bool(begun) is has_time


def test_looks_at_the_error_take_a_part_of_the_seconds(scene: et.Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    """Those that a render to an error will make; one of as many samples makes none."""
    session = Session(Job(scene=scene, strategy=Strategy(), limits=Limits(error=0.05)))
    watched, measure = Pilot(session, Limits(error=0.05), probes=False), session.error

    def slow(*, lasting: bool = False) -> et.Estimate:
        time.sleep(0.1)
        return measure(lasting)

    monkeypatch.setattr(session, "error", slow)
    quote = first_quote(session, watched)
    looks = sum(n <= quote.spp.value for n in quote.law.looks_until(0.05))
    rendering = quote.law.seconds_for(quote.spp).value
    assert quote.seconds.value == pytest.approx(rendering + looks * watched._estimating)
    assert quote.seconds.value > rendering + 0.1


def test_what_there_was_of_the_processors_is_watched_until_the_probe_ends(
    scene: et.Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    """All of them during the pilot, and half of them with the probe: to go on with half takes twice as long."""
    limits, passed, fitted = Limits(error=0.03), [Processors(0.0, 0.0)], list[Law]()
    monkeypatch.setattr(Processors, "now", lambda: passed[-1])
    session = Session(Job(scene=scene, strategy=Strategy(), limits=limits))
    watched, fit, probe = Pilot(session, limits), pilot.fit, Probe.of

    def noted_fit(*data: Any) -> Law:
        fitted.append(fit(*data))
        return fitted[-1]

    def noted_probe(session: Session, samples: int, draws: int) -> Probe:
        passed.append(Processors(2.0, 2.0))
        return probe(session, samples, draws)

    monkeypatch.setattr(pilot, "fit", noted_fit)
    monkeypatch.setattr(Probe, "of", noted_probe)
    passed.append(Processors(1.0, 0.0))
    quote = first_quote(session, watched)
    assert passed[-1].waited == 2.0
    assert quote.law.seconds_per_sample == pytest.approx(2.0 * fitted[-1].seconds_per_sample)
