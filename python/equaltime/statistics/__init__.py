"""Statistics: intervals from repeats, error curves over time, and tests whether two renderers agree."""
