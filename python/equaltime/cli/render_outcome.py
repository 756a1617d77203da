"""Lines that ``equaltime render`` prints at its end: the error reached, then the time that a smaller error takes."""

from __future__ import annotations

import math
import shlex
from collections.abc import Iterator, Mapping

import numpy as np

from equaltime.cli.messages import Written, bias, headline, selects_images
from equaltime.cli.recorded import error_limit, plain, recorded_command
from equaltime.quoting.pilot import FEWEST, Quote
from equaltime.rendering.budget import LEAST_DOUBT, Looks, Stop
from equaltime.rendering.render_record import checked
from equaltime.rendering.result import Result
from equaltime.rendering.stated import asked_samples, samples_in_words, stated
from equaltime.statistics.in_words import count
from equaltime.strategy import Strategy
from equaltime.words import duration, duration_of_runs, percent

__all__ = ["details", "nothing_added", "outcome"]

_ENDS = {
    "spp": "Done",
    "time": "Time is up",
    "interrupt": "Interrupted",
    "nonfinite": "Stopped, as a sample was not a number",
    "faulty": "Stopped, as a sample raised a floating-point fault",
}
_SELECTS = (
    "a render that stops by looking at its own error favours images that have not met rare light: "
    "with caustics they are 2 % darker on average (measured); --stop fixed avoids that"
)

_FAR_BELOW = 0.75
"""Share of the wanted error below which an upper limit surprises users, who may think that the render took too long."""
_HARDLY = 0.05
"""Share of the picture below which its transparent parts may be missed: the rim of a room in small pictures has 3 %."""
_LOOKS_TOLD = 3
"""Number of looks that are told: the two that ended the render, and the one before, at which it went on."""


def outcome(
    result: Result, written: Written, quote: Quote | None, first: bool = True, resumable: bool = True
) -> Iterator[str]:
    """Yield the answer of a finished render in one line, then up to five lines.

    These tell biases, doubts, looks, files and the time to a smaller error. ``quote`` is the prediction for this
    render, from which the time follows; None if nothing was predicted. ``resumable`` tells whether the render can go
    on. ``first`` is False for later frames of an animation, which leave out why their error is better than asked for.
    """
    number, stats = stated(result.origin), result.stats
    seconds = duration_of_runs(stats.seconds, stats.runs)
    said = f"{number.noun} {result.error:%}{number.of_paths}"
    because = bias(result)
    asked = asked_samples(result.stopped_by, result.position)
    exact = ", unbiased" if because == ["unbiased"] else ""
    yield f"{_end(result)}: {said} in {seconds}, {samples_in_words(result.spp, asked)}{exact} -> {written}"
    if about := "; ".join([*(word for word in because if word != "unbiased"), *filter(None, [number.missing])]):
        yield about
    if missed := _count_missed(result) if result.stopped_by in ("spp", "time") else "":
        yield missed
    if short := _too_short(result):
        yield short
    if first and (below := _far_below(result)):
        yield below
    if result.stopped_by == "error" and selects_images(result):
        yield _SELECTS
    if opaque := _opaque(result):
        yield opaque
    if written.counted:
        yield written.counted
    if written.scale:
        yield f"{[file for file in written.files if not file.name.endswith('~')][-1]}: {written.scale}"
    yield from filter(None, [written.kept, written.replaced])
    if resumable and (missed_error := _missed_error(result)):
        yield _how_to_reach(missed_error, result, written, quote)
    elif resumable and quote is not None:
        yield from _price(result, written, quote)


def nothing_added(result: Result, written: Written) -> Iterator[str]:
    """Yield why a resumed render took no sample, if its file had all that were asked for, and how it goes on."""
    if result.stopped_by in ("spp", "count"):
        more = 2 * max(1, round(result.spp))
        had = f"the file had {count(result.spp)} samples a pixel already"
        further = _resuming(result, written, "--spp", str(more))
        yield f"nothing was added: {had}, and --spp counts all runs together; more: {further}"


def details(result: Result, phases: Mapping[str, float]) -> Iterator[str]:
    """Yield lines on a render's size, error, samples, times, speed, looks, strategy, and what it decided by itself.

    ``phases`` maps names of phases to their seconds.
    """
    yield headline(result)
    fewest, most = int(result.samples.min()), int(result.samples.max())
    yield f"pixels have {fewest} samples" if fewest == most else f"pixels have {fewest} to {most} samples"
    threads = result.stats.threads
    on = f"{result.stats.rays_per_second / 1e6:.3g} M rays/s on {threads} thread{'s' * (threads != 1)}"
    runs = {"render": result.stats.runs}  # other phases are those of this run
    times = [f"{phase} {duration_of_runs(time, runs.get(phase, 1))}" for phase, time in phases.items()]
    yield f"{', '.join(times)}; {on}"
    if result.stopped_by == "error" and not _far_below(result):  # which tells them
        yield f"last looks at the error: {_looks(result)}"
    if result.stats.cluster:
        yield result.stats.cluster
    yield f"strategy {Strategy.parse(result.origin.strategy).in_full}"
    if str(result.decision):
        yield str(result.decision)


