"""The command ``equaltime selftest``: runs the hard cases on this machine."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, get_args

import typer
from rich.table import Table
from rich.text import Text

from equaltime.cli.messages import plain_console, print_json, print_line
from equaltime.cli.options import AsJson, Threads, Verbose
from equaltime.cli.progress import progress_bar
from equaltime.hardcases import CaseReport, SelfTest
from equaltime.hardcases import selftest as run
from equaltime.hardcases.judge import Outcome
from equaltime.hardcases.subjects import PeerName

__all__ = ["selftest"]

_WIDTH_OF_FILES = 132
_MANY_ULP = 2.0**20


def selftest(
    only: Annotated[
        list[str] | None,
        typer.Option("--only", metavar="ID", show_default=False, help="Run this case, by id or name; may be repeated."),
    ] = None,
    peer: Annotated[
        str | None,
        typer.Option(metavar="RENDERER", show_default=False, help="Run the same scenes through mitsuba too."),
    ] = None,
    threads: Threads = 0,
    as_json: AsJson = False,
    verbose: Verbose = False,
) -> int:
    """Run the hard cases on this machine: small scenes whose correct images are known.

    Either the mean value is known in closed form, or a changed scene must give the same bits. Seeds are fixed. With
    other seeds, a correct renderer would fail at least one case once in a thousand runs. The exit code is 1 if
    equaltime fails a case; results of another renderer do not affect the exit code.


    For instance: `equaltime selftest --only G3 --peer mitsuba`
    """
    if peer not in (None, *get_args(PeerName)):
        raise typer.BadParameter(f"unknown renderer '{peer}'; known is {', '.join(get_args(PeerName))}")
    try:
        with progress_bar() as progress:
            report = run(only=tuple(only or ()), peer=peer, threads=threads, progress=progress)  # type: ignore[arg-type]  # looked at above
    except ValueError as error:
        raise typer.BadParameter(str(error)) from error
    if as_json:
        print_json(report)
    else:
        _print(report, verbose)
    return 0 if report.passed else 1


def _print(report: SelfTest, verbose: bool) -> None:
    """Print how many cases passed and failed, and the failed cases in full; all cases if ``verbose``."""
    console = plain_console()
    if not console.is_terminal:
        console.width = _WIDTH_OF_FILES
    for line in _summary(report):
        print_line(console, line)
    cases = report.cases if verbose else [case for case in report.cases if not case.ours.passed]
    if cases:
        console.print(_table(cases, report.peer))
    for line in _failures(report.cases):
        print_line(console, line)
    if not verbose:
        print_line(console, "-v shows all cases, with expected and found values", "dim")


def _table(cases: Sequence[CaseReport], peer: str | None) -> Table:
    table = Table(box=None, pad_edge=False)
    table.add_column("case", no_wrap=True)
    for heading in ("what",) if peer else ("what", "stresses"):
        table.add_column(heading, overflow="fold", min_width=12)
    for heading in ("expected", "got", "off by", "", *((peer, "off by", "") if peer else ())):
        table.add_column(heading, justify="right", no_wrap=True)
    for case in cases:
        table.add_row(*_cells(case, peer is not None))
    return table


def _cells(report: CaseReport, beside: bool) -> tuple[str | Text, ...]:
    case, ours = report.case, report.ours
    expected = "" if ours.expected is None else f"{ours.expected:.5g}"
    if not beside:
        spread = f" ± {ours.error:.1g}" if ours.error else ""
        got, off, verdict = _outcome(ours)
        return (case.id, case.name, case.stresses, expected, f"{got}{spread}", off, verdict)
    theirs = ("", "", "") if report.theirs is None else _outcome(report.theirs)
    return (case.id, case.name, expected, *_outcome(ours), *theirs)


def _outcome(outcome: Outcome) -> tuple[str, str, Text]:
    verdict = Text("pass", style="green") if outcome.passed else Text("FAIL", style="bold red")
    if outcome.got is None:
        return "", "", verdict
    if outcome.kind == "z":
        off = f"{outcome.score:.2g} sd"
    else:
        off = f"{outcome.score:.2g} ulp" if outcome.score < _MANY_ULP else "much"
    return f"{outcome.got:.5g}", off, verdict


def _failures(cases: Sequence[CaseReport]) -> list[str]:
    """Return a line for each case that could not be rendered."""
    return [
        f"{case.case.id} {case.case.name}: {outcome.note}"
        for case in cases
        for outcome in (case.ours, case.theirs)
        if outcome is not None and outcome.note
    ]


def _summary(report: SelfTest) -> list[str]:
    """Return the answer in one line, and a second line for the other renderer."""
    failed, count = sum(not case.ours.passed for case in report.cases), len(report.cases)
    lines = [f"{count - failed} of {count} hard cases passed, {failed or 'none'} failed ({report.seconds:.0f} s)."]
    if report.peer:
        theirs = [(case.case.id, case.theirs) for case in report.cases if case.theirs is not None]
        lost = dict.fromkeys(name for name, outcome in theirs if not outcome.passed)
        failures = f"; failed: {', '.join(lost)}" if lost else ""
        passed = sum(outcome.passed for _, outcome in theirs)
        lines.append(f"{report.peer}: {passed} of {len(theirs)} passed{failures}.")
    return lines
