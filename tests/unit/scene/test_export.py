"""Scenes written again: names, numbers and files as they were, and nothing overwritten."""

from __future__ import annotations

import json
import shutil
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import equaltime as et
from equaltime import files as disk
from equaltime.cli import main
from equaltime.scene import model as m
from equaltime.scene.export import FORMATS
from equaltime.scene.export.files import Folder, write_ply
from equaltime.scene.export.look_at import look_at_of
from equaltime.scene.model import poses
from equaltime.scene.transforms import parse

from .gltf_files import Builder

TRIANGLE = b"""ply
format ascii 1.0
element vertex 3
property float x
property float y
property float z
element face 1
property list uchar int vertex_indices
end_header
0 0 0
1 0 0
0 1 0
3 0 1 2
"""


def scene(**parts: Any) -> dict[str, Any]:
    return {"type": "scene", "sensor": {"type": "perspective"}} | parts


def written(description: dict[str, Any], folder: Path, kind: str) -> et.Scene:
    file = folder / f"again{kind}"
    et.load_dict(description).write(file)
    return et.load(file)


@pytest.mark.parametrize("kind", [".toml", ".xml"])
def test_the_model_that_is_read_again_is_equal(kind: str, tmp_path: Path) -> None:
    description = scene(
        integrator={"type": "path", "max_depth": 7},
        sensor={"type": "perspective", "fov": 0.1 + 0.2, "film": {"type": "hdrfilm", "width": 20, "height": 10}},
        ball={"type": "sphere", "center": [1e-20, -0.0, 3], "radius": 1 / 3, "flip_normals": True, "bsdf": "red"},
        red={"type": "diffuse", "reflectance": [0.1, 0.2, 0.3]},
        lamp={"type": "point", "position": [1, 2, 3], "intensity": {"type": "rgb", "value": [1e30, 0, 1e-30]}},
        mirror={"type": "disk", "to_world": [{"rotate": {"axis": [1, 2, 3], "angle": 77}}]},
    )
    assert written(description, tmp_path, kind).model == et.load_dict(description).model


@pytest.mark.parametrize("kind", [".toml", ".xml"])
@pytest.mark.parametrize("name", ["a.b", "path", "it's", 'a "quoted" name', "ünï <&> code", "$cost", "two\nlines", ""])
def test_any_name_can_be_written(name: str, kind: str, tmp_path: Path) -> None:
    parts = {name: {"type": "null"}} if name else {}
    shapes = {"one": {"type": "sphere", "bsdf": {"type": "ref", "id": name}} if name else {"type": "sphere"}}
    again = written(scene(**parts, **shapes, two={"type": "disk"}), tmp_path, kind)
    assert [shape.id for shape in again.model.shapes] == ["one", "two"]
    assert (again.model.shapes[0].bsdf is not None) == bool(name)  # type: ignore[union-attr]


def test_a_name_with_a_dollar_sign_is_read_again_within_a_list(tmp_path: Path) -> None:
    parts = {"type": "blendbsdf", "weight": 0.5, "one": {"type": "ref", "id": "$a"}, "two": {"type": "diffuse"}}
    first, second = ({"$a": {"type": "conductor"}, "ball": {"type": "sphere", "bsdf": parts}} for _ in range(2))
    again = written(scene(**first, other=second["ball"]), tmp_path, ".toml")
    assert [shape.bsdf.bsdf[0].type for shape in again.model.shapes] == ["conductor"] * 2  # type: ignore[union-attr]


def test_what_is_shared_is_written_once(tmp_path: Path) -> None:
    shared = scene(
        board={"type": "checkerboard"},
        metal={"type": "roughconductor", "specular_reflectance": "board", "alpha": 0.3},
        group={"type": "shapegroup", "part": {"type": "cube", "bsdf": "metal"}},
        one={"type": "instance", "shapegroup": "group"},
        two={"type": "instance", "shapegroup": "group", "to_world": [{"translate": [3, 0, 0]}]},
        three={"type": "sphere", "bsdf": "metal"},
    )
    again = written(shared, tmp_path, ".toml")
    assert again.digest == et.load_dict(shared).digest
    text = (tmp_path / "again.toml").read_text()
    assert [text.count(f'type = "{name}"') for name in ("checkerboard", "roughconductor", "cube")] == [1, 1, 1]
    assert text.count('bsdf = "metal"') == 2


