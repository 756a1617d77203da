"""Results of an experiment: the only input of reports, figures and verdicts.

`analysis.summarise` computes the results from records. Errors are relative (0.02 is 2 %, see
`equaltime.images.metrics`). Times are seconds of wall clock from a run's first sample. Every estimated number is an
`Interval`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING, Any

from equaltime.experiments.model.experiment import Quantity, Question, Theirs
from equaltime.extras import optional
from equaltime.rendering.stated import other_depth
from equaltime.statistics.in_words import figure, in_time
from equaltime.statistics.intervals import UNKNOWN, Interval, sound
from equaltime.words import Shown, duration, percent

if TYPE_CHECKING:
    import pandas

__all__ = ["BUSY", "DISAGREES", "REFERENCE_SHARE", "Beside", "Curve", "SceneResult", "StrategyResult", "Summary"]

DISAGREES = "disagrees with the reference"
"""Words in the note of a number that a renderer does not get, because its picture is another one."""

BUSY = 0.8
"""Share of its processors below which a run shows that other programs took part of them. It is 0.98 to 0.99 on a
machine that does nothing else (medians of ten experiments, two processors)."""
_SHORTEST_CURVE = 0.1
"""Least equal time, in seconds, for curves against time. Curves begin at about a hundredth of it, and threads
take about a millisecond to start."""
_APART = 0.05
"""Share of the equal time by which the median end of a strategy's runs differs from it before a reader is told. Runs
aim at their budget with a few per cent."""
REFERENCE_SHARE = 3.0
"""Factor by which a target should exceed a reference's error, whose noise is then a ninth of the square."""
_WITHIN = "it is the smallest target whose times can be trusted; times within the runs come before extrapolated ones"
_BEYOND = (
    "no target is reached within the runs. It is the nearest to them of those that are known on most scenes; targets "
    "below three times the reference's error come last"
)
"""Rules by which the verdict chooses among an experiment's target errors: within the runs, and beyond them."""


@dataclass(frozen=True)
class Curve:
    """Error of a strategy on one scene as a function of time.

    Each tuple has one entry per checkpoint (moment at which the error is measured), in order of time.
    """

    spp: tuple[int, ...]
    """Samples per pixel."""
    seconds: tuple[Interval, ...]
    """Wall time since the first sample, without the time spent on measuring errors."""
    error: tuple[Interval, ...]
    """Measured relative error against the reference: root mean square over repeats, with the reference's noise
    subtracted.

    Every number in reports that is called a strategy's error is a point of this curve.
    """
    slope: Interval
    """Slope of log error against log time: -0.5 for independent samples. It is against log samples for
    other renderers than equaltime; its note then begins with `equaltime.statistics.curves.AGAINST_SAMPLES`."""
    own_estimate: tuple[Interval, ...]
    """Errors that the renders themselves state, without a reference; the value is NaN if the renderer states none."""


