"""The example of cpp/equaltime/sampling/README.md: a roulette rule as a patch that is small and unbiased."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PATCH = ROOT / "cpp" / "equaltime" / "sampling" / "example-roulette.patch"
MOST_LINES = 60
RULE = "root"
GIT = shutil.which("git")
needs_git = pytest.mark.skipif(GIT is None, reason="git is not installed")


def run(*command: str | Path, cwd: Path, **environment: str) -> str:
    done = subprocess.run(
        [str(c) for c in command], cwd=cwd, env=os.environ | environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-3000:]
    return done.stdout + done.stderr


def test_the_example_changes_fewer_lines_than_it_may() -> None:
    lines = PATCH.read_text().splitlines()
    changed = [line for line in lines if line[:1] in "+-" and not line.startswith(("+++", "---"))]
    assert 10 < len(changed) < MOST_LINES


def test_the_readme_names_every_file_that_the_example_touches() -> None:
    readme = PATCH.with_name("README.md").read_text()
    touched = [line.removeprefix("+++ b/") for line in PATCH.read_text().splitlines() if line.startswith("+++ b/")]
    assert [file for file in touched if f"`{file}`" not in readme] == []


@needs_git
def test_the_example_applies() -> None:
    run("git", "apply", "--check", PATCH, cwd=ROOT)


@pytest.mark.slow
@needs_git
def test_the_example_builds_and_its_rule_is_unbiased(tmp_path: Path) -> None:
    """The rule goes through the tests of all rules, with their power twins; before, there is no such rule."""
    pybind11 = pytest.importorskip("pybind11")
    tree, build = tmp_path / "tree", tmp_path / "build"
    for part in ("CMakeLists.txt", "pyproject.toml", "LICENSE", "README.md"):
        tree.mkdir(exist_ok=True)
        shutil.copy(ROOT / part, tree)
    for part in ("cpp", "python", "scenes", "tests"):
        shutil.copytree(ROOT / part, tree / part, ignore=shutil.ignore_patterns("__pycache__", "_core.*.so"))
    run("git", "apply", PATCH, cwd=tree)
    options = {"CMAKE_BUILD_TYPE": "Release", "EQUALTIME_PYTHON": "ON", "EQUALTIME_TESTS": "OFF"}
    options |= {"Python_EXECUTABLE": sys.executable, "pybind11_DIR": pybind11.get_cmake_dir()}
    run("cmake", "-S", tree, "-B", build, *(f"-D{key}={value}" for key, value in options.items()), cwd=tmp_path)
    run("cmake", "--build", build, "--target", "_core", "--parallel", cwd=tmp_path)
    (module,) = build.glob("_core.*.so")
    shutil.copy(module, tree / "python" / "equaltime")
    tests = ["tests/statistical/test_techniques_agree.py", "tests/unit/test_strategy.py"]
    every = ["-m", "slow or not slow", "-p", "no:cacheprovider", "-q", "-rA"]
    told = run(
        sys.executable, "-m", "pytest", *every, *tests, "-k", "root or strategy", cwd=tree,
        PYTHONPATH=str(tree / "python"),
    )  # fmt: skip
    assert f"PASSED tests/statistical/test_techniques_agree.py::test_strategies_agree[sky-{RULE} roulette]" in told
