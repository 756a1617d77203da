"""The film: statistics of each pixel's samples, estimates of an image's error, and adaptive sample counts."""
