"""Analysis of records: intervals, ratios and verdicts."""
