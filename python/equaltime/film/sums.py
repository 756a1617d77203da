"""Array operations of the core on films and images, and the core's searches for light that samples have missed."""

from equaltime._core import (
    MOST_PIXELS_A_SECOND_NET,
    box_sum,
    error_contributions,
    focused_light,
    join_replicates,
    lamps_in_sight,
    merge_moments,
    mirrored_lamps,
    nearest_mean,
    others_sum,
    sample_deviations,
    second_net_pixels,
    standard_errors,
    unshadowed,
)

__all__ = [
    "MOST_PIXELS_A_SECOND_NET",
    "box_sum",
    "error_contributions",
    "focused_light",
    "join_replicates",
    "lamps_in_sight",
    "merge_moments",
    "mirrored_lamps",
    "nearest_mean",
    "others_sum",
    "sample_deviations",
    "second_net_pixels",
    "standard_errors",
    "unshadowed",
]
