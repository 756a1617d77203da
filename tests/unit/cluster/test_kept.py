"""Units that are kept in files: what is read back, to which render they belong, and damage."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import equaltime as et
from equaltime.cluster.kept import KeptUnits
from equaltime.cluster.units import probe_unit
from equaltime.errors import ImageError
from equaltime.rendering.units import Rendered, Unit, add_samples

SCENE = et.load("cornell-box").with_(size=(40, 40))
UNIT = probe_unit(SCENE)


@pytest.fixture(scope="module")
def rendered() -> Rendered:
    found = add_samples(SCENE, UNIT, 1)
    return replace(found, nonfinite=((1, 2, 3),), faulty=((4, 5, 6, "overflow"),), pixel_rays=np.ones((16, 16), "u8"))


def test_a_kept_unit_comes_back_as_it_was(tmp_path: Path, rendered: Rendered) -> None:
    kept = KeptUnits(tmp_path / "units", SCENE.digest)
    kept.keep(UNIT, rendered)
    (found,) = kept.of(UNIT.recipe)
    assert (found.window, found.begin, found.end) == (UNIT.window, UNIT.begin, UNIT.end)
    again = found.read()
    assert again is not None
    assert again.pixel_rays is not None
    assert again.moments.tobytes() == rendered.moments.tobytes()
    assert (again.second.shape, again.pixel_rays.sum()) == (rendered.second.shape, 256)
    facts = ("counters", "nonfinite", "faulty", "seconds", "core_seconds", "threads", "process")
    assert all(getattr(again, name) == getattr(rendered, name) for name in facts)


@pytest.mark.parametrize("change", [{"seed": 1}, {"strategy": "bsdf"}, {"build": "{}"}, {"nets": 1}])
def test_units_of_another_render_are_not_taken(tmp_path: Path, rendered: Rendered, change: dict[str, object]) -> None:
    kept = KeptUnits(tmp_path, SCENE.digest)
    kept.keep(UNIT, rendered)
    assert kept.of(replace(UNIT.recipe, **change)) == []  # type: ignore[arg-type]
    assert KeptUnits(tmp_path, "0" * 64).of(UNIT.recipe) == []


def test_a_damaged_unit_is_not_taken(tmp_path: Path, rendered: Rendered) -> None:
    kept = KeptUnits(tmp_path, SCENE.digest)
    kept.keep(UNIT, rendered)
    (file,) = tmp_path.iterdir()
    whole = file.read_bytes()
    for place in range(100, len(whole), 997):
        file.write_bytes(whole[:place] + bytes([whole[place] ^ 4]) + whole[place + 1 :])
        found = kept.of(UNIT.recipe)[0].read()
        assert found is None or found.moments.tobytes() == rendered.moments.tobytes()
    file.write_bytes(whole[: len(whole) // 2])
    assert kept.of(UNIT.recipe)[0].read() is None


def test_forgotten_units_are_gone(tmp_path: Path, rendered: Rendered) -> None:
    kept = KeptUnits(tmp_path / "units", SCENE.digest)
    kept.keep(UNIT, rendered)
    kept.forget()
    kept.forget()
    assert not (tmp_path / "units").exists()
    assert kept.of(UNIT.recipe) == []


def test_a_folder_that_cannot_be_written_is_an_error(tmp_path: Path, rendered: Rendered) -> None:
    (tmp_path / "units").write_text("a file")
    with pytest.raises(ImageError, match="cannot be kept"):
        KeptUnits(tmp_path / "units", SCENE.digest).keep(UNIT, rendered)


def test_a_unit_is_for_one_build_alone() -> None:
    from equaltime.cluster import render_unit
    from equaltime.errors import RenderError

    other = Unit(**{**UNIT.__dict__, "recipe": replace(UNIT.recipe, build='{"version": "0"}')})
    with pytest.raises(RenderError, match="other bits"):
        render_unit("0" * 64, other)
