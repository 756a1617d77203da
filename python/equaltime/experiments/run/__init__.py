"""Runs experiments into records that survive any interruption."""
