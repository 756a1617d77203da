"""The note of a verdict on a baseline without roulette."""

from __future__ import annotations

from dataclasses import replace

from equaltime.experiments.analysis.verdict import verdict as answer_of

from .fake_verdict import RATIO, TARGETS, TIME, scene, verdict


def test_a_baseline_without_roulette_is_told_where_paths_hardly_end() -> None:
    """As the only strategy of its kind: beside mis with roulette, a reader sees both."""
    box = scene((TIME, TIME), (RATIO, RATIO))
    naive, best = box.strategies
    mis = replace(naive, label="mine", name="mis")
    plain = replace(box, baseline="mine", strategies=(mis, best))
    told = (
        "mine has no Russian roulette, and paths on box may be longer than 64: they go on until nearly black. Gains "
        "over mine there may come from roulette. mis,roulette=throughput is the fairer baseline."
    )
    for depth in (-1, 65):
        assert told in answer_of([replace(plain, max_depth=depth)], TARGETS).notes
    endless = replace(plain, max_depth=-1)
    assert told in answer_of([replace(endless, max_depth=64, name="lit"), endless], TARGETS).notes
    assert told in answer_of([endless], TARGETS, "samples").notes
    with_roulette = replace(naive, label="other", name="mis,roulette=throughput")
    for other in (
        replace(plain, max_depth=64),
        replace(box, max_depth=-1),
        replace(endless, strategies=(*endless.strategies, with_roulette)),
        replace(endless, strategies=(replace(mis, renderer="mitsuba"), best)),
        replace(endless, strategies=(mis, replace(best, name="best,roulette=none"))),
    ):
        assert "roulette" not in verdict([other], TARGETS)
