"""README.md and the READMEs of folders: links lead to files, commands and options exist, examples run."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from datetime import date
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from typer.main import get_command

import equaltime as et
from equaltime.cli import COMMANDS, app, main

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text()
FOLDERS = ("cpp", "python", "scenes", "tests")
PAGES = [ROOT / "README.md", *sorted(path for folder in FOLDERS for path in (ROOT / folder).rglob("README.md"))]
SMALL = {
    "(128, 128)": "(12, 12)",
    "spp=1024": "spp=16",
    "spp=256": "spp=8",
    "spp=64": "spp=4",
    "error=0.02": "error=0.9",
    "error=0.1": "error=0.9",
}
"""What makes the example in Python quick."""
NAMES = {command.__name__ for command in COMMANDS}


def test_the_readme_is_short() -> None:
    assert len(README.splitlines()) <= 160


def test_it_counts_the_experiments_and_those_that_go_back_to_a_source() -> None:
    page = (ROOT / "scenes" / "experiments" / "README.md").read_text()
    rows = re.findall(r"^\| `[\w-]+\.toml` \|.*\| (.*) \|$", page, re.MULTILINE)
    sources = [row for row in rows if re.search(r"\[\d\]", row)]
    assert f"[{len(rows)} experiments, {len(sources)} of them on published work]" in README


def test_it_is_cited_by_its_version() -> None:
    (version,) = re.findall(r"VERSION (\d+\.\d+\.\d+)", (ROOT / "CMakeLists.txt").read_text())
    assert f"version: {version}\n" in (ROOT / "CITATION.cff").read_text()


def test_the_bibtex_entry_agrees_with_the_citation_file() -> None:
    """CFF 1.2.0: a day is text, year-month-day."""
    citation = (ROOT / "CITATION.cff").read_text()
    page = (ROOT / "scenes" / "experiments" / "README.md").read_text()
    (entry,) = re.findall(r"```bibtex\n@software\{equaltime,\n(.*?)^\}", page, flags=re.MULTILINE | re.DOTALL)
    fields = dict(re.findall(r"^  (\w+) = \{(.*)\},$", entry, flags=re.MULTILINE))
    said = dict(re.findall(r'^(?:  - )?([a-z-]+): "?(.*?)"?$', citation, flags=re.MULTILINE))
    assert said["cff-version"] == "1.2.0"
    assert fields == {
        "title": said["title"],
        "author": f"{{{said['name']}}}",
        "version": said["version"],
        "year": date.fromisoformat(said["date-released"]).strftime("%Y"),
    }


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_lead_to_files_and_headings(page: Path) -> None:
    wrong = []
    for link in re.findall(r"\]\((?!https?:)([^)\s]+)\)", page.read_text()):
        path, _, heading = link.partition("#")
        target = (page.parent / path) if path else page
        if not target.exists() or (heading and heading not in headings(target)):
            wrong.append(link)
    assert wrong == []


def headings(page: Path) -> set[str]:
    """Return the anchors of a page's headings, as GitHub makes them."""
    titles = re.findall(r"^#+ (.*)$", page.read_text(), re.MULTILINE)
    return {re.sub(r"[^\w -]", "", title.lower()).replace(" ", "-") for title in titles}


def test_the_table_has_every_command() -> None:
    assert set(re.findall(r"^\| `equaltime (\w+)", README, re.MULTILINE)) == NAMES


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_commands_and_options_exist(page: Path) -> None:
    lines = re.findall(r"`(equaltime [^`]+)`", page.read_text())
    lines += re.findall(r"^(?:\.venv/bin/)?(equaltime .*?)(?:\s+#.*)?$", page.read_text(), re.MULTILINE)
    for line in lines:
        _, command, *words = shlex.split(line.replace("…", ""))
        assert command in NAMES, line
        options = {word.split("=")[0] for word in words if word.startswith("--")}
        assert options <= known_options(command), line


