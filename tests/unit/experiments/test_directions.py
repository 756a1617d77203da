"""Where sampling sends rays: what is drawn on which surface, how much of it counts, and that the page shows it."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import equaltime as et
from equaltime.errors import ImageError
from equaltime.experiments.report import page
from equaltime.experiments.report.rays import draw_rays
from equaltime.experiments.run.directions import DRAWN, Rays, read_directions, sample_directions, write_directions
from equaltime.scene import Scene

from .fake_summary import summary
from .test_report import Page

SKY = {"type": "scene", "sensor": {"type": "perspective"}, "sky": {"type": "constant"}}
SILVER = {"eta": [0.16, 0.14, 0.13], "k": [4.0, 3.2, 2.4]}


def scene(**bsdf: Any) -> Scene:
    """Return a ball of some material in front of a wall of another, the camera looking at the ball."""
    ball = {"type": "sphere", "center": [0.0, 0.0, 5.0], "bsdf": bsdf}
    wall = {"type": "rectangle", "to_world": [[9, 0, 0, 0], [0, 9, 0, 0], [0, 0, -1, 9], [0, 0, 0, 1]]}
    return et.load_dict(SKY | {"wall": wall, "ball": ball})


def rays(**bsdf: Any) -> dict[str, Rays]:
    found = sample_directions(scene(**bsdf))
    assert found is not None
    return found


def test_samples_of_a_matte_surface_all_carry_its_reflectance() -> None:
    found = rays(type="diffuse", reflectance=0.6)
    assert found["bsdf"].weight == pytest.approx(0.6, rel=1e-5)
    assert found["bsdf"].effective == pytest.approx(1.0)


def test_uniform_directions_on_a_matte_surface_are_three_quarters_effective() -> None:
    uniform = rays(type="diffuse", reflectance=0.6)["uniform"]
    assert uniform.effective == pytest.approx(0.75, abs=0.01)  # (∫ cos)² / (2π ∫ cos²) over the hemisphere
    assert uniform.weight == pytest.approx(1.2 * uniform.wi[:, 2], rel=1e-4)
    assert abs(uniform.wi[:, 2].mean() - 0.5) < 4.0 * math.sqrt(1.0 / 12.0 / DRAWN)


def test_the_smoother_a_surface_the_less_of_uniform_directions_counts() -> None:
    parts = [rays(type="roughconductor", distribution="ggx", alpha=a, **SILVER) for a in (0.3, 0.1, 0.01, 0.001)]
    uniform = [found["uniform"].effective for found in parts]
    assert all(later < earlier / 3.0 for earlier, later in pairwise(uniform))
    assert uniform[-1] < 1e-4
    assert all(found["bsdf"].effective > 0.8 for found in parts)


def test_a_mirror_has_one_direction_whoever_asks() -> None:
    found = rays(type="conductor", **SILVER)
    for way in found.values():
        assert np.allclose(way.wi, [-math.sqrt(0.5), 0.0, math.sqrt(0.5)], atol=1e-6)
        assert math.isnan(way.effective)


def test_glass_is_sampled_on_both_sides() -> None:
    found = rays(type="dielectric")
    assert (found["bsdf"].wi[:, 2] < 0.0).any()


def test_what_scatters_nothing_has_nothing_to_draw() -> None:
    assert sample_directions(scene(type="diffuse", reflectance=0.0)) is None


def test_where_nothing_is_in_the_middle_there_is_nothing_to_draw(tmp_path: Path) -> None:
    empty = et.load_dict(SKY)
    assert sample_directions(empty) is None
    write_directions(tmp_path / "d.npz", ["empty", "matte"], [empty, scene(type="diffuse")])
    assert list(read_directions(tmp_path / "d.npz")) == ["matte"]


def test_what_cannot_be_read_is_told(tmp_path: Path) -> None:
    with pytest.raises(ImageError):
        read_directions(tmp_path / "d.npz")


def test_the_page_shows_the_pictures_of_every_scene(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(page, "write_figures", lambda *_: ())
    path = tmp_path / "d.npz"
    write_directions(path, ["matte", "$x_y$"], [scene(type="diffuse"), scene(type="conductor", **SILVER)])
    value = replace(summary(tmp_path), directions=path)
    shown = Page(page.write_report(value, tmp_path).read_text("utf-8"))
    assert "Where the rays go" in shown.visible
    pictures = [str(svg["aria-label"]) for svg in shown.all("svg") if "Rays" in str(svg.get("aria-label"))]
    assert len(pictures) == 2
    assert "matte: 7" in pictures[0]
    assert "$x_y$: one direction uniform, one direction from the BSDF" in pictures[0]
    assert (tmp_path / "figures" / "directions.pdf").exists()


def test_a_phone_gets_two_columns(tmp_path: Path) -> None:
    write_directions(
        tmp_path / "d.npz", ["a", "b", "c"], [scene(type="diffuse", reflectance=r) for r in (0.2, 0.4, 0.6)]
    )
    figure = draw_rays(read_directions(tmp_path / "d.npz"), 2)
    assert len(figure.axes) == 6
    assert figure.get_size_inches()[1] > figure.get_size_inches()[0]
