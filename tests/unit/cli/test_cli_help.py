"""The help of commands: groups of options, no types on flags, and suggestions for options of other programs."""

from __future__ import annotations

import pytest

from equaltime.cli import COMMANDS, main
from equaltime.cli.help import PANELS


@pytest.mark.parametrize("command", [command.__name__ for command in COMMANDS])
def test_the_help_has_neither_braces_nor_types_of_flags(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([command, "-h"]) == 0
    text = capsys.readouterr().out
    usage = next(line for line in text.splitlines() if "Usage:" in line)
    assert not set("{}") & set(usage)
    assert usage.rstrip().endswith("[options]")
    assert "<bool>" not in text


def test_options_stand_in_groups(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["render", "-h"]) == 0
    text = capsys.readouterr().out
    places = [text.index(f" {panel} ─") for panel in PANELS]
    assert places == sorted(places)
    assert " Options ─" not in text


@pytest.mark.parametrize(
    ("option", "meant"),
    [
        ("--samples", "did you mean --spp?"),
        ("--output-size", "did you mean --size?"),
        ("--resolution", "did you mean --size?"),
        ("-t", "did you mean --time?"),
        ("--seeed", "did you mean --seed?"),
        ("--denoise", "--error renders until the noise is small"),
        ("--xyzzy", "--help lists all"),
    ],
)
def test_an_unknown_option_names_the_one_that_is_meant(
    option: str, meant: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["render", "a.toml", "-o", "a.exr", option, "1"]) == 2
    told = capsys.readouterr().err
    assert told.startswith(f"error: there is no option {option}")
    assert told.rstrip().endswith(meant)


def test_options_of_other_commands_and_programs_name_the_way_out(capsys: pytest.CaptureFixture[str]) -> None:
    for words, way in (
        (
            ["convert", "a.exr", "a.png", "--transparent"],
            "equaltime render has it, and a finished picture gets no alpha",
        ),
        (["render", "a.toml", "-o", "a.exr", "--denoise"], "integrator 'aov' of the scene writes albedo and normals"),
    ):
        assert main(words) == 2
        assert way in capsys.readouterr().err


def test_the_program_has_a_short_version_option_and_completion(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["-V"]) == 0
    assert capsys.readouterr().out.startswith("equaltime ")
    assert main(["-h"]) == 0
    assert "--install-completion" in capsys.readouterr().out
