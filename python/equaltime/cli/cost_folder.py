"""The command ``equaltime cost FOLDER``: runs all experiments of a folder, and writes a page on all of them."""

from __future__ import annotations

from pathlib import Path

from equaltime.cli.cost_output import as_data, recorded
from equaltime.cli.cost_progress import cost_progress
from equaltime.cli.messages import print_error
from equaltime.experiments.model.reader import check_installed
from equaltime.experiments.report.index import Card
from equaltime.experiments.run.collection import Changes, run_all
from equaltime.strict_json import json_text

__all__ = ["cost_folder"]


def cost_folder(source: Path, output: Path, changes: Changes, command: str, as_json: bool) -> int:
    """Run or continue every experiment file in the folder ``source``, with results in ``output``.

    Returns the exit code: 0 if all ran, 1 if an experiment failed, 130 after Ctrl-C. ``command`` is the command line,
    which the reports show.
    """
    check_installed()

    def tell(card: Card) -> None:
        if card.state == "failed":
            print_error(f"{card.name}: {card.problem}")
        elif not as_json:
            print(f"{card.name}: {card.summary.verdict if card.summary else f'left out: {card.problem}'}", flush=True)

    try:
        with cost_progress() as progress:
            cards = run_all(source, output, changes, progress, tell, command)
    except KeyboardInterrupt:
        print_error(f"interrupted; {recorded(output)}")
        return 130
    if as_json:
        print(json_text(as_data(cards), indent=2))
    else:
        print(f"wrote {output / 'index.html'}")
    return 1 if any(card.state == "failed" for card in cards) else 0
