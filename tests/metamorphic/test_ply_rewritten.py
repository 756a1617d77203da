"""A PLY file in other words is the same mesh to the bit; one that says something else is that."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
import pytest
from hypothesis import find
from hypothesis import strategies as st

import equaltime as et
from equaltime._core import read_ply
from equaltime.scene import model as m
from equaltime.scene.geometry import MeshSurface

from .examples import assert_same_pictures, sizes, try_spellings
from .ply_files import plain, rewritten


def written(folder: Path, content: bytes) -> Path:
    (folder / "a.ply").write_bytes(content)
    return folder / "a.ply"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("ply")


def looks(scene: et.Scene) -> tuple[Any, ...]:
    """Return what is seen of the mesh."""
    (shape, *_), (surface, *_) = scene.model.shapes, scene.surfaces()  # then the ground and the sun
    assert isinstance(shape, m.Ply)
    assert isinstance(surface, MeshSurface)
    arrays = (surface.vertices, surface.faces, surface.normals, surface.uvs, surface.attributes["vertex_color"])
    assert shape.bsdf is not None
    return repr(shape.bsdf), *(np.asarray(array).tolist() for array in arrays)


def loaded(folder: Path, random: Random) -> et.Scene:
    return et.load(written(folder, rewritten(random)))


@sizes
def test_other_words_are_the_same_mesh(examples: int, folder: Path) -> None:
    expected = looks(et.load(written(folder, plain())))

    def check(random: Random) -> None:
        scene = loaded(folder, random)
        assert looks(scene) == expected
        told = [warning for warning in scene.warnings if "line " in warning]
        assert all("is a property that is not used" in line or "'edge' is an element" in line for line in told)

    try_spellings(check, examples)


def test_other_words_are_the_same_picture(folder: Path) -> None:
    assert_same_pictures(
        lambda random: loaded(folder, random).with_(size=(16, 12)),
        et.load(written(folder, plain())).with_(size=(16, 12)),
    )


@pytest.mark.parametrize("change", [(b"-0.375", b"-0.5"), (b" 254 1 0", b" 253 1 0"), (b"3 0 1 4", b"3 0 4 1")])
def test_another_number_is_another_mesh(change: tuple[bytes, bytes], folder: Path) -> None:
    assert change[0] in plain()
    changed = looks(et.load(written(folder, plain().replace(*change))))
    assert changed != looks(et.load(written(folder, plain())))


def test_a_colour_does_not_depend_on_those_of_others(folder: Path) -> None:
    """The reader once divided by 255 where one number of the file was more than 1, which is found here."""

    def first(scale: Callable[[Any], Any], other: int) -> list[float]:
        path = written(folder, plain([(1, 1, 1)] * 4 + [(other,) * 3]))
        row: list[float] = scale(read_ply(path).attributes["vertex_color"])[0].tolist()
        return row

    def by_largest(colors: Any) -> Any:
        return colors / 255 if colors.max() > 1.0 else colors

    def as_read(colors: Any) -> Any:
        shape, *_ = et.load(folder / "a.ply").model.shapes
        reflectance = shape.bsdf.bsdf[0].reflectance  # type: ignore[union-attr, index]
        assert isinstance(reflectance, m.MeshAttribute)
        return reflectance.numbers(colors)

    assert find(st.integers(0, 255), lambda other: first(by_largest, other) != first(by_largest, 1)) == 2
    assert all(first(as_read, other) == pytest.approx([1 / 255] * 3) for other in (0, 1, 2, 255))
