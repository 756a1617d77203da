"""The verdict of an experiment: a plain sentence that answers its question, and notes on what limits the answer.

The verdict takes only numbers whose intervals can be trusted. `analysis.questions` and `analysis.combination` have the
questions other than time.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace

from equaltime.experiments.analysis.combination import combination_verdict
from equaltime.experiments.analysis.fairness import baselines_without_roulette
from equaltime.experiments.analysis.pictures import biased_leaders, other_pictures
from equaltime.experiments.analysis.questions import bias_verdict, efficiency_verdict, samples_verdict
from equaltime.experiments.analysis.sentences import (
    WHAT_TO_DO,
    Answer,
    across,
    compared,
    joined,
    listed,
    where,
)
from equaltime.experiments.analysis.typical_runs import (
    Found,
    beside_nearest_rival,
    elsewhere,
    grows,
    standards,
    typical_ends,
    typical_gain,
)
from equaltime.experiments.analysis.winners import best_per_scene, fastest, is_own, quotient
from equaltime.experiments.model.experiment import Question
from equaltime.experiments.model.summary import REFERENCE_SHARE, SceneResult, StrategyResult
from equaltime.film.tails import MOST_SHARE
from equaltime.statistics.agreement import LEVEL
from equaltime.statistics.curves import BEFORE, BETTER
from equaltime.statistics.in_words import about, figure, in_time, read_off, span
from equaltime.statistics.intervals import UNKNOWN, Interval, product_mean, sound, sound_below
from equaltime.statistics.runs import MISSING, TYPICAL, of_one_kind
from equaltime.words import percent, rough_duration

__all__ = ["headline_target", "pick_standard", "verdict"]


def pick_standard(labels: Sequence[str], biased: Sequence[bool], errors: Sequence[float]) -> str | None:
    """Return the label of the standard strategy, against which other strategies are tested for bias.

    The standard is ``best`` if it is unbiased, else the unbiased strategy with the smallest of ``errors``. Returns None
    if all strategies are biased.
    """
    unbiased = [(e, label) for label, b, e in zip(labels, biased, errors, strict=True) if not b]
    if any(label == "best" for _, label in unbiased):
        return "best"
    return min(unbiased, key=lambda one: one[0] if math.isfinite(one[0]) else math.inf)[1] if unbiased else None


def verdict(scenes: Sequence[SceneResult], targets: Sequence[float], question: Question = "time") -> Answer:
    """Return the answer to an experiment's question in a line or two, and notes on what limits it.

    The last notes name strategies and renderers that converge to another picture although they do not declare
    themselves biased, and how far off these pictures are.

    For the question ``time`` the answer has two numbers: the speed-up of the standard strategy (usually ``best``) over
    the baseline, and its time to an error. Both numbers are for one target error at which their intervals are trusted,
    on all scenes if possible. Numbers that need no extrapolation are preferred, then numbers for which only the
    baseline is extrapolated. Within the runs the smallest target is taken, beyond them the one by `_farness`. Without a
    trusted speed-up on any scene, the answer is the efficiency of typical runs. The last choice is a speed-up of which
    only the lower limit is known, for example because the baseline does not reach the error. The scenes that the answer
    leaves out have a sentence, and a note has their limits: limits cannot be compared.
    """
    if question == "bias":
        found = bias_verdict(scenes, LEVEL)
    elif question == "samples":
        found = samples_verdict(scenes)
    elif question == "combination":
        found = combination_verdict(scenes)
    elif question == "efficiency":
        found = efficiency_verdict(scenes).then(best_per_scene(scenes))
    else:
        found, _ = _answer_in_time(scenes, targets)
    different = () if question == "bias" else other_pictures(scenes)
    unfair = "" if question == "bias" else baselines_without_roulette(scenes)
    found = replace(found, notes=()).noted([_doubted_references(scenes), unfair, *found.notes])
    return found.noted([*different, biased_leaders(scenes)])


def _doubted_references(scenes: Sequence[SceneResult]) -> str:
    """Return sentences on references whose own error has a heavy tail; empty without any."""
    doubted = [scene for scene in scenes if scene.reference_has_heavy_tail]
    if not doubted:
        return ""
    named = listed([f"{scene.name} (stated error {percent(scene.reference_error)})" for scene in doubted])
    several = len(doubted) > 1
    subject, verb = ("references", "have heavy tails") if several else ("reference", "has a heavy tail")
    return (
        f"The {subject} of {named} {verb} too: one pixel makes much of the stated error, and light may be missing. "
        f"Errors of strategies that are not much larger may be too small or too large; {BETTER}."
    )


def headline_target(scenes: Sequence[SceneResult], targets: Sequence[float], question: Question) -> float | None:
    """Return the error whose time the verdict gives; None if it gives none or answers another question than time."""
    return _answer_in_time(scenes, targets)[1] if question == "time" else None


def _answer_in_time(scenes: Sequence[SceneResult], targets: Sequence[float]) -> tuple[Answer, float | None]:
    """Return the answer to the question ``time``, and the error whose time it gives (None if it gives none)."""
    tests: list[tuple[bool, _Test]] = [(True, sound), (False, sound)]
    if not typical_gain(scenes):  # a measured number says more than a limit
        tests += [(True, _is_limit), (False, _is_limit)]
    for everywhere, ratio_is_good in tests:
        for reach in _REACHES:
            known = {
                target: found
                for target in sorted(targets)
                if (found := [one for scene in scenes if (one := _at(scene, target, reach, ratio_is_good)) is not None])
                and (len(found) == len(scenes) or not everywhere)
            }
            if known:
                target = min(known, key=lambda one: _farness(one, known[one], ratios=True))
                found = known[target]
                others = [one for one in scenes if one not in [named for named, _ in found]]
                answer = _speed_ups(found, target, len(scenes)).then(elsewhere(others, target))
                answer = answer.noted([_limits(others, target)]).then(fastest(scenes, target))
                return _with_own(answer, scenes, target), target
    alone = _time_alone(scenes, targets)
    if alone is None:
        return _without_ratio(scenes, alone).noted([_next_step(scenes, targets)]), None
    limits = _limits(scenes, alone[2]) if len(scenes) > 1 else ""
    answer = _without_ratio(scenes, alone).noted([limits]).then(fastest(scenes, alone[2]))
    return _with_own(answer, scenes, alone[2]), alone[2]


def _farness(target: float, found: Sequence[Found], ratios: bool) -> tuple[bool, bool, int, float]:
    """Return how far outside the runs the times to ``target`` on the scenes ``found`` are; the smallest is the best.

    ``ratios`` tells that speed-ups count too. Targets within the runs are equal. Of the others, those for which the
    references are good enough come first, then those that are known on most scenes, then the nearest to the runs.
    """
    numbers = [one.time_to[target] for _, one in found] + ratios * [one.ratio[target] for _, one in found]
    reach = max(number.reach for number in numbers)
    if reach == 1.0:
        return False, False, 0, reach
    noisy = any(REFERENCE_SHARE * scene.reference_error > target for scene, _ in found)
    return True, noisy, -len(found), reach


def _is_limit(ratio: Interval) -> bool:
    """Tell whether a speed-up has a lower limit; it is infinite if the baseline does not reach the error."""
    return sound_below(_limited(ratio))


def _limited(ratio: Interval) -> Interval:
    """Return a speed-up over a baseline that does not reach the error as its lower limit; others are unchanged."""
    if not math.isinf(ratio.value):
        return ratio
    return replace(ratio, value=ratio.low).bounded("low", "the baseline does not reach the error")


_Test = Callable[[Interval], bool]

_REACHES: tuple[Callable[[Interval, Interval], bool], ...] = (
    lambda time, ratio: time.reach == ratio.reach == 1.0,
    lambda time, ratio: time.reach == 1.0,
    lambda time, ratio: True,
)
"""Tests of how far time and ratio are extrapolated, in order of preference: neither, only the ratio, any."""
_MOST_OWN = 3
"""Largest number of methods of one's own that the verdict names; tables show more of them better."""