def _opaque(result: Result) -> str:
    """Return a remark if hardly anything is transparent in a render with ``--transparent``; else empty."""
    if result.alpha is None or not result.origin.record.get("transparent"):
        return ""
    clear = 1.0 - float(result.alpha.mean(dtype=np.float64))
    if clear >= _HARDLY:
        return ""
    share = f"only {percent(clear)} of the picture" if clear > 0.0 else "nothing"
    return f"{share} is transparent: surfaces fill the picture, as in a closed room or before a ground"


def _end(result: Result) -> str:
    """Return why the render ended, in a few words."""
    stop = result.stop
    if result.stopped_by == "error" and stop is not None:
        return f"Reached {percent(stop.error if result.bias is None else math.hypot(stop.error, result.bias.high))}"
    if result.stopped_by == "count" and stop is not None:
        return f"Done with the {stop.spp} samples a pixel that a pilot chose for {percent(stop.error)}"
    if stop is not None and result.stopped_by == "time" and result.error.trusted and result.error.high <= stop.error:
        return f"Time is up, and {percent(stop.error)} is reached"
    return _ENDS[result.stopped_by]


def _too_short(result: Result) -> str:
    """Return how long the samples take that an error needs, if the time limit came before them; else empty."""
    if result.stopped_by != "time" or result.spp >= FEWEST:
        return ""
    took = f", about {duration(FEWEST * result.stats.seconds / result.spp)} here" if result.spp > 0 else ""
    return f"the time was too short: an error takes {FEWEST} samples a pixel{took}"


def _far_below(result: Result) -> str:
    """Return why a render ended far below the wanted error; empty if it did not, or if it was resumed there."""
    stop = result.stop
    if result.stopped_by != "error" or stop is None or result.error.high >= _FAR_BELOW * stop.error:
        return ""
    if Looks(result.looks[:-1]).met(stop.error):
        return ""
    return f"better than asked for, as a render goes on until two looks in a row find its error small: {_looks(result)}"


def _looks(result: Result) -> str:
    """Return the errors by which the last looks decided, and which of them single bright paths widen.

    If one is above the upper limit of the stated error, the text tells why.
    """
    limits = [
        f"{percent(look.believed)} at {look.samples}" + " (due to a bright path)" * look.widened
        for look in result.looks[-_LOOKS_TOLD:]
    ]
    more = any(look.believed > look.high for look in result.looks[-_LOOKS_TOLD:])
    why = f" (a look counts at least {LEAST_DOUBT} times the estimate)" if more else ""
    return f"at most {', '.join(limits)} samples a pixel{why}"


def _count_missed(result: Result) -> str:
    """Return a remark that another limit came before a pilot's sample count; empty without such a pilot.

    It is empty, too, if an earlier run had that count already.
    """
    stop = result.stop
    if stop is None or stop.selects:
        return ""
    if stop.spp is None:
        return "the pilot chose no sample count for the error"
    if result.position is not None and result.position[0] >= stop.spp:
        return ""
    return f"ended before the {stop.spp} samples a pixel that a pilot chose for {percent(stop.error)}"


def _missed_error(result: Result) -> Stop | None:
    """Return the error that was asked for, if another limit or Ctrl-C ended the render before it; else None."""
    stop = result.stop
    if stop is None or result.stopped_by not in ("time", "interrupt", "spp"):
        return None
    return None if result.error.trusted and result.error.high <= stop.error else stop


def _how_to_reach(stop: Stop, result: Result, written: Written, quote: Quote | None) -> str:
    """Return the command that goes on to the error that was asked for, with its time if the quote has it."""
    limit = error_limit(stop.error, result.bias, fixed=not stop.selects)
    wanted, further = limit[1].replace("%", " %"), _resuming(result, written, *limit)
    seconds = None if quote is None or result.bias is not None else quote.prices.get(stop.error)
    if seconds is None or seconds.value <= result.stats.seconds:
        return f"to reach {wanted}: {further}"
    return f"{wanted} takes {seconds:s} in all: {further}"


def _resuming(result: Result, written: Written, *limits: str) -> str:
    """Return the whole command that continues the render with these limits."""
    record = checked(result.record, written.files[0])
    if record["scene"] is None:
        return " ".join(["--resume", *limits])
    words = recorded_command(record, str(written.files[0]), ["--resume", *limits])
    return shlex.join(words + (["--exposure", plain(written.stops)] if written.counted else []))


def _price(result: Result, written: Written, quote: Quote) -> Iterator[str]:
    """Yield the time to the next smaller error of the quote, if the render ended before it.

    If the render's error is above all that the quote expected, bright paths came later, and no time can be told.
    """
    if result.stopped_by not in ("time", "interrupt", "spp") or result.bias is not None:
        return
    smaller = [(target, seconds) for target, seconds in quote.prices.items() if target < 0.9 * result.error.value]
    if smaller and result.spp >= FEWEST and result.error.value > quote.law.error_at(result.spp).high:
        target = smaller[0][0]
        yield (
            f"how long {percent(target)} takes cannot be told, since a few bright paths make most of the error: "
            f"{_resuming(result, written, '--error', f'{100.0 * target:g}%')}"
        )
        return
    for target, seconds in smaller:
        if seconds.value > result.stats.seconds:
            further = _resuming(result, written, "--error", f"{100.0 * target:g}%")
            yield f"{percent(target)} takes {seconds:s} in all: {further}"
            return
