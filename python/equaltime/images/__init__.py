"""Image files, previews, and metrics between images."""
