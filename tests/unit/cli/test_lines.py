"""Lines on a terminal are broken between words, never within a number; files get them in one piece."""

from __future__ import annotations

import io

import pytest

from equaltime.cli.lines import fitted, in_columns
from equaltime.cli.messages import print_lines, print_warning


class Terminal(io.StringIO):
    """Text stream that says that it is a terminal."""

    def isatty(self) -> bool:
        return True


@pytest.fixture(autouse=True)
def narrow(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "60")


def test_a_file_gets_lines_in_one_piece() -> None:
    text = "word " * 40
    assert fitted(text, io.StringIO()) == text
    assert max(map(len, fitted(text, Terminal()).split("\n"))) <= 60


@pytest.mark.parametrize(
    "kept",
    [
        *("2.1 s (1.9 to 2.4)", "4.1 % (0 to 8.5)", "24,478 spp", "140 MB", "12 % (3 or more)", "about 12 min"),
        *("3: 39.4 % ±6.7", "3 39.4 % ±6.7", "14 none measurable", "0.5 %"),
        *("`equaltime replay SCENE --pixel 24,4`", "equaltime render scene.toml -o out.exr"),
    ],
)
def test_numbers_with_unit_and_interval_and_commands_are_not_broken(kept: str) -> None:
    for letters in range(30, 62):
        text = f"{'x' * (letters // 2)} {'y' * (letters - letters // 2)} {kept}; and more words after them"
        lines = fitted(text, Terminal()).split("\n")
        assert " ".join(line.strip() for line in lines) == text
        assert any(kept in line for line in lines)
        assert max(map(len, lines)) <= 60


@pytest.mark.parametrize(
    ("start", "hang"),
    [
        *(("plain", 2), ("  at place", 4), ("warning: text", 9), ("materials  4 diffuse", 11)),
        *(("by how it was found  aimed at", 21), (" " * 21 + "more", 21)),
    ],
)
def test_further_lines_begin_below_the_text_of_the_first(start: str, hang: int) -> None:
    lines = fitted(start + " word" * 30, Terminal()).split("\n")
    assert [len(line) - len(line.lstrip()) for line in lines[1:]] == [hang] * (len(lines) - 1)


def test_a_word_that_is_wider_than_its_column_has_a_line_of_its_own() -> None:
    digest = "0123456789abcdef" * 3 + "01234567"
    assert fitted(f"digest     {digest}", Terminal()) == f"digest\n  {digest}"


def test_lines_that_fit_or_that_nothing_fits_are_left_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    table = "  10 %   2.1 s (1.9 to 2.4)   grainy, for a layout"
    assert fitted(table, Terminal()) == table
    monkeypatch.setenv("COLUMNS", "20")
    assert fitted(table, Terminal()) == table


def test_messages_and_answers_are_fitted(monkeypatch: pytest.MonkeyPatch) -> None:
    out, err = Terminal(), Terminal()
    monkeypatch.setattr("sys.stdout", out)
    monkeypatch.setattr("sys.stderr", err)
    print_lines(["word " * 20])
    print_warning("word " * 20)
    assert len(out.getvalue().splitlines()) == 2
    assert len(err.getvalue().splitlines()) == 2


def test_pairs_stand_in_columns() -> None:
    assert in_columns([("a", "one"), ("long", "two"), ("", "three")]) == ["a     one", "long  two", "      three"]
    assert in_columns([]) == []
