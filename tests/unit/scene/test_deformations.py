"""Meshes that deform as scenes have them: how they are written, where they are at a time, what calls for motion."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import equaltime as et
from equaltime.pricing import derive, leave_out
from equaltime.scene import deforming, motion
from equaltime.scene.export.files import write_ply
from equaltime.scene.export.plain import mitsuba_dict
from equaltime.scene.geometry import MeshSurface
from equaltime.scene.model import Deformation, Ply

from ...invariants.shipped import same_bits
from ...statistical.sheets import FACES, TIMES, deformation, sheet, write
from .test_motion import animated, bits, rays, scene
from .test_serialized import several, stream

Array = NDArray[np.float64]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("sheets")
    write(path)
    return path


def cloth(folder: Path, *numbers: int, **more: Any) -> dict[str, Any]:
    return {"type": "ply", "filename": deformation(folder, *numbers)} | more


def between(time: float) -> Array:
    """Return the vertices at a time: evenly between keys."""
    return np.stack([np.interp(time, TIMES, column) for column in np.array([sheet(t)[0].ravel() for t in TIMES]).T])


@pytest.mark.parametrize("kind", ["by itself", "without normals", "mirrored", "moving", "in an instance"])
def test_a_mesh_that_deforms_is_at_each_time_the_still_mesh_of_that_time(
    kind: str, folder: Path, tmp_path: Path
) -> None:
    if kind == "without normals":
        write(tmp_path, normals=False)
    it = cloth(tmp_path if kind == "without normals" else folder)
    parts: dict[str, Any] = {"it": it}
    if kind == "mirrored":
        it["to_world"] = [{"scale": [-1, 1, 1]}]
    if kind == "moving":
        turn = {"rotate": {"axis": [1, 2, 3], "angle": 100}}
        it["to_world"] = animated([{"time": 0, "translate": [-0.5, 0, 0]}, {"time": 1, "transform": [turn]}])
    if kind == "in an instance":
        spot = {"type": "instance", "g": {"type": "ref", "id": "it"}, "to_world": [{"scale": 0.7}]}
        parts = {"it": {"type": "shapegroup", "a": it}, "here": spot}
    moving = scene(**parts)
    assert moving.core.effects()["motion"]
    origins, directions = rays(3000)
    for time in (0.0, 0.125, 0.25, 0.6, 1.0):
        expected = moving.replaced(motion.at_time(moving.model, time)).core.intersect(origins, directions)
        found = moving.core.intersect(origins, directions, time=time)
        both = (expected["shape"] > 0) & (found["shape"] > 0)
        same = both & (found["primitive"] == expected["primitive"])
        assert ((expected["shape"] > 0) != (found["shape"] > 0)).sum() <= 3, "but for what grazes an edge"
        assert same.sum() > 0.99 * both.sum() > 100
        np.testing.assert_allclose(found["t"][same], expected["t"][same], rtol=1e-5)
        np.testing.assert_array_equal(found["front"][same], expected["front"][same])
        np.testing.assert_allclose(found["shading_normal"][same], expected["shading_normal"][same], atol=1e-4)


def test_vertices_go_straight_from_key_to_key_and_hold_beyond(folder: Path) -> None:
    loaded = scene((0.1, 0.6), it=cloth(folder))
    for time in (-1.0, 0.0, 0.1, 0.25, 0.5, 1.0, 3.0):
        *_, surface = motion_surfaces(loaded, time)
        np.testing.assert_allclose(surface.vertices.ravel(), between(time), atol=1e-6)


def motion_surfaces(loaded: et.Scene, time: float) -> list[MeshSurface]:
    found = list(loaded.replaced(motion.at_time(loaded.model, time)).surfaces())
    return [surface for surface in found if isinstance(surface, MeshSurface)]


def test_dict_toml_and_xml_say_the_same(folder: Path, tmp_path: Path) -> None:
    loaded = scene(it=cloth(folder))
    without, _ = leave_out(loaded, et.Strategy.parse("best"), ["motion"])
    for number, one in enumerate((loaded, without)):
        for suffix in ("toml", "xml"):
            file = tmp_path / f"scene-{number}.{suffix}"
            one.write(file)
            again = et.load(file)
            assert again.digest == one.digest
            assert same_bits(bits(again), bits(one))
        assert et.load_dict(one.to_dict()).digest == one.digest
    (tmp_path / "own.xml").write_text(
        f'<scene version="3.0.0"><sensor type="perspective"/><path value="{folder}"/><shape type="ply">'
        '<animation name="filename"><string time="1" value="sheet-0.ply"/><string time="2" value="sheet-1.ply"/>'
        "</animation></shape></scene>"
    )
    (shape,) = et.load(tmp_path / "own.xml").model.shapes
    assert isinstance(shape, Ply)
    assert shape.filename == Deformation((1.0, 2.0), ("sheet-0.ply", "sheet-1.ply"))


@pytest.mark.parametrize("kind", ["obj", "serialized"])
def test_all_kinds_of_meshes_can_deform(kind: str, tmp_path: Path) -> None:
    for number, time in enumerate(TIMES):
        points = sheet(time)[0]
        lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in points.tolist()]
        lines += [f"f {a} {b} {c}" for a, b, c in (FACES + 1).tolist()]
        (tmp_path / f"{number}.obj").write_text("\n".join(lines))
        (tmp_path / f"{number}.serialized").write_bytes(several(stream(vertices=points[[0, 1, 6, 5]])))
    keys = [{"time": t, "filename": str(tmp_path / f"{k}.{kind}")} for k, t in enumerate(TIMES)]
    loaded = scene(it={"type": kind, "filename": {"animation": keys}})
    assert [reason.what for reason in derive(loaded)["motion"]] == [f"shape '{kind}'"]


def test_a_mesh_can_be_held_between_two_files(folder: Path) -> None:
    held = scene(it={"type": "ply", "filename": deformation(folder) | {"time": 0.1}})
    assert not held.core.effects()["motion"]
    assert not held.warnings
    np.testing.assert_allclose(motion_surfaces(held, 0.9)[-1].vertices.ravel(), between(0.1), atol=1e-6)
    at_key = scene(it={"type": "ply", "filename": deformation(folder) | {"time": 0.25}})
    assert at_key.digest == scene(it={"type": "ply", "filename": str(folder / "sheet-1.ply")}).digest
    with pytest.raises(ValueError, match="Mitsuba 3 cannot hold a mesh between two poses"):
        mitsuba_dict(held.model, held.assets)
    moving = scene(it=cloth(folder))
    with pytest.raises(ValueError, match="Mitsuba 3 has no transforms that change with time, nor meshes"):
        mitsuba_dict(moving.model, moving.assets)


STILL = {
    "a shutter that closes at once": ((0.25, 0.25), (0, 1, 2), 1),
    "motion before the shutter opens": ((2, 3), (0, 1, 2), 2),
    "keys that are all the same": ((0, 1), (1, 1, 1), 1),
    "files that are all the same": ((0, 1), (1, 3, 1), 1),
}


@pytest.mark.parametrize("name", STILL)
def test_what_does_not_deform_calls_for_nothing_and_changes_no_bit(name: str, folder: Path) -> None:
    shutter, numbers, number = STILL[name]
    (folder / "sheet-3.ply").write_bytes((folder / "sheet-1.ply").read_bytes())
    shines = {"emitter": {"type": "area", "radiance": 2.0}}  # which what deforms cannot
    loaded = scene(shutter, it=cloth(folder, *numbers, **shines))
    plain = scene(shutter, it={"type": "ply", "filename": str(folder / f"sheet-{number}.ply")} | shines)
    assert loaded.core.effects() == plain.core.effects()
    assert "motion" not in derive(loaded)
    assert loaded.digest == plain.digest
    assert same_bits(bits(loaded), bits(plain))


def test_deformation_is_left_out_at_the_centre_of_the_shutter(folder: Path) -> None:
    loaded = scene((0, 0.5), it=cloth(folder))
    (reason,) = derive(loaded)["motion"]
    assert str(reason) == "it: shape 'ply'"
    without, _ = leave_out(loaded, et.Strategy.parse("best"), ["motion"])
    plain = scene((0, 0.5), it={"type": "ply", "filename": str(folder / "sheet-1.ply")})
    assert same_bits(bits(without), bits(plain))
    assert leave_out(without, et.Strategy.parse("best"), ["motion"])[0] is without


def test_files_that_are_no_poses_of_one_mesh_are_refused_at_their_place(folder: Path, tmp_path: Path) -> None:
    vertices, normals = sheet(0.0)
    first = folder / "sheet-0.ply"
    write_ply(tmp_path / "less.ply", vertices[:-1], FACES[:8], normals[:-1], None, None)
    write_ply(tmp_path / "turned.ply", vertices, FACES[:, [0, 2, 1]], normals, None, None)
    write_ply(tmp_path / "bare.ply", vertices, FACES, None, None, None)
    write_ply(tmp_path / "uv.ply", vertices, FACES, normals, vertices[:, :2], None)
    wrong = {
        "less.ply": f"less.ply: has 14 vertices instead of 25 as in {first}",
        "turned.ply": f"turned.ply: has other faces than {first}",
        "bare.ply": f"bare.ply: has no normals, unlike {first}",
        "uv.ply": f"uv.ply: has other texture coordinates than {first}",
        "none.ply": "no such file",
    }
    for name, message in wrong.items():
        files = {"animation": [{"time": 0, "filename": str(first)}, {"time": 1, "filename": str(tmp_path / name)}]}
        with pytest.raises(et.SceneError) as error:
            scene(it={"type": "ply", "filename": files})
        assert str(error.value).startswith("it.filename: ")
        assert message in str(error.value)


KEY = {"time": 0, "filename": "a.ply"}


@pytest.mark.parametrize(
    ("filename", "message"),
    [
        ({"animation": [KEY]}, "it.filename: an animation needs two keys at least"),
        ({"animation": [KEY, KEY]}, "it.filename: the times of an animation's keys must increase"),
        ({"animation": [KEY, {"time": 1}]}, "it.filename: a key of an animation of files is a table with a time and"),
        ({"animation": [KEY, {"time": 1, "filename": 3}]}, "it.filename: a key of an animation of files is a table"),
        ({"animation": [KEY, KEY | {"time": "soon"}]}, "it.filename: expected finite numbers, found 'soon'"),
        ({"animation": KEY}, "it.filename: an animation of files is a table with a list of keys"),
        ({"animation": [KEY], "at": 0}, "it.filename: an animation of files is a table with a list of keys"),
        (7, "it.filename: expected a string, found 7"),
    ],
)
def test_an_animation_of_files_that_is_none_is_refused_at_its_place(filename: Any, message: str) -> None:
    with pytest.raises(et.SceneError) as error:
        scene(it={"type": "ply", "filename": filename})
    assert message in str(error.value)


def test_what_cannot_deform_says_so(folder: Path, tmp_path: Path) -> None:
    with pytest.raises(et.SceneError, match=r"it.emitter: a mesh that deforms cannot emit"):
        _ = scene(it=cloth(folder, emitter={"type": "area"})).core
    with pytest.raises(et.SceneError, match="filename: expected a string"):
        scene(it={"type": "diffuse", "reflectance": {"type": "bitmap", "filename": deformation(folder)}})
    (tmp_path / "s.xml").write_text(
        '<scene version="3.0.0"><sensor type="perspective"/><shape type="cube"><animation name="to_world">'
        '<string time="0" value="a"/><string time="1" value="b"/></animation></shape></scene>'
    )
    with pytest.raises(et.SceneError, match=r"s.xml:1: to_world: expected a transform"):
        et.load(tmp_path / "s.xml")


def test_keys_are_where_equal_parts_of_the_shutter_meet_nearly_or_it_is_told(folder: Path) -> None:
    def loaded(*times: float) -> et.Scene:
        keys = [{"time": t, "filename": str(folder / f"sheet-{k % 3}.ply")} for k, t in enumerate(times)]
        return scene(it={"type": "ply", "filename": {"animation": keys}})

    def parts(one: et.Scene) -> int:
        return len(deforming.steps(motion.in_shutters(one.model).shapes[1], one.assets)) - 1  # type: ignore[arg-type]

    assert parts(loaded(-1, 2)) == 1
    assert parts(loaded(0, 0.3333, 1)) == 3
    assert parts(loaded(0, 0.25, 0.5, 0.9, 1)) == 20
    assert not loaded(0, 0.3333, 1).warnings
    odd = loaded(0, 0.1234567, 0.2718281, 0.5772156, 0.9876543, 1)
    assert parts(odd) == 128
    (warning,) = odd.warnings
    assert "off its time: keys are where 128 equal parts of the shutter's time meet" in warning
