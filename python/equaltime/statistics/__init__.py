"""Statistics: intervals from repeats, error curves over time, and tests of agreement; independent of images."""
