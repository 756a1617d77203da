"""Rendering: sessions that render pass by pass in the core, and the files of their results."""
