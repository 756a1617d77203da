"""The film: moments of pixels, error estimates, and adaptive sample counts."""
