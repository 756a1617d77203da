"""Error against time: the time to a wanted error, the error at a given time, the slope.

A strategy's curve shows the *expected* squared error: at each checkpoint the mean of relMSE over repeats. The variance
of the reference is already subtracted from relMSE. The relMSE of a single repeat may therefore be below 0, but the mean
is unbiased. The error of a strategy after a time is read off this curve, which is straight between checkpoints in
log-log axes: it is the root mean square over repeats. Times to an error need a curve that falls, though noise may make
measured errors rise. So times are read off an isotonic regression, through the means of its blocks. Every number read
off a curve is computed on the logarithm of means over repeats. Its interval comes from the jackknife over repeats,
which also corrects times, ratios and slopes for the curvature of the logarithm; errors stay as they were measured. The
jackknife accounts for samples that checkpoints of one run share, and for a drifting machine that two strategies'
repeats share. The reference's noise affects all repeats alike, so their spread does not show it. So every number is
computed again with relMSE moved by its standard error. If two strategies are compared, both are moved by the same
amount.

Where a few events make most of the error (`Runs.tail`), the mean over repeats is decided by the runs that met such
events. The spread over repeats does not tell the frequency of these events. Times are then times of typical runs:
medians over repeats, where each repeat has its own curve. Their interval is from the sign test, which holds for any
distribution. Beyond its end every curve continues with the slope of the median curve, even where samples are
independent. 1 / sqrt(time) is the law of the mean error, but a run that has not met the rare light still lacks it after
twice the time. Where tails are light, mean and median are the same number, and the mean has the narrower interval.

A renderer that starts anew for every checkpoint (`Runs.spp`) pays a fixed time before its first sample. Its error falls
steeply with time as long as the start makes most of it, and no steeper than others afterwards. So its curve continues
in samples, and the fixed time is added. No curve continues to later times with a slope steeper than `STEEPEST`, nor
beyond `FARTHEST_REACH` times the longest run.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from equaltime.statistics.intervals import (
    UNKNOWN,
    Z95,
    Interval,
    exp,
    few,
    jackknife,
    join,
    mean_interval,
    median_interval,
    signed_root,
)
from equaltime.statistics.runs import Runs
from equaltime.words import duration, percent

__all__ = [
    "AGAINST_SAMPLES",
    "BEFORE",
    "BELOW",
    "BETTER",
    "BEYOND",
    "ERRORS_OF",
    "ERROR_OF",
    "INDEPENDENT",
    "RISES",
    "STEEPEST",
    "TOO_NOISY",
    "error_at",
    "error_curve",
    "interval_of",
    "least_error_at",
    "log_time",
    "log_times",
    "second_curve",
    "slope",
    "slope_doubt",
    "start_seconds",
    "steep_doubt",
    "time_to_error",
    "typical_interval",
]

Floats = NDArray[np.float64]

INDEPENDENT = -0.5
"""Slope of log error against log time for independent samples, whose variance falls as 1 / n for n samples."""
STEEPEST = -0.8
"""Steepest slope of log error against log samples with which a curve continues to later times.