@cache
def known_options(command: str) -> set[str]:
    """Return the options of a command."""
    found: Any = get_command(app)
    return {
        option
        for parameter in found.commands[command].params
        for option in (*parameter.opts, *parameter.secondary_opts)
    }


def test_the_example_in_python_runs(tmp_path: Path) -> None:
    (block,) = re.findall(r"^```python\n(.*?)^```", README, re.DOTALL | re.MULTILINE)
    code = block.replace("scenes/cornell-box.toml", str(ROOT / "scenes" / "cornell-box.toml"))
    for long, short in SMALL.items():
        code = code.replace(long, short)
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "time to" in done.stdout or "faster" in done.stdout or "best" in done.stdout


def test_the_error_that_the_learn_page_shows_is_what_its_command_prints(tmp_path: Path) -> None:
    text = (ROOT / "scenes" / "learn" / "README.md").read_text()
    (command,) = re.findall(r"^equaltime (render .*? -o four\.exr .*)$", text, re.MULTILINE)
    (shown,) = re.findall(r"This one states (\S+) % \((\S+) to (\S+)\)", text)
    words = shlex.split(command.replace("scenes/", f"{ROOT}/scenes/").replace("four.exr", str(tmp_path / "four.exr")))
    assert main(words) == 0
    error = et.read(tmp_path / "four.exr").error
    printed = [100.0 * number for number in (error.value, error.low, error.high)]
    assert [float(number) for number in shown] == pytest.approx(printed, rel=0.03)


def test_the_bright_dot_of_the_learn_page_is_what_its_command_finds(capsys: pytest.CaptureFixture[str]) -> None:
    text = (ROOT / "scenes" / "learn" / "README.md").read_text()
    by_chance, by_both = re.findall(r"^equaltime (replay .*)$", text, re.MULTILINE)
    (shown,) = re.findall(r"Two of the pixel's 50 samples met a lamp, each with (\d+)\. The other (\d+) are bla", text)
    assert main(shlex.split(by_chance.replace("scenes/", f"{ROOT}/scenes/"))) == 0
    first = capsys.readouterr().out.partition("\n")[0]
    said = r"sample (\d+) .* of the first 50 is one of the 2 brightest: luminance (\d+); the other (\d+) are black"
    sample, *printed = re.findall(said, first)[0]
    assert f"--sample {sample} " in by_both
    assert [*shown] == printed
    assert main(shlex.split(by_both.replace("scenes/", f"{ROOT}/scenes/"))) == 0
    radiance = re.findall(r"^radiance (\S+)", capsys.readouterr().out, re.MULTILINE)
    assert re.findall(r"The sample is now (\S+) where it\nwas 300", text) == radiance


def test_the_programs_of_the_learn_page_print_what_it_says(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Their seeds are fixed: only a rounding of the last digit may differ."""
    monkeypatch.chdir(ROOT)
    text = (ROOT / "scenes" / "learn" / "README.md").read_text()
    blocks = re.findall(r"^```python\n(.*?)^```", text, re.DOTALL | re.MULTILINE)
    assert len(blocks) == 4
    for block in blocks:
        exec(block, {})
        (said,) = re.findall(r"  # (.*)$", block, re.MULTILINE)
        numbers = re.findall(r"\d+\.\d+", said)
        printed = [float(number) for number in capsys.readouterr().out.split()]
        assert len(printed) == len(numbers)
        for number, found in zip(numbers, printed, strict=True):
            assert found == pytest.approx(float(number), abs=10.0 ** -len(number.partition(".")[2]))


def test_the_error_that_the_readme_shows_is_what_its_example_prints() -> None:
    (shown,) = re.findall(r"an Interval as three numbers: (\S+), (\S+), (\S+)$", README, re.MULTILINE)
    error = et.render(et.load(ROOT / "scenes" / "cornell-box.toml").with_(size=(128, 128)), spp=64).error
    assert [float(number) for number in shown] == pytest.approx([error.value, error.low, error.high], rel=0.03)
