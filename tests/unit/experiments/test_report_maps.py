"""The maps of a report: their squares add up to the error, a planted loss is found, and chance alone is not."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from equaltime.experiments.report.gallery import choose_crops
from equaltime.experiments.report.losing import LEVEL, Losses, losses, ratio_sentence
from equaltime.experiments.report.pictures import coloured, error_map, spread_map, squares
from equaltime.images.metrics import Reference, measure
from equaltime.images.preview import reduced

SHAPE = (56, 84, 3)
REPEATS = 8

Floats = NDArray[np.float64]


def reference(seed: int = 1) -> Reference:
    """Return an uneven picture that is known exactly."""
    return Reference(np.random.default_rng(seed).uniform(0.1, 2.0, SHAPE), np.zeros(SHAPE))


def runs(seed: int, truth: Reference, noise: float | Floats = 0.1) -> Floats:
    """Return renders (K, H, W, 3) whose relative error is ``noise`` in each pixel."""
    normal = np.random.default_rng(seed).standard_normal((REPEATS, *SHAPE))
    return np.asarray(truth.mean + noise * np.sqrt(truth.denominator) * normal)


def test_the_squares_of_a_map_add_up_to_the_error_of_the_image() -> None:
    truth = reference()
    image = runs(2, truth)[:1]
    whole = measure(image[0], truth, ("relmse",))["relmse"].value
    assert float((error_map(squares(image, truth)) ** 2).mean()) == pytest.approx(whole)


def test_error_and_standard_error_agree_without_bias_and_part_with_it() -> None:
    truth = reference()
    images = runs(3, truth)
    for bias in (0.0, 0.3):
        shifted = images + bias * np.sqrt(truth.denominator)
        error = float(np.sqrt((error_map(squares(shifted, truth)) ** 2).mean()))
        spread = spread_map(shifted, truth)
        assert spread is not None
        assert float(np.sqrt((spread**2).mean())) == pytest.approx(0.1, rel=0.02)
        assert error == pytest.approx(np.hypot(0.1, bias), rel=0.02)


def test_one_run_has_no_standard_error() -> None:
    assert spread_map(runs(4, reference())[:1], reference()) is None


def test_where_a_strategy_was_made_to_lose_it_is_found_to_lose() -> None:
    truth = reference()
    noise = np.full(SHAPE, 0.1)
    noise[6:18, 9:27] = 0.9
    planted = np.zeros(SHAPE[:2], np.bool_)
    planted[6:18, 9:27] = True
    found = losses(squares(runs(5, truth, noise), truth), squares(runs(6, truth, 0.2), truth))
    assert found.worse is not None
    assert found.better is not None
    assert found.ratio is not None
    inside = np.asarray(found.spread(found.worse, SHAPE))
    assert inside[planted].all()
    assert (inside & ~planted).mean() < 0.01
    assert np.asarray(found.spread(found.better, SHAPE))[~planted].mean() > 0.95
    assert np.asarray(found.spread(found.half, SHAPE))[~planted].sum() == 0
    assert found.half_area < planted.mean()
    assert float(np.median(found.ratio[found.worse])) == pytest.approx(4.5, rel=0.1)


def test_a_loss_by_rare_samples_is_told_although_no_block_shows_it() -> None:
    """One run of eight has a bright pixel in each block: the mean error is larger, and no test of a block finds it."""
    truth = reference()
    plain = squares(runs(11, truth), truth)
    rare = squares(runs(12, truth), truth)
    rare[0, ::3, ::3] += 5.0
    told = ratio_sentence(losses(rare, plain), "mis")
    first, _, second = told.partition(" Over the whole picture ")
    assert first.startswith("Nowhere worse than mis beyond chance, ")
    assert second.startswith("its measured error is ")
    assert second.endswith("blocks where it may be chance, as where rare bright samples fell.")
    assert "whole picture" not in ratio_sentence(losses(squares(runs(13, truth), truth), plain), "mis")


def test_a_loss_that_one_block_shows_is_told_where_other_blocks_make_most_of_it() -> None:
    """The error over the whole picture is much larger, and a few blocks that are a little worse do not explain it."""
    truth = reference()
    noise = np.full(SHAPE, 0.1)
    noise[:12, :12] = 0.2
    plain = squares(runs(11, truth), truth)
    rare = squares(runs(12, truth, noise), truth)
    rare[0, 20::3, ::3] += 5.0
    found = losses(rare, plain)
    assert found.shown < 0.1
    told = ratio_sentence(found, "mis")
    assert told.startswith("Beyond chance, worse than mis in ")
    assert " Over the whole picture its measured error is " in told
    planted = losses(squares(runs(12, truth, 5.0 * noise), truth), plain)
    assert planted.shown > 0.9
    assert "whole picture" not in ratio_sentence(planted, "mis")


@pytest.mark.parametrize(
    ("factor", "words"),
    [(1.002, "with hardly more than its error"), (1.04, "with 1.04\N{MULTIPLICATION SIGN} its error")],
)
def test_a_loss_is_never_told_as_one_times_the_error(factor: float, words: str) -> None:
    one = np.full((1, 1), True)
    found = Losses(1, one, 1.0, np.full((1, 1), factor), one, ~one, factor)
    told = ratio_sentence(found, "mis")
    assert told.startswith("Beyond chance, worse than mis in ")
    assert told.endswith(f", {words} in the median; nowhere better.")


def test_between_equals_chance_alone_marks_about_one_block_in_a_thousand() -> None:
    truth = reference()
    marked, blocks = 0, 0
    for seed in range(20):
        found = losses(squares(runs(100 + seed, truth), truth), squares(runs(200 + seed, truth), truth))
        assert found.worse is not None
        assert found.better is not None
        marked += int((found.worse | found.better).sum())
        blocks += found.worse.size
    # Poisson with mean about 11; 30 or more has a chance below 1e-5
    assert marked < 30 < blocks * LEVEL * 4


def test_with_fewer_than_three_repeats_nothing_is_called_worse() -> None:
    truth = reference()
    found = losses(squares(runs(7, truth, 0.9)[:2], truth), squares(runs(8, truth)[:2], truth))
    assert found.worse is None
    assert found.better is None
    assert found.ratio is not None


def test_crops_are_chosen_where_strategies_differ_and_do_not_overlap() -> None:
    truth = reference()
    noise = np.full(SHAPE, 0.1)
    noise[30:44, 60:74] = 0.8
    pixels = {"even": squares(runs(9, truth), truth), "uneven": squares(runs(10, truth, noise), truth)}
    (x, y, w, h), (other_x, other_y, _, _) = choose_crops(pixels, SHAPE[:2])
    assert (x + w / 2, y + h / 2) == pytest.approx((67, 37), abs=3)
    assert abs(x - other_x) >= w or abs(y - other_y) >= h


def test_a_picture_is_reduced_by_whole_blocks_and_a_small_one_is_left_alone() -> None:
    values = np.arange(48.0).reshape(6, 8)
    assert reduced(values, 8) is values
    np.testing.assert_array_equal(reduced(values, 4), values.reshape(3, 2, 4, 2).mean(axis=(1, 3)))
    assert reduced(np.zeros((7, 9, 3)), 4).shape == (2, 3, 3)
    assert reduced(np.zeros((1, 1000, 3)), 622).shape == (1, 500, 3)


def test_colours_hold_their_ends_and_what_is_no_number() -> None:
    values = np.array([[0.0, 0.01, 1.0, 5.0, np.nan]])
    pixels = coloured(values, 0.01, 1.0, "magma")
    assert (pixels[0, 0] == pixels[0, 1]).all()
    assert (pixels[0, 2] == pixels[0, 3]).all()
    assert (pixels[0, 4] == pixels[0, 0]).all()
    assert not (pixels[0, 0] == pixels[0, 2]).all()
