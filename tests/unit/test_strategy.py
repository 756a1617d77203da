import itertools
from pathlib import Path

import pytest

from equaltime.errors import StrategyError
from equaltime.strategy import PRESETS, Strategy


def every_strategy() -> list[Strategy]:
    choices = itertools.product(
        ["bsdf", "light", "mis"],
        ["balance", "power"],
        ["uniform", "power"],
        ["none", "throughput"],
        [1, 5],
        [None, 3],
        ["independent", "sobol"],
    )
    return [Strategy.model_validate(dict(zip(Strategy.model_fields, choice, strict=True))) for choice in choices]


def test_every_strategy_is_read_back_from_its_name() -> None:
    for strategy in every_strategy():
        assert Strategy.parse(str(strategy)) == strategy


def test_no_two_strategies_share_a_name() -> None:
    strategies = every_strategy()
    assert len({strategy.name for strategy in strategies}) == len(strategies)


@pytest.mark.parametrize("name", PRESETS)
def test_a_preset_is_called_by_its_name(name: str) -> None:
    assert Strategy.parse(name).name == name


def test_best_is_the_default() -> None:
    assert Strategy() == Strategy.parse("best")


def test_a_name_mentions_only_what_differs_from_the_nearest_preset() -> None:
    assert Strategy.parse("mis, sampler=sobol , truncate=3").name == "mis,truncate=3,sampler=sobol"


def test_values_may_be_given_without_a_preset() -> None:
    assert Strategy.parse("technique=light") == Strategy(technique="light")


def test_only_truncation_is_biased() -> None:
    assert [strategy.biased for strategy in every_strategy()] == [s.truncate is not None for s in every_strategy()]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("bets", "did you mean 'best'?"),
        ("best,smapler=sobol", "unknown key 'smapler'; did you mean 'sampler'?"),
        ("best,sampler=sobl", "unknown sampler 'sobl'; did you mean 'sobol'?"),
        ("best,lights=tree", "known are uniform, power"),
        ("best,truncate=0", "truncate must be a whole number of at least 1 or none, found '0'"),
        ("best,roulette_depth=2.5", "roulette_depth must be a whole number of at least 1, found '2.5'"),
        ("best,roulette_depth=none", "roulette_depth must be a whole number of at least 1, found 'none'"),
        ("best,sobol", "expected key=value"),
        ("best,sampler=sobol,sampler=sobol", "'sampler' is given twice"),
        ("", "known are best"),
    ],
)
def test_a_wrong_strategy_is_refused_with_the_nearest_name(text: str, message: str) -> None:
    with pytest.raises(StrategyError, match="strategy") as caught:
        Strategy.parse(text)
    assert message in str(caught.value)


def test_all_problems_are_reported_together() -> None:
    with pytest.raises(StrategyError) as caught:
        Strategy.parse("best,sampler=x,truncate=y,foo=1")
    assert len(str(caught.value).splitlines()) == 3


def test_the_constructor_reports_like_parse() -> None:
    with pytest.raises(StrategyError, match="did you mean 'bsdf'"):
        Strategy(technique="bsd")  # type: ignore[arg-type]


def test_a_toml_file_starts_from_a_preset(tmp_path: Path) -> None:
    path = tmp_path / "cut.toml"
    path.write_text('preset = "mis"\ntruncate = 4\nsampler = "sobol"\n')
    assert Strategy.parse(path) == Strategy.parse(str(path)) == Strategy.parse("mis,truncate=4,sampler=sobol")


@pytest.mark.parametrize("content", ['sampler = "sobl"', "preset = 3", "not toml", "truncate = true"])
def test_a_wrong_toml_file_is_named_in_the_error(tmp_path: Path, content: str) -> None:
    path = tmp_path / "wrong.toml"
    path.write_text(content)
    with pytest.raises(StrategyError, match=r"wrong\.toml: "):
        Strategy.parse(path)


def test_a_missing_file_is_named_in_the_error(tmp_path: Path) -> None:
    with pytest.raises(StrategyError, match=r"none\.toml: No such file"):
        Strategy.parse(tmp_path / "none.toml")


def test_a_strategy_cannot_be_changed() -> None:
    with pytest.raises(ValueError, match="frozen"):
        Strategy().truncate = 3  # type: ignore[misc]
