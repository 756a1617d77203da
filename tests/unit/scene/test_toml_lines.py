"""The line of a key is the one on which it stands, whatever stands in strings before it."""

from __future__ import annotations

import time

import pytest

from equaltime.scene.toml_reader import line_numbers

WITHIN = """begin
scenes = 3
[sensor]
]
# no comment
"quoted" = 1"""


@pytest.mark.parametrize("quotes", ['"""', "'''"])
@pytest.mark.parametrize("end", ["", "''", ' \\"'])
def test_what_looks_like_a_key_within_a_string_is_none(quotes: str, end: str) -> None:
    end = end.replace("'", quotes[0])
    text = f"title = {quotes}{WITHIN}{end}{quotes} # a comment\nscenes = 1\n[sensor]\nfov = 2\n"
    assert line_numbers(text) == {"title": 1, "scenes": 7, "sensor": 8, "sensor.fov": 9}


def test_a_string_over_several_lines_is_one_entry_of_a_list() -> None:
    text = f"list = [\n  '''{WITHIN}'''\n  , 2,\n  3,\n]\nnext = 1\n"
    assert line_numbers(text) == {"list": 1, "list[0]": 2, "list[1]": 8, "list[2]": 9, "next": 11}


@pytest.mark.parametrize("text", ["a = '\"'", "a = \"it'''s\"", "# it'''s \"\"\"", 'a = ""', "a = ''"])
def test_quotes_in_comments_and_in_other_strings_begin_no_string(text: str) -> None:
    assert line_numbers(f"{text}\nb = 1\n'c' = 2\n") | {"a": 1} == {"a": 1, "b": 2, "c": 3}


@pytest.mark.parametrize("letter", ["\u2028", "\u0085", "\f", "\v", "\x1c"])
def test_only_a_line_feed_ends_a_line(letter: str) -> None:
    assert line_numbers(f"a = '{letter}'\r\n# {letter}\n[x]\n") == {"a": 1, "x": 3}


@pytest.mark.parametrize(
    "line", ["a" * 100_000, " " * 100_000, "a " * 50_000, "[" + "a " * 50_000, "= [" + " " * 100_000]
)
def test_a_long_line_takes_no_longer_than_its_length(line: str) -> None:
    begin = time.process_time()
    line_numbers(f'title = """\n{line}"""\nb = 1\n{line}\n')
    assert time.process_time() - begin < 2
