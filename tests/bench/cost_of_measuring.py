"""What it costs that a render knows its error: statistics of the film and estimates, over the time of the render.

Rendering is timed by the wall clock, on all threads; measuring is what `equaltime.render` spends after the last sample
(statistics of pixels, standard errors, the error of the image), and what its progress shows while it renders.
"""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter
from types import ModuleType
from typing import Any

from measuring import SHIPPED, arguments, print_conditions, text

import equaltime as et
from equaltime.rendering import passes, result, session
from equaltime.statistics.intervals import median_interval


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--size", type=int, nargs=2, default=[256, 256])
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--max-depth", type=int, default=8)
    options = parser.parse_args()
    print_conditions(options)
    during = timed(passes, "statistics_so_far", "stated", "stated_error")
    after = timed(session, "statistics") + timed(result, "standard_error", "stated_error")
    for path in SHIPPED:
        scene = et.load(path).with_(size=tuple(options.size), max_depth=options.max_depth)
        shares: list[tuple[float, float]] = []
        for number in range(options.repeats + 1):
            for spent in (*during, *after):
                spent.clear()
            render = et.render(
                scene, spp=options.spp, seed=number, threads=options.threads, observer=et.Observer.of(progress=ignore)
            )
            seconds = render.stats.phases["render"]
            if number > 0:
                shares.append((100.0 * sum(map(sum, after)) / seconds, 100.0 * sum(map(sum, during)) / seconds))
        both, end, meanwhile = (
            median_interval(column) for column in ([a + b for a, b in shares], *zip(*shares, strict=True))
        )
        print(f"  {path.stem:14} {text(both)} % of the render: {text(end)} % at its end, {text(meanwhile)} % meanwhile")


def timed(module: ModuleType, *names: str) -> list[list[float]]:
    """Let functions that a module calls note how many seconds they take, each in a list of its own."""
    lists: list[list[float]] = []
    for name in names:
        lists.append(spent := [])
        setattr(module, name, _noting(getattr(module, name), spent))
    return lists


def _noting(function: Callable[..., Any], spent: list[float]) -> Callable[..., Any]:
    def call(*arguments: Any, **named: Any) -> Any:
        begin = perf_counter()
        value = function(*arguments, **named)
        spent.append(perf_counter() - begin)
        return value

    return call


def ignore(progress: object) -> None:
    """Want a progress, as the command line does."""


if __name__ == "__main__":
    main()