@dataclass(frozen=True)
class StrategyResult:
    """Results of one strategy on one scene, from all its repeats: error curve, times, ratios to the baseline, tests."""

    label: str
    name: str
    """Full text of the strategy, of which ``label`` may be a short form."""
    renderer: str
    """Renderer of the strategy: ``core``, ``mitsuba`` or ``command``."""
    biased: bool
    """Whether the strategy declares itself biased: it may not converge to the scene's light transport."""
    repeats: int
    curve: Curve
    time_to: Mapping[float, Interval] = field(hash=False)
    """Seconds to reach each target error, by target; ``inf`` if never reached. The note of an interval tells whether
    the time is extrapolated."""
    ratio: Mapping[float, Interval] = field(hash=False)
    """Baseline's time to each target error over this strategy's time, by target; above 1 this strategy is faster."""
    efficiency: Interval
    """Baseline's squared error x time over this strategy's: median over pairs of repeats; above 1 this strategy is
    better.

    The median describes typical runs, however heavy their tails.
    """
    error_at_budget: Interval
    """Relative error at equal time: after ``SceneResult.budget_s`` seconds, read off ``curve.error``."""
    fewer_samples: Interval
    """Factor by which this strategy needs fewer samples than the baseline for equal error; ``inf`` if it has no error.
    """
    equality_p: float | None
    """P-value of the test that the strategy has the same expected image as the scene's ``standard`` strategy; None for
    that strategy itself, or if the test was not possible."""
    bias: Interval | None
    """Relative bias, as a fraction: the root of the estimated bias², with the sign of the estimate, which may be
    negative by chance. None without images or reference."""
    notes: tuple[str, ...]
    """Warnings to show beside this strategy on this scene."""
    image: Path | None
    """File of the first repeat's final image (float32 .npy, (H, W, 3)), for comparison at equal time; None without one.
    """
    image_error: float | None = None
    """Measured relative error of ``image``, a single run; negative if below what the reference can show, None if
    unknown."""
    image_seconds: float | None = None
    """Wall time of the run that made ``image``, in seconds since its first sample; None if unknown."""
    images: tuple[Path, ...] = ()
    """Files of the final images of all repeats in order, for the report's error and standard-error maps."""
    unequal: bool = False
    """Whether the strategy's expected image differs significantly from the standard strategy's (``equality_p``)."""
    agreement_p: float | None = None
    """P-value of the test of agreement with equaltime that another renderer failed; None if it passed or had none.

    Its errors are measured against ``reference``. Those that are not much larger than ``difference`` are left out, and
    so are times to them (`equaltime.experiments.analysis.disagreement`)."""
    difference: Interval | None = None
    """Relative distance of the expected image from the scene's reference, if ``agreement_p`` is given; else None."""
    samples: Path | None = None
    """File with the number of samples of each pixel of ``image`` (.npy, (H, W)); None if all pixels have equal counts.
    """
    variances: tuple[Path, ...] = ()
    """Files with the variance of one sample of each pixel, one file per repeat (float32 .npy, (H, W)); empty if the
    renderer reports none."""
    reference: Path | None = None
    """File of a reference for this strategy alone, if its renderer has another expected image; else None."""
    decided: tuple[str, ...] = ()
    """Words that each repeat put in place of what the strategy leaves open, such as ``roulette=efficiency``; empty if
    it leaves nothing open."""
    splitting: tuple[float, ...] = ()
    """Variance times rays with split paths over the same without, by the pilot of each repeat; empty without pilots."""
    run_seconds: tuple[float, ...] = ()
    """Wall time of the run of each repeat, in seconds from its first sample to its last image."""
    tail_share: float = 0.0
    """Share of the squared error of all repeats that one pixel of one repeat makes, if that shows a heavy tail; else 0.
    """
    first_share: float | None = None
    """Processor time of the first run over wall time times threads: its share of its processors. None if unknown."""
    late: float | None = None
    """Mean time of the first image in seconds if it is more than a tenth above the experiment's budget; else None."""
    film: Path | None = None
    """File of a film that shows how the strategy's image converges (`equaltime.experiments.run.forming.read_film`);
    None if not wanted."""

    @property
    def decisions(self) -> str:
        """Words that the runs put in place of what the strategy leaves open, and how many runs; empty if nothing is."""
        found = Counter(self.decided)
        if not found:
            return ""
        told = " and ".join(f"{words} in {count} run{'s' * (count != 1)}" for words, count in found.most_common())
        if self.splitting:
            ends = " to ".join(dict.fromkeys(figure(end(self.splitting)) for end in (min, max)))
            return f"{told}; by its pilots, splitting paths multiplies variance times rays by {ends}"
        no_pilot = "; splitting was not tried: the picture is small, or the technique has no pilot"
        return f"{told}{no_pilot if any('roulette' in words for words in found) else ''}"

    @property
    def disagrees(self) -> bool:
        """Whether this is another renderer that failed the test of agreement with equaltime."""
        return self.agreement_p is not None

    @property
    def another_picture(self) -> bool:
        """Whether the test of agreement, or the test against the standard strategy, found another expected image."""
        return self.unequal or self.disagrees

    @property
    def remark(self) -> str:
        """``biased``, or ``another picture`` if a test found that the strategy's picture is another one; or empty."""
        return "biased" if self.biased else "another picture" if self.another_picture else ""

    @property
    def named(self) -> str:
        """Label, with its `remark` in brackets."""
        return f"{self.label} ({self.remark})" if self.remark else self.label

    @property
    def picture_p(self) -> float | None:
        """P-value of the test that decides `another_picture`; None if there was none."""
        return self.agreement_p if self.disagrees else self.equality_p


