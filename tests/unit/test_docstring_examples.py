"""The examples in the docstrings of public functions are run, and print what they say."""

from __future__ import annotations

import doctest
import inspect
from pathlib import Path

import pytest

import equaltime as et

CORNELL = Path(__file__).parents[2] / "scenes" / "cornell-box.toml"
FUNCTIONS = [name for name in et.__all__ if inspect.isfunction(getattr(et, name))]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with the files that examples name: a small scene and two renders of it."""
    place = tmp_path_factory.mktemp("examples")
    text = CORNELL.read_text()
    (place / "scene.toml").write_text(text)
    scene = et.load(place / "scene.toml").with_(size=(16, 16))
    small = text.replace("width = 256", "width = 16").replace("height = 256", "height = 16")
    (place / "scene.toml").write_text(small)
    assert et.load(place / "scene.toml").size == scene.size
    for seed, name in enumerate(("a.exr", "b.exr")):
        et.render(place / "scene.toml", spp=16, seed=seed).save(place / name)
    return place


@pytest.mark.parametrize("name", FUNCTIONS)
def test_the_example_prints_what_it_says(name: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder)
    function = getattr(et, name)
    (found,) = (one for one in doctest.DocTestFinder(recurse=False).find(function, name, globs={"et": et}))
    assert found.examples, f"{name} has no example"
    report: list[str] = []
    doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE).run(found, out=report.append)
    assert report == []
