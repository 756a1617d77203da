"""What accuracy costs in time: metrics, statistics, experiments and their reports.

A number that is shown comes from a record, and has an interval, or says why none can be trusted.
"""

from __future__ import annotations

__all__: list[str] = []
