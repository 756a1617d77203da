"""glTF files: both containers, and what is wrong with them told with its place."""

import base64
import copy
import json
import os
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import equaltime as et
from equaltime.errors import SceneError

from .gltf_files import Builder, chunk, glb, one_triangle


def problem(path: Path, **defines: object) -> str:
    with pytest.raises(SceneError) as caught:
        et.load(path, **defines)
    text = str(caught.value)
    assert str(path) in text
    return text.replace(str(path), path.name)


def test_both_containers_hold_the_same_scene(tmp_path: Path) -> None:
    builder = one_triangle()
    a, b = et.load(builder.gltf(tmp_path / "a.gltf")), et.load(builder.glb(tmp_path / "b.glb"))
    assert a.digest == b.digest
    assert next(a.surfaces()).vertices.tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0]]


def test_zeros_behind_the_json_of_a_glb_are_blanks(tmp_path: Path) -> None:
    builder = one_triangle()
    text = json.dumps(builder.document()).encode()
    text += b" " * (1 - len(text) % 4 + 4)  # so that there is something to fill up
    padded = [chunk(b"JSON", text, filler) + chunk(b"BIN\0", builder.binary, b"\0") for filler in (b" ", b"\0")]
    assert padded[0] != padded[1]
    digests = set()
    for chunks in padded:
        (tmp_path / "a.glb").write_bytes(b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks)
        digests.add(et.load(tmp_path / "a.glb").digest)
    assert len(digests) == 1


def test_chunks_and_bytes_of_a_glb_that_nobody_reads_are_told(tmp_path: Path) -> None:
    builder = one_triangle()
    plain = glb(json.dumps(builder.document()).encode(), builder.binary)
    more = plain[12:] + chunk(b"XTRA", b"12345678", b"\0") + chunk(b"BIN\0", b"second", b"\0")
    (tmp_path / "a.glb").write_bytes(b"glTF" + struct.pack("<II", 2, 12 + len(more)) + more + b"behind")
    told = et.load(tmp_path / "a.glb").warnings
    assert "chunk 2 of the GLB file is not used: b'XTRA'" in told
    assert "chunk 3 of the GLB file is not used: b'BIN\\x00'" in told
    assert "6 bytes behind the last chunk of the GLB file are not used" in told


def test_a_buffer_may_stand_in_a_file_beside_it(tmp_path: Path) -> None:
    builder = one_triangle()
    document = builder.document()
    document["buffers"][0]["uri"] = "parts/with%20space.bin"
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "with space.bin").write_bytes(builder.binary)
    (tmp_path / "scene.gltf").write_text(json.dumps(document))
    scene = et.load(tmp_path / "scene.gltf")
    assert scene.digest == et.load(builder.glb(tmp_path / "b.glb")).digest


@pytest.mark.parametrize("header", ["data:;base64,", "data:application/octet-stream;BASE64,"])
def test_base64_may_lack_its_padding_and_have_white_space(tmp_path: Path, header: str) -> None:
    builder = one_triangle()
    builder.binary += b"\0" * ((1 - len(builder.binary)) % 3)
    document = builder.document()
    padded = base64.b64encode(builder.binary).decode()
    assert padded.endswith("==")
    for written in (padded, padded.rstrip("="), padded.replace("=", "%3D"), f"{padded[:20]}\r\n  {padded[20:]}"):
        document["buffers"][0]["uri"] = header + written
        (tmp_path / "a.gltf").write_text(json.dumps(document))
        assert et.load(tmp_path / "a.gltf").digest == et.load(builder.glb(tmp_path / "b.glb")).digest


def test_files_are_found_from_the_current_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    builder = one_triangle()
    document = builder.document()
    document["buffers"][0]["uri"] = "a.bin"
    (tmp_path / "models").mkdir()
    (tmp_path / "models" / "a.bin").write_bytes(builder.binary)
    (tmp_path / "models" / "a.gltf").write_text(json.dumps(document))
    monkeypatch.chdir(tmp_path)
    assert len(list(et.load("models/a.gltf").surfaces())) == 1


