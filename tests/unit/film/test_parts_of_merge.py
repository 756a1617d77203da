"""What a merged render knows of its parts: associative, in its file, and read from files of before.

Simulations have fixed seeds; a z-test here rejects beyond 4.4 standard errors (false alarms: 1e-5 each).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import reduce
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import equaltime as et
from equaltime.film.error import PixelStatistics, image_error, pixel_statistics, standard_error
from equaltime.film.lamps import Lamps
from equaltime.film.moments import DTYPE, PARTS, channel_names, packed, stored, unpacked
from equaltime.film.parts_of_merge import MergedFilm, statistics_of
from equaltime.images import image_files as images
from equaltime.rendering.render_file import read_picture
from equaltime.rendering.saved import SavedRender

SCENES = Path(__file__).parents[3] / "scenes"
BEFORE = Path(__file__).parents[1] / "data" / "format_1" / "merged-without-sums.exr"
Z_LIMIT = 4.4
SIDE = 200

Floats = NDArray[np.float64]


def film_of(samples: Floats) -> NDArray[Any]:
    """Return the moments of samples (n, H, W, 3): sample i belongs to replicate i mod 2."""
    moments = np.zeros((2, *samples.shape[1:3]), DTYPE)
    for r in range(2):
        of = samples[r::2]
        moments[r]["count"] = len(of)
        if len(of):
            moments[r]["mean"], moments[r]["deviation"] = of.mean(axis=0), stored(of.std(axis=0))
    return moments


def drawn(rng: np.random.Generator, count: int, power: float, side: int = SIDE) -> NDArray[Any]:
    """Return the moments of a part whose replicates of n samples have the variance n^-power about 0, in each pixel.

    Independent samples have the power 1, points of low discrepancy up to 2.
    """
    moments = np.zeros((2, side, side), DTYPE)
    for r in range(2):
        n = (count + 1 - r) // 2
        moments[r]["count"] = n
        if n:
            moments[r]["mean"] = rng.standard_normal((side, side, 3)) * n ** (-0.5 * power)
    return moments


def true_variance(counts: Sequence[int], power: float) -> float:
    """Return the variance of the mean of parts whose replicates are as `drawn` makes them."""
    sizes = [n for count in counts for n in ((count + 1) // 2, count // 2) if n]
    return sum(n ** (2.0 - power) for n in sizes) / sum(counts) ** 2


def merged(films: Sequence[NDArray[Any]]) -> MergedFilm:
    return reduce(MergedFilm.joined, map(MergedFilm.of, films))


def z_of(values: Floats, expected: float) -> float:
    return float((values.mean() - expected) / (values.std() / math.sqrt(values.size)))


PLANS = ([8] * 2, [8] * 5, [3] * 4, [1] * 6, [5, 5], [28, 4], [16, 8, 4, 2])


@pytest.mark.parametrize("power", [1.0, 1.5, 2.0])
@pytest.mark.parametrize("counts", PLANS, ids=str)
def test_the_variance_is_unbiased_whatever_the_sampler(counts: list[int], power: float) -> None:
    rng = np.random.default_rng(sum(counts))
    found = merged([drawn(rng, count, power) for count in counts]).statistics().variance
    expected = true_variance(counts, power)
    assert abs(z_of(found, expected)) < Z_LIMIT
    assert abs(z_of(1.05 * found, expected)) > Z_LIMIT, "one that is 5 % too large would be seen"


@pytest.mark.parametrize("power", [1.5, 2.0])
def test_joined_replicates_alone_would_be_seen_to_be_biased_for_odd_parts(power: float) -> None:
    rng = np.random.default_rng(7)
    film = merged([drawn(rng, 3, power) for _ in range(4)])
    assert abs(z_of(pixel_statistics(film.moments).variance, true_variance([3] * 4, power))) > Z_LIMIT


@pytest.mark.parametrize(
    ("counts", "degrees"),
    [([8] * 2, 3.0), ([8] * 5, 9.0), ([3] * 4, 3.0), ([1] * 6, 5.0), ([28, 4], 1.28), ([3, 5], 1.0), ([7], 1.0)],
    ids=str,
)
def test_the_degrees_of_freedom_are_those_of_the_estimate(counts: list[int], degrees: float) -> None:
    """An estimate of v by d degrees of freedom varies by 2 v²/d."""
    rng = np.random.default_rng(len(counts))
    pixels = merged([drawn(rng, count, 1.0) for count in counts]).statistics()
    assert pixels.degrees == pytest.approx(degrees, rel=1e-12)
    squares = np.square(pixels.variance / true_variance(counts, 1.0) - 1.0)
    assert abs(z_of(squares, 2.0 / degrees)) < Z_LIMIT
    assert abs(z_of(squares, 2.0 / (degrees + 0.2 * degrees))) > Z_LIMIT, "a fifth more would be seen"


def test_pixels_of_unlike_counts_have_their_own_estimates() -> None:
    """Where a time limit cut a part, pixels have other counts, or none."""
    rng = np.random.default_rng(3)
    films = [drawn(rng, 4, 1.5, side=3) for _ in range(3)]
    films[0][:, 0] = films[1][:, 1] = np.zeros(1, DTYPE)
    films[2][:, 2] = drawn(rng, 6, 1.5, side=3)[:, 2]
    found = merged(films).statistics()
    for y, present in enumerate(([1, 2], [0, 2], [0, 1, 2])):
        alone = merged([films[k][:, y : y + 1] for k in present]).statistics()
        np.testing.assert_allclose(found.variance[y : y + 1], alone.variance, rtol=1e-12)
    assert found.degrees == pytest.approx(3.0 / (1 / 3 + 1 / 3 + (16 + 16 + 36) / 14**2))


def test_where_no_part_has_two_replicates_nothing_is_known() -> None:
    found = merged([drawn(np.random.default_rng(1), 1, 1.0, side=2)]).statistics()
    assert np.isnan(found.variance).all()
    assert found.degrees == 1.0
    assert np.isfinite(
        merged([drawn(np.random.default_rng(s), 1, 1.0, side=2) for s in (1, 2)]).statistics().variance
    ).all()


def independent(count: int) -> tuple[PixelStatistics, PixelStatistics]:
    """Return what is known of a film of independent skewed samples, and of the same ones in parts of 4."""
    samples = np.random.default_rng(count).lognormal(size=(count, 64, 64, 3))
    parts = [film_of(samples[first : first + 4]) for first in range(0, count, 4)]
    return pixel_statistics(film_of(samples)), merged(parts).statistics()


def test_parts_of_independent_samples_make_the_render_of_all_of_them() -> None:
    whole, parts = independent(24)
    np.testing.assert_allclose(parts.mean, whole.mean, rtol=1e-13)
    np.testing.assert_array_equal(parts.samples, whole.samples)
    assert abs(z_of(parts.variance - whole.variance, 0.0)) < Z_LIMIT
    assert abs(z_of(1.1 * parts.variance - whole.variance, 0.0)) > Z_LIMIT, "the twin: a tenth more"
    assert parts.degrees == 11.0


def test_pixels_without_noise_have_none_between_parts() -> None:
    films = []
    for count in (3, 6, 7):
        films.append(np.zeros((2, 2, 2), DTYPE))
        films[-1]["count"] = np.array([(count + 1) // 2, count // 2])[:, None, None]
        films[-1]["mean"] = 0.1
    assert (merged(films).parts["between"] == 0.0).all()
    means = [pixel_statistics(film).mean.max() for film in films]
    assert len(set(means)) > 1, "the twin: means by sums of products, which round"


def test_sums_over_parts_survive_as_words() -> None:
    rng = np.random.default_rng(1)
    parts = rng.integers(0, 2**64, (5, 7, PARTS.itemsize // 8), dtype=np.uint64).view(PARTS)[..., 0]
    words = packed(parts[None])
    assert words.shape == (5, 2, len(channel_names(PARTS, 1)))
    assert unpacked(words, 7, PARTS)[0].tobytes() == parts.tobytes()


@pytest.fixture(scope="module", params=[(6, 6, 6, 6), (4, 9, 2, 3), (3, 3, 3, 3)], ids=str)
def files(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Render and save parts of a Cornell box, by their sample counts."""
    folder, scene = tmp_path_factory.mktemp("parts"), et.load(SCENES / "cornell-box.toml").with_(size=(24, 20))
    paths = [folder / f"{seed}.exr" for seed in range(len(request.param))]
    for seed, (path, spp) in enumerate(zip(paths, request.param, strict=True)):
        et.render(scene, spp=spp, seed=seed, threads=1).save(path)
    return paths


