"""What the core does with films and images beside rendering: arithmetic, and what samples have missed."""

from equaltime._core import (
    box_sum,
    error_contributions,
    join_replicates,
    lamps_in_sight,
    merge_moments,
    nearest_mean,
    sample_deviations,
    standard_errors,
    unshadowed,
)

__all__ = [
    "box_sum",
    "error_contributions",
    "join_replicates",
    "lamps_in_sight",
    "merge_moments",
    "nearest_mean",
    "sample_deviations",
    "standard_errors",
    "unshadowed",
]
