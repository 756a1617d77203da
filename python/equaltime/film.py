"""What the core does with films and images beside rendering: arithmetic, and what black pixels could have seen."""

from equaltime._core import box_sum, join_replicates, merge_moments, unshadowed

__all__ = ["box_sum", "join_replicates", "merge_moments", "unshadowed"]
