"""Other renderers as subjects of an experiment: Mitsuba 3, and any command that writes an image."""

from __future__ import annotations
