"""The commit that records name: it comes from git in a checkout, from a file in a wheel, or it is unknown."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

import equaltime as et
from equaltime.rendering import session
from equaltime.revision import UNKNOWN_REVISION, revision

TOP = Path(__file__).parents[2]
SCENE = TOP / "scenes" / "cornell-box.toml"


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    """Make a checkout with one commit; returns the folder of its package."""
    package = tmp_path / "python" / "equaltime"
    package.mkdir(parents=True)
    (tmp_path / "pyproject.toml").write_text('[project]\nname = "equaltime"\n')
    (package / "a.py").write_text("a = 1\n")
    git(tmp_path, "init", "-q")
    git(tmp_path, "add", ".")
    git(tmp_path, "commit", "-q", "-m", "first")
    return package


def git(folder: Path, *words: str) -> str:
    if shutil.which("git") is None:
        pytest.skip("there is no git")
    who = {f"GIT_{role}_{key}": "x@y" for role in ("AUTHOR", "COMMITTER") for key in ("NAME", "EMAIL")}
    return subprocess.run(
        ["git", *words], cwd=folder, env={**os.environ, **who}, check=True, capture_output=True, text=True
    ).stdout.strip()


def test_a_checkout_has_its_commit_and_tells_of_changes(checkout: Path) -> None:
    commit = git(checkout, "rev-parse", "HEAD")
    assert revision.__wrapped__(checkout) == commit
    (checkout / "a.py").write_text("a = 2\n")
    assert revision.__wrapped__(checkout) == f"{commit} with uncommitted changes"


def test_another_repository_round_a_copy_of_the_package_does_not_count(checkout: Path) -> None:
    (checkout.parents[1] / "pyproject.toml").write_text('[project]\nname = "mine"\n')
    assert revision.__wrapped__(checkout) == UNKNOWN_REVISION


def test_a_wheel_has_the_commit_in_a_file(tmp_path: Path) -> None:
    package = tmp_path / "lib" / "equaltime"
    package.mkdir(parents=True)
    assert revision.__wrapped__(package) == UNKNOWN_REVISION
    (package / "revision.txt").write_text("c0ffee\n")
    assert revision.__wrapped__(package) == "c0ffee"


def test_without_git_the_commit_is_unknown(checkout: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", "/nowhere")
    assert revision.__wrapped__(checkout) == UNKNOWN_REVISION


def test_importing_the_package_does_not_ask_git() -> None:
    code = "import sys, equaltime; sys.exit('equaltime.revision' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


@pytest.fixture
def committed(monkeypatch: pytest.MonkeyPatch) -> Callable[[str], None]:
    return lambda text: monkeypatch.setattr(session, "revision", lambda: text)


def test_renders_of_two_commits_are_resumed_and_merged_and_name_both(
    tmp_path: Path, committed: Callable[[str], None]
) -> None:
    scene = et.load(SCENE).with_(size=(8, 6))
    committed("one")
    first = et.render(scene, spp=4, seed=1)
    first.save(tmp_path / "a.exr")
    assert et.read(tmp_path / "a.exr").record["revisions"] == ["one"]
    committed("two")
    resumed = et.render(scene, spp=8, seed=1, resume=tmp_path / "a.exr")
    assert resumed.record["revisions"] == ["one", "two"]
    other = et.render(scene, spp=4, seed=2)
    assert et.merge([first, other]).record["revisions"] == ["one", "two"]
    assert (resumed.image == et.render(scene, spp=8, seed=1).image).all()
