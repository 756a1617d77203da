"""The film: moments (count, mean, deviation) of each pixel's samples, error estimates, and adaptive sample counts."""