def test_a_file_that_changes_after_loading_is_refused(tmp_path: Path) -> None:
    scene = et.load(one_triangle().glb(tmp_path / "a.glb"))
    scene.assets.release()
    os.utime(tmp_path / "a.glb", ns=(1, 1))
    with pytest.raises(ValueError, match="has changed since the scene was loaded"):
        next(scene.surfaces())


@pytest.mark.parametrize(
    "uri",
    ["../secret.bin", "/etc/passwd", "a/../../secret.bin", "%2e%2e/secret.bin", "..\\secret.bin", "C:\\secret.bin"],
)
def test_a_file_outside_the_folder_is_never_opened(tmp_path: Path, uri: str) -> None:
    (tmp_path / "secret.bin").write_bytes(b"\0" * 1000)
    inside = tmp_path / "inside"
    inside.mkdir()
    document = one_triangle().document()
    document["buffers"][0]["uri"] = uri
    (inside / "a.gltf").write_text(json.dumps(document))
    text = problem(inside / "a.gltf")
    assert "a.gltf: meshes[0].primitives[0]" in text
    assert text.count("buffers[0].uri: ") == 1
    assert "only files in this folder or below it" in text or "beside this one" in text


def test_a_web_address_is_no_file(tmp_path: Path) -> None:
    document = one_triangle().document()
    document["buffers"][0]["uri"] = "https://example.org/a.bin"
    (tmp_path / "a.gltf").write_text(json.dumps(document))
    assert "expected a file beside this one or a data URI" in problem(tmp_path / "a.gltf")


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        (b"", "line 1, column 1 of the JSON: not well-formed"),
        (b"{", "line 1, column 2 of the JSON: not well-formed"),
        (b"[]", "expected a JSON object, found []"),
        (b"\xff\xfe{}", "not UTF-8 text (byte 0 of the JSON)"),
        (b"{}", "the file needs 'asset'"),
        (b'{"asset": {"version": "1.0"}}', "asset.version: expected glTF 2.0, found '1.0'"),
        (b'{"asset": {"version": "2.0"}}', "there is nothing to see"),
        (b"[" * 100_000, "nested too deep"),
        (b'{"asset": ' + b"9" * 5000 + b"}", "a number has more digits than can be read"),
        (b'{"asset": {"version": "2.0"}, "nodes": [{"translation": [0, NaN, 0]}]}', "nodes[0].translation: expected 3"),
        (b"glTF", "the file ends within its GLB header"),
        (b"glTF" + struct.pack("<II", 1, 20) + b"\0" * 8, "expected GLB version 2, found 1"),
        (b"glTF" + struct.pack("<II", 2, 4_000_000_000) + b"\0" * 8, "the file has 20: it was cut"),
        (b"glTF" + struct.pack("<III", 2, 20, 4_000_000_000) + b"JSON", "chunk 0 declares 4000000000 bytes"),
        (b"glTF" + struct.pack("<III", 2, 20, 0) + b"BIN\0", "the GLB file has no JSON chunk"),
    ],
)
def test_what_is_no_gltf_is_told(tmp_path: Path, content: bytes, expected: str) -> None:
    path = tmp_path / ("a.glb" if content.startswith(b"glTF") else "a.gltf")
    path.write_bytes(content)
    assert expected in problem(path)


