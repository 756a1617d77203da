"""One sample that is no number (E4): it is flagged, can be played again, and leaves all others as they are, bit by bit.

The sample is one of a good scene. Where its path meets the ground, a patch of a few millionths gets an albedo that is
no number, which the readers would refuse: it is put there behind their back.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import equaltime as et
from equaltime.rendering.core import split_light
from equaltime.scene.model import Diffuse
from equaltime.strategy import Strategy

from .ground import ground

Moments = NDArray[Any]
PIXEL, SAMPLE, SEED, SPP = (5, 7), 3, 3, 4
"""All samples of the first pass: what comes after the bad one's is not rendered."""
MARKED = 0.123
"""The albedo that the core is told to be none."""
LAMP = {"type": "sphere", "center": [1, 1, 2], "radius": 0.5, "emitter": {"type": "area", "radiance": 5}}
GROUND = ground(16, 12, 4, lamp=LAMP)


def patched(at: Sequence[float]) -> et.Scene:
    """Return the scene with a patch just above a place on the ground."""
    place = [{"scale": 2e-6}, {"translate": [at[0], at[1], 1e-6]}]
    bsdf = {"type": "diffuse", "reflectance": MARKED}
    return et.load_dict(GROUND | {"patch": {"type": "rectangle", "to_world": place, "bsdf": bsdf}})


@pytest.fixture
def bad(monkeypatch: pytest.MonkeyPatch) -> et.Scene:
    """The scene in which one path meets what reflects no number."""

    right = Diffuse.parameters

    def parameters(bsdf: Diffuse) -> dict[str, Any]:
        found = right(bsdf)
        return {"reflectance": [math.nan] * 3} if np.allclose(found["reflectance"], MARKED) else found

    monkeypatch.setattr(Diffuse, "parameters", parameters)
    first = et.replay(et.load_dict(GROUND), pixel=PIXEL, sample=SAMPLE, seed=SEED).vertices[0]
    return patched(first["surface"]["point"])


def only_that_one_is_left_out(found: Moments, clean: Moments) -> bool:
    """Tell whether moments are those without the bad sample to the last bit, in its pixel and in all others."""
    right = clean.copy()
    own = right[SAMPLE % len(right), PIXEL[1], PIXEL[0]]
    kept = [index for index in range(SPP) if index % len(right) == SAMPLE % len(right) and index != SAMPLE]
    (other,) = kept  # of two samples, one is its own mean and has no spread
    own["count"], own["mean"] = 1, et.replay(et.load_dict(GROUND), pixel=PIXEL, sample=other, seed=SEED).radiance
    own["deviation"] = 0.0
    return found.tobytes() == right.tobytes()


def test_E04_one_sample_that_is_no_number_is_flagged_and_leaves_all_others_as_they_are(bad: et.Scene) -> None:  # noqa: N802
    clean = et.render(et.load_dict(GROUND), spp=SPP, seed=SEED)
    with pytest.raises(et.NonFiniteSample, match=f"pixel 5,7, sample {SAMPLE}, seed {SEED}") as caught:
        et.render(bad, spp=SPP, seed=SEED)
    found = caught.value.result
    assert isinstance(found, et.Result)
    assert np.isfinite(found.image).all()
    assert np.argwhere(found.samples != clean.samples).tolist() == [[PIXEL[1], PIXEL[0]]]
    assert found.samples[PIXEL[1], PIXEL[0]] == SPP - 1
    assert found.moments is not None
    assert clean.moments is not None
    assert only_that_one_is_left_out(found.moments, clean.moments)
    for radiance in (0.0, math.nan):  # the twins: taken for black, and taken as it is
        with_it = found.moments.copy()
        own = with_it[SAMPLE % 2, PIXEL[1], PIXEL[0]]
        own["mean"], own["count"] = (own["mean"] + radiance) / 2, 2
        assert not only_that_one_is_left_out(with_it, clean.moments), "the twin"


def test_E04_the_sample_that_is_no_number_can_be_played_again_and_no_other_is_one(bad: et.Scene) -> None:  # noqa: N802
    replays = [et.replay(bad, pixel=PIXEL, sample=index, seed=SEED) for index in range(SPP)]
    assert [index for index, path in enumerate(replays) if path.first_nonfinite] == [SAMPLE]
    path = replays[SAMPLE]
    assert all(math.isnan(value) for value in path.radiance)
    assert path.first_nonfinite is not None
    assert path.first_nonfinite[0] == 0, "the vertex on the patch"
    assert path.vertices[0]["surface"]["name"].startswith("'patch'")


def test_E04_parts_of_the_light_are_those_of_the_samples_that_count(bad: et.Scene) -> None:  # noqa: N802
    names, parts = split_light(bad, Strategy.parse("best"), SEED, 1, SPP)
    assert np.isfinite(parts).all()
    lengths = [i for i, (kind, _) in enumerate(names) if kind == "length"]
    found = parts[PIXEL[1], PIXEL[0], lengths].sum(axis=0, dtype=np.float64)
    kept = [et.replay(bad, pixel=PIXEL, sample=index, seed=SEED).radiance for index in range(SPP) if index != SAMPLE]
    assert found == pytest.approx(np.mean(kept, axis=0), rel=1e-5)
    assert found != pytest.approx(np.sum(kept, axis=0) / SPP, rel=1e-5), "the twin: counted as black"
