"""The command ``equaltime quote``: predicts time or error of a render."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Annotated

import typer
from rich.table import Table

from equaltime.cli.messages import WAYS, plain_console, print_json, print_warnings
from equaltime.cli.options import (
    AsJson,
    Crop,
    Define,
    ErrorTarget,
    MaxDepth,
    SceneFile,
    Seed,
    Size,
    StrategyWords,
    Substitute,
    Threads,
    Time,
    parse_definitions,
)
from equaltime.cli.progress import progress_bar
from equaltime.quoting.law import Law
from equaltime.quoting.noise_light import NoiseLight
from equaltime.quoting.noise_places import NoisePlaces
from equaltime.quoting.pilot import Quote
from equaltime.quoting.quote import quote as quote_scene
from equaltime.rendering.stated import Stated, stated
from equaltime.scene import load_file
from equaltime.statistics.intervals import Interval
from equaltime.words import duration, percent

__all__ = ["quote"]

_WORTH_TELLING = 0.01
"""Smallest share of error² that is printed."""
_MOST_PIXELS, _MOST_PARTS = 3, 4
_KINDS = {"light": "by lamp", "bsdf": "by last surface", "way": "by how it was found"}


def quote(
    scene: SceneFile,
    error: ErrorTarget = None,
    time: Time = None,
    size: Size = None,
    crop: Crop = None,
    max_depth: MaxDepth = None,
    strategy: StrategyWords = "best",
    seed: Seed = 0,
    threads: Threads = 0,
    define: Define = None,
    substitute: Substitute = False,
    why: Annotated[
        bool | None,
        typer.Option(
            "--why/--no-why",
            show_default=False,
            help="Tell which light makes the noise, even if that takes a second pilot as long as the first; or never. "
            "By default, if there is room for it in a twentieth of the work.",
        ),
    ] = None,
    as_json: AsJson = False,
) -> int:
    """Predict the time to an error, or the error after a time, before rendering.

    First renders a pilot: a twentieth of the work, at most ten seconds, but at least 8 samples per pixel. Also
    renders some pixels with all their samples. Reports how fast the error falls, where in the image the error is
    large, and which light causes the error.


    For instance:

    * `equaltime quote scene.toml --error 2%`

    * `equaltime quote scene.toml --time 30s --size 1920x1080`
    """
    if (error is None) == (time is None):
        raise typer.BadParameter("give --error or --time, one of them")
    loaded = load_file(scene, parse_definitions(define or ()), substitute=substitute)
    print_warnings(loaded)
    loaded = loaded.with_(size=size, crop=crop, max_depth=max_depth)
    with progress_bar(as_json) as progress:
        found = quote_scene(
            loaded,
            error=error,
            time=time,
            strategy=strategy,
            seed=seed,
            threads=threads,
            progress=progress,
            why=why,
        )
    if as_json:
        print_json(found)
    else:
        _print(found, why)
    return 0


def _print(found: Quote, why: bool | None) -> None:
    console = plain_console()
    law, number = found.law, stated(found.origin)
    table = Table(show_header=False, box=None, pad_edge=False)
    table.add_row("time", _range(found.seconds, duration))
    table.add_row("samples per pixel", _range(found.spp, "{:.3g}".format))
    table.add_row(number.noun, _range(found.error, percent))
    if number.noun != "error":
        table.add_row("which is", _of_what(found, number))
    if found.error.doubt:
        table.add_row("in doubt", found.error.doubt)
    table.add_row("memory", _range(found.memory, lambda count: f"{count / 1e6:.3g} MB"))
    speed = duration(law.seconds_per_sample)
    exponent = f"{law.exponent:.2f} ± {1.96 * law.exponent_doubt:.2f}"
    table.add_row(
        "law", f"{percent(law.error)} at {law.samples} spp, falling as spp^-({exponent}); {speed} for one spp"
    )
    if found.places is not None:
        _add_places(table, found.places)
    if found.light is not None:
        _add_light(table, found.light, law)
    elif why is None:
        table.add_row("which light", "not asked, for want of time: --why tells")
    for target, seconds in found.prices.items():
        table.add_row(f"{percent(target)} would take", _range(seconds, duration))
    table.add_row("this quote took", duration(found.pilot_seconds))
    console.print(table)


def _of_what(found: Quote, number: Stated) -> str:
    """Return the rendered paths or biased strategy that the noise refers to, and the part of the error it lacks."""
    by = f"biased: {found.origin.strategy}" if number.by_strategy else ""
    return "; ".join(filter(None, (number.of_paths.strip(), by, number.missing)))


def _add_places(table: Table, places: NoisePlaces) -> None:
    (least, worst), *others = places.noisiest.items()
    more = "".join(f", the noisiest {percent(part)} make {_share(share)}" for part, share in others)
    table.add_row("where", f"the noisiest {percent(least)} of the pixels make {_share(worst)} of error²{more}")
    held = places.rectangle
    if held.stands_out:
        across, down = (f"{first} to {last}" for first, last in (held.x, held.y))
        area = f"{100.0 * held.area:.2g} % of the picture"
        table.add_row("", f"x {across}, y {down}, which is {area}, make {_share(held.share)} of error²")
    else:
        table.add_row("", "no rectangle of the picture stands out")
    if places.single.value > _WORTH_TELLING:
        count = len(places.single_pixels)
        words = "a single pixel makes" if count == 1 else f"{count} single pixels make"
        at = "; ".join(f"{x},{y}" for x, y in places.single_pixels[:_MOST_PIXELS])
        more = "; …" if count > _MOST_PIXELS else ""
        table.add_row("", f"{words} {_share(places.single)} of error², far above those around: {at}{more}")


def _add_light(table: Table, light: NoiseLight, law: Law) -> None:
    if not light.direct.known:
        table.add_row("which light", "no noise was seen by so few paths")
        return
    paths = {"direct": light.direct, "indirect": light.indirect, "seen by the camera": light.seen}
    table.add_row("which light", f"{_largest(paths)} of error²")
    if _WORTH_TELLING < light.indirect.value < 1.0 - _WORTH_TELLING:
        common = f"twice their covariance {_share(light.common)}"
        alone = f"indirect alone would make {_share(light.indirect_alone)}, all other {_share(light.alone)}"
        table.add_row("", f"{alone}, {common}")
        without = f"without the noise of indirect light {_share(law.samples_left(light.alone))}"
        other = f"without that of all other {_share(law.samples_left(light.indirect_alone))}"
        table.add_row("", f"{without} of the samples would do, {other}")
    for kind, title in _KINDS.items():
        shares = {WAYS.get(what, what): share for what, share in light.kinds[kind].items()}
        if sum(abs(share.value) >= _WORTH_TELLING for share in shares.values()) > 1:
            table.add_row(title, _largest(shares))
    if light.doubt:
        table.add_row("", f"these shares are in doubt: {light.doubt}")
    width, height = light.size
    table.add_row(
        "",
        f"({light.repeats} repeats of {light.samples} spp at {width}x{height}; `equaltime effects` tells more)",
    )


def _largest(shares: Mapping[str, Interval]) -> str:
    """Format the shares of at least 1 %, the largest first, with the number and the sum of the others."""
    ordered = sorted(shares.items(), key=lambda item: -item[1].value)
    told = [(what, share) for what, share in ordered if abs(share.value) >= _WORTH_TELLING][:_MOST_PARTS]
    words = "; ".join(f"{what} {_share(share)}" for what, share in told)
    rest = sum(share.value for what, share in ordered if (what, share) not in told)
    return f"{words}; {len(ordered) - len(told)} more {_whole(rest)} %" if abs(rest) >= _WORTH_TELLING else words


def _share(share: Interval) -> str:
    if not share.known:
        return "an unknown part"
    if not share.trusted:
        return f"about {_whole(share.value)} %"
    return f"{_whole(share.value)} % [{_whole(share.low)}, {_whole(share.high)}]"


def _whole(share: float) -> str:
    """Format a share in whole per cent, or with two digits below 9.5 %."""
    return f"{100.0 * share:.0f}" if abs(share) >= 0.095 else f"{100.0 * share:.2g}"


def _range(estimate: Interval, words: Callable[[float], str]) -> str:
    if not estimate.high > estimate.low:
        return words(estimate.value)
    return f"{words(estimate.value)} [{words(estimate.low)}, {words(estimate.high)}]"
