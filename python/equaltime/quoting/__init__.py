"""Quotes: predictions of a render's time, error and memory, and of the sources of its noise, from short pilots."""
