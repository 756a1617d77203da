"""Computation of a `Summary` from the records of an experiment; `conclude` also writes the report.

The inputs are the rows of the records, the images that the rows name, the references, and the origin of the records.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from equaltime.errors import ExperimentError, Problem
from equaltime.experiments import report
from equaltime.experiments.analysis.beside import beside
from equaltime.experiments.analysis.disagreement import withheld
from equaltime.experiments.analysis.questions import NO_RARE_PATHS
from equaltime.experiments.analysis.sentences import listed
from equaltime.experiments.analysis.strategy_runs import StrategyRuns, efficiency, fewer_samples, speed_up
from equaltime.experiments.analysis.verdict import headline_target, pick_standard, verdict
from equaltime.experiments.model.experiment import LEAST_CROP, Experiment, Window
from equaltime.experiments.model.summary import BUSY, REFERENCE_SHARE, Curve, SceneResult, StrategyResult, Summary
from equaltime.experiments.report.telling import is_quick
from equaltime.experiments.run.folder import OWN_DEPTHS, ExperimentFolder
from equaltime.experiments.run.record import Row, complete, load
from equaltime.experiments.run.reference import TOLERANCE
from equaltime.experiments.run.reference import read as read_reference
from equaltime.images.bias_variance import BiasVariance, relmse_of_parts
from equaltime.images.metrics import Reference
from equaltime.statistics.agreement import LEVEL, equality_test, near_normal, share
from equaltime.statistics.curves import error_at, error_curve, least_error_at, second_curve, slope, time_to_error
from equaltime.statistics.in_words import probability
from equaltime.statistics.intervals import FEWEST_REPEATS, UNKNOWN, Interval, signed_root, sound, sound_below
from equaltime.statistics.runs import Runs
from equaltime.words import duration, percent, rough_duration

__all__ = ["conclude", "concluded", "summarise"]

Floats = NDArray[np.float64]

_LATE = 1.1
"""Times the budget from which a first image is told to be late; runs aim at the budget with about this accuracy."""
_SHORTEST_RUN = 0.1
"""Least seconds of a run whose share of its processors is judged: threads take milliseconds to start."""
_BELOW_ZERO = "its square is below 0 by more than its interval: rare bright paths make the errors"
"""Reason why the interval of a bias is not valid; no square is below 0."""
_DECLARED = f"told despite the heavy tail: {NO_RARE_PATHS}"
_HEAVY_REFERENCE = "the reference has a heavy tail: one pixel makes much of its error"
_NO_COMMON_COUNT = "its repeats have no sample count in common, so that they cannot be joined"


def conclude(
    experiment: Experiment, folder: Path, command: str = "", told: Callable[[float], object] = lambda share: None
) -> Summary:
    """Summarise the records in ``folder``, write the report to the same folder, and return the summary.

    Parameters
    ----------
    command
        Command line that started the experiment, for the report's provenance.
    told
        Function that is called with the completed share of the work, in [0, 1], first with 0.
    """
    told(0.0)
    summary = concluded(experiment, folder)
    if command:
        summary = replace(summary, provenance={"command": command, **summary.provenance})
    report.write_report(summary, folder, told)
    return summary


def concluded(experiment: Experiment, folder: Path) -> Summary:
    """Return the summary of the records in ``folder``, and compare it with the experiment's published numbers.

    No report is written.
    """
    summary = summarise(experiment, load(ExperimentFolder(folder).records), folder)
    if experiment.theirs is None:
        return summary
    return replace(summary, theirs=experiment.theirs, beside=beside(experiment.theirs, summary))


def summarise(experiment: Experiment, rows: Sequence[Row], folder: Path) -> Summary:
    """Return the summary of an experiment's records (``rows``); unfinished runs are left out.

    Images and references are read from ``folder`` if they exist. Without images or references, the summary lacks three
    checks: bias, equality of expected images, and heavy tails.
    """
    by_scene: dict[str, list[Row]] = defaultdict(list)
    for row in complete(rows):
        by_scene[row.scene].append(row)
    place = ExperimentFolder(folder)
    provenance = place.read_provenance()
    named = [entry.name for entry in experiment.scenes if entry.name in by_scene]
    tests = sum(len({row.strategy for row in by_scene[name]}) - 1 for name in named)
    level = share(LEVEL, max(tests, 1))
    with np.errstate(all="ignore"):  # a black reference makes errors infinite and their results unknown
        scenes = tuple(_Scene(experiment, name, by_scene[name], place, provenance, level).result() for name in named)
    targets = tuple(sorted(experiment.targets, reverse=True))
    runs = len({row.key for rows in by_scene.values() for row in rows})
    shown = {section: found for section, found in provenance.items() if section != OWN_DEPTHS}
    facts = {**shown, "runs": runs, "seeds": {name: _seeds(by_scene[name]) for name in named}}
    answer = verdict(scenes, targets, experiment.question)
    found = Summary(
        experiment.title,
        experiment.description,
        scenes,
        targets,
        facts,
        answer.text,
        experiment.question,
        headline_target=headline_target(scenes, targets, experiment.question),
        verdict_notes=answer.notes,
        directions=_existing(place.directions) if "directions" in experiment.figures else None,
    )
    hasty = () if is_quick(found) else _hasty_references(provenance.get("references", {}), experiment, named)
    busy = _busy([row for name in named for row in by_scene[name]])
    return replace(found, verdict_notes=(*busy, *hasty, *found.verdict_notes))


def _hasty_references(references: Mapping[str, Any], experiment: Experiment, scenes: Sequence[str]) -> tuple[str, ...]:
    """Return a sentence on references whose time ended before the wanted error, if that error matters for targets.

    ``references`` has the facts of each reference by the name of its scene.
    """
    wanted, matters = experiment.reference.error, min(experiment.targets) / REFERENCE_SHARE
    facts = {name: references[name] for name in scenes if "seconds_allowed" in references.get(name, {})}
    errors = {name: one["error"] for name, one in facts.items() if one["error"] > max(TOLERANCE * wanted, matters)}
    if not errors:
        return ()
    each = listed([f"{name} ({percent(error)})" for name, error in errors.items()])
    several = f"The references of {each} have larger errors than the wanted {percent(wanted)}: their"
    name, error = next(iter(errors.items()))
    one = f"The reference of {name} has an error of {percent(error)}, where {percent(wanted)} was wanted: its"
    time = max(facts[scene]["seconds"] * (found / wanted) ** 2 for scene, found in errors.items())
    would_do = f"about {rough_duration(time)} would do"
    if wanted < matters:
        would_do += f", and {rough_duration(time * (wanted / matters) ** 2)} for a third of the smallest target"
    return (
        f"{several if len(errors) > 1 else one} time ended. It widens the intervals of small errors; {would_do} "
        "(reference.seconds of an experiment file).",
    )


@dataclass(frozen=True, eq=False)
class _Scene:
    """Records and settings of one scene."""

    experiment: Experiment
    name: str
    rows: Sequence[Row]
    place: ExperimentFolder
    provenance: Mapping[str, Any]
    level: float

    def result(self) -> SceneResult:
        first = self.rows[0]
        reference = self._reference(None)
        found = [
            StrategyRuns.of(entry.label, rows, self.place.path, self._reference(entry.label) or reference)
            for entry in self.experiment.strategies
            if (rows := tuple(row for row in self.rows if row.strategy == entry.label))
        ]
        strategies = [strategy for strategy in found if strategy.spp]
        if not strategies:
            raise ExperimentError((Problem(str(self.place.records), f"{self.name}: {_NO_COMMON_COUNT}"),))
        differences = {s.label: self._difference(s) for s in strategies if self._agreement_p(s.label) is not None}
        budget = self.experiment.budget or min(float(s.runs.seconds[:, -1].mean()) for s in strategies)
        labels = [s.label for s in strategies]
        errors = [least_error_at(s.runs, budget) for s in strategies]
        baseline = next((s for s in strategies if s.label == self.experiment.baseline), strategies[0])
        standard: str | None = baseline.label
        if self.experiment.question != "bias":
            biased = [s.runs.biased for s in strategies]
            other = [self._agreement_p(label) is not None for label in labels]
            standard = pick_standard(labels, [b or o for b, o in zip(biased, other, strict=True)], errors)
            standard = standard or pick_standard(labels, biased, errors)
        images = next((s.images() for s in strategies if s.label == standard and self._can_be_tested(s)), None)
        own = math.sqrt(max(first.reference_relmse or 0.0, 0.0)) if reference is None else math.sqrt(reference.relmse)
        return SceneResult(
            name=self.name,
            digest=first.digest,
            size=(first.crop[2], first.crop[3]),
            max_depth=first.max_depth,
            reference_error=own,
            baseline=baseline.label,
            standard=standard,
            budget_s=budget,
            strategies=tuple(
                withheld(
                    replace(self._one(s, baseline, standard, images, budget), difference=differences.get(s.label)),
                    None if s is baseline else differences.get(baseline.label),
                )
                for s in strategies
            ),
            reference=self._reference_file(None),
            crops=tuple(window for window in self._crops() if window not in self._small_crops()),
            crops_left_out=_left_out(self._small_crops()),
            scene_max_depth=self.provenance.get(OWN_DEPTHS, {}).get(self.name, {}).get("max_depth"),
            left_out=tuple((strategy.label, _NO_COMMON_COUNT) for strategy in found if not strategy.spp),
            reference_has_heavy_tail=reference is not None and reference.has_heavy_tail,
            reference_caveat=self.provenance.get("references", {}).get(self.name, {}).get("caveat", ""),
        )

    def _crops(self) -> tuple[Window, ...]:
        """Return the windows that the report is to show enlarged: the scene's own, else the experiment's."""
        own = next((entry.crops for entry in self.experiment.scenes if entry.name == self.name), None)
        return self.experiment.crops if own is None else own

    def _small_crops(self) -> tuple[Window, ...]:
        """Return the windows that the scene's own size makes too small to be shown."""
        own = self._crops() if self._crops() is not self.experiment.crops else ()
        return tuple(window for window in own if min(window[2:]) < LEAST_CROP)

    def _can_be_tested(self, strategy: StrategyRuns) -> bool:
        """Tell whether its images may be tested against others: not if rarely found light looks like a bias.

        An experiment with the question "bias" declares that its scenes have no such light.
        """
        return self.experiment.question == "bias" or not strategy.heavy

    def _agreement(self, label: str) -> Mapping[str, Any]:
        """Return the recorded outcome of the test of agreement of another renderer; empty without a test."""
        facts: Mapping[str, Any] = self.provenance.get("agreements", {}).get(self.name, {}).get(label, {})
        return facts

    def _agreement_p(self, label: str) -> float | None:
        """Return the p-value of the test of agreement if another renderer failed it, else None."""
        agreement = self._agreement(label)
        return agreement.get("p", 0.0) if agreement.get("agrees") is False else None

    def _difference(self, strategy: StrategyRuns) -> Interval:
        """Return the relative distance of a strategy's expected image from the scene's reference."""
        images, reference = strategy.images(), self._reference(None)
        if images is None or reference is None or reference.mean.shape != images.shape[1:]:
            return UNKNOWN
        return _bias(relmse_of_parts(images, reference), differs=True)

    def _samples(self, strategy: StrategyRuns) -> Path | None:
        """Return the file with the sample counts of the first repeat's image, if its counts differ between pixels."""
        last = strategy.last
        return _existing(self.place.samples(self.name, strategy.label, last[0].repeat)) if last else None

    def _variances(self, strategy: StrategyRuns) -> tuple[Path, ...]:
        """Return the files with the variances of all repeats; none if a repeat lacks it."""
        files = [self.place.variance(self.name, strategy.label, row.repeat) for row in strategy.last]
        return tuple(files) if all(file.exists() for file in files) else ()

    def _reference_file(self, label: str | None) -> Path | None:
        return _existing(self.place.reference(self.name, label))

    def _reference(self, label: str | None) -> Reference | None:
        path = self._reference_file(label)
        return None if path is None else read_reference(path).reference

    def _one(
        self,
        strategy: StrategyRuns,
        baseline: StrategyRuns,
        standard: str | None,
        standard_images: Floats | None,
        budget: float,
    ) -> StrategyResult:
        runs, parts, equality = strategy.runs, strategy.parts, None
        if standard_images is not None and strategy.label != standard and self._can_be_tested(strategy):
            images = strategy.images()
            careful = self.experiment.question != "bias" and not runs.biased
            equality = None if images is None else _equality(images, standard_images, careful)
        unequal = equality is not None and equality < self.level
        if unequal and self.experiment.question == "bias":  # a biased strategy, whatever it says of itself
            limit = parts.bias2.low if parts is not None and sound_below(parts.bias2) else 0.0
            runs = replace(runs, missing="", biased=True, bias=math.sqrt(max(limit, 0.0)))
            strategy = replace(strategy, runs=runs)
        targets = self.experiment.targets
        same = strategy.label == baseline.label
        first, last = strategy.rows[0], strategy.last
        return StrategyResult(
            label=strategy.label,
            name=first.name,
            renderer=first.renderer,
            biased=first.biased,
            repeats=runs.repeats,
            curve=_curve(strategy, runs),
            time_to={target: time_to_error(runs, target) for target in targets},
            ratio={t: Interval(1.0, 1.0, 1.0) if same else speed_up(baseline.runs, runs, t) for t in targets},
            efficiency=Interval(1.0, 1.0, 1.0) if same else efficiency(baseline.runs, runs),
            error_at_budget=error_at(runs, budget),
            fewer_samples=Interval(1.0, 1.0, 1.0) if same else fewer_samples(baseline, strategy),
            equality_p=equality,
            unequal=unequal,
            agreement_p=self._agreement_p(strategy.label),
            bias=None if parts is None else self._bias_of(parts, unequal or runs.biased, strategy),
            notes=tuple(self._notes(strategy, baseline, standard, equality)),
            image=self.place.path / last[0].image if last and last[0].image else None,
            image_error=_error_of(last[0]) if last else None,
            image_seconds=last[0].wall_s if last else None,
            images=tuple(self.place.path / row.image for row in last if row.image),
            samples=self._samples(strategy),
            variances=self._variances(strategy),
            reference=self._reference_file(strategy.label),
            decided=tuple(row.decided for row in last if row.decided),
            splitting=tuple(row.splitting for row in last if row.splitting is not None),
            run_seconds=tuple(row.wall_s for row in last),
            tail_share=strategy.tail_share,
            first_share=_share_of_processors(last[0]) if last else None,
            late=self._late(strategy),
            film=_existing(self.place.film(self.name, strategy.label)) if self.experiment.animate else None,
        )

    def _bias_of(self, parts: BiasVariance, differs: bool, strategy: StrategyRuns) -> Interval:
        """Return the bias of a strategy; it is not trusted where rare bright paths make the spread over repeats.

        ``differs`` tells whether the strategy is known to converge to another picture. An experiment with the question
        "bias" declares that its scenes have no such paths.
        """
        bias, reference = _bias(parts, differs), self._reference(None)
        if not (bias.known and bias.trusted):
            return bias
        if self.experiment.question == "bias":
            return bias.noted(_DECLARED) if strategy.heavy else bias
        if strategy.heavy:
            return bias.doubted(strategy.runs.doubt)
        if not differs and bias.high < 0.0:
            return bias.doubted(_BELOW_ZERO)
        return bias.doubted(_HEAVY_REFERENCE) if reference is not None and reference.has_heavy_tail else bias

    def _late(self, strategy: StrategyRuns) -> float | None:
        """Return the mean time of a strategy's first image in seconds if it clearly exceeds the budget; else None."""
        first, budget = float(strategy.runs.seconds[:, 0].mean()), self.experiment.budget
        return first if budget is not None and first > _LATE * budget else None

    def _notes(
        self, strategy: StrategyRuns, baseline: StrategyRuns, standard: str | None, equality: float | None
    ) -> list[str]:
        notes, runs = [], strategy.runs
        if runs.repeats > 1 and strategy.apart_from(baseline):
            notes.append(f"measured apart from {baseline.label}, not in turns: ratios may show a change of the machine")
        if runs.biased:
            notes.append(_bias_note(strategy))
        if note := self._agreement(strategy.label).get("note"):
            notes.append(note)
        if runs.repeats < FEWEST_REPEATS:
            notes.append(f"too few repeats for intervals: {runs.repeats}, and {FEWEST_REPEATS} are needed")
        notes += [reason for reason in (runs.tail, runs.missing) if reason]
        if not np.isfinite(runs.relmse).all():
            notes.append("some of its images have pixels that are not finite, and cannot be measured")
        if equality is not None and equality < self.level:
            notes.append(f"its picture differs from the picture of {standard} ({probability(equality)})")
        if late := self._late(strategy):
            budget = duration(self.experiment.budget or 0.0)
            notes.append(f"its first image took {duration(late)}, longer than the budget: no image after {budget}")
        return notes