def saved(paths: Sequence[Path], to: Path) -> Path:
    et.merge(paths).save(to)
    return to


def test_merging_is_associative_to_an_ulp(files: list[Path], tmp_path: Path) -> None:
    a, b, c, d = files
    once = et.merge(files)
    left = et.merge([saved([saved([a, b], tmp_path / "ab.exr"), c], tmp_path / "abc.exr"), d])
    right = et.merge([a, saved([b, saved([c, d], tmp_path / "cd.exr")], tmp_path / "bcd.exr")])
    turned = et.merge([d, c, b, a])
    for other in (left, right, turned):
        np.testing.assert_array_max_ulp(other.image, once.image, maxulp=1)
        np.testing.assert_array_max_ulp(other.standard_error, once.standard_error, maxulp=1)
        np.testing.assert_array_equal(other.samples, once.samples)
        assert other.degrees == once.degrees
        ends = ([e.value, e.low, e.high] for e in (other.error, once.error))
        np.testing.assert_allclose(*ends, rtol=1e-6)


def test_a_merged_file_holds_what_its_result_told(files: list[Path], tmp_path: Path) -> None:
    result = et.merge(files)
    result.save(path := tmp_path / "all.exr")
    read, film = read_picture(path), SavedRender.read(path).film
    assert result.parts is not None
    assert result.moments is not None
    assert film.parts.tobytes() == result.parts.tobytes()
    assert read.record["degrees"] == film.statistics().degrees == result.degrees
    np.testing.assert_allclose(read.standard_error, result.standard_error, rtol=2.0**-6)
    pixels = statistics_of(result.moments, result.parts)
    np.testing.assert_array_equal(result.standard_error, standard_error(pixels))
    lamps = Lamps.from_channels(result.missed["lamps"])
    assert result.error.value == image_error(pixels, least=lamps.least(*result.samples.shape)).value


