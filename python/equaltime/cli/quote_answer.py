"""Short answer of ``equaltime quote``: the error after a time, the times to errors, and where the noise comes from."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from equaltime.cli.messages import WAYS
from equaltime.quoting.law import Law
from equaltime.quoting.light_parts import short_names
from equaltime.quoting.noise_light import NoiseLight
from equaltime.quoting.noise_places import NoisePlaces
from equaltime.quoting.pilot import FEWEST, USUAL_SECONDS, Quote
from equaltime.rendering.budget import noise_within
from equaltime.rendering.stated import stated
from equaltime.statistics.in_words import count, megabytes, rounded
from equaltime.statistics.intervals import Interval
from equaltime.words import duration, percent

__all__ = ["Asked", "answer"]

_LOOKS = {0.10: "grainy, for a layout", 0.05: "some grain, for a preview", 0.02: "clean on a screen", 0.01: "for print"}
"""Errors whose times are told, and what they look like."""
_WORTH_SAYING = 0.05
"""Smallest share of error² that the short answer names."""
_MOST_LIGHTS = 3
_MUCH_SEEN = 0.25
"""Smallest share of light seen by the camera for which the answer says what to do about it."""
_TOO_WIDE = 0.5
"""Width of the 95 % interval of a doubted share of the noise from which the share is not printed."""
_EDGES = "light seen by the camera is noisy at the edges of lamps and sky, where only more samples help"
_WIDE = 4.0
"""Upper over lower end of a time's interval, beyond which the answer says how to predict the time more closely."""
_MORE = "-v tells more"
_SAME_SAMPLES = (
    "this quote has rendered these samples: a render with the same seed takes them again, and states about this error"
)
"""Line of a quote for few samples, which predicts nothing about another seed."""


@dataclass(frozen=True)
class Asked:
    """Question that ``equaltime quote`` answers. A field that is None is not asked for.

    ``seconds`` asks for the error after that time, and ``error`` for the time to reach that error. ``spp`` asks for
    error and time with that number of samples per pixel.
    """

    seconds: float | None
    error: float | None
    spp: int | None = None
    without: tuple[str, ...] = ()
    """Names of the effects (features such as media) that the render is to leave out."""


def answer(found: Quote, asked: Asked, verbose: bool = False) -> list[str]:
    """Return the answer to ``asked`` in at most twelve lines: the numbers that were asked for, then a doubt of them.

    ``verbose`` tells that details follow, so that the answer does not point to ``-v``.
    """
    lines = [*_asked(found, asked), *_less(found, asked), *_doubt(found)]
    lines += [*_biased(found), *_prices(found), *_noise(found)]
    if found.interrupted:
        lines.append(f"interrupted: the quote is from the {found.law.samples} samples a pixel until then")
    end = filter(
        None, (f"This quote took {duration(found.pilot_seconds)}", _closer(found, asked), "" if verbose else _MORE)
    )
    return [*lines, f"{'; '.join(end)}."]


def _closer(found: Quote, asked: Asked) -> str:
    """Return how to predict a small error's time more closely, if its interval is wide and a longer test may be made.

    The test takes a share of the render's time, so that quotes for different limits differ within their intervals.
    """
    smallest = min(_LOOKS)
    price = found.prices.get(smallest)
    longest = found.pilot_seconds >= USUAL_SECONDS or (asked.error is not None and asked.error <= smallest)
    if price is None or longest or price.high <= _WIDE * price.low:
        return ""
    return f"--error {100.0 * smallest:g}% predicts more closely, by a longer test"


def _less(found: Quote, asked: Asked) -> Iterator[str]:
    """Yield lines on the effects that the render leaves out, the error due to that, and effects that are not there."""
    left = found.origin.without
    if found.bias is not None:
        spp = found.spp.value
        noise = f"; noise alone: {found.law.error_at(spp):%}" if spp >= FEWEST else ""
        yield f"biased: without {', '.join(left)}, which makes {found.bias:%} of it{noise}"
    used = {name.partition("=")[0] for name in left}
    yield from (
        f"{name}: the scene does not call for it" for name in asked.without if name.partition("=")[0] not in used
    )


def _doubt(found: Quote) -> Iterator[str]:
    """Yield a line on why the numbers, times as well as errors, may be far off."""
    if found.error.doubt:
        yield f"in doubt: {found.error.doubt}"


def _asked(found: Quote, asked: Asked) -> Iterator[str]:
    """Yield one line for each number that was asked for; the first names the memory."""
    memory = f", {megabytes(found.memory.value)} of memory"
    for line in _numbers(found, asked):
        yield f"{line}{memory}"
        memory = ""
    if asked.spp is not None and FEWEST <= asked.spp <= _of_pilot(found.law):
        yield _SAME_SAMPLES


