"""Arithmetic on films and images that the core does: it is paid for in every render."""

from equaltime._core import box_sum, join_replicates, merge_moments

__all__ = ["box_sum", "join_replicates", "merge_moments"]
