"""Data classes of an experiment: its settings, and the summary of its results."""
