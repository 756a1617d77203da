"""Runners of experiments, which record each result, so that an interrupted experiment can be continued."""
