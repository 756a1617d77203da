"""What is measured and decided by errors: against a reference that has noise (E10), and of light in other units (T4).

Z-tests at 4 standard errors: false alarms once in 15,787. Seeds are fixed.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import equaltime as et
from equaltime.hardcases.units import in_units
from equaltime.images.metrics import Reference, measure

Array = NDArray[np.float64]
SHAPE = (16, 24, 3)
TRUTH = np.random.default_rng(7).uniform(0.2, 2.0, SHAPE)
SAMPLES = 4.0 ** np.arange(8)
SIGMA, OF_REFERENCE = 0.5, 0.02
"""Of one sample; the reference has as little noise as 625 of them."""


def curve(seed: int, subtracts: bool) -> Array:
    """Return the squared errors of renders of more and more samples, all against one reference."""
    rng = np.random.default_rng(seed)
    halves = TRUTH + OF_REFERENCE * np.sqrt(2.0) * rng.standard_normal((2, *SHAPE))
    variance = np.full(SHAPE, OF_REFERENCE**2 if subtracts else 0.0)
    reference = Reference(halves.mean(axis=0), variance, (halves[0], halves[1]) if subtracts else None)
    images = [TRUTH + SIGMA / np.sqrt(n) * rng.standard_normal(SHAPE) for n in SAMPLES]
    return np.array([measure(image, reference, ["relmse"])["relmse"].value for image in images])


def test_E10_errors_fall_by_the_root_of_the_samples_down_to_a_floor_that_is_known_beforehand() -> None:  # noqa: N802
    scale = float(np.mean(1.0 / (TRUTH**2 + (0.1 * TRUTH.mean()) ** 2)))
    floor, falling = OF_REFERENCE**2 * scale, SIGMA**2 * scale / SAMPLES

    def off(subtracts: bool, expected: Array) -> float:
        found = np.array([curve(seed, subtracts) for seed in range(200)])
        error = found.std(axis=0, ddof=1) / np.sqrt(len(found))
        # the reference's noise is in the denominators too: some per mille of what is measured
        return float((np.abs(found.mean(axis=0) - expected) / (error + 2e-3 * expected)).max())

    assert off(True, falling) < 4.0
    assert off(False, falling + floor) < 4.0
    assert off(False, falling) > 4.0, "the twin: the noise left in"
    assert off(True, falling + 0.1 * floor) > 4.0, "the twin: a tenth of it left in"


SCALES = [2.0**-40, 2.0**40]
TARGET = 0.1


def lit(light: float) -> et.Result:
    scene = et.load(Path(__file__).parents[2] / "scenes" / "cornell-box.toml").with_(size=(32, 32), max_depth=4)
    return et.render(in_units(scene, 1.0, light), error=TARGET, strategy="best,adaptive=error")


@pytest.mark.parametrize("light", SCALES)
def test_T04_samples_are_as_many_and_in_the_same_pixels_in_any_unit_of_light(light: float) -> None:  # noqa: N802
    """Where a render stops by its error, and which pixels get more: the same, and so is each bit of the image."""
    one, other = lit(1.0), lit(light)
    assert one.stopped_by == other.stopped_by == "error"
    assert (other.samples == one.samples).all()
    assert np.ptp(one.samples) > 0
    assert (other.image / np.float32(light) == one.image).all()
    assert other.error == one.error
    assert (lit(3.0).image / np.float32(3.0) != one.image).any(), "the twin: 3 is no power of two"
    noise = [float(result.standard_error.mean() / (1e-4 + np.sqrt(result.image.mean()))) for result in (one, other)]
    assert abs(np.log(noise[1] / noise[0])) > 1.0, "the twin: by an absolute threshold, they would not stop alike"