Independent samples have -1/2. Stratified and low-discrepancy points have -3/4 in pixels that an edge crosses: of n
strata it cuts about sqrt(n), so the variance falls as n^(-3/2). Smooth pixels may do better, and then those with edges
make the error in the end. Fits scatter by some 0.05 around their slope. Steeper ones come from warming up or by chance,
and do not last."""
TRUSTED_REACH = 10.0
"""Largest factor of time beyond the longest run for which a fitted slope is trusted."""
FARTHEST_REACH = 100.0
"""Largest factor of time beyond the longest run to which a curve goes on, by a fitted slope or by -1/2. A longer time
would rest on a hundredth of its samples."""
_FARTHEST_ERROR = 2.0
"""Largest factor of time outside the runs for which an error is stated."""
_NEAR_ENOUGH = 1.15
"""Same limit as `_FARTHEST_ERROR`, for an unknown slope: runs may end a tenth of their time early."""
_AS_LONG = 1.05
"""Factor of time outside the runs from which an error counts as extrapolated: runs aim at their budget with a few per
cent."""
BETTER = "reference.error and reference.seconds of an experiment file ask for a better one"
"""Advice where a reference is too noisy."""
BELOW = f"the error is below what the reference can show; {BETTER}"
"""Reason why an error is not known: the noise of the reference hides it."""
RISES = "read off the mean of errors that rise with time: the last of them is above this error"
"""Note of a time within the runs to an error that the last measurement exceeds. Low-discrepancy points have such
errors between powers of two, and noise makes them too."""
BEYOND, BEFORE = "beyond the longest run", "before the first measurement"
"""Words in the note of an extrapolated number: the end of the curve outside which it lies."""
ERROR_OF, ERRORS_OF = "the reference has an error of", "the references have errors of"
"""Beginning of the note of a time that is not given because of the reference's noise, for one scene and for several."""
TOO_NOISY = ", too much for times beyond the runs to a smaller one"
"""Part of the note of a time that is not given because of the reference's noise."""
_SHALLOW = "shallower than -0.5, the slope of independent samples: fixed costs at the start, or rare bright samples"
_TAIL_OCTAVES = 3.0
_STEEP = (
    "the fitted slope is steeper than -0.8, which does not last: the interval reaches from the fitted slope to one as "
    "much flatter than -0.8"
)
"""Remark on a time that is extrapolated by `STEEPEST`."""
AGAINST_SAMPLES = "against samples, not time"
"""Beginning of the note of a slope of log error against log samples; other slopes are against log time."""
_FEWEST_POINTS = 3
_MOST_LOG = 600.0
"""Logarithm of a factor of samples beyond which the time counts as infinite: float64 ends near e^709."""


def interval_of(statistic: Callable[[Floats, float], float], repeats: int) -> Interval:
    """Return a statistic over repeats with its 95 % interval, which includes the uncertainty of the reference.

    ``statistic`` takes two arguments. The first is the weights of the repeats, (K,). The second is an assumed error of
    the reference, in standard errors of relMSE; 0 for none. ``repeats`` is K. The spread over repeats comes from the
    jackknife.
    """
    found = jackknife(lambda kept: statistic(kept, 0.0), repeats)
    everything = np.ones(repeats)
    moved = 0.5 * abs(statistic(everything, 1.0) - statistic(everything, -1.0))
    if moved == 0.0 or not math.isfinite(found.value):
        return found
    if not math.isfinite(moved):
        return found.doubted("the noise of the reference is too large to tell")
    half = math.hypot(0.5 * (found.high - found.low), Z95 * moved)
    return replace(found, low=found.value - half, high=found.value + half)


