"""Peers, other renderers that take part in an experiment: Mitsuba 3, and any command that writes an image."""
