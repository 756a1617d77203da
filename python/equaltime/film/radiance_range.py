"""Ratio of radiances up to which dim lights are known to be found."""

from __future__ import annotations

__all__ = ["FAR_APART"]

FAR_APART = 1e12
"""Largest ratio of radiances for which the tests of dim lights hold (S22)."""
