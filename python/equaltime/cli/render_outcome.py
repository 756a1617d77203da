"""Lines that ``equaltime render`` prints at its end: the error reached, then the time that a smaller error takes."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

from equaltime.cli.messages import Written, bias, headline, selects_images
from equaltime.quoting.pilot import Quote
from equaltime.rendering.budget import Stop
from equaltime.rendering.result import Result
from equaltime.rendering.stated import stated
from equaltime.statistics.in_words import count, error_range, time_range
from equaltime.words import duration, percent

__all__ = ["details", "outcome"]

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


def outcome(result: Result, written: Written, quote: Quote | None) -> Iterator[str]:
    """Yield the answer of a finished render in one line, then up to four lines.

    These four tell biases, doubts, files and the time to a smaller error. ``quote`` is the prediction for this render,
    from which the time follows. ``quote`` is None if nothing was predicted, or if the render cannot be continued.
    """
    number, seconds = stated(result.origin), duration(result.stats.seconds)
    said = f"{number.noun} {error_range(result.error)}{number.of_paths}"
    because = bias(result)
    exact = ", unbiased" if because == ["unbiased"] else ""
    yield f"{_end(result)}: {said} in {seconds}, {count(result.spp)} samples a pixel{exact} -> {written}"
    if about := "; ".join([*(word for word in because if word != "unbiased"), *filter(None, [number.missing])]):
        yield about
    if missed := _count_missed(result.stop) if result.stopped_by in ("spp", "time") else "":
        yield missed
    if result.stopped_by == "error" and selects_images(result):
        yield _SELECTS
    if written.scale:
        yield f"{written.files[-1 - bool(written.kept)]}: {written.scale}"
    if written.kept:
        yield written.kept
    if quote is not None:
        yield from _price(result, quote)


def details(result: Result, phases: Mapping[str, float]) -> Iterator[str]:
    """Yield lines on a render's size, error, samples, times, speed, and what the strategy decided by itself.

    ``phases`` maps names of phases to their seconds.
    """
    yield headline(result)
    fewest, most = int(result.samples.min()), int(result.samples.max())
    yield f"pixels have {fewest} samples" if fewest == most else f"pixels have {fewest} to {most} samples"
    threads = result.stats.threads
    on = f"{result.stats.rays_per_second / 1e6:.3g} M rays/s on {threads} thread{'s' * (threads != 1)}"
    yield f"{', '.join(f'{phase} {duration(time)}' for phase, time in phases.items())}; {on}"
    if result.stats.cluster:
        yield result.stats.cluster
    if str(result.decision):
        yield str(result.decision)


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


def _count_missed(stop: Stop | None) -> str:
    """Return a remark that another limit came before a pilot's sample count; empty without such a pilot."""
    if stop is None or stop.selects:
        return ""
    if stop.spp is None:
        return "the pilot chose no sample count for the error"
    return f"ended before the {stop.spp} samples a pixel that a pilot chose for {percent(stop.error)}"


def _price(result: Result, quote: Quote) -> Iterator[str]:
    """Yield the time to the next smaller error of the quote, if the render ended before it."""
    low = 0.9 * result.error.value
    if result.stopped_by in ("time", "interrupt", "spp") and result.bias is None:
        for target, seconds in quote.prices.items():
            if target < low and seconds.value > result.stats.seconds:
                yield f"{percent(target)} takes {time_range(seconds)} in all: --resume --error {100.0 * target:g}%"
                return