@dataclass(frozen=True)
class SceneResult:
    """Results of all strategies on one scene, and the facts that they share, such as reference and equal time."""

    name: str
    digest: str
    size: tuple[int, int]
    """Width and height of the image, in pixels."""
    max_depth: int
    reference_error: float
    """Relative error of the reference by its own noise; already subtracted from the errors measured against it."""
    baseline: str
    """Label of the strategy with which all others are compared."""
    standard: str | None
    """Label of the strategy that counts as unbiased, usually ``best``: the expected images of all others are tested
    against its own. None if all strategies are biased."""
    budget_s: float
    """Equal time at which strategies are compared, in seconds: a run's budget, else the mean time of the fastest
    strategy's runs."""
    strategies: tuple[StrategyResult, ...]
    reference: Path | None = None
    """File of the reference (``.npz``, read by `equaltime.experiments.run.reference.read`); None if the folder has
    none."""
    crops: tuple[tuple[int, int, int, int], ...] = ()
    """Windows to show enlarged: x, y, width, height in pixels of the image; empty to let the report choose."""
    crops_left_out: str = ""
    """Sentence on wanted windows that are too small to be shown; empty if all are shown."""
    scene_max_depth: int | None = None
    """The ``max_depth`` that the scene's file asks for; None if it is not known."""
    left_out: tuple[tuple[str, str], ...] = ()
    """Strategies without results, since their runs have no sample count in common: pairs of label and reason."""
    reference_caveat: str = ""
    """Known limit of the reference besides its noise; empty if there is none."""
    reference_has_heavy_tail: bool = False
    """Whether one pixel makes much of the reference's own error, so that `reference_error` cannot be trusted."""

    def equal_samples(self, strategy: StrategyResult) -> int | None:
        """Return the samples per pixel at which a strategy's `fewer_samples` compares it with the baseline.

        It is the largest count that both have in all repeats; None if they have none in common.
        """
        counts = (set(one.curve.spp) for one in self.strategies if one.label == self.baseline)
        return max(set(strategy.curve.spp).intersection(*counts), default=None)

    @property
    def against_samples(self) -> bool:
        """Whether charts show errors against samples per pixel, since the equal time is too short for a clock."""
        return self.budget_s < _SHORTEST_CURVE

    @property
    def late(self) -> str:
        """Sentence for reports on the strategies whose first image took longer than the budget; empty without any."""
        told = [f"{one.label} ({duration(one.late)})" for one in self.strategies if one.late is not None]
        took = "first images took" if len(told) > 1 else "the first image took"
        return f"{took} longer than the budget of {duration(self.budget_s)}: {', '.join(told)}" if told else ""

    def other_end(self, strategy: StrategyResult) -> float | None:
        """Return the median seconds of a strategy's runs, or None if all strategies were given about this time.

        The first run fixes the sample count of all runs. Runs end early if the first run was slow, and late if it was
        fast.
        """
        end = median(strategy.run_seconds) if strategy.run_seconds else self.budget_s
        return end if abs(end - self.budget_s) > _APART * self.budget_s else None

    @property
    def other_ends(self) -> str:
        """Sentence for reports on strategies whose runs visibly differ from the equal time; empty without any.

        A strategy whose first image is late is told by `late` instead.
        """
        found = [(one, end) for one in self.strategies if one.late is None and (end := self.other_end(one)) is not None]
        if not found:
            return ""
        told = [
            f"{one.label} after {in_time(Interval(end, min(one.run_seconds), max(one.run_seconds)))}"
            for one, end in found
        ]
        return (
            f"runs did not end at the equal time of {duration(self.budget_s)} (median, range): {', '.join(told)}. "
            f"{_why_other_ends([one for one, _ in found])} Errors at the equal time are read off the curve; beyond its "
            "end they are extrapolated"
        )

    @property
    def decisions(self) -> str:
        """Sentence for reports on what strategies decided by themselves; empty if none left anything open."""
        told = [f"{one.label} decided by itself: {one.decisions}" for one in self.strategies if one.decided]
        return ". ".join(told)

    @property
    def other_depth(self) -> str:
        """Sentence for reports if the experiment's ``max_depth`` differs from the scene file's; else empty."""
        return "" if self.scene_max_depth is None else other_depth(self.max_depth, self.scene_max_depth)


def _why_other_ends(strategies: Sequence[StrategyResult]) -> str:
    """Return a sentence on what sets the samples of runs, and on first runs of ``strategies`` that were disturbed."""
    shares = [one.first_share for one in strategies if one.first_share is not None]
    slow = bool(shares) and min(shares) < BUSY
    least = f"{'as little as ' * (len(shares) > 1)}{percent(min(shares))}" if slow else ""
    return f"All runs take the samples of the first one{f', which had {least} of its processors' if slow else ''}."


@dataclass(frozen=True)
class Beside:
    """One published number beside the number that the experiment measured, for a comparison in the report."""

    what: str
    theirs: str
    """Published value as text; empty if no figure was published."""
    quantity: Quantity
    strategy: str
    scene: str
    value: Interval = UNKNOWN
    """Measured number; unknown, with a note on the reason, if it was not measured."""
    target: float | None = None
    """Error at which the number is given; None if the quantity has no target."""