def test_two_shapes_never_get_one_name() -> None:
    model = et.load_dict(scene(a={"type": "sphere"}, b={"type": "disk"})).model
    named = model.replace(shapes=(m.Sphere(id="x.y"), m.Disk(id="x_y"), m.Disk(id="sensor")))
    from equaltime.scene.export import scene_dict

    assert [part["type"] for part in scene_dict(named, str).values() if isinstance(part, dict)][-3:] == [
        *("sphere", "disk", "disk"),
    ]


# -- cameras ---------------------------------------------------------------------------------------------------------


def camera_of(text: str) -> Any:
    """Return what stands for ``to_world`` in the only camera of a TOML file."""
    return tomllib.loads(text)["sensor"]["to_world"]


@pytest.mark.parametrize(
    ("origin", "target", "up"),
    [
        *(([0, 1, 6.8], [0, 1, 0], [0, 1, 0]), ([0.95, 0.1, 0.9], [0.4, -0.3, -0.6], [0, 1, 0])),
        *(([28.2792, 3.5, 0], [0, 3.5, 0], [0, 1, 0]), ([-9.41, -3.4, 6.68], [0, 0.75, 0], [0, 0, 1])),
        *(([3, 4, 5], [0.15, 0.1, 0.05], [0.5, 1, 0]), ([0, 2, 0], [0, 0, 0], [1, 0, 0])),
    ],
)
def test_a_camera_is_written_with_the_few_digits_that_it_was_given(
    origin: list[float], target: list[float], up: list[float], tmp_path: Path
) -> None:
    placed = {"look_at": {"origin": origin, "target": target, "up": up}}
    loaded = et.load_dict(scene() | {"sensor": {"type": "perspective", "to_world": placed}})
    for kind in ("toml", "xml"):
        loaded.write(tmp_path / f"new.{kind}")
        assert et.load(tmp_path / f"new.{kind}").digest == loaded.digest
    assert camera_of((tmp_path / "new.toml").read_text()) == [placed]
    text = "".join(
        f' {name}="{", ".join(str(float(n)) for n in vector)}"' for name, vector in placed["look_at"].items()
    )
    assert f'<transform name="to_world"><lookat{text}/></transform>' in (tmp_path / "new.xml").read_text()


SCENES = Path(__file__).parents[3] / "scenes"
FOLDERS = (".", "experiments", "montelight", "terrain")
OURS = [path for name in FOLDERS for path in sorted((SCENES / name).glob("*.toml")) if "look_at" in path.read_text()]


@pytest.mark.parametrize("path", OURS, ids=lambda path: path.stem)
def test_cameras_of_our_scenes_are_written_as_look_at(path: Path, tmp_path: Path) -> None:
    camera = et.load(path).model.sensor
    for matrix in poses(camera.to_world):
        found = look_at_of(matrix)
        assert found is not None
        assert np.array(matrix).tobytes() == parse({"look_at": found}).tobytes()
    named = m.SceneModel(integrator=m.Path(), sensor=camera, shapes=(), emitters=())
    for kind in ("toml", "xml"):
        et.load_dict(scene()).replaced(named).write(tmp_path / f"new.{kind}")
        assert repr(et.load(tmp_path / f"new.{kind}").model.sensor.to_world) == repr(camera.to_world)


def test_a_camera_with_all_digits_is_written_as_look_at_only_if_no_bit_is_lost() -> None:
    rng = np.random.default_rng(1)
    made = [dict(zip(("origin", "target", "up"), rng.normal(size=(3, 3)).tolist(), strict=True)) for _ in range(20)]
    matrices = [parse({"look_at": vectors}) for vectors in made]
    found = [look_at_of(matrix.tolist()) for matrix in matrices]
    assert sum(vectors is not None for vectors in found) >= 12
    for matrix, vectors in zip(matrices, found, strict=True):
        assert vectors is None or parse({"look_at": vectors}).tobytes() == matrix.tobytes()