@pytest.mark.parametrize(("name", "value"), [("parts", 0), ("squares", 1), ("squares", 1 << 40), ("within", np.nan)])
def test_sums_that_cannot_belong_to_the_samples_are_refused(
    files: list[Path], tmp_path: Path, name: str, value: float
) -> None:
    result = et.merge(files)
    assert result.parts is not None
    parts = result.parts.copy()
    parts[name][3, 4] = value
    replace(result, parts=parts).save(tmp_path / "a.exr")
    with pytest.raises(et.ImageError, match="do not belong to its samples"):
        SavedRender.read(tmp_path / "a.exr")


def test_a_file_that_was_merged_before_counts_as_one_part(tmp_path: Path) -> None:
    before = SavedRender.read(BEFORE)
    assert before.parts is None
    assert before.film.statistics().degrees == 1.0
    assert (before.film.parts["parts"] == 1).all()
    same = before.film.statistics().variance, pixel_statistics(before.moments).variance
    np.testing.assert_allclose(*same, rtol=1e-15)
    ball = {"type": "sphere", "center": [0.0, 0.0, 3.0], "bsdf": {"type": "diffuse"}}
    scene = et.load_dict({"type": "scene", "sensor": {"type": "perspective"}, "sky": {"type": "constant"}, "b": ball})
    best_before = "best,roulette=throughput,sampler=sobol,adaptive=none"
    new = et.render(scene.with_(size=(12, 10)), spp=12, seed=5, threads=1, strategy=best_before)
    new = replace(new, origin=replace(new.origin, digest=before.record["digest"]))  # whatever goes into digests by now
    new.save(tmp_path / "new.exr")
    both = et.merge([BEFORE, tmp_path / "new.exr"])
    assert both.degrees == 3.0
    assert [source["seed"] for source in both.origin.sources] == [0, 1, 2, 5]
    expected = 0.5 * (images.read(BEFORE).image.astype(np.float64) + new.image)
    np.testing.assert_allclose(both.image, expected, rtol=3e-7, atol=1e-12)
    with pytest.raises(et.ImageError, match="both have the samples of seed 2"):
        et.merge([BEFORE, saved_again(new, tmp_path)])


def saved_again(result: et.Result, folder: Path) -> Path:
    """Save a result as if it were of a seed that is in the file of before."""
    replace(result, origin=replace(result.origin, seed=2)).save(folder / "same.exr")
    return folder / "same.exr"


def test_renders_that_look_at_their_own_pixels_are_refused_in_plain_words(tmp_path: Path) -> None:
    scene = et.load(SCENES / "cornell-box.toml").with_(size=(8, 8))
    for seed, strategy in enumerate(("best", "best,adaptive=history")):
        et.render(scene, spp=4, seed=seed, strategy=strategy).save(tmp_path / f"{seed}.exr")
    words = (
        r"1\.exr: renders with adaptive=history cannot be merged: each pixel chose its sample counts from its own "
        r"samples\. Render the parts with adaptive=error or adaptive=none\.$"
    )
    with pytest.raises(et.ImageError, match=words):
        et.merge([tmp_path / "0.exr", tmp_path / "1.exr"])
