"""What an experiment found: the values that reports, figures and verdicts are made of, and nothing else.

`analysis.summarise` makes them from records. Errors are relative (0.02 is 2 %, see `metrics`), times are seconds of
wall clock from a run's first sample, and every number that was estimated is an `Interval`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from equaltime.experiments.model.theirs import Quantity, Theirs
from equaltime.extras import optional
from equaltime.rendering.stated import other_depth
from equaltime.statistics.intervals import UNKNOWN, Interval
from equaltime.words import Shown

if TYPE_CHECKING:
    import pandas

__all__ = ["Beside", "Curve", "Question", "SceneResult", "StrategyResult", "Summary"]

Question = Literal["time", "bias", "samples", "efficiency"]
"""An experiment's question: the time to an error, which strategies are biased, the samples to an error, or squared
error times time."""


@dataclass(frozen=True)
class Curve:
    """How the error of a strategy falls; all tuples run over the checkpoints."""

    spp: tuple[int, ...]
    seconds: tuple[Interval, ...]
    """Wall time since the first sample, without measuring."""
    error: tuple[Interval, ...]
    """Realised error against the reference, whose own noise is subtracted: root of the mean square over repeats."""
    slope: Interval
    """Of log error against log time: -0.5 where samples are independent."""
    own_estimate: tuple[Interval, ...]
    """What the renders themselves said; value NaN where a renderer says nothing."""


@dataclass(frozen=True)
class StrategyResult:
    """What one strategy did on one scene."""

    label: str
    name: str
    """The strategy in full."""
    renderer: str
    """core, mitsuba or command."""
    biased: bool
    """Named biased: it may converge to something else."""
    repeats: int
    curve: Curve
    time_to: Mapping[float, Interval] = field(hash=False)
    """Target error → seconds; ``inf`` if it is never reached. Notes say what is extrapolated."""
    ratio: Mapping[float, Interval] = field(hash=False)
    """Target error → the baseline's time over this one's: above 1 this one is faster."""
    efficiency: Interval
    """The baseline's squared error x time over this one's, in the median of repeats: what typical runs do, however
    heavy their tails."""
    error_at_budget: Interval
    """Error at equal time: the scene's ``budget_s``."""
    fewer_samples: Interval
    """The baseline's samples over this one's to the same error; ``inf`` if this one has none."""
    equality_p: float | None
    """P-value of the hypothesis that its images have the expectation of the scene's ``standard`` strategy."""
    bias: Interval | None
    """Relative bias: root of bias², signed as that is, since an estimate of 0 falls on both sides of it."""
    notes: tuple[str, ...]
    """What a reader must know of this strategy on this scene."""
    image: Path | None
    """Final image of the first repeat (float32 .npy, (H, W, 3)), at the budget: equal time."""
    images: tuple[Path, ...] = ()
    """Final images of all repeats, the first one first: a report makes error and standard-error maps of them."""
    unequal: bool = False
    """Whether that p-value is below the level of the experiment's tests."""
    samples: Path | None = None
    """Samples of each pixel of ``image`` (.npy, (H, W)); None if they are the same everywhere."""
    reference: Path | None = None
    """The reference of its own that it is held against, where it has one; as `SceneResult.reference`."""
    film: Path | None = None
    """Its image forming, for `equaltime.experiments.run.forming.read_film`; None if the experiment does not want it."""


@dataclass(frozen=True)
class SceneResult:
    """All strategies on one scene."""

    name: str
    digest: str
    size: tuple[int, int]
    """Width, height of the image."""
    max_depth: int
    reference_error: float
    """Relative error of the reference, as it is known; it is subtracted from what is measured against it."""
    baseline: str
    """Label of the strategy that all are compared with."""
    standard: str | None
    """Label of the strategy that others' expectations are tested against."""
    budget_s: float
    """Seconds at which equal-time numbers are given: the budget of a run, else what the fastest runs took in all."""
    strategies: tuple[StrategyResult, ...]
    reference: Path | None = None
    """File of the reference, for `equaltime.experiments.run.reference.read`; None if it is not at hand."""
    crops: tuple[tuple[int, int, int, int], ...] = ()
    """Windows x, y, width, height to look at closely, in pixels of the image; empty to let the report choose."""
    scene_max_depth: int | None = None
    """The ``max_depth`` that the scene's file asks for; None if the folder does not say."""
    left_out: tuple[tuple[str, str], ...] = ()
    """Labels of strategies whose runs cannot be joined, and why."""
    reference_caveat: str = ""
    """What limits the reference besides its noise; empty if nothing is known to."""

    @property
    def other_depth(self) -> str:
        """The paths that were rendered and those that the scene asks for, in words; empty if these are the same."""
        return "" if self.scene_max_depth is None else other_depth(self.max_depth, self.scene_max_depth)


@dataclass(frozen=True)
class Beside:
    """A number of ours beside one that others gave."""

    what: str
    theirs: str
    """What they say of it; empty if they give no figure."""
    quantity: Quantity
    strategy: str
    scene: str
    value: Interval = UNKNOWN
    target: float | None = None
    """The error to which a time is given."""


@dataclass(frozen=True, repr=False)
class Summary(Shown):
    """What an experiment found on all its scenes."""

    title: str
    description: str
    """A paragraph for students: what is compared, what to see, why."""
    scenes: tuple[SceneResult, ...]
    targets: tuple[float, ...]
    """Errors to which times are given, largest first."""
    provenance: Mapping[str, Any] = field(hash=False)
    """Machine, build, dates, counts of runs."""
    verdict: str
    """One sentence, such as ``best: 2 % in 4.1 s [3.9, 4.4], 31x [27, 35] faster than naive``."""
    question: Question = "time"
    """What the verdict is an answer to."""
    theirs: Theirs | None = None
    """What others say of it."""
    beside: tuple[Beside, ...] = ()
    """Our numbers beside theirs."""
    directions: Path | None = None
    """Where sampling sends rays, for `equaltime.experiments.run.directions.read_directions`."""

    def __str__(self) -> str:
        return self.verdict

    def to_frame(self) -> pandas.DataFrame:
        """Return the error curves as a table for pandas: a row for each checkpoint of each strategy on each scene.

        Columns: ``scene``, ``strategy``, ``biased``, ``spp``; ``seconds``, ``error`` and ``own_estimate``, each with
        ``_low`` and ``_high`` (95 %). Times in seconds, errors relative. Raises `EqualtimeError` without pandas.
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
    for intervals in zip(*(getattr(curve, name) for name in names), strict=True):
        yield {
            f"{name}{end}": value
            for name, interval in zip(names, intervals, strict=True)
            for end, value in (("", interval.value), ("_low", interval.low), ("_high", interval.high))
        }