FAR = {"look_at": {"origin": [1e308, 0, 0], "target": [0, 0, 0], "up": [0, 1, 0]}}
LEANING = {"look_at": {"origin": [0, 0, 4], "target": [0, 0, 0], "up": [0, 1e-9, 1]}}
MIRRORED = [{"look_at": {"origin": [0, 1, 4], "target": [0, 0, 0], "up": [0, 1, 0]}}, {"scale": [-1, 1, 1]}]
STRETCHED = [{"scale": [5, 5, 1]}, {"translate": [0, 0, -10]}]
TURNED = [{"rotate": {"axis": [1, 2, 3], "angle": 40}}]


@pytest.mark.parametrize(
    ("placed", "is_look_at"),
    [(FAR, True), (LEANING, True), (MIRRORED, False), (STRETCHED, False), (TURNED, False), ({"scale": 1e200}, False)],
)
def test_an_odd_camera_stays_as_it_is(placed: Any, is_look_at: bool, tmp_path: Path) -> None:
    camera = et.load_dict(scene() | {"sensor": {"type": "orthographic", "to_world": placed}})
    for kind in ("toml", "xml"):
        camera.write(tmp_path / f"new.{kind}")
        assert repr(et.load(tmp_path / f"new.{kind}").model.sensor.to_world) == repr(camera.model.sensor.to_world)
    assert ("look_at" in str(camera_of((tmp_path / "new.toml").read_text()))) == is_look_at


def test_the_keys_of_a_moving_camera_are_written_as_look_at(tmp_path: Path) -> None:
    first, last = ({"origin": [x, 1.0, 4.0], "target": [x, 1.0, 0.0], "up": [0.0, 1.0, 0.0]} for x in (0.0, 0.5))
    keys = [{"time": time, "look_at": vectors} for time, vectors in ((0.0, first), (1.0, last))]
    camera = et.load_dict(scene() | {"sensor": {"type": "perspective", "to_world": {"animation": keys}}})
    camera.write(tmp_path / "new.toml")
    camera.write(tmp_path / "new.xml")
    written = camera_of((tmp_path / "new.toml").read_text())["animation"]
    assert written == [{"time": float(n), "transform": [{"look_at": look}]} for n, look in enumerate((first, last))]
    assert (tmp_path / "new.xml").read_text().count("<lookat ") == 2
    for name in ("new.toml", "new.xml"):
        assert et.load(tmp_path / name).model.sensor.to_world == camera.model.sensor.to_world


def test_only_cameras_are_written_as_look_at(tmp_path: Path) -> None:
    placed = {"look_at": {"origin": [0, 0, 4], "target": [0, 0, 0], "up": [0, 1, 0]}}
    loaded = et.load_dict(scene(ball={"type": "sphere", "to_world": placed}))
    loaded.write(tmp_path / "new.toml")
    assert "look_at" not in (tmp_path / "new.toml").read_text()
    assert loaded.to_dict()["ball"]["to_world"][2] == [0.0, 0.0, -1.0, 4.0]


# -- files -----------------------------------------------------------------------------------------------------------


@pytest.fixture
def with_mesh(tmp_path: Path) -> Path:
    (tmp_path / "data").mkdir()
    (tmp_path / "data" / "a $mesh.ply").write_bytes(TRIANGLE)
    text = "sensor.type = 'perspective'\n[leaf]\ntype = 'ply'\nfilename = 'data/a \\$mesh.ply'\n"
    (tmp_path / "scene.toml").write_text(text)
    return tmp_path