def _at(scene: SceneResult, target: float, reach: Callable[[Interval, Interval], bool], good: _Test) -> Found | None:
    for _, strategy in standards((scene,)):
        if strategy.label != scene.baseline:
            time, ratio = strategy.time_to.get(target), strategy.ratio.get(target)
            if time is not None and ratio is not None and sound(time) and good(ratio) and reach(time, ratio):
                return scene, strategy
    return None


def _speed_ups(found: Sequence[Found], target: float, count: int) -> Answer:
    """Return a sentence for each kind of speed-up: of mean errors, and of typical runs. The two have no common mean.

    Speed-ups and times to ``target`` are known on the scenes ``found`` of ``count`` scenes.
    """
    kinds = [[one for one in found if _is_typical(one, target) is kind] for kind in (False, True)]
    apart = all(kinds) and len(found) == count
    first, *others = (
        _speed_up(kind, target, 1 if apart and len(kind) == 1 else count, count > 1) for kind in kinds if kind
    )
    for other in others:  # both are the answer, whatever its length
        first = Answer(f"{first.text} {other.text}", (*first.notes, *other.notes))
    return first


def _is_typical(found: Found, target: float) -> bool:
    """Tell whether a speed-up or its time to ``target`` is of typical runs."""
    return any(TYPICAL in number[target].note for number in (found[1].ratio, found[1].time_to))


