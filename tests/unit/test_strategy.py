import contextlib
import itertools
from functools import cache
from pathlib import Path

import pytest

from equaltime.errors import StrategyError
from equaltime.strategy import PRESETS, Strategy

CHOICES: dict[str, list[object]] = {
    "technique": ["uniform", "bsdf", "light", "mis", "mixture"],
    "heuristic": [None, "balance", "power"],
    "lights": ["uniform", "power", "tree"],
    "environment": [None, "plain", "compensated"],
    "roulette": ["none", "constant", "albedo", "throughput", "efficiency", "automatic"],
    "roulette_depth": [None, 1, 5],
    "survival": [None, 0.75, 0.95],
    "truncate": [None, 3],
    "sampler": ["independent", "stratified", "sobol", "lattice"],
    "adaptive": ["none", "error"],
}


@cache
def every_strategy() -> list[Strategy]:
    """Return all combinations of CHOICES that make sense, each once."""
    assert CHOICES.keys() == Strategy.model_fields.keys()
    strategies = set()
    for choice in itertools.product(*CHOICES.values()):
        with contextlib.suppress(StrategyError):
            strategies.add(Strategy.model_validate(dict(zip(CHOICES, choice, strict=True))))
    return sorted(strategies, key=str)


def test_every_strategy_is_read_back_from_its_name() -> None:
    for strategy in every_strategy():
        assert Strategy.parse(str(strategy)) == strategy


def test_no_two_strategies_share_a_name() -> None:
    strategies = every_strategy()
    assert len({strategy.name for strategy in strategies}) == len(strategies) > 250


def test_a_strategy_is_made_again_from_its_own_values() -> None:
    for strategy in every_strategy():
        assert Strategy.model_validate(strategy.model_dump()) == strategy


@pytest.mark.parametrize("name", PRESETS)
def test_a_preset_is_called_by_its_name(name: str) -> None:
    assert Strategy.parse(name).name == name


@pytest.mark.parametrize("text", [*PRESETS, "best,roulette=constant,survival=0.8", "naive,truncate=3"])
def test_a_strategy_in_full_does_not_depend_on_presets(text: str) -> None:
    strategy = Strategy.parse(text)
    assert not strategy.in_full.startswith(tuple(PRESETS))
    assert Strategy.parse(strategy.in_full) == strategy


def test_best_is_the_default() -> None:
    assert Strategy() == Strategy.parse("best")


def test_a_name_mentions_only_what_differs_from_the_nearest_preset() -> None:
    assert Strategy.parse("mis, sampler=sobol , truncate=3").name == "mis,truncate=3,sampler=sobol"


def test_naive_knows_nothing_of_lights_and_bsdfs() -> None:
    naive = Strategy.parse("naive")
    assert (naive.technique, naive.roulette, naive.sampler) == ("uniform", "albedo", "independent")
    assert not naive.biased


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
        ("best,lights=cluster", "expected one of 'power', 'tree', 'uniform'"),
        ("best,truncate=0", "truncate must be a whole number of at least 1 or none, found '0'"),
        ("best,roulette_depth=2.5", "roulette_depth must be a whole number of at least 1, found '2.5'"),
        ("best,roulette_depth=none", "roulette_depth must be a whole number of at least 1, found 'none'"),
        ("best,sobol", "expected key=value"),
        ("best,roulette=constant,survival=1", "survival must be a number between 0 and 1, found '1.0'"),
        ("best,roulette=constant,survival=often", "survival must be a number between 0 and 1, found 'often'"),
        ("best,heuristic=none", "unknown heuristic 'none'; expected one of 'balance', 'power'"),
        ("best,sampler=sobol,sampler=sobol", "'sampler' is given twice"),
        ("", "expected one of 'best'"),
    ],
)
def test_a_wrong_strategy_is_refused_with_the_nearest_name(text: str, message: str) -> None:
    with pytest.raises(StrategyError, match="strategy") as caught:
        Strategy.parse(text)
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("bsdf,heuristic=balance", "heuristic=balance has no meaning with technique=bsdf"),
        ("best,technique=light,heuristic=power", "heuristic=power has no meaning with technique=light"),
        ("naive,heuristic=power", "heuristic=power has no meaning with technique=uniform"),
        ("best,technique=mixture,heuristic=balance", "heuristic=balance has no meaning with technique=mixture"),
        ("best,technique=light,environment=compensated", "environment=compensated has no meaning with technique=light"),
        ("mis,roulette_depth=3", "roulette_depth=3 has no meaning with roulette=none"),
        ("best,roulette=throughput,survival=0.9", "survival=0.9 has no meaning with roulette=throughput"),
        ("naive,roulette=efficiency", "roulette=efficiency has no meaning with technique=uniform"),
        ("best,technique=mixture,roulette=efficiency", "roulette=efficiency has no meaning with technique=mixture"),
    ],
)
def test_a_meaningless_pair_is_refused_with_the_reason(text: str, message: str) -> None:
    with pytest.raises(StrategyError) as caught:
        Strategy.parse(text)
    assert message in str(caught.value)


def test_what_a_preset_says_gives_way_to_what_makes_it_meaningless() -> None:
    assert Strategy.parse("best,technique=bsdf").heuristic is None
    assert Strategy.parse("bsdf,technique=mis").heuristic == "power"
    assert Strategy.parse("best,roulette=constant").survival == 0.75
    assert Strategy.parse("best,roulette=none").roulette_depth is None


def test_all_problems_are_reported_together() -> None:
    with pytest.raises(StrategyError) as caught:
        Strategy.parse("best,technique=light,heuristic=power,sampler=x,truncate=y,foo=1")
    assert len(str(caught.value).splitlines()) == 4


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


GIVEN = {
    "heuristic": "bsdf,technique=mis",
    "environment": "bsdf,technique=mis",
    "roulette_depth": "bsdf,roulette=albedo",
    "survival": "best,roulette=constant",
}
"""Strategies by a key that their preset leaves without a value, and that their change gives a meaning."""


def told(key: str, strategy: Strategy) -> str:
    """Return a key's value as pages write it; a dash if the key has no meaning."""
    value = getattr(strategy, key)
    return f"`{value}`" if value is not None else "`none`" if key == "truncate" else "\N{EN DASH}"


@pytest.mark.parametrize("key", Strategy.model_fields)
def test_the_page_has_the_value_of_each_key_in_each_preset(key: str) -> None:
    page = (Path(__file__).parents[2] / "scenes" / "experiments" / "README.md").read_text(encoding="utf-8")
    assert f"| key | {' | '.join(f'`{name}`' for name in PRESETS)} | else |" in page
    values = " | ".join(told(key, preset) for preset in PRESETS.values())
    default = told(key, Strategy.parse(GIVEN[key])) if key in GIVEN else ""
    assert f"| `{key}` | {values} | {default} |" in page


def test_every_key_that_may_have_no_meaning_has_a_default_in_the_page() -> None:
    without = {key for preset in PRESETS.values() for key in Strategy.model_fields if getattr(preset, key) is None}
    assert without - {"truncate"} == GIVEN.keys()
