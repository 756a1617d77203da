"""Reports: one self-contained HTML page an experiment, with figures as PDF and PNG beside it.

`page` puts together what the other modules make of a `Summary`: curves, tables, pictures, maps, sentences. The files in
``template/`` are its HTML, style and script; they are written into the page, which fetches nothing.
"""

from __future__ import annotations

from equaltime.experiments.report.page import write_report

__all__ = ["write_report"]
