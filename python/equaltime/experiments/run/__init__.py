"""Runs experiments, and records each result so that an interrupted experiment can be continued."""
