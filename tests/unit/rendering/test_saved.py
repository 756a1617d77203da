"""Saved renders that are read again: the result that was saved, and as good as its file."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

import equaltime as et
from equaltime.film.lamps import Lamps
from equaltime.rendering import core

CORNELL = Path(__file__).parents[3] / "scenes" / "cornell-box.toml"
MEASURED = ("stats",)
"""Fields that hold a clock's seconds."""
BEFORE = Path(__file__).parents[1] / "data" / "format_1"


def scene(size: tuple[int, int] = (40, 32)) -> et.Scene:
    return et.load(CORNELL).with_(size=size)


def assert_same(found: et.Result, wanted: et.Result, but: tuple[str, ...] = ()) -> None:
    """Compare every field; arrays to the bit."""
    for field in dataclasses.fields(et.Result):
        if field.name in (*but, "saved"):  # the file, which only one that was read has
            continue
        ours, theirs = (getattr(result, field.name) for result in (found, wanted))
        if field.name == "second":
            ours, theirs = (None if each is None else each.moments for each in (ours, theirs))
        if field.name in ("missed", "aovs"):
            assert ours.keys() == theirs.keys(), field.name
            for name in ours:
                np.testing.assert_array_equal(ours[name], theirs[name], err_msg=name)
        elif ours is None or not isinstance(ours, np.ndarray):
            assert ours == theirs, field.name
        else:
            np.testing.assert_array_equal(ours, theirs, err_msg=field.name)


@pytest.mark.parametrize("how", [{"spp": 8}, {"error": 0.5}, {"spp": 20, "without": ("long_paths=3",)}])
def test_a_result_that_is_read_is_the_one_that_was_saved(how: dict[str, object], tmp_path: Path) -> None:
    wanted = et.render(scene(), **how)  # type: ignore[arg-type]
    wanted.save(tmp_path / "a.exr")
    assert_same(et.read(tmp_path / "a.exr"), wanted)


def test_one_net_with_its_second_nets_is_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(core, "ONE_NET", 1)
    monkeypatch.setattr(Lamps, "mostly_small", False)  # at this size the lamp is hardly a pixel
    wanted = et.render(scene(), spp=8)
    wanted.save(tmp_path / "a.exr")
    assert wanted.second is not None
    assert_same(et.read(tmp_path / "a.exr"), wanted)


def test_outputs_beside_the_image_are_read(tmp_path: Path) -> None:
    integrator = {"type": "aov", "aovs": "z:depth", "inner": {"type": "path"}}
    wanted = et.render(
        et.load_dict(
            {
                "type": "scene",
                "integrator": integrator,
                "sensor": {"type": "perspective", "film": {"type": "hdrfilm", "width": 8, "height": 6}},
                "light": {"type": "constant"},
            }
        ),
        spp=4,
    )
    wanted.save(tmp_path / "a.exr")
    assert_same(et.read(tmp_path / "a.exr"), wanted)


def test_results_serve_wherever_files_do(tmp_path: Path) -> None:
    first, second = (et.render(scene(), spp=8, seed=seed) for seed in (1, 2))
    first.save(tmp_path / "a.exr")
    second.save(tmp_path / "b.exr")
    read = et.read(tmp_path / "a.exr")
    assert_same(et.merge([read, second]), et.merge([tmp_path / "a.exr", tmp_path / "b.exr"]), MEASURED)
    assert_same(et.merge([first, tmp_path / "b.exr"]), et.merge([read, second]), MEASURED)
    longer = et.render(scene(), spp=16, seed=1)
    np.testing.assert_array_equal(et.render(scene(), spp=16, seed=1, resume=read).image, longer.image)
    found, wanted = (et.compare(*pair) for pair in ((read, second), (tmp_path / "a.exr", tmp_path / "b.exr")))
    assert repr(found.images[0].metrics) == repr(wanted.images[0].metrics)  # NaN where B is too noisy to tell
    assert str(found.against) == "the render with seed 2"


def test_what_cannot_be_merged_is_named_by_its_seed() -> None:
    one = et.render(scene(), spp=4, seed=3)
    with pytest.raises(et.ImageError, match=r"the render with seed 3: cannot be merged with .* seed 3: both have"):
        et.merge([one, one])


def test_small_files_are_read_without_what_merging_needs(tmp_path: Path) -> None:
    wanted = et.render(scene(), spp=4)
    wanted.save(tmp_path / "a.exr", small=True)
    found = et.read(tmp_path / "a.exr")
    assert found.moments is None
    assert found.error == wanted.error
    np.testing.assert_allclose(found.image, wanted.image, rtol=2e-3, atol=1e-6)
    with pytest.raises(et.ImageError, match="holds no moments"):
        et.merge([found, wanted])


def test_renders_of_the_version_before_are_read() -> None:
    for path in sorted(BEFORE.glob("*.exr")):
        found = et.read(path)
        assert found.error.known
        assert found.stats.seconds > 0.0


def test_another_program_s_image_is_no_render(tmp_path: Path) -> None:
    picture = tmp_path / "a.png"
    et.render(scene((8, 8)), spp=2).save(picture)
    with pytest.raises(et.ImageError, match="was not rendered by equaltime"):
        et.read(picture)


def test_a_result_that_is_read_has_its_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    result = et.render(et.load("cornell-box").with_(size=(4, 4)), spp=2)
    result.save("a.exr")
    assert result.saved is None
    assert (read := et.read("a.exr")).saved == tmp_path / "a.exr"
    assert et.render(et.load("cornell-box").with_(size=(4, 4)), spp=4, resume=read).saved is None
