"""Largest ratio of radiances in a scene at which tests have shown that dim lights are found."""

from __future__ import annotations

__all__ = ["FAR_APART"]

FAR_APART = 1e12
"""Largest ratio of radiances for which the tests of dim lights hold (S22)."""