@dataclass(frozen=True, repr=False)
class Summary(Shown):
    """Results of an experiment on all its scenes, from which reports, figures and verdicts are made."""

    title: str
    description: str
    """Paragraph for students: the comparison, what to look for, and why."""
    scenes: tuple[SceneResult, ...]
    targets: tuple[float, ...]
    """Relative errors to which times are given, largest first."""
    provenance: Mapping[str, Any] = field(hash=False)
    """Origin of the numbers: machine, build, dates, number of runs and their seeds."""
    verdict: str
    """Answer in a line or two, such as ``On box, best is about 31 times faster than naive (27 to 35): 2 % error in 4.1
    s.`` Print it with ``verdict_notes``, which tell what limits it."""
    question: Question = "time"
    """Question that the verdict answers."""
    theirs: Theirs | None = None
    """Published claim that the experiment tests."""
    beside: tuple[Beside, ...] = ()
    """Numbers of the published claim, each with the number that the experiment measured; empty without a claim."""
    headline_target: float | None = None
    """Error whose time the verdict gives; None if it gives none."""
    verdict_notes: tuple[str, ...] = ()
    """Sentences on what limits the verdict, such as a time that is extrapolated."""
    directions: Path | None = None
    """File of ray directions drawn by uniform and by BSDF sampling, for the report; None if not wanted."""

    def __str__(self) -> str:
        return self.verdict

    @property
    def headline_rule(self) -> str:
        """Sentence on why the verdict gives the time to this error; empty if it gives none."""
        if self.headline_target is None:
            return ""
        known = [
            (time, one.ratio.get(self.headline_target, UNKNOWN))
            for scene in self.scenes
            for one in scene.strategies
            if one.label == scene.standard and sound(time := one.time_to.get(self.headline_target, UNKNOWN))
        ]
        compared = [pair for pair in known if sound(pair[1])] or known
        within = [pair for pair in compared if not any(number.reach > 1.0 for number in pair)]
        # An answer on some of the scenes leaves out scenes with extrapolated times if another has none.
        beyond = len(within) < len(compared) if len(compared) == len(self.scenes) else not within
        return f"Why {percent(self.headline_target)}: {_BEYOND if beyond else _WITHIN}."

    @property
    def ratio_target(self) -> float | None:
        """Error for which tables of one column of speed-ups have them; None if no speed-up is known.

        It is the error of the verdict if a speed-up to it is known, else the smallest with a known speed-up.
        """
        wanted = [self.headline_target] if self.headline_target is not None else []
        return next((target for target in (*wanted, *sorted(self.targets)) if self._has_ratio(target)), None)

    def _has_ratio(self, target: float) -> bool:
        """Tell whether the speed-up of a strategy over the baseline to the error ``target`` is known, or a limit."""
        found = [
            one.ratio.get(target, UNKNOWN)
            for scene in self.scenes
            for one in scene.strategies
            if one.label != scene.baseline
        ]
        return any(sound(ratio) or bool(ratio.bound) for ratio in found)

    def to_frame(self) -> pandas.DataFrame:
        """Return the error curves as a pandas table, with a row for each point of each strategy's curve on each scene.

        The columns are ``scene``, ``strategy`` (its label), ``biased``, ``spp`` (samples per pixel), and three numbers.
        ``seconds`` is the rendering time. ``error`` is the relative error measured against the reference: 0.02 is 2 %.
        ``own_estimate`` is the relative error that the render states itself, without a reference. Each of the three has
        two further columns with the ends of its 95 % interval, such as ``error_low`` and ``error_high``. A third one,
        such as ``error_trusted``, tells whether the interval can be trusted. Raises `EqualtimeError` if pandas is not
        installed.
        """
        rows = [
            {"scene": scene.name, "strategy": strategy.label, "biased": strategy.biased, "spp": spp, **point}
            for scene in self.scenes
            for strategy in scene.strategies
            for spp, point in zip(strategy.curve.spp, _points(strategy.curve), strict=True)
        ]
        frame: pandas.DataFrame = optional("pandas", "frames").DataFrame(rows)
        return frame


def _points(curve: Curve) -> Iterator[dict[str, float]]:
    """Give the intervals of each checkpoint, by column."""
    names = ("seconds", "error", "own_estimate")
    ends = {"": "value", "_low": "low", "_high": "high", "_trusted": "trusted"}
    for intervals in zip(*(getattr(curve, name) for name in names), strict=True):
        yield {
            f"{name}{end}": getattr(interval, attribute)
            for name, interval in zip(names, intervals, strict=True)
            for end, attribute in ends.items()
        }
