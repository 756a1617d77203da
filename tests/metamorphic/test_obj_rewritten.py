"""An OBJ file in other words is the same scene to the bit; one that says something else is that."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from random import Random
from typing import Any, Final

import numpy as np
import pytest
from hypothesis import find
from hypothesis import strategies as st

import equaltime as et
from equaltime.images import image_files as images
from equaltime.scene import model as m
from equaltime.scene.geometry import MeshSurface
from equaltime.scene.mtl import read_mtl
from equaltime.scene.report import Account

from .examples import assert_same_pictures, sizes, try_spellings
from .obj_files import MATERIALS, NAMES, plain, rewritten, write

RANDOM: Final = st.integers(0, 2**64).map(Random)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("obj")
    pixels = np.random.default_rng(1).integers(0, 255, (8, 8, 3), dtype=np.uint8)
    grey = np.ascontiguousarray(pixels[..., :1])
    for name, channels, stored in (("wood", "RGB", pixels), ("normals", "RGB", pixels), ("heights", "Y", grey)):
        images.write(folder / f"my {name}.png", "png", [images.Layer(tuple(channels), stored, {})])
    return folder


def looks(scene: et.Scene) -> Iterator[tuple[Any, ...]]:
    """Yield what is seen of each shape: all but names, which other words may change."""
    for shape, surface in zip(scene.model.shapes, scene.surfaces(), strict=True):
        if not isinstance(shape, m.Obj):  # the ground and the sun
            continue
        assert isinstance(surface, MeshSurface)
        assert surface.uvs is not None
        arrays = surface.vertices.tolist(), surface.faces.tolist(), surface.uvs.tolist()
        yield re.sub(r"(\./)+my ", "my ", repr(shape.bsdf)), repr(shape.emitter), arrays


def told(scene: et.Scene) -> list[str]:
    return [warning for warning in scene.warnings if "-D " not in warning]


def loaded(folder: Path, random: Random) -> et.Scene:
    return et.load(write(folder, rewritten(random)))


@sizes
def test_other_words_are_the_same_scene(examples: int, folder: Path) -> None:
    expected = list(looks(et.load(write(folder, plain()))))

    def check(random: Random) -> None:
        scene = loaded(folder, random)
        assert list(looks(scene)) == expected
        assert told(scene) == []

    try_spellings(check, examples)


def test_other_words_are_the_same_picture(folder: Path) -> None:
    assert_same_pictures(
        lambda random: loaded(folder, random).with_(size=(16, 12)),
        et.load(write(folder, plain())).with_(size=(16, 12)),
    )


def test_half_a_colour_is_half_a_colour(folder: Path) -> None:
    def colors(files: tuple[bytes, bytes]) -> list[tuple[float, ...]]:
        found = read_mtl(files[1], "a.mtl", Account()).values()
        return [material.color for material in found if material.color is not None]

    files = plain()
    halved = re.sub(
        rb"Kd (\S+) (\S+) (\S+)", lambda f: b"Kd %r %r %r" % tuple(float(x) / 2 for x in f.groups()), files[1]
    )
    assert colors((files[0], halved)) == [tuple(x / 2 for x in color) for color in colors(files)]


def test_another_material_is_another_scene(folder: Path) -> None:
    """The comparison sees one number, and one face of another material."""
    files = plain()
    expected = list(looks(et.load(write(folder, files))))
    assert list(looks(et.load(write(folder, (files[0], files[1].replace(b"Kd 0.75", b"Kd 0.76")))))) != expected
    other = files[0].replace(b"usemtl red\nf 4/4", b"usemtl lamp\nf 4/4")
    assert list(looks(et.load(write(folder, (other, files[1]))))) != expected


# ---- faults that readers had: each is found among the files above


def parts_by_pattern(content: bytes) -> list[str]:
    """The materials that have faces, as regular expressions see them beside the reader of the faces."""
    found = list(re.finditer(rb"^[ \t]*(usemtl|mtllib)[ \t]+([^\r\n#]*)", content, re.MULTILINE))
    return [match[2].decode("utf-8", "replace").strip() for match in found if match[1] == b"usemtl"]


def colors_by_words(content: bytes) -> dict[str, tuple[float, ...]]:
    """The colours of materials, where a blank is the only separator and a name begins and ends its line."""
    found: dict[str, tuple[float, ...]] = {}
    current = ""
    for line in content.decode("utf-8", "replace").splitlines():
        word, _, rest = line.strip().partition(" ")
        if word == "newmtl":
            current = rest.strip()
        elif word == "Kd":
            try:
                numbers = [float(x) for x in rest.split()[:3]]
            except ValueError:
                continue
            found[current] = tuple(numbers if len(numbers) == 3 else numbers[:1] * 3)
    return found


def test_the_old_pattern_for_materials_would_be_caught() -> None:
    assert set(parts_by_pattern(plain()[0])) == {name.decode() for name in NAMES}
    find(RANDOM, lambda random: len(set(parts_by_pattern(rewritten(random)[0]))) != len(NAMES))


def test_the_old_reader_of_libraries_would_be_caught() -> None:
    colors = sorted(paint.color for paint in MATERIALS if paint.color is not None)
    assert sorted(colors_by_words(plain()[1]).values()) == colors
    find(RANDOM, lambda random: sorted(colors_by_words(rewritten(random)[1]).values()) != colors)
