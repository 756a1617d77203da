"""Reports: one self-contained HTML page per experiment, with figures as PDF and PNG beside it.

The module `page` assembles what the other modules make from a `Summary`: curves, tables, pictures, maps, sentences.
The folder ``template/`` has the HTML, style and script of the page. All are copied into the page, which loads no other
file.
"""

from __future__ import annotations

from equaltime.experiments.report.page import write_report

__all__ = ["write_report"]
