"""Image files, previews, and metrics that compare two images."""
