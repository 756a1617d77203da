"""Runs of an experiment that other machines take: one run on a machine at a time, first repeats first."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

from equaltime.cluster.tasks import Ground, Machine
from equaltime.errors import ExperimentError, Problem, RenderError
from equaltime.experiments.model.experiment import Experiment
from equaltime.experiments.run.record import Key
from equaltime.experiments.run.single_run import RunOrder
from equaltime.experiments.run.stage import FinishedRun, perform
from equaltime.strategy import Strategy

if TYPE_CHECKING:  # not everyone has Dask
    from equaltime.cluster.machines import Machines

__all__ = ["check_spread", "finished_runs"]

_MOST_LOSSES = 4
"""Machines that may be lost during one run. One more is probably ended by the run, such as by its memory."""


def check_spread(experiment: Experiment) -> None:
    """Raise `ExperimentError` if strategies of an experiment cannot run elsewhere: their programs stand here alone."""
    foreign = [entry.label for entry in experiment.strategies if entry.strategy is None]
    if foreign:
        text = (
            f"{', '.join(foreign)}: other renderers and estimators in Python run on this machine alone; leave out "
            "--cluster (cluster=), or name other strategies with --strategies"
        )
        raise ExperimentError((Problem("strategies", text),))


def finished_runs(
    machines: Machines,
    keys: Sequence[Key],
    order_of: Callable[[Key], RunOrder | None],
    grounds: Mapping[str, Ground],
    strategies: Mapping[str, Strategy],
    told: Callable[[Key, int], object],
) -> Iterator[tuple[Key, Machine, FinishedRun]]:
    """Let machines take runs, and yield each one with its machine when it is finished.

    A machine without a run takes one of the lowest repeat. Among these it takes the strategy that it has run least
    often on the scene, so that a slower machine does not favour a strategy.

    Parameters
    ----------
    keys
        The missing runs in their order.
    order_of
        Returns the order of a run; None as long as a run must wait for the first repeat.
    grounds, strategies
        Scenes with references by name, and strategies by label.
    told
        Called with a run and the number of machines when a machine takes the run.

    Raises
    ------
    RenderError
        If no machine is left, or a run has lost several machines.
    """
    waiting, running, losses = list(keys), 0, Counter[Key]()
    taken = Counter[tuple[str, str, str]]()
    while waiting or running:
        machines.look()
        for machine in machines.free:
            ready = [key for key in waiting if order_of(key) is not None]
            if not ready:
                break
            key = _next(ready, machine, taken)
            waiting.remove(key)
            taken[machine.address, *key[:2]] += 1
            machines.give(key, machine, grounds[key[0]], perform, order_of(key), strategies[key[1]])
            running += 1
            told(key, len(machines.present))
        for end in machines.ended():
            running -= 1
            if end.result is not None:
                yield end.name, end.machine, end.result
                continue
            waiting.insert(0, end.name)
            taken[end.machine.address, *end.name[:2]] -= 1
            losses[end.name] += end.lost
            if losses[end.name] > _MOST_LOSSES:
                raise RenderError(f"{_named(end.name)} ended several machines in turn, perhaps for lack of memory")


def _next(ready: Sequence[Key], machine: Machine, taken: Mapping[tuple[str, str, str], int]) -> Key:
    """Return the run of the lowest repeat whose strategy the machine has run least often on the scene."""
    return min(ready, key=lambda key: (key[2], taken[machine.address, *key[:2]]))


def _named(key: Key) -> str:
    scene, label, repeat = key
    return f"repeat {repeat} of {label} on {scene}"