Change = Callable[[dict[str, Any]], object]


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        (lambda d: d["nodes"][0].update(mesh=7), "nodes[0].mesh: expected the index of one of 1 meshes, found 7"),
        (lambda d: d["nodes"][0].update(mesh="a"), "nodes[0].mesh: expected the index of one of 1 meshes, found 'a'"),
        (lambda d: d["nodes"][0].update(mesh=True), "nodes[0].mesh: expected the index"),
        (lambda d: d["nodes"][0].update(children=[0]), "nodes[0]: the node is, or hangs below, its own"),
        (lambda d: d["nodes"][0].update(rotation=[1, 2]), "nodes[0].rotation: expected 4 numbers, found [1, 2]"),
        (lambda d: d["nodes"][0].update(matrix=[0] * 15 + ["1"]), "nodes[0].matrix: expected 16 numbers"),
        (lambda d: d.update(nodes={}), "nodes: expected a list, found {}"),
        (lambda d: d.update(scene=0), "scene: expected the index of one of 0 scenes, found 0"),
        (lambda d: d["accessors"][0].update(count=4), "accessors[0]: 4 elements end at byte 48 of buffer view 0"),
        (lambda d: d["accessors"][0].update(count=1 << 50), "elements end at byte"),
        (lambda d: d["accessors"][0].update(count=-1), "accessors[0].count: expected an integer of at least 0"),
        (lambda d: d["accessors"][0].update(count=1.5), "accessors[0].count: expected an integer of at least 0"),
        (lambda d: d["accessors"][0].update(type="VEC2"), "accessors[0].type: expected VEC3, found VEC2"),
        (lambda d: d["accessors"][0].update(componentType=5124), "accessors[0].componentType: expected 5120 or"),
        (lambda d: d["accessors"][0].pop("bufferView") is None or d["accessors"][0].update(count=1 << 40), "the limit"),
        (lambda d: d["bufferViews"][0].update(byteOffset=1), "bufferViews[0]: reaches to byte 37 of buffer 0, which"),
        (lambda d: d["bufferViews"][0].update(byteStride=4), "bufferViews[0].byteStride: expected at least 12, the by"),
        (lambda d: d["bufferViews"][0].update(byteLength=1 << 60), "bufferViews[0].byteLength: expected an integer"),
        (lambda d: d["buffers"][0].update(byteLength=1 << 45), "buffers[0]: declares 35184372088832 bytes, but there"),
        (lambda d: d["buffers"][0].update(uri="data:,abc"), "buffers[0]: declares 36 bytes, but there are only 3"),
        (lambda d: d["buffers"][0].update(uri="data:x;base64,a"), "buffers[0].uri: the data URI is not valid base64"),
        (lambda d: d["buffers"][0].update(uri="data:"), "buffers[0].uri: a data URI needs a comma"),
        (lambda d: d["buffers"][0].update(uri="gone.bin"), "buffers[0].uri: no such file"),
        (lambda d: d["buffers"][0].pop("uri"), "buffers[0]: has no 'uri', and the file has no binary chunk"),
        (lambda d: d["meshes"][0].pop("primitives"), "meshes[0]: needs 'primitives'"),
        (lambda d: d["meshes"][0]["primitives"][0].update(mode=9), "meshes[0].primitives[0].mode: expected 0 or 1"),
        (lambda d: d["meshes"][0]["primitives"][0].update(attributes={}), "primitives[0].attributes: needs 'POSITION'"),
        (lambda d: d.update(extensionsRequired=["KHR_draco_mesh_compression"]), "gltf-transform"),
        (lambda d: d.update(extensionsRequired=["EXT_meshopt_compression"]), "EXT_meshopt_compression' is not supp"),
        (lambda d: d.update(extensionsRequired=["KHR_materials_foo"]), "extensionsRequired[0]: the extension"),
    ],
)
def test_a_malformed_file_gives_one_error_with_its_place(tmp_path: Path, change: Change, expected: str) -> None:
    builder = one_triangle()
    document = builder.document()
    document["buffers"][0]["uri"] = "data:;base64," + base64.b64encode(builder.binary).decode()
    change(document)
    (tmp_path / "a.gltf").write_text(json.dumps(document))
    text = problem(tmp_path / "a.gltf")
    assert expected in text
    assert text.count("a.gltf: ") == 1
    assert len(text.splitlines()) == 1


def test_the_version_is_the_only_problem_of_another_version(tmp_path: Path) -> None:
    old = {"asset": {"version": "1.0"}, "accessors": {"a": {}}, "meshes": {"m": {}}, "scene": "s"}
    (tmp_path / "a.gltf").write_text(json.dumps(old))
    assert problem(tmp_path / "a.gltf") == "a.gltf: asset.version: expected glTF 2.0, found '1.0'"