def _speed_up(found: Sequence[Found], target: float, count: int, several: bool) -> Answer:
    """Return the sentence on speed-up and time to ``target``, on the scenes ``found`` of ``count`` scenes.

    ``several`` tells that the experiment has several scenes, so that a single one is named.
    """
    times = [strategy.time_to[target] for _, strategy in found]
    ratios = [_limited(strategy.ratio[target]) for _, strategy in found]
    label, baseline = joined(strategy.label for _, strategy in found), joined(scene.baseline for scene, _ in found)
    faster = compared(label, product_mean(ratios), baseline) + _why_a_limit(found, target)
    each = [(scene.name, strategy.time_to[target]) for scene, strategy in found]
    many = len(found) > 1
    on = f" on {found[0][0].name}" if several and not many else ""
    farthest, widest = (max(numbers, key=lambda number: number.reach) for numbers in (times, ratios))
    notes = [_extrapolated(farthest, target, many, on), _rare((*times, *ratios))]
    limits = ", in typical runs" if notes[1] else ""
    beyond = [scene.name for scene, strategy in found if strategy.time_to[target].reach > 1.0]
    if beyond:
        limits += ", extrapolated" + f" on {listed(beyond)}" * (len(beyond) < len(found))
    if widest.reach > farthest.reach:
        notes.insert(1, f"The time of {baseline}{on} is extrapolated: it is {_outside(widest, many, 'its')}.")
        limits += "" if beyond else f", with the time of {baseline} extrapolated"
    if against := _against_the_mean(found, target):
        limits += f"; over all runs, {listed(against)}"
        notes += ["Rare bright paths make the error over all runs.", _out_of_the_tail([scene for scene, _ in found])]
    place = where([scene.name for scene, _ in found], count)
    return Answer(f"{place}, {faster}: {percent(target)} error in {across(each, in_time)}{limits}.").noted(notes)


def _against_the_mean(found: Sequence[Found], target: float) -> list[str]:
    """Return clauses on scenes where errors at equal time contradict a speed-up of typical runs."""
    told = []
    for scene, strategy in found:
        errors = {one.label: one.error_at_budget for one in scene.strategies}
        error, baseline = errors[strategy.label], errors.get(scene.baseline, UNKNOWN)
        ratio = error.value / baseline.value if baseline.value > 0.0 else math.nan
        known = _is_typical((scene, strategy), target) and 0.0 < ratio < math.inf
        if known and (ratio > 1.0) == (strategy.ratio[target].value > 1.0):
            on = f" on {scene.name}" if len(found) > 1 else ""
            size = f"{figure(ratio)} times larger" if ratio > 1.0 else f"{figure(1.0 / ratio)} times smaller"
            told.append(f"the {read_off(error, baseline)} error at equal time{on} is {size}")
    return told


