"""Twins of hard cases whose tests stand elsewhere: the usual formula, and how it fails (README.md has the table).

Each breaks the very mark of its test: that what comes out is a number, or a weight of 1, or the right one.
"""

from __future__ import annotations

import math

import numpy as np

F = np.float32


def test_G09_bounds_do_not_notice_a_vertex_that_is_no_number() -> None:  # noqa: N802
    """The twin. A vertex that nobody refuses is in no bound: comparisons with it are all false."""
    low = math.inf
    for x in (0.5, math.nan, 0.25):
        low = x if x < low else low
    assert low == 0.25


def test_S03_a_great_density_in_place_of_none_leaves_light_to_the_other_technique() -> None:  # noqa: N802
    """The twin. A mirror with a density of a million has no weight of 1 beside a light whose own is large."""
    mirror, light = F(1e6), F(3e6)
    assert mirror**2 / (mirror**2 + light**2) < 0.2


def test_S06_within_a_ball_the_angle_of_its_cone_is_no_number() -> None:  # noqa: N802
    """The twin."""
    radius, distance = F(1), np.nextafter(F(1), F(0))
    with np.errstate(invalid="ignore"):
        assert np.isnan(np.sqrt(F(1) - (radius / distance) ** 2))


def test_S07_in_a_lamp_s_plane_the_density_per_solid_angle_is_infinite() -> None:  # noqa: N802
    """The twin."""
    with np.errstate(divide="ignore", invalid="ignore"):
        density = F(4) / F(0)
        assert np.isinf(density)
        assert np.isnan(density * F(0))


def test_S08_points_drawn_over_a_lamp_that_touches_have_a_variance_that_grows_with_what_is_seen() -> None:  # noqa: N802
    """Between two squares at a right angle that share an edge, by their areas: the square of cosθ cosθ' / (π d²)."""
    rng = np.random.default_rng(1)
    x, y, u, z = rng.random((4, 1_000_000))
    d2 = x * x + (y - u) ** 2 + z * z
    integrand = x * z / (np.pi * d2 * d2)
    assert abs(integrand.mean() / 0.200044 - 1) < 0.02
    # of a finite second moment, the largest of a million samples would be a small part
    assert (integrand**2).max() > 0.01 * (integrand**2).sum()


def test_E04_one_sample_that_is_no_number_takes_the_whole_pixel() -> None:  # noqa: N802
    """The twin."""
    assert np.isnan(np.mean([1.0, 2.0, math.nan, 1.5]))


def test_E05_black_samples_have_no_spread_so_that_simple_rules_stop_at_once() -> None:  # noqa: N802
    """The twin. Of pixels that one path in fifty lights, three of four have sixteen black samples first."""
    samples = np.random.default_rng(1).random((10_000, 16)) < 0.02
    assert (samples.std(axis=1) == 0).mean() > 0.7


def test_E11_errors_relative_to_the_pixel_alone_are_infinite_at_black_ones() -> None:  # noqa: N802
    """The twin."""
    with np.errstate(divide="ignore"):
        assert np.isinf(F(1e-6) / F(0))
