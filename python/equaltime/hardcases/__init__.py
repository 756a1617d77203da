"""The hard cases: small scenes that test a renderer on the user's own machine.

Each case knows its correct image: the mean is known in closed form, or a changed scene must give the same bits.

`cases` has the list, `judge` the criteria of passing, `subjects` the renderers. With random seeds, a correct renderer
fails at least one case of known mean with the probability `equaltime.hardcases.judge.LEVEL`. A case has the same limit
if only some cases are run.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, field
from time import perf_counter
from typing import Any

from equaltime.hardcases.cases import CASES, Case, chosen
from equaltime.hardcases.judge import LEVEL, Outcome
from equaltime.hardcases.subjects import MitsubaSubject, OurSubject, PeerName
from equaltime.machine import machine
from equaltime.rendering.core import build_facts
from equaltime.strict_json import fields_to_json
from equaltime.words import Shown, duration

__all__ = ["CASES", "CaseReport", "SelfTest", "selftest"]


@dataclass(frozen=True)
class CaseReport:
    """Outcomes of one case of the self-test: equaltime's, and that of the peer (another renderer) if there is one."""

    case: Case
    ours: Outcome
    theirs: Outcome | None
    """Outcome of the peer (another renderer); None without a peer, or if the case tests a guarantee that only equaltime
    gives."""

    def as_dict(self) -> dict[str, Any]:
        """Return the case and its outcomes as JSON data."""
        case, found = self.case, self.ours.as_dict()
        peer = {} if self.theirs is None else {"peer": self.theirs.as_dict()}
        return {"id": case.id, "name": case.name, "stresses": case.stresses, "scene": case.scene, **found, **peer}


@dataclass(frozen=True, repr=False)
class SelfTest(Shown):
    """Outcome of `selftest`: its cases, its duration in seconds, the machine and the build."""

    cases: tuple[CaseReport, ...]
    seconds: float
    peer: str | None
    """Name and version of the other renderer that ran beside equaltime (peer); None if there was none."""
    machine: Mapping[str, Any] = field(hash=False)
    build: Mapping[str, Any] = field(hash=False)

    def __str__(self) -> str:
        failed = [case.case.id for case in self.cases if not case.ours.passed]
        count = f"{len(self.cases) - len(failed)} of {len(self.cases)} cases passed in {duration(self.seconds)}"
        return "\n".join([count, *([f"failed: {', '.join(failed)}"] if failed else [])])

    @property
    def passed(self) -> bool:
        """Whether equaltime passed every case; failures of the other renderer that ran beside it do not count."""
        return all(case.ours.passed for case in self.cases)

    def as_dict(self) -> dict[str, Any]:
        """Return the outcomes of all cases, with machine and build, as JSON data."""
        return {**fields_to_json(self), "level": LEVEL, "passed": self.passed}


def selftest(
    *,
    only: Sequence[str] = (),
    peer: PeerName | None = None,
    threads: int = 0,
    progress: Callable[[float], object] | None = None,
) -> SelfTest:
    """Run the hard cases, and compare each rendered image with its known image.

    Parameters
    ----------
    only
        Ids (``T1``) or names of cases; all cases if empty.
    peer
        Name of another renderer to run on the same scenes, such as ``mitsuba``; None for none.
    threads
        Worker threads; 0 for one per processor.
    progress
        Called after every case with the completed share of the cases, in (0, 1].

    Raises
    ------
    ValueError
        If `only` has an unknown id or name, or `peer` is unknown.
    PeerError
        If the peer is not installed.

    Examples
    --------
    >>> et.selftest(only=["G13"]).passed
    True
    """
    if peer not in (None, "mitsuba"):
        raise ValueError(f"unknown peer '{peer}'; known is mitsuba")
    begin, wanted = perf_counter(), chosen(only)
    if peer is None:
        reports = tuple(_run(wanted, OurSubject(threads), None, progress))
        return SelfTest(reports, perf_counter() - begin, None, machine(), build_facts())
    with closing(MitsubaSubject(threads)) as other:
        name = other.start()
        reports = tuple(_run(wanted, OurSubject(threads), other, progress))
    return SelfTest(reports, perf_counter() - begin, name, machine(), build_facts())


def _run(
    wanted: Sequence[Case],
    subject: OurSubject,
    other: MitsubaSubject | None,
    progress: Callable[[float], object] | None,
) -> Iterator[CaseReport]:
    for number, case in enumerate(wanted, 1):
        ours = subject.outcome(case)
        yield CaseReport(case, ours, None if other is None or not case.for_peers else other.outcome(case))
        if progress is not None:
            progress(number / len(wanted))