def _numbers(found: Quote, asked: Asked) -> Iterator[str]:
    law, number = found.law, stated(found.origin)
    several = sum(each is not None for each in (asked.seconds, asked.error, asked.spp)) > 1
    if asked.seconds is not None:
        spp = law.samples_in(asked.seconds) if several else found.spp
        error = law.error_at(spp.value).with_bias(found.bias) if several else found.error
        said = f"{number.noun} {error:%}{number.of_paths}, about {count(spp.value)} samples a pixel"
        if spp.value < FEWEST:
            said = _too_few(found)
        yield f"In {duration(asked.seconds)}: {said}"
    if asked.spp is not None:
        error = law.error_at(asked.spp).with_bias(found.bias) if several else found.error
        seconds = law.seconds_for(Interval(asked.spp, asked.spp, asked.spp)) if several else found.seconds
        said = f"{number.noun} {error:%}{number.of_paths}" if asked.spp >= FEWEST else _too_few(found)
        samples = f"{count(asked.spp)} sample{'s' * (asked.spp != 1)}"
        yield f"With {samples} a pixel: {said}" + (f" after {seconds:s}" if asked.spp >= FEWEST else "")
    if asked.error is not None:
        noise = noise_within(asked.error, found.bias)
        spp = law.samples_until(noise) if several and noise is not None else found.spp
        seconds = law.seconds_for(spp) if several else found.seconds
        said = f"{number.noun}{number.of_paths} surely below {percent(asked.error)} after {seconds:s}"
        yield f"{said[0].upper()}{said[1:]}, about {count(spp.value)} samples a pixel"


def _of_pilot(law: Law) -> float:
    """Return the samples per pixel of the test render behind a quote."""
    return float(law.before[0][0] if law.before else law.samples)


def _too_few(found: Quote) -> str:
    least = found.law.seconds_for(Interval(FEWEST, FEWEST, FEWEST))
    noun = stated(found.origin).noun
    return f"no {noun} can be known: it takes {FEWEST} samples a pixel, which take {least:s}"


def _biased(found: Quote) -> Iterator[str]:
    """Yield a line on the part of the error that the number lacks, if any."""
    number = stated(found.origin)
    by = f"biased: {found.origin.strategy}" if number.by_strategy else ""
    if told := "; ".join(filter(None, (by, number.missing))):
        yield told


def _prices(found: Quote) -> Iterator[str]:
    """Yield a table of errors and their times.

    An error that the pilot has reached takes less time than the pilot. An error below the upper limit of the bias
    is not surely reached, only by the noise.
    """
    law = found.law
    pilot = _of_pilot(law)
    reached = f"under {duration(law.seconds_for(Interval(pilot, pilot, pilot)).value)}"
    times = {error: f"{found.prices[error]:s}" if error in found.prices else reached for error in sorted(_LOOKS)[::-1]}
    for error in (error for error in times if noise_within(error, found.bias) is None):
        times[error] = f"not surely; noise alone: {law.seconds_for(law.samples_until(error)):s}"
    width = max(map(len, times.values()))
    yield f"How long until the {stated(found.origin).noun} is surely below"
    yield from (f"  {percent(error):>5}   {time:<{width}}   {_LOOKS[error]}" for error, time in times.items())


def _noise(found: Quote) -> Iterator[str]:
    """Yield a line on where the noise is, and one on the light that makes it."""
    if found.places is not None:
        yield f"Where the noise is: {_place(found.places)}"
    if found.light is not None:
        yield f"Which light makes it: {_light(found.light)}"


def _place(places: NoisePlaces) -> str:
    held, single = places.rectangle, places.single.value
    if held.stands_out:
        across, down = (f"{first} to {last}" for first, last in (held.x, held.y))
        words = f"half of it in {rounded(100.0 * held.area)} % of the picture (x {across}, y {down})"
    else:
        words = "all over the picture"
    return f"{words}; {rounded(100.0 * single)} % in single bright pixels" if single > _WORTH_SAYING else words


def _light(light: NoiseLight) -> str:
    if not light.direct.known:
        return "too few paths to tell"
    ways = {"direct": light.direct, "indirect": light.indirect, "seen by the camera": light.seen}
    if light.doubt and max(way.high - way.low for way in ways.values()) > _TOO_WIDE:
        return "a few bright samples make too much of it to tell (see -v)"
    lamps, surfaces = (
        {WAYS.get(name, name): shares[what] for what, name in short_names(shares).items()}
        for shares in (light.kinds["light"], light.kinds["surface"])
    )
    straight = surfaces.pop(WAYS["none"], None)  # falls on no surface, and is told as seen
    whole = 1.0 if straight is None else 1.0 - straight.value
    last = f"falling on {_largest(surfaces, whole)}" if len(surfaces) > 1 and whole >= _WORTH_SAYING else ""
    edges = _EDGES if light.seen.value >= _MUCH_SEEN else ""
    told = "; ".join(filter(None, (_largest(ways), edges, _largest(lamps) if len(lamps) > 1 else "", last)))
    return f"{told} (in doubt, see -v)" if light.doubt else told


def _largest(shares: Mapping[str, Interval], whole: float = 1.0) -> str:
    """Return the largest shares in whole per cent, and the rest of the ``whole`` if it is more than rounding."""
    ordered = sorted(shares.items(), key=lambda item: -item[1].value)[:_MOST_LIGHTS]
    told = {what: round(100.0 * min(share.value, 1.0)) for what, share in ordered if share.value >= _WORTH_SAYING}
    rest = round(100.0 * whole) - sum(told.values())
    return ", ".join(f"{what} {share} %" for what, share in (told | ({"the rest": rest} if rest > 1 else {})).items())
