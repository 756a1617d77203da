"""Rendering: sessions of the core, pass by pass, and the files that they leave."""