def _busy(rows: Sequence[Row]) -> tuple[str, ...]:
    """Return a sentence if runs had too small a share of their processors, by CPU time over wall time times threads.

    Only equaltime's own strategies are judged, since other renderers may have fewer threads than they are given.
    """
    shares = [one for row in rows if row.last and (one := _share_of_processors(row)) is not None]
    if not shares or (share := float(np.median(shares))) >= BUSY:
        return ()
    return (
        f"The machine was busy: runs had {100.0 * share:.0f} % of their processors, in the median. Times are too long "
        "and uncertain. Ratios are fairer, since runs take turns.",
    )


def _share_of_processors(row: Row) -> float | None:
    """Return processor time over wall time times threads; None for another renderer, or a run that is too short."""
    if row.renderer != "core" or row.wall_s < _SHORTEST_RUN or row.threads == 0:
        return None
    return row.cpu_s / (row.wall_s * row.threads)


def _left_out(windows: Sequence[Window]) -> str:
    """Return a sentence on windows that are too small to be shown; empty without any."""
    if not windows:
        return ""
    told = ", ".join(f"{w}x{h} at {x}, {y}" for x, y, w, h in windows)
    return f"Not shown enlarged, since a side has fewer than {LEAST_CROP} pixels at this size: {told}."


def _bias_note(strategy: StrategyRuns) -> str:
    """Return the warning about a strategy that is biased, with the size of its bias if known."""
    first = strategy.rows[0]
    declared = "cuts paths" if "truncate=" in first.name else "biased by its settings"
    why = declared if first.biased else "found to be biased"
    bias = UNKNOWN if strategy.parts is None else strategy.parts.bias2.map(signed_root)
    if not sound(bias):
        return f"{why}, so its picture may stay different"
    return f"{why}, so its picture stays different ({percent(float(f'{bias.value:.2g}'))} off)"


