"""The words around the number that a render states: error, or noise of another problem or of a biased strategy."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

import equaltime as et
from equaltime.cli.messages import headline
from equaltime.images.image_files import Window
from equaltime.rendering.origin import Origin
from equaltime.rendering.stated import asked_samples, different_problems, not_as_asked, other_depth, shorter, stated

CORNELL = Path(__file__).parents[3] / "scenes" / "cornell-box.toml"
ALL, UP_TO_8 = "the scene asks for paths of any length", "the scene asks for paths up to depth 8"
BIAS = "the bias is not in the noise: `equaltime compare` with a render by `best` measures it"


def origin(max_depth: int, asked: int | None, strategy: str = "best", *without: str) -> Origin:
    biased = strategy not in ("best", "crosscheck") or bool(without)
    backend = "embreex" if strategy == "crosscheck" else "core"
    fixed = (max_depth, strategy, biased, 0, 2, backend, without)
    return Origin("box.toml", "ab12", Window(0, 0, 8, 8), *fixed, scene_max_depth=asked)


@pytest.mark.parametrize(
    "whole",
    [
        origin(-1, -1),
        origin(8, 8),
        origin(8, None),  # a record of an earlier version
        origin(-1, -1, "best,truncate=2", "long_paths=2"),  # measured
        origin(8, 8, "best", "lens"),
        origin(8, 8, "crosscheck"),
    ],
)
def test_the_number_is_the_error_where_nothing_is_missing_in_it(whole: Origin) -> None:
    number = stated(whole)
    assert (number.noun, number.of_paths, number.by_strategy, number.missing) == ("error", "", False, "")


@pytest.mark.parametrize(
    ("cut", "of", "missing"),
    [
        (origin(2, -1), 2, f"{ALL}: `--without long_paths=2` instead of `--max-depth 2` measures the difference"),
        (origin(2, 8), 2, f"{UP_TO_8}: `--without long_paths=2` instead of `--max-depth 2` measures the difference"),
        (origin(0, -1), 0, ALL),  # long_paths=0 cannot be left out
        (origin(20, 8), 20, UP_TO_8),
        (origin(-1, 8), -1, UP_TO_8),
        (origin(-1, -1, "best,truncate=3"), 3, f"{ALL}: `--without long_paths=3` measures the difference"),
        (origin(2, -1, "best,truncate=3"), 2, f"{ALL}: `--without long_paths=2` instead of `--max-depth 2` measures "
         "the difference"),
        (origin(6, -1, "best,truncate=3"), 3, f"{ALL}: `--without long_paths=3` instead of `--max-depth 6` measures "
         "the difference"),
        (origin(6, -1, "best,truncate=3", "long_paths=3"), 6, f"{ALL}: `--without long_paths=3` instead of "
         "`--max-depth 6` measures the difference"),
        (origin(-1, -1, "best,adaptive=history,truncate=3"), 3, f"{ALL}: `--without long_paths=3` measures the "
         f"difference; {BIAS}"),
        (origin(2, -1, "crosscheck"), 2, f"{ALL}: `--without long_paths=2` instead of `--max-depth 2` measures the "
         "difference"),
    ],
)  # fmt: skip
def test_the_noise_of_another_problem_names_both_depths_and_what_measures_the_difference(
    cut: Origin, of: int, missing: str
) -> None:
    number = stated(cut)
    assert number.noun == ("noise and measured bias" if cut.without else "noise")
    assert number.of_paths == (" of paths of any length" if of < 0 else f" of paths up to depth {of}")
    assert number.missing == missing
    assert number.by_strategy == ("truncate" in cut.strategy and not cut.without)


def test_the_noise_of_a_biased_strategy_is_not_its_error() -> None:
    number = stated(origin(8, 8, "best,adaptive=history"))
    assert (number.noun, number.of_paths, number.by_strategy, number.missing) == ("noise", "", True, BIAS)
    both = stated(origin(8, 8, "best,adaptive=history", "lens"))
    assert (both.noun, both.by_strategy) == ("noise and measured bias", True)
    useless = stated(origin(8, 8, "best,truncate=9"))  # the scene has no paths to be cut
    assert (useless.noun, useless.of_paths, useless.missing) == ("noise", "", "")


def test_no_limit_is_longer_than_any_depth() -> None:
    assert [shorter(a, b) for a, b in ((-1, None), (-1, -1), (-1, 3), (3, -1), (2, 3), (3, 2))] == [-1, -1, 3, 3, 2, 2]
    assert other_depth(2, -1) == f"paths up to depth 2; {ALL}"
    assert other_depth(-1, -1) == ""


def record(max_depth: int, asked: int, digest: str, scene: str = "box.toml") -> dict[str, Any]:
    return {"max_depth": max_depth, "scene_max_depth": asked, "digest": digest, "scene": scene}


@pytest.mark.parametrize(
    ("records", "notes"),
    [
        ([record(8, 8, "a"), record(8, 8, "a")], []),
        ([record(8, 8, "a"), {"max_depth": 8, "digest": "a"}, {}], []),
        ([record(2, -1, "a"), record(-1, -1, "b")], ["images of two problems: 0.exr shows paths up to depth 2, 1.exr "
         "shows paths of any length. The noise that an image states does not contain the difference"]),
        ([record(2, -1, "a"), record(2, -1, "a")], [f"the images show paths up to depth 2; {ALL}"]),
        ([record(2, -1, "a"), record(2, 2, "a")], [f"the images show paths up to depth 2; {ALL}"]),
        ([record(8, 8, "a"), record(8, 8, "b")], ["the files say that they show different scenes"]),
        ([record(2, 8, "a"), record(8, 8, "b", "hall.toml")], ["images of two problems: 0.exr shows paths up to depth "
         "2, 1.exr shows paths up to depth 8. The noise that an image states does not contain the difference", "the "
         "files say that they show different scenes"]),
        ([{"max_depth": "deep", "digest": ["a"], "scene": 3}, {"max_depth": 2, "digest": ["a"]}], []),
    ],
)  # fmt: skip
def test_images_of_different_problems_are_noted(records: list[dict[str, Any]], notes: list[str]) -> None:
    assert list(different_problems([(Path(f"{i}.exr"), said) for i, said in enumerate(records)])) == notes


def test_a_mean_of_samples_that_is_not_the_number_asked_for_has_the_reason() -> None:
    assert asked_samples("spp", (1024, 1024, 0)) == 1024
    assert asked_samples("time", (1024, 1024, 0)) is None
    assert asked_samples("spp", None) is None
    assert not_as_asked(1033.2, 1024) == " (for 1,024: more where it is noisy)"
    assert not_as_asked(1024.0, 1024) == not_as_asked(1033.2, None) == ""


def test_a_result_and_its_file_say_why_it_has_more_samples_than_were_asked_for() -> None:
    scene = et.load(CORNELL).with_(size=(48, 48))
    result = et.render(scene, spp=64, seed=1)
    assert round(result.spp) != 64, "counts follow the noise"
    assert f" {round(result.spp)} spp (for 64: more where it is noisy), " in str(result)
    assert " spp (for 64: more where it is noisy), " in headline(result)
    even = et.render(scene, spp=4, seed=1, strategy="mis")
    assert " 4 spp, " in str(even)