def _why_a_limit(found: Sequence[Found], target: float) -> str:
    """Return in brackets why speed-ups to ``target`` are limits: by the baseline's time; empty if that is known."""
    for scene, strategy in found:
        ratio = strategy.ratio[target]
        if math.isinf(ratio.value):
            baseline = next(one for one in scene.strategies if one.label == scene.baseline)
            return f" ({baseline.time_to[target].note.partition('; ')[0] or 'not reached'})"
        if not ratio.trusted and MISSING in ratio.note:
            return f" (samples of {scene.baseline} may have met too little light)"
    return ""


def _limits(scenes: Sequence[SceneResult], target: float) -> str:
    """Return sentences on scenes where only a lower limit of the standard's speed-up is known; empty without any."""
    found = [
        one
        for scene in scenes
        if (one := _at(scene, target, _REACHES[-1], lambda ratio: _is_limit(ratio) and not sound(ratio)))
    ]
    if not found:
        return ""
    limits = [f"{figure(strategy.ratio[target].low)} times on {scene.name}" for scene, strategy in found]
    baseline = joined(scene.baseline for scene, _ in found)
    return (
        f"To {percent(target)} error, only a limit of the speed-up over {baseline} is known: at least "
        f"{listed(limits)}. A larger limit does not show a larger gain."
    )


def _with_own(answer: Answer, scenes: Sequence[SceneResult], target: float) -> Answer:
    """Return the answer with a sentence on each method of one's own, as far as there is room; notes have the rest."""
    for sentence in _own_methods(scenes, target):
        answer = answer.then(sentence)
    return answer


def _own_methods(scenes: Sequence[SceneResult], target: float) -> Iterator[str]:
    """Yield a sentence on the time of each method of one's own beside baseline and standard, if known on all scenes.

    On several scenes it is the geometric mean, beside the standard alone, since the answer has less room. Times of
    typical runs and times of mean errors have no common mean.
    """
    own = {one.label: one.named for scene in scenes for one in scene.strategies if is_own(scene, one)}
    average = " on average" if len(scenes) > 1 else ""
    baselines, standards = tuple(scene.baseline for scene in scenes), tuple(scene.standard for scene in scenes)
    sides = [standards] if len(scenes) > 1 else list(dict.fromkeys((baselines, standards)))
    for label, named in own.items() if len(own) <= _MOST_OWN else ():
        told = []
        for others in sides:
            ratios = [_beside(scene, label, other, target) for scene, other in zip(scenes, others, strict=True)]
            known = [ratio for ratio in ratios if ratio is not None]
            if len(known) == len(scenes) and of_one_kind(known):
                told.append(_as_long(product_mean(known), joined(map(str, others))))
        times = [one.time_to[target] for scene in scenes for one in scene.strategies if one.label == label]
        typical = ", in typical runs" if any(TYPICAL in time.note for time in times) else ""
        if told:
            yield f"{named} needs {' and '.join(told)} for {percent(target)}{average}{typical}."


def _as_long(ratio: Interval, other: str) -> str:
    """Return in words how long a method needs beside another; ``ratio`` is its time over the other's."""
    if ratio.high < 1.0:
        inverse = ratio.map(lambda value: 1.0 / value)
        return f"{about(inverse)} times less time than {other} {span(inverse)}"
    if ratio.low <= 1.0:
        return f"about as long as {other} (factor {about(ratio)}; {span(ratio)[1:]}"
    return f"{about(ratio)} times as long as {other} {span(ratio)}"