def _bias(parts: BiasVariance, differs: bool) -> Interval:
    """Return the bias of a strategy; ``differs`` tells whether it is known to converge to another picture.

    If it is not, an offset that all its images share may as well be the reference's: no bias is then told from 0. If it
    is, a bias that includes 0 is an upper limit.
    """
    bias = parts.bias2.map(signed_root)
    if not (bias.known and bias.trusted):
        return bias
    if differs:
        return bias if bias.low > 0.0 else bias.bounded("high", "the picture differs, and by no more than this")
    return replace(bias, low=min(bias.low, 0.0))


def _error_of(row: Row) -> float | None:
    """Return the realised error of one run; None if it is not finite."""
    return None if row.relmse is None or not math.isfinite(row.relmse) else signed_root(row.relmse)


def _existing(path: Path) -> Path | None:
    return path if path.exists() else None


def _seeds(rows: Sequence[Row]) -> dict[str, list[int]]:
    """Return the seeds of each strategy's repeats, in order."""
    seeds: dict[str, dict[int, int]] = defaultdict(dict)
    for row in rows:
        seeds[row.strategy][row.repeat] = row.seed
    return {label: [found[repeat] for repeat in sorted(found)] for label, found in seeds.items()}


def _curve(strategy: StrategyRuns, runs: Runs) -> Curve:
    own = tuple(_own([row for row in strategy.rows if row.spp == spp]) for spp in strategy.spp)
    return Curve(strategy.spp, second_curve(runs), error_curve(runs), slope(runs), own)