@pytest.mark.parametrize("kind", ["toml", "xml"])
def test_files_are_named_as_seen_from_the_new_file(kind: str, with_mesh: Path) -> None:
    out = with_mesh / "other" / f"scene.{kind}"
    out.parent.mkdir()
    assert et.load(with_mesh / "scene.toml").write(out) == (out,)
    assert str(et.load(out).model.shapes[0].filename) == "../data/a $mesh.ply"  # type: ignore[union-attr]


def test_files_can_be_copied_and_none_is_overwritten(with_mesh: Path) -> None:
    copies = with_mesh / "new_files"
    copies.mkdir()
    (copies / "a $mesh.ply").write_bytes(b"somebody else's")
    loaded = et.load(with_mesh / "scene.toml")
    for name in ("new.xml", "new.toml"):
        loaded.write(with_mesh / name, copy=True)
        assert et.load(with_mesh / name).model.shapes[0].filename == "new_files/a $mesh-2.ply"  # type: ignore[union-attr]
    assert sorted(path.name for path in copies.iterdir()) == ["a $mesh-2.ply", "a $mesh.ply"]
    assert (copies / "a $mesh.ply").read_bytes() == b"somebody else's"


@pytest.mark.parametrize("kind", ["glb", "gltf"])
def test_a_gltf_file_is_copied_with_its_buffers_and_images(kind: str, tmp_path: Path) -> None:
    (source := tmp_path / "old").mkdir()
    builder = Builder()
    texture = builder.image(np.full((2, 2, 3), 90, np.uint8), source)
    colour = {"baseColorTexture": {"index": texture}}
    material = builder.add("materials", {"pbrMetallicRoughness": colour})
    plane = [[-1, -1, 0], [1, -1, 0], [1, 1, 0]]
    for _ in range(2):
        mesh = builder.mesh(plane, TEXCOORD_0=[[0, 0], [1, 0], [1, 1]], material=material)
        builder.add("nodes", {"mesh": mesh})
    if kind == "glb":
        model = builder.glb(source / "model.glb")
        expected = {"model.glb"}
    else:
        (source / "maps").mkdir()
        image = builder.json["images"][0]
        view = builder.json["bufferViews"][image.pop("bufferView")]
        begin = view["byteOffset"]
        (source / "maps" / "a b.png").write_bytes(builder.binary[begin : begin + view["byteLength"]])
        image["uri"] = "maps/a%20b.png"
        (source / "model.bin").write_bytes(builder.binary)
        buffers = [{"uri": "model.bin", "byteLength": len(builder.binary)}]
        images = [image, {"uri": "missing.png"}]
        model = source / "model.gltf"
        model.write_text(json.dumps(builder.document() | {"buffers": buffers, "images": images}))
        expected = {"model/model.gltf", "model/model.bin", "model/maps/a b.png"}
    image_before = et.render(et.load(model).with_(size=(8, 8)), spp=2).image
    for name in ("new.toml", "again.toml"):
        files = et.load(model).write(tmp_path / "out" / name, copy=True)
        folder = tmp_path / "out" / f"{name.removesuffix('.toml')}_files"
        assert {path.relative_to(folder).as_posix() for path in files[1:]} == expected
    shutil.rmtree(source)
    (tmp_path / "out").rename(tmp_path / "elsewhere")
    image_after = et.render(et.load(tmp_path / "elsewhere" / "new.toml").with_(size=(8, 8)), spp=2).image
    assert image_before.tobytes() == image_after.tobytes()


def test_a_gltf_file_whose_name_is_taken_is_copied_with_its_buffers_elsewhere(tmp_path: Path) -> None:
    (tmp_path / "a.gltf").write_text("a")
    (tmp_path / "a.bin").write_text("b")
    (taken := tmp_path / "new" / "a").mkdir(parents=True)
    (taken / "a.bin").write_text("somebody else's")
    for _ in range(2):
        assert Folder(tmp_path / "new").copy(tmp_path / "a.gltf", ["a.bin"]) == tmp_path / "new" / "a-2" / "a.gltf"
    assert (tmp_path / "new" / "a-2" / "a.bin").read_text() == "b"
    assert sorted(path.name for path in (tmp_path / "new").rglob("*")) == ["a", "a-2", "a.bin", "a.bin", "a.gltf"]


