"""Long answer of ``equaltime quote -v``: everything that a quote holds, with all intervals."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from equaltime.cli.messages import WAYS
from equaltime.quoting.law import Law
from equaltime.quoting.noise_light import NoiseLight
from equaltime.quoting.noise_places import NoisePlaces
from equaltime.quoting.pilot import Quote
from equaltime.statistics.in_words import rounded
from equaltime.statistics.intervals import Interval
from equaltime.words import duration, percent

__all__ = ["details", "single_pixels"]

_WORTH_TELLING = 0.01
"""Smallest share of error² that is printed."""
_MOST_PIXELS, _MOST_PARTS = 3, 4
_KINDS = {
    "light": "by lamp",
    "bsdf": "on which BSDF",
    "surface": "on which surface",
    "way": "by how it was found",
}


def details(found: Quote, asked_why: bool | None) -> Iterator[tuple[str, str]]:
    """Yield everything that a quote predicts, as rows of a table: pairs of title and text.

    An empty title continues the row before. ``asked_why`` tells whether the light that makes the noise was asked for;
    None leaves it to the quote.
    """
    law = found.law
    yield "time", f"{found.seconds:s}"
    spp = found.spp
    yield "samples per pixel", f"{rounded(spp.value, 3)} ({rounded(spp.low, 3)} to {rounded(spp.high, 3)})"
    yield "error", f"{found.error:%}"
    memory = (rounded(1e-6 * number, 3) for number in (found.memory.value, found.memory.low, found.memory.high))
    yield "memory", "{} MB ({} to {})".format(*memory)
    exponent = f"{law.exponent:.2f} ± {1.96 * law.exponent_doubt:.2f}"
    yield "law", f"{percent(law.error)} at {law.samples} spp, falling as spp^-({exponent})"
    yield "speed", f"{duration(law.seconds_per_sample)} for one spp"
    for target, seconds in found.prices.items():
        yield f"{percent(target)} takes", f"{seconds:s}"
    if found.places is not None:
        yield from _places(found.places)
    if found.light is not None:
        yield from _light(found.light, law)
    elif asked_why is None:
        yield "which light", "not measured, for lack of time: --why measures it"


def _places(places: NoisePlaces) -> Iterator[tuple[str, str]]:
    (least, worst), *others = places.noisiest.items()
    more = "".join(f", the noisiest {percent(part)} make {_share(share)}" for part, share in others)
    yield "where", f"the noisiest {percent(least)} of the pixels make {_share(worst)} of error²{more}"
    held = places.rectangle
    if held.stands_out:
        across, down = (f"{first} to {last}" for first, last in (held.x, held.y))
        area = f"{100.0 * held.area:.2g} % of the picture"
        yield "", f"x {across}, y {down}, which is {area}, make {_share(held.share)} of error²"
    else:
        yield "", "no rectangle of the picture stands out"
    if dots := single_pixels(places):
        yield "", dots
        x, y = places.single_pixels[0]
        yield "", f"`equaltime replay SCENE --pixel {x},{y}` shows the brightest path there (same size, seed, strategy)"


def single_pixels(places: NoisePlaces) -> str:
    """Return the share of error² that bright dots make, and where the largest are; empty if they make too little."""
    if places.single.value <= _WORTH_TELLING:
        return ""
    count = len(places.single_pixels)
    words, whose = ("a single pixel makes", "its") if count == 1 else (f"{count} single pixels make", "their")
    at = "; ".join(f"{x},{y}" for x, y in places.single_pixels[:_MOST_PIXELS])
    more = "; …" if count > _MOST_PIXELS else ""
    return f"{words} {_share(places.single)} of error², far above {whose} neighbours: {at}{more}"


def _light(light: NoiseLight, law: Law) -> Iterator[tuple[str, str]]:
    if not light.direct.known:
        yield "which light", "unknown: the few paths showed no noise"
        return
    paths = {"direct": light.direct, "indirect": light.indirect, "seen by the camera": light.seen}
    yield "which light", f"{_largest(paths)} of error²"
    if _WORTH_TELLING < light.indirect.value < 1.0 - _WORTH_TELLING:
        common = f"twice their covariance {_signed(light.common)}"
        alone = f"indirect alone would make {_share(light.indirect_alone)}, all other {_share(light.alone)}"
        yield "", f"{alone}, {common}"
        without = f"without the noise of indirect light {_share(law.samples_left(light.alone))}"
        other = f"without that of all other {_share(law.samples_left(light.indirect_alone))}"
        yield "", f"{without} of the samples would do, {other}"
    for kind, title in _KINDS.items():
        shares = {WAYS.get(what, what): share for what, share in light.kinds[kind].items()}
        if sum(share.value >= _WORTH_TELLING for share in shares.values()) > 1:
            yield title, _largest(shares)
    if light.doubt:
        yield "", f"these shares are in doubt: {light.doubt}"
    width, height = light.size
    yield "", f"({light.repeats} repeats of {light.samples} spp at {width}x{height}; `equaltime effects` tells more)"


def _largest(shares: Mapping[str, Interval]) -> str:
    """Format the shares of at least 1 %, the largest first, with the number and the sum of the others."""
    ordered = sorted(shares.items(), key=lambda item: -item[1].value)
    told = [(what, share) for what, share in ordered if share.value >= _WORTH_TELLING][:_MOST_PARTS]
    words = "; ".join(f"{what} {_share(share)}" for what, share in told)
    rest = sum(share.value for what, share in ordered if (what, share) not in told)
    return f"{words}; {len(ordered) - len(told)} more {_whole(rest)} %" if rest >= _WORTH_TELLING else words


def _share(share: Interval) -> str:
    """Return a share of error² in per cent; a share that is not above 0 cannot be measured."""
    if not share.known:
        return "an unknown part"
    if not share.value > 0.0:
        return "none measurable"
    if not share.trusted:
        return f"about {_whole(share.value)} %"
    return f"{_whole(share.value)} % ({_whole(max(share.low, 0.0))} to {_whole(share.high)})"


def _signed(share: Interval) -> str:
    """Return a share that may be negative, such as a covariance."""
    return f"{_whole(share.value)} % ({_whole(share.low)} to {_whole(share.high)})" if share.trusted else "in doubt"


def _whole(share: float) -> str:
    """Format a share in whole per cent, or with two digits below 9.5 %."""
    return f"{100.0 * share:.0f}" if abs(share) >= 0.095 else f"{100.0 * share:.2g}"
