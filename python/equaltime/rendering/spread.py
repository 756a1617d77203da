"""Renderer whose samples other processes take, unit by unit: the film, its passes and all decisions stay here.

A pass brings the whole film from one sample count to another. It is cut into units (`equaltime.rendering.units`), which
a `Team` of processes renders in any order. All units of a pass are in the film before the next pass begins, so the
moments have the bits of a render in one process.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from dataclasses import dataclass, field
from functools import partial
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from equaltime import _core
from equaltime.errors import EqualtimeError
from equaltime.film.adaptive import PILOT
from equaltime.rendering.core import (
    REPLICATES,
    AdaptiveRenderer,
    build_info,
    decision_of,
    make_renderer,
    nets,
    second_net,
)
from equaltime.rendering.team import KeptUnit, Team
from equaltime.rendering.units import BLOCK, Recipe, Rendered, Unit, Window, place, second_place
from equaltime.scene import Scene
from equaltime.strategy import Strategy
from equaltime.strict_json import json_text

__all__ = ["AdaptiveSpreadRenderer", "SpreadRenderer", "spread_renderer", "windows"]

_MOST_PIXELS = 2**16
"""Most pixels of a unit: its moments take 5 MB, and its message less than 8 MB."""
_GOAL, _LONGEST = 1.0, 30.0
"""Seconds that a unit should take at least, if there are enough units for all processes, and at most."""
_EACH = 12
"""Units for each process in a long pass, so that all of them end nearly at once."""
_FIRST_PACE = 1e-6
"""Assumed seconds of one sample of a pixel, before any were measured."""
_AHEAD = 2
"""Units for each process that are submitted at once, so that none waits for the next."""
_POLL = 0.05
"""Most seconds between two questions whether to go on."""


@dataclass
class _Pass:
    """Units of a pass that are not in the film yet."""

    begin: int
    end: int
    waiting: list[Window] = field(default_factory=list)
    running: dict[Future[Rendered], Unit] = field(default_factory=dict)

    @property
    def done(self) -> bool:
        return not self.waiting and not self.running


class SpreadRenderer(_core.Renderer):
    """Renderer whose samples a `Team` of processes takes in units, which are windows of the film; passes stay here."""

    def spread(self, team: Team, recipe: Callable[[_core.Renderer], Recipe]) -> None:
        """Let the processes of ``team`` take the samples, from now on.

        ``recipe`` returns the settings that decide a sample's bits. This function is called once it is decided whether
        paths are split.
        """
        self._team, self._recipe = team, recipe
        self._pass: _Pass | None = None
        self._shares: NDArray[np.float32] | None = None
        self._pixel_rays = np.zeros(self.moments.shape[1:], np.uint64)
        self._gained = dict.fromkeys(("paths", "rays", "shadow_rays"), 0)
        self._bad: tuple[list[tuple[int, int, int]], list[tuple[int, int, int, str]]] = [], []
        self._processes: dict[str, int] = {}
        self._units, self._core_seconds = 0, 0.0
        self._took = _FIRST_PACE, 1  # seconds of all units, and their samples over all pixels

    @property
    def breadth(self) -> int:
        """Number of processes that take samples at once."""
        return self._team.size

    def told(self) -> str:
        """Return, in words, the numbers of processes, finished units and processor seconds so far.

        A unit is a window of the film with some samples.
        """
        left = 0 if self._pass is None else len(self._pass.waiting) + len(self._pass.running)
        units = f"{self._units} units done{f', {left} left in this pass' if left else ''}"
        return f"{self.breadth} process{'es' * (self.breadth != 1)}, {units}, {self._core_seconds:.3g} core-seconds"

    @property
    def pixel_rays(self) -> NDArray[np.uint64]:
        """Number of rays of each pixel's samples in the image, (H, W); 0 if rays are not counted."""
        return self._pixel_rays

    @property
    def nonfinite(self) -> list[tuple[int, int, int]]:
        """Samples that were NaN or infinite, as (x, y, sample index)."""
        return sorted(self._bad[0])

    @property
    def faulty(self) -> list[tuple[int, int, int, str]]:
        """Samples that raised floating-point faults, as (x, y, sample index, fault)."""
        return sorted(self._bad[1])

    @property
    def threads(self) -> int:
        """Number of threads of all processes that have rendered; before the first has, of this process."""
        return sum(self._processes.values()) or super().threads

    def set_sample_rates(self, pilot: int, rates: NDArray[np.float32]) -> None:
        """Make sample counts uneven after the first ``pilot`` samples of each pixel.

        ``rates`` (H, W) is the number of samples that each pixel then gets for one sample of the average.
        """
        self._shares = rates
        super().set_sample_rates(pilot, rates)

    def saved(self) -> None:
        """Tell the team that the film was saved, so that it may delete its own copies of finished windows."""
        self._team.saved()

    def advance(
        self,
        samples: int,
        seconds: float | None = None,
        poll: Callable[[], bool] | None = None,
        pause: float | None = None,
    ) -> bool:
        """Render until pixels have ``samples`` samples on average; return whether that count is reached.

        The call ends early after ``seconds``, after ``pause`` seconds, or when ``poll``, called often, returns False.
        Units that run when ``seconds`` are over are given up; those that run when a pause begins go on. An error of a
        unit is raised here, after all finished units have been added to the film.
        """
        now = time.monotonic()
        last, pause_at = (math.inf if limit is None else now + limit for limit in (seconds, pause))
        super().advance(0)  # lets the core decide on the roulette
        try:
            while (work := self._begun(samples)) is not None:
                if not self._run(work, last, pause_at, poll):
                    return False
                self._settle()
            return True
        except BaseException:
            self._give_up()
            raise
        finally:
            self._settle()

    def _begun(self, samples: int) -> _Pass | None:
        """Return the pass that is under way, or begin one; None if all pixels have ``samples``."""
        done, target, _ = self.position
        if self._pass is None and done < samples:
            self._team.begin()
            kept = [unit for unit in self._team.kept(self._recipe(self)) if unit.begin == done]
            end = target if target > done else max((u.end for u in kept if done < u.end <= samples), default=samples)
            self._pass = _Pass(done, end)
            self._take_kept(self._pass, kept)
            missing = self._missing(end)
            height, width = self.moments.shape[1:]
            seconds = self._pace * int(missing.sum()) * BLOCK**2 * (end - done)
            self._pass.waiting.extend(windows(missing, height, width, _parts(seconds, self._team.size)))
        return self._pass

    def _run(self, work: _Pass, last: float, pause_at: float, poll: Callable[[], bool] | None) -> bool:
        """Put units into the film until the pass is done; return False if a limit or ``poll`` ends this early."""
        while not work.done:
            while work.waiting and len(work.running) < _AHEAD * self._team.size:
                unit = self._unit(work, work.waiting.pop(0))
                work.running[self._team.submit(unit)] = unit
            ready, _ = wait(work.running, timeout=_POLL, return_when=FIRST_COMPLETED)
            for future in ready:
                rendered, unit = self._result(future), work.running.pop(future)
                self._took = self._took[0] + rendered.seconds, self._took[1] + unit.pixels * (unit.end - unit.begin)
                self._units += 1
                self._core_seconds += rendered.core_seconds
                self._put(unit.window, unit.recipe, rendered)
                self._team.keep(unit, rendered)
            if self._team.check():
                self._give_up()
            if (poll is not None and not poll()) or time.monotonic() >= last:
                self._give_up()
                return work.done
            if time.monotonic() >= pause_at:
                return work.done
        return True

    def _result(self, future: Future[Rendered]) -> Rendered:
        try:
            return future.result()
        except EqualtimeError:
            raise
        except Exception as error:  # of the engine: whatever it raises when processes end
            raise self._team.failure(error) from error

    def _unit(self, work: _Pass, window: Window) -> Unit:
        recipe = self._recipe(self)
        there, second = place(window), second_place(window, recipe.second_net)
        return Unit(
            recipe,
            window,
            work.begin,
            work.end,
            self.moments[there].copy(),
            self.second_moments[second].copy(),
            None if self._shares is None else self._shares[there[1:]].copy(),
        )

    def _put(self, window: Window, recipe: Recipe, rendered: Rendered) -> None:
        """Put a rendered unit into the film."""
        there = place(window)
        self.moments[there] = rendered.moments
        if rendered.second.size:
            self.second_moments[second_place(window, recipe.second_net)] = rendered.second
        if rendered.pixel_rays is not None:
            self._pixel_rays[there[1:]] += rendered.pixel_rays
        for name in self._gained:
            self._gained[name] += rendered.counters[name]
        self._bad[0].extend(rendered.nonfinite)
        self._bad[1].extend(rendered.faulty)
        self._processes[rendered.process] = rendered.threads

    @property
    def _pace(self) -> float:
        """Seconds that one process takes for one sample of a pixel."""
        return self._took[0] / self._took[1]

    def _give_up(self) -> None:
        """Give up the units that are not rendered yet: the next call begins them anew."""
        if (work := self._pass) is None:
            return
        for future, unit in work.running.items():
            if future.done() and not future.cancelled() and future.exception() is None:
                self._put(unit.window, unit.recipe, future.result())
            else:
                future.cancel()
                work.waiting.append(unit.window)
        work.running.clear()

    def _settle(self) -> None:
        """Tell the core where the passes stand, and what the units took."""
        if (work := self._pass) is None:
            return
        blocks = math.prod(-(-side // BLOCK) for side in self.moments.shape[1:])
        position = (work.end, work.end, 0) if work.done else (work.begin, work.end, blocks)
        if work.done:
            self._pass = None
        before, gained = self.counters, self._gained
        self._gained = dict.fromkeys(gained, 0)
        paths, rays, shadow_rays = (before[name] + gained[name] for name in ("paths", "rays", "shadow_rays"))
        _core.Renderer.resume(self, paths=paths, rays=rays, shadow_rays=shadow_rays, position=position)

    def _take_kept(self, work: _Pass, kept: Sequence[KeptUnit]) -> None:
        """Put into the film what earlier units of this pass rendered."""
        before, after, recipe = self._wanted(work.begin), self._wanted(work.end), self._recipe(self)
        for unit in kept:
            there = place(unit.window)[1:]
            if unit.end != work.end or not (_counts(self.moments)[there] == before[there]).all():
                continue
            rendered = unit.read()
            if rendered is not None and (_counts(rendered.moments) == after[there]).all():
                self._put(unit.window, recipe, rendered)

    def _missing(self, average: int) -> NDArray[np.bool_]:
        """Return for each block of the film, (rows, columns), whether some of its pixels lack samples.

        ``average`` is the mean sample count that the pixels should have.
        """
        there = _counts(self.moments) == self._wanted(average)
        for axis, side in enumerate(there.shape):
            there = np.logical_and.reduceat(there, range(0, side, BLOCK), axis=axis)
        return np.asarray(~there)

    def _wanted(self, average: int) -> NDArray[np.uint64]:
        """Return the sample count of each pixel, (H, W), if the mean count is ``average``."""
        if self._shares is None or average <= PILOT:
            return np.full(self.moments.shape[1:], average, np.uint64)
        rounds = (average - PILOT) * self._shares.astype(np.float64) / REPLICATES
        return PILOT + REPLICATES * (rounds + 0.5).astype(np.uint64)


class AdaptiveSpreadRenderer(AdaptiveRenderer, SpreadRenderer):
    """Renderer with adaptive sample counts whose samples a team of processes takes; the team renders the pilot too."""


def spread_renderer(
    scene: Scene, strategy: Strategy, seed: int, threads: int, team: Team, traps: str
) -> SpreadRenderer:
    """Return a renderer of ``scene`` by ``strategy`` with ``seed``, whose samples the processes of ``team`` take.

    ``threads`` is the number of threads of this process; 0 is one for each processor. ``traps`` is the treatment of
    floating-point faults: ``ignore`` or ``check``.
    """
    kinds = SpreadRenderer, AdaptiveSpreadRenderer
    made = cast(SpreadRenderer, make_renderer(scene, strategy, seed, threads, kinds, traps=traps))
    made.spread(team, partial(_recipe, scene, strategy, seed, traps))
    return made


def _recipe(scene: Scene, strategy: Strategy, seed: int, traps: str, renderer: _core.Renderer) -> Recipe:
    decided = decision_of(renderer, strategy).applied(strategy).model_copy(update={"adaptive": "none"})
    rays = isinstance(renderer, AdaptiveRenderer)
    build = json_text(build_info(), sort_keys=True)
    return Recipe(decided.name, seed, nets(scene, strategy), second_net(scene, strategy), rays, traps, build)


def _counts(moments: NDArray[Any]) -> NDArray[np.uint64]:
    """Return the sample count of each pixel, (H, W), from the moments of the replicates."""
    return np.asarray(moments["count"].sum(axis=0, dtype=np.uint64))


def windows(missing: NDArray[np.bool_], height: int, width: int, parts: int) -> Iterator[Window]:
    """Yield about ``parts`` windows of a film that together contain all its missing blocks and no other blocks.

    A block is 16 x 16 pixels. ``missing`` (rows, columns) is True for each block whose samples are missing. ``height``
    and ``width`` are the size of the film, in pixels. A window has at most 2^16 pixels.
    """
    most = math.isqrt(_MOST_PIXELS) // BLOCK
    side = min(max(round(math.sqrt(int(missing.sum()) / parts)), 1), most)
    rows, columns = missing.shape
    for top in range(0, rows, side):
        for left in range(0, columns, side):
            cell = missing[top : top + side, left : left + side]
            parts_of_cell = [(0, 0, *cell.shape)] if cell.all() else _runs(cell)
            for row, column, high, wide in parts_of_cell:
                y, x = (top + row) * BLOCK, (left + column) * BLOCK
                yield x, y, min(x + wide * BLOCK, width), min(y + high * BLOCK, height)


def _runs(cell: NDArray[np.bool_]) -> Iterator[tuple[int, int, int, int]]:
    """Yield row, column, height and width of each run of missing blocks in a row."""
    for row, line in enumerate(cell):
        edges = np.flatnonzero(np.diff(line.astype(np.int8), prepend=0, append=0))
        yield from ((row, int(begin), 1, int(end - begin)) for begin, end in zip(edges[::2], edges[1::2], strict=True))


def _parts(seconds: float, size: int) -> int:
    """Return the number of units for work that takes one process ``seconds``, if ``size`` processes share it."""
    wanted = min(max(seconds / _GOAL, size), _EACH * size)
    return max(1, math.ceil(wanted), math.ceil(seconds / _LONGEST))