def _beside(scene: SceneResult, label: str, other: str | None, target: float) -> Interval | None:
    """Return the time of one strategy to ``target`` over that of another, by their labels; None if it is not known."""
    found = {one.label: one for one in scene.strategies}
    one, theirs = found.get(label), found.get(other or "")
    return None if one is None or theirs is None or one is theirs else _times_as_long(scene, one, theirs, target)


def _times_as_long(
    scene: SceneResult, strategy: StrategyResult, other: StrategyResult, target: float
) -> Interval | None:
    """Return a strategy's time to ``target`` over another's; None if it is not known.

    Beside the baseline it is the inverse of the speed-up that tables show, which compares paired repeats. Times of
    typical runs are not compared with times of the mean error.
    """
    ratio = strategy.ratio.get(target)
    if other.label == scene.baseline and ratio is not None and sound(ratio):
        return ratio.map(lambda speed_up: 1.0 / speed_up)
    time, theirs = strategy.time_to[target], other.time_to[target]
    typical = TYPICAL in time.note
    found = quotient(time, theirs) if typical == (TYPICAL in theirs.note) else None
    return None if found is None else found.noted(TYPICAL * typical)


def _without_ratio(scenes: Sequence[SceneResult], alone: tuple[SceneResult, StrategyResult, float] | None) -> Answer:
    """Return a line with the efficiency of typical runs and a trusted time, or that both are missing.

    ``alone`` is the result of `_time_alone`: the first trusted time. The notes have the reasons.
    """
    typical = typical_gain(scenes)
    if alone is None:
        lacking = f"No time{_of_standards(scenes)} to a given error can be trusted{_reason(scenes)}."
        return Answer(typical).noted([typical_ends(scenes), lacking]) if typical else Answer(lacking)
    scene, strategy, target = alone
    time = strategy.time_to[target]
    notes = [_extrapolated(time, target), _rare((time,))]
    limits = (", in typical runs" if notes[1] else "") + (", extrapolated" if notes[0] else "")
    reached = f"{strategy.label} reaches {percent(target)} error in {in_time(time)}{limits}."
    answer = f"On {scene.name}, {reached}"
    if typical:
        return Answer.of((typical, answer), [typical_ends(scenes), grows(scenes), *notes])
    if strategy.label == scene.baseline:
        if len(scene.strategies) == 1:
            return Answer(answer).noted(notes)
        beside = beside_nearest_rival(scene) or "It is the baseline of the comparison."
        return Answer(f"{answer} {beside}").noted(notes)
    why = next((s.notes for s in scene.strategies if s.label == scene.baseline), ()) or (strategy.ratio[target].note,)
    notes.append(f"Speed-up over {scene.baseline}: {why[0]}." if why[0] else "")
    return Answer(f"{answer} How much faster it is than {scene.baseline} cannot be told.").noted(notes)


def _next_step(scenes: Sequence[SceneResult], targets: Sequence[float]) -> str:
    """Return a sentence on the runs that would give a time to an error, by the standards' errors at equal time.

    The budget is told for the largest target on the scene that needs the shortest runs. Errors are taken to fall as
    1/sqrt(time), and a lower limit of an error gives a lower limit of the budget. The text is empty if the reason
    already tells what to do.
    """
    if BETTER in _reason(scenes):
        return ""
    if rare := _out_of_the_tail(scenes):
        return rare
    largest = max(targets)
    found: list[tuple[float, SceneResult, bool]] = []
    for scene, strategy in standards(scenes):
        error = strategy.error_at_budget
        known = error.low if error.bound == "low" else error.value
        if known > 0.0 and math.isfinite(known):
            found.append((scene.budget_s * (known / largest) ** 2, scene, error.bound == "low"))
    longer = [one for one in found if one[0] > one[1].budget_s]
    if not longer or len(longer) < len(found):
        return f"{WHAT_TO_DO}: longer runs (--budget), or more of them (--repeats)."
    seconds, scene, is_limit = min(longer, key=lambda one: one[0])
    least = "at least" if is_limit else "about"
    on = f" on {scene.name}" if len(scenes) > 1 else ""
    runs = f"runs of {least} {rough_duration(seconds)} (--budget)"
    return f"{WHAT_TO_DO}: {runs} would reach {percent(largest)}{on}, if errors go on to fall as 1/sqrt(time)."