def test_what_is_there_is_not_overwritten_and_unknown_kinds_are_refused(with_mesh: Path) -> None:
    loaded = et.load(with_mesh / "scene.toml")
    there = "is there already; choose another name, or overwrite=True replaces it"
    for name, problem in (("scene.toml", there), ("x.json", r"expected \.toml or \.xml")):
        with pytest.raises(et.SceneError, match=problem):
            loaded.write(with_mesh / name)
    (with_mesh / "data" / "a $mesh.ply").write_bytes(TRIANGLE + b" ")
    with pytest.raises(et.SceneError, match="the file has changed"):
        loaded.write(with_mesh / "new.toml")
    assert not (with_mesh / "new.toml").exists()


def test_a_scene_that_cannot_be_written_leaves_no_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = et.load_dict({"type": "scene", "sensor": {"type": "perspective"}})
    with monkeypatch.context() as patched:
        patched.setitem(FORMATS, ".toml", lambda _: "a name that UTF-8 does not hold: \ud800")
        with pytest.raises(et.SceneError, match=r"new\.toml: .*surrogates not allowed"):
            scene.write(tmp_path / "new.toml")
    assert not list(tmp_path.iterdir())
    assert scene.write(tmp_path / "new.toml") == (tmp_path / "new.toml",)


def test_a_name_that_is_taken_without_looking_so_is_not_overwritten(tmp_path: Path) -> None:
    """A link to nowhere does not exist for who asks, like a file that is made between the question and the renaming."""
    target = tmp_path / "mesh.ply"
    target.symlink_to("nowhere")
    assert Folder(tmp_path).put("mesh.ply", lambda file: file.write_bytes(b"ours")) == tmp_path / "mesh-2.ply"
    assert target.is_symlink()
    assert {file.name for file in tmp_path.iterdir()} == {"mesh.ply", "mesh-2.ply"}


def test_a_folder_is_tidied_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    tidied: list[Path] = []
    monkeypatch.setattr(disk, "tidy", tidied.append)
    folder = Folder(tmp_path)
    for name in ("a", "b", "c"):
        folder.put(name, Path.touch)
    assert tidied == [tmp_path]