def _own(rows: Sequence[Row]) -> Interval:
    """Return the root mean square of the renders' own error estimates, and likewise of their limits.

    Realised errors are joined in the same way. If one render doubts its upper limit, the joined limit is doubted too.
    """
    said = [(row.estimate, row.estimate_low, row.estimate_high) for row in rows]
    known = [one for one in said if one[0] is not None and math.isfinite(one[0])]
    if not known or len(known) < len(said):
        return replace(UNKNOWN, note="not every render stated its error")
    value, low, high = (
        math.sqrt(float(np.mean([math.inf if x is None else x * x for x in column])))
        for column in zip(*known, strict=True)
    )
    doubts = [row.doubt for row in rows if row.doubt]
    joined = Interval(value, low, high)
    return joined.bounded("low", f"{len(doubts)} of {len(rows)} renders: {doubts[0]}") if doubts else joined


def _equality(images: Floats, others: Floats, careful: bool) -> float | None:
    """Return the p-value of equal expectations, from blocks of at most a quarter of the image's shorter side.

    If ``careful``, blocks grow until their means are nearly normal; None if even the largest are not.
    """
    if min(len(images), len(others)) < FEWEST_REPEATS or images.shape[1:] != others.shape[1:]:
        return None
    largest = max(1, min(images.shape[1:3]) // 4)
    blocks = [min(8, largest)]
    while careful and not near_normal(images, others, blocks[-1]):
        if blocks[-1] == largest:
            return None
        blocks.append(min(2 * blocks[-1], largest))
    return equality_test(images, others, blocks[-1])
