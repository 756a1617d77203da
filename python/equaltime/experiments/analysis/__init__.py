"""From records to intervals, ratios and verdicts."""