def falling(x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Return the decreasing step function that fits ``y`` best (isotonic regression): mean x and mean y of each step.

    ``x`` and ``y`` are arrays (N,), and ``x`` must be ascending.
    """
    from scipy.optimize import isotonic_regression  # late: slow to import

    fitted = isotonic_regression(y, increasing=False)
    first = fitted.blocks[:-1]
    return np.add.reduceat(x, first) / np.diff(fitted.blocks), fitted.x[first]


def _steepness(x: Floats, y: Floats) -> float:
    """Return the slope of the least squares line; NaN for fewer than two points."""
    centred = x - x.mean() if x.size else x
    square = float(centred @ centred)
    return float(centred @ y) / square if square > 0.0 else math.nan


def start_seconds(runs: Runs, kept: Floats) -> float:
    """Return the seconds of a render that do not grow with its samples, such as the start of a program.

    They are 0 if one image grows from checkpoint to checkpoint, since no checkpoint then starts anew. The start is the
    intercept of a line through the mean times over sample counts, by least squares of relative deviations. ``kept``
    (K,) is the weight of each repeat. The result is below the shortest mean time.
    """
    if runs.spp is None or runs.spp.size < _FEWEST_POINTS:
        return 0.0
    from scipy.optimize import nnls  # late: slow to import

    seconds = kept @ runs.seconds / kept.sum()
    if not (np.isfinite(seconds).all() and seconds.min() > 0.0):
        return 0.0
    line = np.stack([1.0 / seconds, runs.spp / runs.spp[-1] / seconds], axis=1)
    start = float(nnls(line, np.ones_like(seconds))[0][0])
    return min(start, float(np.nextafter(seconds.min(), 0.0)))


def _outside(runs: Runs, x: Floats, y: Floats, late: bool) -> float:
    """Return the slope with which the curve continues after its end (or before its beginning)."""
    if runs.law:
        return INDEPENDENT
    steep = _fitted(runs, x, y, late)
    return STEEPEST if late and steep < STEEPEST else steep


def _fitted(runs: Runs, x: Floats, y: Floats, late: bool) -> float:
    """Return the slope of the last (or first) three doublings of a curve; NaN for too few points."""
    x = _axis(runs, x)
    near = np.abs(x - (x[-1] if late else x[0])) <= _TAIL_OCTAVES * math.log(2.0)
    return _steepness(x[near], y[near]) if np.count_nonzero(near) >= _FEWEST_POINTS else math.nan


def _axis(runs: Runs, x: Floats) -> Floats:
    """Return what slopes are measured against: log samples if every time contains a start, else log seconds ``x``."""
    return x if runs.spp is None else np.log(runs.spp[: x.size])


def _continued(log_seconds: float, log_factor: float, start: float) -> float:
    """Return the log of the seconds in which a render takes ``exp(log_factor)`` times the samples."""
    if start == 0.0:
        return log_seconds + log_factor
    sampling = max(math.exp(log_seconds) - start, 0.0)
    return math.inf if log_factor >= _MOST_LOG else math.log(start + sampling * math.exp(log_factor))


def _factor(log_seconds: float, end: float, start: float) -> float:
    """Return the log of the factor of samples between two times; the inverse of `_continued`, NaN before the start."""
    if start == 0.0 or not math.isfinite(log_seconds):
        return log_seconds - end
    sampling = [math.exp(one) - start for one in (log_seconds, end)]
    return math.log(sampling[0] / sampling[1]) if min(sampling) > 0.0 else math.nan


def log_time(runs: Runs, target: float, kept: Floats) -> float:
    """Return the natural logarithm of the seconds after which the mean error of repeats falls to ``target``.

    ``target`` is a relative error: 0.02 is 2 %. ``kept`` (K,) is the weight of each repeat in ``runs``. The result is
    ``inf`` if the error never falls to ``target``, and NaN if there are too few checkpoints to tell.
    """
    curve = runs.points(kept)
    return _crossing(runs, target, curve, curve, start_seconds(runs, kept))


def log_times(runs: Runs, target: float) -> Floats:
    """Return the natural logarithms of the seconds after which the error of each repeat falls to ``target``, (K,).

    ``target`` is a relative error: 0.02 is 2 %. Beyond its last checkpoint, the curve of a repeat continues with the
    slope of the curve of medians over all repeats in ``runs``. A number is ``inf`` if the error never falls to
    ``target``, and NaN if there are too few checkpoints to tell.
    """
    typical = runs.typical(np.ones(runs.repeats))
    return np.array(
        [_crossing(runs, target, runs.points(one), typical, start_seconds(runs, one)) for one in np.eye(runs.repeats)]
    )


def _crossing(
    runs: Runs, target: float, curve: tuple[Floats, Floats], slopes: tuple[Floats, Floats], start: float
) -> float:
    """Return the log of the seconds at which a curve falls to the target; ``slopes`` extrapolates beyond its ends.

    ``start`` is the time that each render takes beside its samples, in seconds.
    """
    x, y = curve
    if not x.size:
        return math.nan
    wanted = math.log(target)
    level_x, level_y = falling(x, y)
    if level_y[-1] <= wanted <= level_y[0]:
        return float(np.interp(-wanted, -level_y, level_x))
    late = bool(wanted < level_y[-1])
    if late and runs.biased:
        return math.inf
    steep = _outside(runs, *slopes, late)
    if not steep < 0.0:
        return math.nan if math.isnan(steep) else math.inf
    end = -1 if late else 0
    return _continued(float(level_x[end]), float(wanted - level_y[end]) / steep, start)


def time_to_error(runs: Runs, target: float) -> Interval:
    """Return the seconds after which a strategy reaches the relative error ``target`` (0.02 is 2 %), as an interval.

    - The time is usually the one at which the mean error over repeats falls to ``target``. If a few rare bright paths
      make most of the error (`Runs.tail`), it is the median of the times of the repeats. The field ``note`` of the
      interval then says so.
    - Beyond the measured times the error curve is extrapolated in log-log axes, which ``note`` says too. The slope is
      -1/2 for independent samples without such paths. Otherwise it is fitted to the last three doublings of time.
      A steeper fit than `STEEPEST` is replaced by it, and the interval is wider then (`steep_doubt`). No curve goes on
      beyond 100 times the longest run, and that of a biased strategy is not extrapolated to later times.
    - If the error is below ``target`` in the middle of the runs but above it at their end, ``note`` is `RISES`. The
      time is then read off a curve that takes means of such earlier and later errors.
    - If a renderer starts anew for every checkpoint, slopes are against samples, and the start is added to times.
    - The value is ``inf`` if the curve does not reach ``target`` within these limits. The field ``low`` is then a time
      that is surely too short for ``target``; it is 0 if no such time is known. For a biased strategy it is the longest
      run, or ``inf`` if the bias alone exceeds ``target`` (`Runs.bias`).
    - If the fitted error of an unbiased strategy does not fall, ``value`` is ``inf`` and only ``low`` tells anything.
    - The value is NaN if there are too few checkpoints to extrapolate, or if the error is below the reference's noise
      from the first checkpoint on. It is NaN if ``target`` is reached within the limits only by a curve with the steep
      end of the slope's 95 % interval. It is also NaN for a time beyond the runs to an error below the reference's own,
      which the reference could not confirm.
    """
    whole = np.ones(runs.repeats)
    typical = bool(runs.tail)
    x, y = runs.typical(whole) if typical else runs.points(whole)
    if runs.exact:
        first = float(runs.seconds[:, 0].mean())
        return Interval(first, 0.0, first).bounded("high", "the first image is exact already")
    if not x.size:
        return UNKNOWN.doubted(BELOW)
    begin, end = float(x[0]), float(x[-1])
    if typical:
        value = float(np.median(log_times(runs, target)))
        found = typical_interval(lambda off: log_times(runs.moved(off), target), slope_doubt(runs, value))
    else:
        value = log_time(runs, target, whole)
        found = interval_of(lambda kept, off: log_time(runs.moved(off), target, kept), runs.repeats)
    if math.isnan(value):
        return runs.judged_time(UNKNOWN.doubted("too few checkpoints to extrapolate"))
    if value > end and target < runs.reference and not runs.biased:
        return UNKNOWN.doubted(f"{ERROR_OF} {percent(runs.reference)}{TOO_NOISY} ({BETTER})")
    if math.isinf(value) and not runs.biased:  # more samples do make it smaller, but the runs do not tell how fast
        low = _surely_until(runs, target, x.size - 1)
        why = "not reached in the runs, whose error does not fall over the last three doublings of time"
        return runs.judged_time(Interval(math.inf, low, math.inf).bounded("low", why))
    farthest = end + math.log(FARTHEST_REACH)
    far = value > farthest
    if far and not runs.biased and (found.low < farthest if runs.law else _may_be_near(runs, target)):
        return runs.judged_time(UNKNOWN.doubted("the error varies too much between repeats to tell how it goes on"))
    if math.isinf(value):  # only biased strategies are left
        if runs.bias > target:
            return runs.judged_time(Interval(math.inf, math.inf, math.inf).noted("never reached: its bias is larger"))
        low = _surely_until(runs, target, x.size - 1)
        return runs.judged_time(Interval(math.inf, low, math.inf).noted("not reached: biased, not extrapolated"))
    if far:
        low = max(_surely_until(runs, target, x.size - 1), min(_lower_end(found), FARTHEST_REACH * math.exp(end)))
        why = f"not reached in {FARTHEST_REACH:g} times the longest run"
        return runs.judged_time(Interval(math.inf, low, math.inf).noted(why))
    found = _with_reach(found.map(exp), value, (begin, end), runs, steep_doubt(runs, target))
    return runs.judged_time(found.noted(RISES) if value <= end and y[-1] > math.log(target) else found)


def steep_doubt(runs: Runs, target: float) -> tuple[float, float]:
    """Return by how much the time to the error ``target`` may be below and above its estimate, as fractions of it.

    Both are 0 unless `STEEPEST` takes the place of a steeper fit. Then the slope may be the fitted one, or as much
    flatter than `STEEPEST` as the fit is steeper, but not flatter than -1/2.
    """
    whole = np.ones(runs.repeats)
    x, y = runs.typical(whole) if runs.tail else runs.points(whole)
    if runs.law or runs.biased or not x.size:
        return 0.0, 0.0
    level_x, level_y = falling(x, y)
    fall, fitted = math.log(target) - float(level_y[-1]), _fitted(runs, x, y, late=True)
    if fall >= 0.0 or not fitted < STEEPEST:
        return 0.0, 0.0
    start, slopes = start_seconds(runs, whole), (fitted, STEEPEST, min(2.0 * STEEPEST - fitted, INDEPENDENT))
    fast, value, slow = (_continued(float(level_x[-1]), fall / steep, start) for steep in slopes)
    return (exp(value - fast) - 1.0, exp(slow - value) - 1.0) if math.isfinite(slow) else (math.inf, math.inf)


def typical_interval(logs: Callable[[float], Floats], more: float) -> Interval:
    """Return the median over repeats of a logarithm, with an interval that includes the reference's uncertainty.

    Use it for times of typical runs. ``logs`` is a function of an assumed error of the reference, in standard errors of
    relMSE; it returns the logarithm for each repeat, (K,). ``more`` is the half width of another, independent 95 %
    interval of the logarithm, which widens the result.
    """
    found = median_interval(logs(0.0))
    if not math.isfinite(found.value):
        return found
    moved = 0.5 * abs(float(np.median(logs(1.0)) - np.median(logs(-1.0))))
    if not math.isfinite(moved):
        return found.doubted("the noise of the reference is too large to tell")
    more = math.hypot(Z95 * moved, more)
    down, up = math.hypot(found.value - found.low, more), math.hypot(found.high - found.value, more)
    return replace(found, low=found.value - down, high=found.value + up)


def slope_doubt(runs: Runs, value: float) -> float:
    """Return the half width of the 95 % interval of an extrapolated log time, as far as an uncertain slope causes it.

    ``value`` is the natural logarithm of the time. The slope is the one of the curve of medians over repeats in
    ``runs``. The result is 0 if the time is within the curve, or if the slope is known (`Runs.law`). The slope's
    uncertainty comes from the jackknife over repeats. It is too large on average, since the jackknife overestimates the
    variance of a median.
    """
    x, _ = runs.typical(np.ones(runs.repeats))
    if x[0] <= value <= x[-1] or not math.isfinite(value) or runs.law:
        return 0.0
    late = bool(value > x[-1])
    beyond = abs(_factor(value, float(x[-1] if late else x[0]), start_seconds(runs, np.ones(runs.repeats))))
    found = jackknife(lambda kept: _outside(runs, *runs.typical(kept), late), runs.repeats)
    steep = _outside(runs, *runs.typical(np.ones(runs.repeats)), late)
    half = 0.5 * (found.high - found.low)
    return float(beyond * half / abs(steep)) if math.isfinite(half) and math.isfinite(beyond) else math.inf


def _may_be_near(runs: Runs, target: float) -> bool:
    """Tell whether the curve may reach ``target`` within `FARTHEST_REACH` times the longest run.

    It is continued with the steep end of the slope's 95 % interval. With a heavy tail it is continued with -1/2 if that
    is steeper: medians may rise while rare events are met for the first time, and fall as fast as that later.
    """
    curve = runs.typical if runs.tail else runs.points
    _, level = falling(*curve(np.ones(runs.repeats)))
    steep = jackknife(lambda kept: _outside(runs, *curve(kept), True), runs.repeats).low
    steep = steep if steep > STEEPEST else STEEPEST
    if runs.tail:
        steep = min(steep, INDEPENDENT)
    return bool(steep < 0.0 and (math.log(target) - level[-1]) / steep <= math.log(FARTHEST_REACH))


def _surely_until(runs: Runs, target: float, last: int) -> float:
    """Return the time of a checkpoint if the error there is surely above the target, else 0."""
    squares = runs.relmse[:, last]
    error = median_interval(squares).map(signed_root) if runs.tail else _root_mean(squares, runs.shared)
    return float(runs.seconds[:, last].mean()) if error.trusted and error.low > target else 0.0


def _lower_end(log_time: Interval) -> float:
    """Return the lower end of a time from the interval of its logarithm; 0 if the interval is not trusted."""
    return exp(log_time.low) if log_time.trusted and not math.isnan(log_time.low) else 0.0


def _with_reach(
    found: Interval, value: float, ends: tuple[float, float], runs: Runs, steep: tuple[float, float]
) -> Interval:
    """Note how far outside the runs the number lies, and doubt it where a fitted slope is used too far.

    ``ends`` are the logarithms of the first and the last time, and ``steep`` is the result of `steep_doubt`.
    """
    begin, end = ends
    reach = math.exp(max(value - end, begin - value, 0.0))
    if reach <= 1.0 + 1e-9:
        return found
    late = value > end
    by = "by slope -1/2" if runs.law else "by slope -0.8" if any(steep) else "by the fitted slope"
    start = start_seconds(runs, np.ones(runs.repeats))
    told = (f"extrapolated {reach:.3g} times {_side(late)} {by}", _STEEP if any(steep) else "", _started(start))
    noted = replace(found.widened(steep[0], "low").widened(steep[1]), reach=reach).noted(join(told))
    factor = math.exp(abs(_factor(value, end if late else begin, start)))
    if factor <= (TRUSTED_REACH if late else 2.0):
        return noted
    if not runs.law:
        return noted.doubted("a fitted slope may not hold so far")
    few = runs.seconds.shape[1] < _FEWEST_POINTS  # so few samples have not met what is rare
    return noted.doubted("too few checkpoints to extrapolate so far") if late and few else noted


def _started(start: float) -> str:
    """Return a remark on the time that each render takes beside its samples; empty if there is none."""
    return f"each render takes {duration(start)} beside its samples" if start > 0.0 else ""


def error_at(runs: Runs, seconds: float) -> Interval:
    """Return the relative error of ``runs`` after ``seconds`` seconds, as an interval.

    The error is the root mean square over repeats. At the mean time of a checkpoint, the value is the error that was
    measured there. Between checkpoints, the logarithms of error and time are interpolated. The error is extrapolated by
    the curve's slope up to twice the longest time, and down to half of the shortest. From 5 % of time outside on, the
    field ``reach`` says how far, and ``note`` too. The value is NaN for times farther outside, or if the error is below
    the reference's noise. In the second case the upper end is valid alone, unless few events make most of the error.
    """
    wanted = math.log(seconds)

    def log_error(kept: Floats, off: float) -> float:
        x, y = runs.moved(off).points(kept)
        if not x.size:
            return math.nan
        if x[0] <= wanted <= x[-1]:
            return float(np.interp(wanted, x, y))
        late = bool(wanted > x[-1])
        end, steep = -1 if late else 0, _outside(runs, x, y, late)
        beyond = _factor(wanted, float(x[end]), start_seconds(runs, kept))
        if math.isnan(beyond) or abs(beyond) > math.log(_NEAR_ENOUGH if math.isnan(steep) else _FARTHEST_ERROR):
            return math.nan
        return float(y[end] + (0.0 if math.isnan(steep) else min(steep, 0.0)) * beyond)

    if runs.exact:
        return few(Interval(0.0, 0.0, 0.0), runs.repeats)
    found = _measured(log_error, runs.repeats)
    if math.isnan(found.value):
        return _below_noise(runs, wanted) if runs.is_below() else UNKNOWN.doubted("no run is near that time")
    if runs.tail:
        found = _no_less(found, median_interval([log_error(one, 0.0) for one in np.eye(runs.repeats)]).map(exp))
    x, _ = runs.points(np.ones(runs.repeats))
    reach = math.exp(max(wanted - float(x[-1]), float(x[0]) - wanted))
    if reach >= _AS_LONG:
        found = replace(found, reach=reach).noted(f"extrapolated {reach:.3g} times {_side(wanted > x[-1])}")
    return runs.judged(found)


def _below_noise(runs: Runs, wanted: float) -> Interval:
    """Return the upper limit of an error that the reference's noise hides, at the time with the logarithm ``wanted``.

    The value is unknown. The limit, at 97.5 %, is interpolated between checkpoints as the error is. A run that ends a
    little early has its last limit, since errors fall. Farther outside the runs no limit is known.
    """
    times = np.log(runs.seconds.mean(axis=0))
    if not times[0] <= wanted <= times[-1] + math.log(_NEAR_ENOUGH):
        return UNKNOWN.doubted(BELOW)
    means = [mean_interval(column) for column in runs.relmse.T]
    squares = [mean.value + math.hypot(mean.high - mean.value, Z95 * runs.shared) for mean in means]
    logs = [math.log(square) if square > 0.0 else math.nan for square in squares]
    limit = exp(0.5 * float(np.interp(wanted, times, logs)))
    if math.isnan(limit) or not means[-1].trusted:
        return UNKNOWN.doubted(BELOW)
    return runs.judged(Interval(math.nan, 0.0, limit).bounded("high", BELOW))


def _side(late: bool) -> str:
    """Name the end of the curve outside which a time lies."""
    return BEYOND if late else BEFORE


def _no_less(mean: Interval, median: Interval) -> Interval:
    """Return an error with the lower end of typical runs, if that is higher: rare events can only add."""
    return replace(mean, low=max(mean.low, min(median.low, mean.value))) if median.trusted else mean


def least_error_at(runs: Runs, seconds: float) -> float:
    """Return the relative error after ``seconds`` seconds as one number, for a comparison of strategies.

    The error is the root mean square over repeats, as `error_at` finds it. It is 0 if it is below the reference's
    noise, and NaN if no run is near that time.
    """
    found = error_at(runs, seconds).value
    return 0.0 if math.isnan(found) and runs.is_below() else found


def slope(runs: Runs) -> Interval:
    """Return the slope of log error against log time over all checkpoints of ``runs``, as an interval.

    Independent samples have a slope of -0.5. The slope is against log samples if a renderer starts anew for every
    checkpoint: its start makes errors fall steeply with time for a while. The field ``note`` then begins with
    `AGAINST_SAMPLES`. The value is NaN if there are too few checkpoints.
    """

    def steepness(kept: Floats, off: float) -> float:
        x, y = runs.moved(off).points(kept)
        return _steepness(_axis(runs, x), y)

    found = interval_of(steepness, runs.repeats)
    if math.isnan(found.value):
        return UNKNOWN.doubted("an exact image has no error that falls" if runs.exact else "too few checkpoints")
    if runs.spp is not None:
        found = found.noted(f"{AGAINST_SAMPLES}: times of other programs than equaltime may contain a start")
    if found.trusted and found.low > INDEPENDENT and not runs.biased:
        found = found.noted(_SHALLOW)
    reason = join((runs.tail, runs.missing))
    return found.doubted(reason) if reason else found


def error_curve(runs: Runs) -> tuple[Interval, ...]:
    """Return the relative error at each of the C checkpoints of ``runs``, with its interval: a tuple of C intervals.

    The error is the root of the mean of relMSE over repeats.
    """
    errors = [_root_mean(column, runs.shared) for column in runs.relmse.T]
    if runs.tail:
        medians = (median_interval(column).map(signed_root) for column in runs.relmse.T)
        errors = list(map(_no_less, errors, medians))
    return tuple(map(runs.judged, errors))


def second_curve(runs: Runs) -> tuple[Interval, ...]:
    """Return the seconds from the first sample to each checkpoint, with intervals: the means over repeats.

    The tuple has C intervals, one for each checkpoint of ``runs``. Lower ends are at least 0.
    """
    means = (mean_interval(column) for column in runs.seconds.T)
    return tuple(replace(mean, low=max(mean.low, 0.0)) for mean in means)


def _root_mean(squares: Floats, shared: float) -> Interval:
    mean = float(squares.mean())
    if shared == 0.0 and not squares.any():
        return few(Interval(0.0, 0.0, 0.0), squares.size)  # every image is the exact truth
    if not mean > 0.0:
        return mean_interval(squares).map(signed_root).doubted("below what the reference can show")

    def log_root(kept: Floats, off: float) -> float:
        square = float(kept @ squares) / float(kept.sum()) + off * shared
        return 0.5 * math.log(square) if square > 0.0 else math.nan

    if np.ptp(squares) == shared == 0.0:
        return few(Interval(math.sqrt(mean), math.sqrt(mean), math.sqrt(mean)), squares.size)
    return _measured(log_root, squares.size)


def _measured(log_error: Callable[[Floats, float], float], repeats: int) -> Interval:
    """Return an error as it was measured over all repeats, with the interval of `interval_of`.

    ``log_error`` takes the arguments of `interval_of`'s statistic. The value that the jackknife corrects for curvature
    is not used: after one bad run of a few it is far from the root mean square, which maps and captions show.
    """
    found, value = interval_of(log_error, repeats), log_error(np.ones(repeats), 0.0)
    return replace(found, value=value, low=min(found.low, value), high=max(found.high, value)).map(exp)
