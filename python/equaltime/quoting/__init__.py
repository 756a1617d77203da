"""Quotes: predictions, from short pilots, of a render's cost, and of where its noise is."""
