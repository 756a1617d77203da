"""glTF files that are rewritten without a change of meaning load to the same bits, and known changes follow.

Each example writes one mesh with a texture in another way: layouts of accessors, containers, JSON. Old faults, put
back, must be caught.
"""

from __future__ import annotations

import random
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

import equaltime as et
from equaltime.scene.geometry import MeshSurface
from equaltime.scene.gltf import accessors, document

from .gltf_rewrites import Writer, arrays

EVERYDAY, MANY = 200, 10_000
SEARCH = (Phase.generate,)
"""Phases for faults: an example that fails is wanted, but not the smallest one."""
Array = NDArray[Any]


def loaded(mesh: dict[str, Array], chance: random.Random | None, folder: Path) -> et.Scene:
    """Write a mesh and load it; without chance, in the plainest way."""
    writer = Writer(chance)
    pixels = np.random.default_rng(7).integers(0, 256, (2, 3, 4), np.uint8)
    writer.document(mesh, pixels, folder)
    return et.load(writer.write(folder))


def parts(scene: et.Scene) -> list[Array]:
    """Return all arrays of the one mesh of a scene."""
    (surface,) = scene.surfaces()
    assert isinstance(surface, MeshSurface)
    assert surface.normals is not None
    assert surface.uvs is not None
    return [surface.vertices, surface.faces, surface.normals, surface.uvs, *surface.attributes.values()]


def same(a: list[Array], b: list[Array]) -> bool:
    return len(a) == len(b) and all(map(np.array_equal, a, b))


def check(seed: int, way: int) -> None:
    with TemporaryDirectory() as plain, TemporaryDirectory() as other:
        mesh = arrays(seed)
        expected, found = loaded(mesh, None, Path(plain)), loaded(mesh, random.Random(way), Path(other))
        assert same(parts(found), parts(expected))
        assert found.digest == expected.digest


def examine(examples: int, phases: Sequence[Phase] = tuple(Phase)) -> None:
    """Look at so many examples; raises AssertionError or SceneError for the first that loads to something else."""

    @settings(max_examples=examples, deadline=None, database=None, phases=phases)
    @given(seed=st.integers(0, 2**16), way=st.integers(0, 2**32))
    def every_example(seed: int, way: int) -> None:
        check(seed, way)

    every_example()


def test_a_file_written_in_another_way_loads_to_the_same_bits() -> None:
    examine(EVERYDAY)


@pytest.mark.slow
def test_a_file_written_in_ten_thousand_ways_loads_to_the_same_bits() -> None:
    examine(MANY)


@settings(max_examples=EVERYDAY, deadline=None, database=None)
@given(seed=st.integers(0, 2**16), way=st.integers(0, 2**32))
def test_known_changes_follow(seed: int, way: int) -> None:
    """A mesh that is moved, turned inside out or painted is that, in whatever way it is written."""
    mesh = arrays(seed)
    changed = {name: values.copy() for name, values in mesh.items()}
    changed["POSITION"][:, 0] += 1
    changed["TEXCOORD_0"] = 1 - changed["TEXCOORD_0"]
    changed["COLOR_0"][:, 0] = 1 - changed["COLOR_0"][:, 0]
    changed["indices"] = changed["indices"].reshape(-1, 3)[:, ::-1].ravel()
    with TemporaryDirectory() as plain, TemporaryDirectory() as other:
        vertices, faces, _, uvs, colors, *_ = parts(loaded(mesh, None, Path(plain)))
        found = parts(loaded(changed, random.Random(way), Path(other)))
    assert np.array_equal(found[0], np.add(vertices, (2, 0, 0)))  # the node scales by two along x
    assert np.array_equal(found[1], faces[:, ::-1])
    assert np.array_equal(found[3], 1 - uvs)
    assert np.array_equal(found[4], np.abs(colors - (1, 0, 0)))


def test_rewritten_files_render_to_the_same_bits(tmp_path: Path) -> None:
    images = []
    for number, chance in enumerate((None, random.Random(1), random.Random(2))):
        folder = tmp_path / str(number)
        folder.mkdir()
        images.append(et.render(loaded(arrays(3), chance, folder).with_(size=(16, 12)), spp=4).image)
    assert images[0].std() > 0.0
    assert all(np.array_equal(image, images[0]) for image in images)


# -- power ------------------------------------------------------------------------------------------------------------


def packed(array: Any) -> Any:
    return lambda document, view, where, dtype, shape, stride, place: array(
        document, view, where, dtype, shape, 0, place
    )


def without_offset(array: Any) -> Any:
    class Nowhere:
        byteOffset = 0  # noqa: N815 -- glTF's name

    return lambda document, view, where, *more: array(document, view, Nowhere(), *more)


FAULTS: dict[str, tuple[Any, str, Any]] = {
    "strides are not looked at": (accessors, "_array", packed),
    "offsets are not looked at": (accessors, "_array", without_offset),
    "sparse values are left out": (
        accessors,
        "_corrected",
        lambda old: lambda document, accessor, values, place: values,
    ),
    "zeros behind the JSON are part of it": (
        document,
        "_chunks",
        lambda old: (
            lambda content: (
                (content[20 : 20 + int.from_bytes(content[12:16], "little")], *old(content)[1:])
                if content.startswith(b"glTF")
                else old(content)
            )
        ),
    ),
}


@pytest.mark.parametrize("name", FAULTS)
def test_old_faults_are_caught(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    where, function, fault = FAULTS[name]
    monkeypatch.setattr(where, function, fault(getattr(where, function)))
    with pytest.raises((AssertionError, et.SceneError, ExceptionGroup)):
        examine(EVERYDAY, SEARCH)
