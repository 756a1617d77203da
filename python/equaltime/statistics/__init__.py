"""Statistics: intervals from repeats, error curves over time, and tests of agreement. Nothing here knows of images."""