def test_draco_data_is_refused_even_if_the_file_does_not_require_it(tmp_path: Path) -> None:
    builder = one_triangle()
    builder.json["meshes"][0]["primitives"][0]["extensions"] = {"KHR_draco_mesh_compression": {}}
    del builder.json["accessors"][0]["bufferView"]
    text = problem(builder.gltf(tmp_path / "a.gltf"))
    assert "meshes[0].primitives[0]: the data is stored by KHR_draco_mesh_compression, which is not supported" in text


def test_an_index_that_names_no_vertex_is_told(tmp_path: Path) -> None:
    builder = Builder()
    builder.node(mesh=builder.mesh(indices=[0, 1, 3]))
    expected = "a.gltf: meshes[0].primitives[0].indices: index 2 names vertex 3, but there are 3"
    assert problem(builder.gltf(tmp_path / "a.gltf")) == expected


def test_a_vertex_that_is_not_finite_is_told(tmp_path: Path) -> None:
    builder = Builder()
    builder.node(mesh=builder.mesh(positions=[[0, 0, 0], [1, 0, 0], [0, np.inf, 0]]))
    assert "vertex 2 is not finite" in problem(builder.gltf(tmp_path / "a.gltf"))


def test_all_problems_of_a_file_are_told_at_once_but_not_thousands(tmp_path: Path) -> None:
    document = one_triangle().document()
    document["nodes"] = [{"mesh": 9}] * 1000
    (tmp_path / "a.gltf").write_text(json.dumps(document))
    assert 2 < len(problem(tmp_path / "a.gltf").splitlines()) <= 20


def test_definitions_that_mean_nothing_are_refused(tmp_path: Path) -> None:
    path = one_triangle().gltf(tmp_path / "a.gltf")
    assert "nothing in the scene uses the definition 'camra'; did you mean 'camera'?" in problem(path, camra=1)
    assert "'sky' must be a number of at least 0 or a colour such as #20c040, found -1" in problem(path, sky=-1)


def test_damaged_files_never_crash(tmp_path: Path) -> None:
    """Hundreds of files with one byte changed load or are refused in words."""
    builder = one_triangle(pbrMetallicRoughness={"baseColorFactor": [1, 0.5, 0, 1]}, alphaMode="BLEND")
    whole = glb(json.dumps(builder.document()).encode(), builder.binary)
    random = np.random.default_rng(7)
    path = tmp_path / "a.glb"
    loaded = 0
    for _ in range(300):
        damaged = bytearray(whole)
        damaged[random.integers(len(whole))] = random.integers(256)
        path.write_bytes(bytes(damaged))
        try:
            et.load(path)
            loaded += 1
        except SceneError:
            pass
    assert 0 < loaded < 300


def test_cut_files_never_crash(tmp_path: Path) -> None:
    whole = one_triangle().glb(tmp_path / "whole.glb").read_bytes()
    for length in range(0, len(whole) - 1, 7):
        path = tmp_path / "a.glb"
        path.write_bytes(whole[:length])
        with pytest.raises(SceneError):
            et.load(path)


def test_every_value_may_be_of_a_wrong_type(tmp_path: Path) -> None:
    """Each value of a document in turn becomes something else; none gives anything but an error in words."""
    builder = one_triangle(name="a", normalTexture={"index": 0}, extensions={"KHR_materials_ior": {"ior": 1.4}})
    builder.json |= {"textures": [{"source": 0, "sampler": 0}], "samplers": [{"wrapS": 10497}]}
    builder.json["images"] = [{"uri": "a.png"}]
    document = builder.document()
    path = tmp_path / "a.gltf"
    for where in places(document):
        for wrong in (None, "x", -1, [], {}, [[]], 1e308):
            changed = copy.deepcopy(document)
            target: Any = changed
            for key in where[:-1]:
                target = target[key]
            target[where[-1]] = wrong
            path.write_text(json.dumps(changed))
            try:
                et.load(path)
            except SceneError:
                continue


def places(value: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    found = [path] if path else []
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, entry in items:
        found += places(entry, (*path, key))
    return found
