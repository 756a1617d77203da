"""Values that functions return show their answer: in a line, in a few lines, and in a notebook."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

import equaltime as et
from equaltime.words import Shown, duration, percent

CORNELL = Path(__file__).parents[2] / "scenes" / "cornell-box.toml"
ENDS = ("", "_low", "_high", "_trusted")
MOST_LINES = 20
"""An answer, ten more lines, and the effects of a scene."""
VALUES: dict[str, tuple[Callable[[et.Scene], object], str]] = {
    "scene": (lambda scene: scene, "cornell-box.toml: 16x16, 8 shapes, paths up to depth 30"),
    "stats": (lambda scene: et.render(scene, spp=2, threads=1).stats, "512 paths in"),
    "quote": (lambda scene: et.quote(scene, error=0.5, why=False), "error "),
    "comparison": (lambda scene: et.compare(*(et.render(scene, spp=16, seed=seed) for seed in (1, 2))), "error"),
    "prices": (lambda scene: et.effects(scene, quick=True), "the scene calls for long_paths"),
    "replay": (lambda scene: et.replay(scene, pixel=(3, 4), sample=0), "pixel 3,4, sample 0: radiance ("),
    "result": (lambda scene: et.render(scene, spp=4), "16x16, 4 spp, error"),
}


@pytest.mark.parametrize("name", VALUES)
def test_a_value_shows_its_answer_first(name: str) -> None:
    make, answer = VALUES[name]
    value = make(et.load(CORNELL).with_(size=(16, 16)))
    lines = str(value).splitlines()
    assert answer in lines[0]
    assert len(lines) <= MOST_LINES
    assert repr(value) == f"{type(value).__name__}({lines[0]})" or name == "result"
    assert len(repr(value)) < 250


def test_a_notebook_shows_the_text_and_no_markup_of_names() -> None:
    class Named(Shown):
        def __str__(self) -> str:
            return "<b> & more"

    assert Named()._repr_html_() == "<pre>&lt;b&gt; &amp; more</pre>"


@pytest.mark.parametrize(("seconds", "said"), [(0.0123, "12.3 ms"), (4.56, "4.56 s"), (473.4, "7.89 min")])
def test_times_have_a_unit_that_suits_them(seconds: float, said: str) -> None:
    assert duration(seconds) == said


def test_estimates_print_in_their_units() -> None:
    scene = et.load(CORNELL).with_(size=(16, 16))
    error, quote = et.render(scene, spp=4).error, et.quote(scene, spp=4, why=False)
    assert str(error) == f"{error:%}"
    assert [str(one) for one in (quote.error, quote.memory)] == [f"{quote.error:%}", f"{quote.memory:MB}"]
    assert "%" not in str(error.map(lambda value: value**2)), "the square of an error is no per cent"


def test_errors_are_per_cent() -> None:
    assert percent(0.025) == "2.5 %"


@pytest.mark.filterwarnings("ignore:with . repeat:equaltime.EqualtimeWarning")
def test_a_summary_is_a_table_for_pandas(tmp_path: Path) -> None:
    scene = et.load(CORNELL).with_(size=(8, 8))
    found = et.cost(scene, tmp_path / "cost", budget=0.02, repeats=3, strategies=("mis", "best"))
    assert repr(found) == f"Summary({found.verdict})"
    frame = found.to_frame()
    assert {*frame.strategy} == {"mis", "best"}
    assert list(frame.columns) == [
        *("scene", "strategy", "biased", "spp"),
        *(f"{name}{end}" for name in ("seconds", "error", "own_estimate") for end in ENDS),
    ]
    curve = found.scenes[0].strategies[0].curve
    ours = frame[frame.strategy == found.scenes[0].strategies[0].label]
    assert tuple(ours.spp) == curve.spp
    assert tuple(ours.error_trusted) == tuple(interval.trusted for interval in curve.error)
    assert tuple(ours.error_high) == tuple(interval.high for interval in curve.error)
