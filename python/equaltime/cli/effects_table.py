"""Output of ``equaltime effects``: the effects that make a scene slow, and effects that could be left out."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Final

from rich.table import Table

from equaltime.cli.messages import MOST_LINES, WAYS, plain_console, print_line
from equaltime.pricing import Price, PriceList
from equaltime.quoting.light_parts import name_and_place
from equaltime.rendering.stated import other_depth
from equaltime.scene.effects.kinds import Effect
from equaltime.statistics.intervals import Interval
from equaltime.words import percent

__all__ = ["print_effects"]

_MOST_REASONS = 3
_MOST_LIGHTS = 3
_OTHER_LINES = 8
"""Lines beside the rows of the table: two of the answer, heading, meaning of `_NONE`, two below, other depth, what
``-v`` adds."""
_FAR: Final = 0.1
"""Largest relative error of the picture without an effect at which leaving it out is proposed: beyond, the picture is
clearly another one."""
_WORTH: Final = 0.05
"""Smallest share of the time to the same error that a proposed step saves, at the lower ends of the intervals. For
less, a picture should not be off."""
_MUCH: Final = 0.5
"""Smallest share of the noise of an effect at which its sentence in `_HINTS` is told: below, little is gained."""
_TOLD: Final = 0.05
"""Smallest share of the noise at which the short answer names light that the camera sees without a surface between."""
_ALL: Final = 0.95
"""Smallest share of the noise of an effect that cannot be left out at which the answer names lights and surfaces
instead: all light meets such an effect."""
_HINTS: Final = {
    "point_lights": "A larger, softer light in place of a point or a sun{option} makes less noise, as does rougher "
    "metal (alpha).",
}
"""Sentences on effects that cannot be left out: a change of the scene that makes less noise."""
_NONE = "none measurable"
_NONE_MEANS = f"{_NONE}: the lower end of the 95 % interval is 0 or less."
_SHARES = {
    "length": "by the length of the path (2: direct light)",
    "way": "by how the light was found",
    "bsdf": "by the BSDF that the light of a source falls on",
    "surface": "by the surface that the light of a source falls on",
    "light": "by the light",
}


def print_effects(found: PriceList, name: str, command: str, verbose: bool, softens: str = "") -> None:
    """Print which effects (features such as media) make the scene ``name`` slow, and which could be left out.

    ``command`` renders the scene, and gets the option that leaves an effect out. ``softens`` is the option for a larger
    sun, or empty if the scene has none. The output has at most `MOST_LINES` lines, unless ``verbose`` asks for all
    numbers.
    """
    console = plain_console()
    for line in (_answer(found, name, softens), _proposal(found, command)):
        print_line(console, line)
    priced = [price for price in found.prices if price.instead is not None]
    rows = list(found.prices) if verbose else sorted(priced, key=_cost, reverse=True)[: MOST_LINES - _OTHER_LINES]
    lines = [*(_everything(found) if verbose else _short(found, len(priced) - len(rows)))]
    cells = []
    if rows:
        table = _table(rows)
        console.print(table)
        cells = [str(cell) for column in table.columns for cell in column.cells]
    if any(_NONE in text for text in (*cells, *lines)):
        print_line(console, _NONE_MEANS)
    for line in lines:
        print_line(console, line)


def _cost(price: Price) -> float:
    """Return a number by which effects are ordered: the larger of the measurable shares of time and noise."""
    return max(_value(price.time), _value(price.variance))


def _value(share: Interval | None) -> float:
    return share.value if share is not None and _measurable(share) else 0.0


def _measurable(share: Interval) -> bool:
    return math.isfinite(share.value) and share.low > 0.0


def _answer(found: PriceList, name: str, softens: str) -> str:
    """Return sentences on the effect that costs most, and on the costliest one that could be left out.

    If all light meets the former, the first sentence names the light and the surface that make most of the noise.
    """
    costly = [price for price in sorted(found.prices, key=_cost, reverse=True) if _cost(price) > 0.0]
    removable = next((price for price in costly if price.instead is not None), None)
    if not costly:
        return f"{name}: no effect has a measurable cost (the lower end of every 95 % interval is 0 or less)."
    said = f"What makes {name} slow: first of all {_costs(costly[0])}"
    hints = "".join(
        f" {_HINTS[price.kind.name].format(option=f' ({softens})' * bool(softens))}"
        for price in costly
        if price.kind.name in _HINTS and _value(price.variance) >= _MUCH
    )
    if costly[0] is removable:
        return f"{said}.{hints}"
    rest = f"Of what can be, first {_costs(removable)}" if removable else "Nothing that can be has a measurable cost"
    if _value(costly[0].variance) >= _ALL and (light := _light_and_surface(found)):
        return f"What makes {name} slow: first of all {light}. {_costs(costly[0])}, cannot be left out. {rest}.{hints}"
    return f"{said}; it cannot be left out. {rest}.{hints}"


def _light_and_surface(found: PriceList) -> str:
    """Return the light and the surface that make most of the noise, with their shares; empty if neither makes half."""
    said = []
    for kind, words in (("light", "the light of"), ("surface", "light that falls on")):
        what, share = next(iter(_largest(found.shares[kind])), ("", None))
        if len(found.shares[kind]) > 1 and _value(share) >= _MUCH and what != "none":
            said.append(f"{words} {_element(what)}, {_brief(share)} of the noise")
    return "; and ".join(said)


def _costs(price: Price) -> str:
    """Return an effect with its measurable shares: ``lens, 20 % ±2 of the noise and 10 % ±1 of the time``."""
    title = f" ({price.kind.title})" if price.kind.title != price.kind.name else ""
    return f"{price.kind.name}{title}, {_measured(price)}"


def _measured(price: Price) -> str:
    """Return the measurable shares of an effect: ``20 % ±2 of the noise and 10 % ±1 of the time``; else empty."""
    shares = ((price.variance, "noise"), (price.time, "time"))
    return " and ".join(f"{_brief(share)} of the {what}" for share, what in shares if _value(share))


def _proposal(found: PriceList, command: str) -> str:
    """Return a line with the step that saves most of all, what it saves, and the command that takes it.

    A step leaves an effect out, so that the picture is off by at most `_FAR`. If no step surely saves `_WORTH`, the
    line says so.
    """
    named = {price.kind.name: price for price in found.prices if price.kind.name != "long_paths"}
    if found.cut is not None:
        named[f"long_paths={str(found.cut.instead).removeprefix('truncate=')}"] = found.cut
    near = {name: price for name, price in named.items() if _is_near(price.change)}
    steps = {name: price for name, price in near.items() if _saved(price, surely=True) >= _WORTH}
    limit = f"a picture off by at most {percent(_FAR)}"
    if not steps:
        return f"Leave all effects in: for {limit}, none surely saves {percent(_WORTH)} of the time to the same error."
    name, price = max(steps.items(), key=lambda step: _saved(step[1]))
    assert price.change is not None
    off = f"it is then off by at most {percent(price.change.high)}"
    return f"For {limit}, you save most without {name}: {_measured(price)}; {off}: {command} --without {name}"


def _is_near(change: Interval | None) -> bool:
    """Tell whether a relative change of the image is at most `_FAR`, up to its upper end."""
    return change is not None and change.trusted and change.high <= _FAR


def _saved(price: Price, surely: bool = False) -> float:
    """Return the share of the time to the same error that is saved without an effect, as far as it is measurable.

    ``surely`` asks for the lower ends of the intervals.
    """
    time, noise = (
        share.low if surely and share is not None and _measurable(share) else _value(share)
        for share in (price.time, price.variance)
    )
    return 1.0 - (1.0 - time) * (1.0 - noise)


def _table(prices: list[Price]) -> Table:
    table = Table(box=None, pad_edge=False)
    table.add_column("effect", no_wrap=True)
    for heading in ("time", "noise", "memory", "without it, off by"):
        table.add_column(heading, justify="right", no_wrap=True)
    for price in prices:
        shares = [_brief(share) for share in (price.time, price.variance, price.change)]
        table.add_row(price.kind.name, *shares[:2], _memory(price.memory), shares[2])
    return table


def _memory(size: int | None) -> str:
    """Return a number of bytes in kB, MB or GB; empty if it is below 1 kB or not known."""
    if size is None or size < 1000:
        return ""
    scale, unit = next((pair for pair in ((1e9, "GB"), (1e6, "MB")) if size >= pair[0]), (1e3, "kB"))
    return f"{size / scale:.2g} {unit}" if size < 99.5 * scale else f"{size / scale:,.0f} {unit}"


def _short(found: PriceList, left: int) -> Iterator[str]:
    """Yield the lines below the table: effects that are always there, and where the noise comes from."""
    always = [
        _plainly(price.kind) + (f" ({_brief(price.variance)} of the noise)" if _value(price.variance) else "")
        for price in found.prices
        if price.instead is None
    ]
    if always:
        yield f"Always there: {', '.join(always)}."
    direct = found.shares["length"].get("2")
    said = [f"direct light {_brief(direct)}"] if direct is not None and _measurable(direct) else []
    seen = found.shares["length"].get("1")
    said += [f"seen by the camera {_brief(seen)}"] if seen is not None and _value(seen) >= _TOLD else []
    for kind, heading in (("light", "by light:"), ("surface", "falling on")):
        shares = [(what, share) for what, share in _largest(found.shares[kind]) if what != "none"]  # met no surface
        told = [f"{_element(what)} {_brief(share)}" for what, share in shares if _measurable(share)]
        if len(told) > 1:
            said.append(f"{heading} {', '.join(told[:_MOST_LIGHTS])}")
    if said:
        yield f"Noise: {'; '.join(said)}{' (shares of the noise are in doubt, see -v)' if found.doubt else ''}."
    if depth := other_depth(found.max_depth, found.scene_max_depth):
        yield f"All numbers are for {depth}."
    more = f"{left} more effects, " if left > 0 else ""
    width, height = found.size
    yield (
        f"Measured at {width}x{height}; shares differ at other sizes (--size). {len(found.free)} other effects cost "
        f"nothing here. -v shows {more}reasons, places and all shares."
    )


def _plainly(kind: Effect) -> str:
    """Return the name of an effect; for ``many_lights``, which two lights suffice to use, its title."""
    return kind.title if kind.name == "many_lights" else kind.name


def _everything(found: PriceList) -> Iterator[str]:
    """Yield what uses each effect, all shares of the noise, errors of cut paths, and how all was measured."""
    for price in found.prices:
        reasons = [str(reason) for reason in price.reasons[:_MOST_REASONS]]
        more = len(price.reasons) - len(reasons)
        words = "; ".join(reasons) + (f"; and {more:,} more" if more else "")
        end = f"without it: {price.instead}" if price.instead else "cannot be left out"
        yield f"{price.kind.name}: {price.kind.title}, for {words}; {end}"
    yield f"free, since the scene does not use them: {', '.join(found.free)}"
    for kind, title in _SHARES.items():
        if len(found.shares[kind]) > 1:
            yield f"noise {title}: {'; '.join(_shares(found.shares[kind]))}"
    if found.truncated:
        cut = "; ".join(f"{depth}: {_brief(error)}" for depth, error in found.truncated.items())
        yield f"error of paths cut at depth {cut}"
    if found.outputs:
        times = "; ".join(f"{name} {_brief(share)}" for name, share in found.outputs.items())
        yield f"time of outputs beside the image, each alone: {times}"
    if depth := other_depth(found.max_depth, found.scene_max_depth):
        yield f"all numbers are for {depth}"
    if found.doubt:
        yield f"shares of the noise are in doubt: {found.doubt}"
    width, height = found.size
    measured = f"{found.repeats} repeats of {found.samples} samples a pixel of {width}x{height}, {found.strategy}"
    yield f"noise is variance; shares and errors with their 95 % intervals, from {measured}"


def _shares(shares: Mapping[str, Interval]) -> Iterator[str]:
    """Yield the shares as text, the largest first; lengths of paths keep their order."""
    lengths = all(what.split()[0].isdigit() for what in shares)
    for what, share in shares.items() if lengths else _largest(shares):
        yield f"{WAYS.get(what, what)}{':' * lengths} {_brief(share)}"


def _largest(shares: Mapping[str, Interval]) -> list[tuple[str, Interval]]:
    return sorted(shares.items(), key=lambda item: -item[1].value)


def _element(what: str) -> str:
    """Return the name of a light or a surface, with its line if a text file describes it: ``sun (truck.toml:12)``."""
    name, place = name_and_place(WAYS.get(what, what))
    return f"{name} ({place})" if ":" in place else name


def _brief(share: Interval | None) -> str:
    """Return a share or an error with half its interval; "none measurable" if the interval includes 0."""
    if share is None:
        return ""
    if not math.isfinite(share.value):
        return "unknown"
    return f"{percent(share.value)} ±{50.0 * (share.high - share.low):.2g}" if _measurable(share) else _NONE
