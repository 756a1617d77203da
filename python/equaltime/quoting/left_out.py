"""Effects (such as lens or media) that a render leaves out, and the bias due to that, measured by a pilot.

Effects are chosen by a pilot (a short render that predicts), or named by the user and only measured. The pilot renders
with and without an effect, with the same random numbers. The choice follows from sample counts and seeds, never from a
clock, so a rerun repeats the bits. The bias of several effects together is at most the sum of their single biases. The
chosen effects are measured again, all together, by random numbers that had no influence on the choice. The image's
error bar includes that measurement.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TypeVar

from equaltime.errors import EffectError
from equaltime.quoting.light_parts import measure_parts
from equaltime.quoting.pairs import Versus, run_in_turn
from equaltime.rendering.budget import noise_within
from equaltime.rendering.job import Job
from equaltime.scene import Scene
from equaltime.scene.effects.kinds import derive, kind_of
from equaltime.scene.effects.leaving import can_leave_out, leave_out, parse_names
from equaltime.scene.scene import smaller
from equaltime.statistics.intervals import Interval
from equaltime.strategy import Strategy

__all__ = ["LeftOut", "choose", "measured", "samples_to_measure"]

N = TypeVar("N")

PILOT_SAMPLES = 2**16
"""Number of samples, summed over all pixels, of each short render that measures what leaving out an effect, such as
media, changes. Each pixel gets at least one."""
MOST_A_PIXEL = 64
MOST_PIXELS = 2**14
"""Largest number of pixels of the film on which effects (features such as media) to leave out are chosen. The choice
needs light by path length, which takes kilobytes a pixel."""
REPEATS = 6
PILOTS_SEEDS = 2**63
"""Offset from a render's seed to the seed of the short renders that measure effects such as media, so that no random
numbers are shared."""


@dataclass(frozen=True)
class LeftOut:
    """A scene and a strategy without some effects, ready to render, and the resulting bias of the image.

    An effect is a feature of the scene or its light, such as media.
    """

    scene: Scene
    strategy: Strategy
    names: tuple[str, ...]
    """Names of the effects left out, such as ``media`` or ``long_paths=6``."""
    bias: Interval
    """Relative error of the image due to leaving out the features in ``names``, with its 95 % interval."""
    why: tuple[str, ...]
    """Sentences, one for each decision on an effect (feature such as media): whether it was left out, and why."""

    def job(self, job: Job) -> Job:
        """Return the job without the effects (features such as media).

        The bias uses up a part of the error that the job is to reach. The rest is left for the noise.

        Raises `EffectError` if the bias alone reaches the error that the job is to reach.
        """
        asked = job.limits.error
        noise = None if asked is None else noise_within(asked, self.bias)
        if asked is not None and noise is None:
            raise EffectError(
                f"an error of {100.0 * asked:.3g} % cannot be reached: the effects left out make {self.bias:%}"
            )
        return replace(
            job,
            scene=self.scene,
            strategy=self.strategy,
            limits=replace(job.limits, error=noise),
            without=self.names,
            bias=self.bias if self.names else None,
        )


def measured(scene: Scene, strategy: Strategy, names: tuple[str, ...], seed: int = 0, threads: int = 0) -> LeftOut:
    """Return the scene without the effects in ``names``, and the image's relative error due to leaving them out.

    An effect is a feature such as media. The error is measured by short renders with and without the effects, with
    seeds that follow from ``seed``. ``threads`` is the number of threads; 0 is one for each processor. If
    ``long_paths`` is among the names, the error includes the bias of the strategy's ``truncate``.

    Raises
    ------
    EffectError
        If an effect does not exist or cannot be left out.
    """
    strategy, names = _untruncated(strategy, names)
    present = tuple(name for name in dict.fromkeys(names) if can_leave_out(scene, strategy, name))
    why = tuple(f"{name}: the scene does not call for it" for name in names if name not in present)
    less_scene, shorter = leave_out(scene, strategy, present)
    if not present:
        return LeftOut(less_scene, shorter, (), Interval(0.0, 0.0, 0.0), why)
    versus = _compare(scene, strategy, {present: present}, seed + 2 * REPEATS, threads)[present]
    change = versus.change
    why += (f"without {', '.join(present)}: {_saved(versus)}",)
    return LeftOut(less_scene, shorter, present, Interval(change.value, change.low, change.high), why)


def _untruncated(strategy: Strategy, names: tuple[str, ...]) -> tuple[Strategy, tuple[str, ...]]:
    """Return the strategy with paths of any length, if long paths are left out, and the names with the least depth."""
    depth = parse_names(names).get("long_paths")
    if depth is None or strategy.truncate is None:
        return strategy, names
    others = tuple(name for name in names if not name.startswith("long_paths"))
    whole = Strategy.model_validate(strategy.model_dump() | {"truncate": None})
    return whole, (*others, f"long_paths={min(depth, strategy.truncate)}")


def choose(scene: Scene, strategy: Strategy, within: float, seed: int = 0, threads: int = 0) -> LeftOut:
    """Return the scene without the effects that short renders show to matter little.

    An effect is a feature such as media. ``within`` is the largest relative error, a fraction, that leaving out all
    these effects together may cause. Effects with the least bias are left out first; the upper ends of the biases'
    intervals decide. If paths can be cut at a depth too, the other effects may use half of ``within``. Paths are then
    cut as early as the rest of ``within`` allows.

    The renders are by ``strategy``, with seeds that follow from ``seed``. ``threads`` is the number of threads; 0 is
    one for each processor.
    """
    called = derive(scene)
    candidates = [name for name in called if kind_of(name).instead and can_leave_out(scene, strategy, name)]
    cuts = "long_paths" in candidates
    single = {name: (name,) for name in candidates if name != "long_paths"}
    small = smaller(scene, MOST_PIXELS)
    found = _compare(small, strategy, single, seed, threads) if single else {}
    room, taken, why = within * (0.5 if cuts else 1.0), list[str](), list[str]()
    for name in sorted(found, key=lambda name: found[name].change.high):
        change = found[name].change
        fits = change.high <= room
        room -= change.high if fits else 0.0
        taken += [name] if fits else []
        why.append(f"{'left out' if fits else 'kept'}: {name}, {_words(change)}; {_saved(found[name])}")
    if cuts:
        depth, words = _cut(small, strategy, room + 0.5 * within, seed, threads)
        taken += [] if depth is None else [f"long_paths={depth}"]
        why.append(words)
    left = measured(scene, strategy, tuple(taken), seed, threads)
    while left.names and left.bias.high > within:
        why.append(f"kept after all: {left.names[-1]}, since together they make {left.bias:%}")
        left = measured(scene, strategy, left.names[:-1], seed, threads)
    return LeftOut(left.scene, left.strategy, left.names, left.bias, (*why, *left.why))


def _cut(scene: Scene, strategy: Strategy, room: float, seed: int, threads: int) -> tuple[int | None, str]:
    """Return the least depth whose error fits, and why."""
    parts = measure_parts(scene, strategy, REPEATS, _samples(scene), _seed(seed), threads)
    for depth, error in parts.truncated().items():
        if error.high <= room:
            return depth, f"left out: paths longer than {depth}, {_words(error)}"
    return None, "kept: paths of any length, since cutting them early enough to matter would show"


def _compare(
    scene: Scene, strategy: Strategy, variants: Mapping[N, tuple[str, ...]], seed: int, threads: int
) -> dict[N, Versus]:
    whole, less = run_in_turn(scene, strategy, variants, REPEATS, _samples(scene), _seed(seed), threads)
    return {name: Versus.of(whole, runs) for name, runs in less.items()}


def samples_to_measure(scene: Scene) -> int:
    """Return the samples per pixel that `measured` takes, of the scene with and without the effects together."""
    return 2 * REPEATS * _samples(scene)


def _samples(scene: Scene) -> int:
    _, _, width, height = scene.model.sensor.film.crop
    return max(1, min(MOST_A_PIXEL, PILOT_SAMPLES // (width * height)))


def _seed(seed: int) -> int:
    return (seed + PILOTS_SEEDS) % (2**64 - 256)


def _words(change: Interval) -> str:
    return f"{change:%} of error"


def _saved(versus: Versus) -> str:
    time = versus.time
    if not time.low > 0.0:
        return f"saves no measurable time (at most {100.0 * max(time.high, 0.0):.2g} %)"
    return f"saves {100.0 * time.value:.2g} % of the time ({100.0 * time.low:.2g} to {100.0 * time.high:.2g})"