def _out_of_the_tail(scenes: Sequence[SceneResult]) -> str:
    """Return a sentence on the samples with which one rare event would make little of an error; empty without tails.

    The share of one event falls with the number of such events, and so with the samples of all runs together.
    """
    tails = [
        (one.tail_share, scene)
        for scene in scenes
        for one in scene.strategies
        if one.label in (scene.standard, scene.baseline) and one.tail_share > 0.0
    ]
    if not tails:
        return ""
    share, scene = max(tails, key=lambda one: one[0])
    more = float(f"{share / MOST_SHARE:.2g}")
    on = f" on {scene.name}" if len(scenes) > 1 else ""
    return (
        f"{WHAT_TO_DO}{on}: about {figure(more)} times as many samples in all, such as runs of "
        f"{rough_duration(more * scene.budget_s)} (--budget). An event like the brightest so far then makes "
        f"{percent(MOST_SHARE)} of the squared error, the most that is trusted; brighter ones may come."
    )


def _outside(number: Interval, several: bool, whose: str) -> str:
    """Return how an extrapolated time compares with the longest run, or with the first measurement if it is before it.

    ``number`` is the time, or the ratio of the baseline's time to another one. ``several`` tells that it is the
    farthest of some times. ``whose`` is the word before the run: ``the`` or ``its``.
    """
    most = "up to " * several
    if BEFORE in number.note.partition("this: ")[0]:
        return f"{most}{figure(number.reach)} times shorter than the time of {whose} first measurement"
    how = "a little longer than" if number.reach < 1.05 else f"{most}{figure(number.reach)} times"
    return f"{how} {whose} longest run"


def _extrapolated(time: Interval, target: float, several: bool = False, on: str = "") -> str:
    """Return a sentence on how far a time is outside the runs; empty if it is within them.

    ``target`` is the error that it is a time to. ``several`` tells that the time is the farthest of several scenes, and
    ``on`` names the scene if it is one of several.
    """
    if time.reach <= 1.0:
        return ""
    what, verb = ("times", "are") if several else ("the time", "is")
    return f"Extrapolated: {what} to {percent(target)}{on} {verb} {_outside(time, several, 'the')}."


def _rare(intervals: Iterable[Interval]) -> str:
    """Return a sentence if intervals describe medians of repeats instead of means; else an empty text."""
    typical = any(TYPICAL in interval.note for interval in intervals)
    return "The verdict holds for typical runs: a few rare events make most of the error." if typical else ""


def _time_alone(
    scenes: Sequence[SceneResult], targets: Sequence[float]
) -> tuple[SceneResult, StrategyResult, float] | None:
    """Return a scene, its standard strategy, and the target whose trusted time is the best (`_farness`)."""
    known = [
        (scene, strategy, target)
        for target in sorted(targets)
        for scene, strategy in standards(scenes)
        if sound(strategy.time_to[target])
    ]
    return min(known, key=lambda one: _farness(one[2], [one[:2]], ratios=False), default=None)


def _of_standards(scenes: Sequence[SceneResult]) -> str:
    """Return the phrase `` of best`` if times of other strategies than the standard are known; else an empty text."""
    times = (time for scene in scenes for strategy in scene.strategies for time in strategy.time_to.values())
    return f" of {joined(strategy.label for _, strategy in standards(scenes))}" if any(map(sound, times)) else ""


def _reason(scenes: Sequence[SceneResult]) -> str:
    notes = (n.note for _, strategy in standards(scenes) for n in strategy.time_to.values() if not n.trusted)
    first = next((note for note in notes if note), "")
    clauses = first.split("; ")
    telling = next((clause for clause in clauses if clause.startswith("heavy tail")), first)
    return f": {telling}" if telling else ""
