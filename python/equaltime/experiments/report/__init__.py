"""Reports: one self-contained HTML page per experiment, with figures as PDF and PNG beside it.

`page` assembles the parts that the other modules make of a `Summary`: curves, tables, pictures, maps, sentences. The
files in ``template/`` are its HTML, style and script; they are copied into the page, which loads no other files.
"""

from __future__ import annotations

from equaltime.experiments.report.page import write_report

__all__ = ["write_report"]