def test_files_that_are_there_already_are_not_synced(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    Folder(tmp_path).put("a", Path.touch)
    monkeypatch.setattr(disk, "to_disk", lambda path: pytest.fail(f"{path} was synced"))
    assert Folder(tmp_path).put("a", Path.touch) == tmp_path / "a"


def test_a_mesh_that_is_written_has_the_same_numbers(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    vertices, normals = rng.normal(size=(5, 3)), rng.normal(size=(5, 3)).astype(np.float32).astype(np.float64)
    uvs, faces = rng.random((5, 2)), np.array([[0, 1, 2], [2, 3, 4]], dtype=np.uint32)
    folder = Folder(tmp_path / "new")
    path = folder.put("mesh.ply", lambda file: write_ply(file, vertices, faces, normals, uvs, None))
    from equaltime._core import read_ply

    mesh = read_ply(path)
    for found, expected in ((mesh.vertices, vertices), (mesh.normals, normals), (mesh.uvs, uvs), (mesh.faces, faces)):
        assert found is not None
        assert np.array_equal(found, expected)


# -- the command -----------------------------------------------------------------------------------------------------


def test_a_scene_is_converted_in_silence_if_asked(with_mesh: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["convert", str(with_mesh / "scene.toml"), str(with_mesh / "quiet.xml"), "-q"]) == 0
    assert capsys.readouterr() == ("", "")
    assert (with_mesh / "quiet.xml").exists()


def test_a_scene_is_converted_on_the_command_line(with_mesh: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = with_mesh / "new.xml"
    assert main(["convert", str(with_mesh / "scene.toml"), str(out)]) == 0
    assert capsys.readouterr().out == f"wrote {out}\n"
    assert main(["info", str(out), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["triangles"] == 1
    assert main(["convert", str(with_mesh / "scene.toml"), str(out)]) == 2
    assert f"error: {out}: is there already; choose another name, or --overwrite" in capsys.readouterr().err
    written = out.read_text()
    out.write_text("something else")
    assert main(["convert", str(with_mesh / "scene.toml"), str(out), "--overwrite"]) == 0
    assert out.read_text() == written
    assert main(["convert", str(with_mesh / "scene.toml"), str(with_mesh / "scene.toml"), "--overwrite"]) != 0
    assert "scene.toml: the scene is made of this file; write to another" in capsys.readouterr().err


# -- meshes that a PLY file cannot hold ------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("parts", "words"),
    [
        ({"POSITION": None}, "the mesh is empty: all its faces are degenerate"),
        ({"NORMAL": None}, "its normals are others"),
        ({"NORMAL": [[0, 0, 1], [0, 0, 1], [0, 0, 0]]}, "its normals are others"),
    ],
    ids=["positions", "normals", "one normal"],
)
def test_a_mesh_that_a_ply_file_does_not_hold_is_refused(parts: dict[str, Any], words: str, tmp_path: Path) -> None:
    file = tmp_path / "odd.gltf"
    builder = Builder()
    given: dict[str, Any] = {"POSITION": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], **parts}
    zeros = {"componentType": 5126, "count": 3, "type": "VEC3"}
    accessors = {n: builder.add("accessors", zeros) if v is None else builder.accessor(v) for n, v in given.items()}
    builder.add("nodes", {"mesh": builder.mesh(**accessors)})
    builder.gltf(file)
    loaded = et.load(file)
    with pytest.raises(et.SceneError) as caught:
        loaded.write(tmp_path / "odd.xml")
    assert f"odd.gltf#/meshes/0/primitives/0: a PLY file would be read as another mesh: {words}" in str(caught.value)
    assert [path.name for path in tmp_path.iterdir()] == ["odd.gltf"]
    loaded.write(tmp_path / "odd.toml")
    images = [et.render(scene.with_(size=(4, 4)), spp=2).image for scene in (loaded, et.load(tmp_path / "odd.toml"))]
    assert images[0].tobytes() == images[1].tobytes()


def test_a_mesh_with_vertices_and_faces_that_show_nothing_is_written_to_a_ply_file(tmp_path: Path) -> None:
    builder = Builder()
    positions = [[9, 9, 9], [0, 0, 0], [1, 0, 0], [0, 1, 0], [2, 0, 0], [3, 0, 0]]
    builder.add("nodes", {"mesh": builder.mesh(positions, [1, 2, 3, 1, 4, 5], NORMAL=[[0, 0, 1]] * 6)})
    loaded = et.load(builder.gltf(tmp_path / "spare.gltf")).with_(size=(4, 4))
    loaded.write(tmp_path / "spare.xml")
    images = [et.render(scene, spp=2).image for scene in (loaded, et.load(tmp_path / "spare.xml"))]
    assert images[0].tobytes() == images[1].tobytes()


def test_mitsuba_s_transforms_replace_lists_and_none_that_is_animated() -> None:
    rows = [[2.0, 0.0, 0.0, 0.0], [0.0, 2.0, 0.0, 0.0], [0.0, 0.0, 2.0, 0.0], [0.0, 0.0, 0.0, 1.0]]
    plain = et.load_dict(scene(ball={"type": "sphere", "to_world": rows})).to_dict()
    assert et.scene.export.with_transforms(plain, tuple)["ball"]["to_world"] == tuple(rows)
    keys = [{"time": time, "transform": rows} for time in (0, 1)]
    plain = et.load_dict(scene(ball={"type": "sphere", "to_world": {"animation": keys}})).to_dict()
    with pytest.raises(ValueError, match="'to_world' is animated: Mitsuba 3 has no transforms that change with time"):
        et.scene.export.with_transforms(plain, tuple)
