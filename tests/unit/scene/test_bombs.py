"""Small files that would become large: they are refused at once, with their place."""

from __future__ import annotations

import base64
import json
import struct
import zlib
from collections.abc import Callable, Iterable
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
import pytest

import equaltime as et
from equaltime.images import image_files as images

from ...hard.fuzz.memory import Watch

SECONDS, MEMORY = 2.0, 300 << 20
HEAD = "<scene version='3.0.0'><sensor type='perspective'/>"


def _refused(path: Path, content: str) -> str:
    path.write_text(content)
    started = process_time()
    with Watch(MEMORY).within(len(content)), pytest.raises(et.SceneError) as caught:
        et.load(path)
    assert process_time() - started < SECONDS
    return str(caught.value)


@pytest.mark.parametrize(
    ("tag", "plugin", "leaf", "number"),
    [
        ("bsdf", "blendbsdf", "diffuse", "weight"),
        ("phase", "blendphase", "isotropic", "weight"),
    ],
)
def test_references_that_double_with_each_level(tmp_path: Path, tag: str, plugin: str, leaf: str, number: str) -> None:
    levels = [f"<{tag} type='{leaf}' id='n0'/>"]
    for level in range(40):
        twice = f"<ref id='n{level}'/>" * 2
        levels.append(f"<{tag} type='{plugin}' id='n{level + 1}'><float name='{number}' value='0.5'/>{twice}</{tag}>")
    message = _refused(tmp_path / "bomb.xml", f"{HEAD}{''.join(levels)}</scene>")
    assert "bomb.xml:1: with all references followed these are" in message


HALF = "<float name='weight' value='0.5'/>"
CHAINS = {
    "checkerboards": (
        "<texture type='checkerboard' id='n0'/>",
        "<texture type='checkerboard' id='n{n}'><ref name='color0' id='n{k}'/><ref name='color1' id='n{k}'/></texture>",
        "<shape type='sphere'><bsdf type='diffuse'><ref name='reflectance' id='n40'/></bsdf></shape>",
    ),
    "two sides": (
        "<bsdf type='diffuse' id='n0'/>",
        "<bsdf type='twosided' id='n{n}'><ref id='n{k}'/><ref id='n{k}'/></bsdf>",
        "<shape type='sphere'><ref id='n40'/></shape>",
    ),
    "masks of blends": (
        "<bsdf type='diffuse' id='n0'/>",
        f"<bsdf type='blendbsdf' id='m{{n}}'>{HALF}<ref id='n{{k}}'/><ref id='n{{k}}'/></bsdf>"
        "<bsdf type='mask' id='n{n}'><ref id='m{n}'/></bsdf>",
        "<shape type='sphere'><ref id='n40'/></shape>",
    ),
    "bump and normal maps of one": (
        "<bsdf type='diffuse' id='n0'/><texture type='checkerboard' id='t'/>",
        "<bsdf type='bumpmap' id='a{n}'><ref id='t'/><ref id='n{k}'/></bsdf>"
        "<bsdf type='normalmap' id='b{n}'><ref name='normalmap' id='t'/><ref id='n{k}'/></bsdf>"
        f"<bsdf type='blendbsdf' id='n{{n}}'>{HALF}<ref id='a{{n}}'/><ref id='b{{n}}'/></bsdf>",
        "<shape type='sphere'><ref id='n40'/></shape>",
    ),
}


@pytest.mark.parametrize("name", CHAINS)
def test_other_parts_that_double_with_each_level(tmp_path: Path, name: str) -> None:
    first, level, last = CHAINS[name]
    levels = "".join(level.format(k=k, n=k + 1) for k in range(40))
    message = _refused(tmp_path / "bomb.xml", f"{HEAD}{first}{levels}{last}</scene>")
    assert "with all references followed these are" in message


@pytest.mark.parametrize(
    ("first", "parts", "words"),
    [
        (
            "<shape type='shapegroup' id='n0'><shape type='sphere'/></shape>",
            "<shape type='shapegroup' id='n{n}'><shape type='instance'><ref id='n{k}'/></shape></shape>",
            "shapes: expected",
        ),
        (
            "<integrator type='path' id='n0'/>",
            "<integrator type='aov' id='n{n}'><ref id='n{k}'/><ref id='n{k}'/></integrator>",
            "at most 1 item",
        ),
    ],
    ids=["shapegroups", "integrators"],
)
def test_parts_that_cannot_hold_each_other(tmp_path: Path, first: str, parts: str, words: str) -> None:
    levels = "".join(parts.format(k=k, n=k + 1) for k in range(40))
    assert words in _refused(tmp_path / "bomb.xml", f"{HEAD}{first}{levels}</scene>")


def test_groups_of_instances_of_each_other(tmp_path: Path) -> None:
    groups = "".join(
        f"<shape type='shapegroup' id='{a}'><shape type='instance'><ref id='{b}'/></shape></shape>"
        for a, b in ("ab", "ba")
    )
    message = _refused(tmp_path / "bomb.xml", f"{HEAD}{groups}<shape type='instance'><ref id='a'/></shape></scene>")
    assert "the object contains itself" in message


def _png(width: int, height: int, rows: bytes = bytes(100)) -> bytes:
    header = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    parts = [(b"IHDR", header), (b"IDAT", zlib.compress(rows, 9)), (b"IEND", b"")]
    chunks = (
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data)) for kind, data in parts
    )
    return b"\x89PNG\r\n\x1a\n" + b"".join(chunks)


def _exr(width: int, height: int, folder: Path) -> bytes:
    images.write_exr(folder / "small.exr", np.zeros((8, 8, 3)))
    small = (folder / "small.exr").read_bytes()
    return small.replace(struct.pack("<4i", 0, 0, 7, 7), struct.pack("<4i", 0, 0, width - 1, height - 1))


@pytest.mark.parametrize(("width", "height"), [(10**6, 1), (10**6, 10**6), (1, 10**6), (30_000, 30_000)])
@pytest.mark.parametrize("kind", ["png", "hdr", "exr", "pfm", "ppm"])
def test_pictures_that_declare_more_than_they_hold(tmp_path: Path, kind: str, width: int, height: int) -> None:
    content = {
        "png": _png(width, height),
        "exr": _exr(width, height, tmp_path),
        "hdr": f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n".encode() + bytes(100),
        "pfm": f"PF\n{width} {height}\n-1.0\n".encode() + bytes(100),
        "ppm": f"P6 {width} {height} 255\n".encode() + bytes(100),
    }[kind]
    (tmp_path / f"wide.{kind}").write_bytes(content)
    head = '[sensor]\ntype = "perspective"\n[sky]\ntype = "envmap"\n'
    assert f"wide.{kind}: " in _refused(tmp_path / "bomb.toml", f'{head}filename = "wide.{kind}"\n')


PLY_HEAD = "ply\nformat {format} 1.0\nelement vertex {n}\nproperty float x\nproperty float y\nproperty float z\n"
PLY_HEAD += "element face {n}\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n"


@pytest.mark.parametrize("kind", ["ascii", "binary_little_endian", "binary_big_endian"])
def test_meshes_that_declare_more_than_they_hold(tmp_path: Path, kind: str) -> None:
    message = _refused(tmp_path / "bomb.ply", PLY_HEAD.format(format=kind, n=10**9))
    assert "the header declares 1000000000 elements" in message


def test_serialized_meshes_that_declare_more_than_they_hold(tmp_path: Path) -> None:
    body = struct.pack("<I", 0x1000) + b"m\0" + struct.pack("<QQ", 10**9, 10**9) + bytes(100)
    content = struct.pack("<HH", 0x041C, 4) + zlib.compress(body) + struct.pack("<QI", 0, 1)
    (tmp_path / "m.serialized").write_bytes(content)
    scene = '[sensor]\ntype = "perspective"\n[m]\ntype = "serialized"\nfilename = "m.serialized"\n'
    assert "12000000000 bytes of vertices" in _refused(tmp_path / "bomb.toml", scene)


def test_values_that_double_with_each_default(tmp_path: Path) -> None:
    defaults = ["<default name='v0' value='0.5'/>"]
    defaults += [f"<default name='v{k + 1}' value='$v{k}$v{k}'/>" for k in range(40)]
    message = _refused(tmp_path / "bomb.xml", f"{HEAD}{''.join(defaults)}</scene>")
    assert "the variables of the scene stand for more than" in message


def test_includes_that_double_with_each_level(tmp_path: Path) -> None:
    for level in range(14):
        twice = f"<include filename='f{level + 1}.xml'/>" * 8
        (tmp_path / f"f{level}.xml").write_text(f"<scene version='3.0.0'>{twice}</scene>")
    (tmp_path / "f14.xml").write_text("<scene version='3.0.0'/>")
    message = _refused(tmp_path / "bomb.xml", f"{HEAD}<include filename='f0.xml'/></scene>")
    assert "included again and again" in message


def test_what_many_shapes_share_is_no_bomb(tmp_path: Path) -> None:
    shapes = "<shape type='sphere'><ref id='m'/></shape>" * 300
    material = "<bsdf type='twosided' id='m'><bsdf type='diffuse'/></bsdf>"
    path = tmp_path / "shared.xml"
    path.write_text(f"{HEAD}{material}{shapes}</scene>")
    model = et.load(path).model
    assert len(model.shapes) == 300
    assert sum(node.kind == "bsdf" for node in model.nodes()) == 2  # what is used often is visited once


MILLION = 1 << 20
POSITIONS: dict[str, Any] = {"componentType": 5126, "count": MILLION, "type": "VEC3"}
TRIANGLE = {**POSITIONS, "count": 3}
COPIES = {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 1}}}
SPARSE = {
    "count": 1,
    "indices": {"bufferView": 0, "componentType": 5121},
    "values": {"bufferView": 0},
}


def _gltf(**parts: Any) -> str:
    whole = {
        "asset": {"version": "2.0"},
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}],
        "scene": 0,
        **parts,
    }
    return json.dumps(whole)


def _bytes(count: int) -> dict[str, Any]:
    uri = "data:;base64," + base64.b64encode(bytes(count)).decode()
    return {"buffers": [{"byteLength": count, "uri": uri}], "bufferViews": [{"buffer": 0, "byteLength": count}]}


def _primitives(positions: Iterable[int], **more: Any) -> list[dict[str, Any]]:
    return [{"primitives": [{"attributes": {"POSITION": index}, **more} for index in positions]}]


COPIED = {"extensionsUsed": list(COPIES), "nodes": [{"mesh": 0, "extensions": COPIES}]}
GLTF = {
    "copies without data": ({**COPIED, "accessors": [TRIANGLE, {**POSITIONS, "count": 900_000}]}, "900000 copies"),
    "copies that share data": (
        {
            **COPIED,
            **_bytes(12 * 4000),
            "accessors": [TRIANGLE, {**POSITIONS, "count": 4000, "bufferView": 0}],
            "nodes": COPIED["nodes"] * 500,
            "scenes": [{"nodes": list(range(500))}],
        },
        "32000 copies of nodes in all; the limit for a file of this size is",
    ),
    "primitives that share an accessor": (
        {"accessors": [POSITIONS], "meshes": _primitives([0] * 200)},
        " elements that primitives use in all",
    ),
    "accessors without data": (
        {"accessors": [POSITIONS] * 2000, "meshes": _primitives(range(2000))},
        "elements without data that primitives use in all",
    ),
    "small accessors without data": (
        {"accessors": [{**POSITIONS, "count": 3000}] * 2000, "meshes": _primitives(range(2000))},
        "elements without data that primitives use in all",
    ),
    "indices without data": (
        {
            "accessors": [TRIANGLE, {"componentType": 5125, "count": MILLION, "type": "SCALAR"}],
            "meshes": _primitives([0] * 9, indices=1),
        },
        "elements that primitives use in all",
    ),
    "morph targets without data": (
        {"accessors": [POSITIONS], "meshes": _primitives([0], targets=[{"POSITION": 0, "NORMAL": 0}] * 200)},
        " elements that primitives use in all",
    ),
    "sparse accessors": (
        {**_bytes(16), "accessors": [{**POSITIONS, "sparse": SPARSE}] * 100, "meshes": _primitives(range(100))},
        "elements that primitives use in all",
    ),
    "nodes with two ways to each": (
        {"accessors": [TRIANGLE], "nodes": [{"children": [i + 1, i + 1]} for i in range(40)] + [{"mesh": 0}]},
        "nodes[0].children: a node is listed more than once",
    ),
}


@pytest.mark.parametrize("name", GLTF)
def test_gltf_parts_that_stand_nowhere_or_are_shared(tmp_path: Path, name: str) -> None:
    parts, words = GLTF[name]
    assert words in _refused(tmp_path / "bomb.gltf", _gltf(**parts))


@pytest.mark.parametrize(
    "name", ["accessors without data", "copies that share data", "primitives that share an accessor"]
)
def test_scenes_that_name_a_mesh_of_such_a_file(tmp_path: Path, name: str) -> None:
    parts, words = GLTF[name]
    (tmp_path / "bomb.gltf").write_text(_gltf(**parts))
    shape = "<shape type='gltf'><string name='filename' value='bomb.gltf#/meshes/0/primitives/0'/></shape>"
    assert words in _refused(tmp_path / "scene.xml", f"{HEAD}{shape}</scene>")


def test_sparse_morph_targets_may_have_zeros_for_each_vertex(tmp_path: Path) -> None:
    """The twin: fifty expressions of a face."""
    count = 30_000
    face = {**POSITIONS, "count": count, "bufferView": 0}
    target = {**POSITIONS, "count": count, "sparse": SPARSE}
    targets = [{"POSITION": 1, "NORMAL": 1}] * 50
    path = tmp_path / "face.gltf"
    path.write_text(_gltf(**_bytes(12 * count), accessors=[face, target], meshes=_primitives([0], targets=targets)))
    assert len(et.load(path).model.shapes) == 1


def _white(side: int) -> str:
    """Return a square picture of a few thousand bytes as a data URI."""
    return "data:image/png;base64," + base64.b64encode(_png(side, side, bytes(side * (side + 1)))).decode()


def _painted(materials: int) -> str:
    """Return a file whose materials all have one picture, with a factor of their own."""
    texture = {"index": 0}
    given = [
        {"pbrMetallicRoughness": {"baseColorTexture": texture, "baseColorFactor": [1, 1, i / materials, 1]}}
        for i in range(materials)
    ]
    attributes = {"POSITION": 0, "TEXCOORD_0": 1}
    return _gltf(
        accessors=[TRIANGLE, {**TRIANGLE, "type": "VEC2"}],
        images=[{"uri": _white(2048)}],
        textures=[{"source": 0}],
        materials=given,
        meshes=[{"primitives": [{"attributes": attributes, "material": i} for i in range(materials)]}],
    )


def test_materials_that_share_a_picture_of_few_bytes(tmp_path: Path) -> None:
    path = tmp_path / "bomb.gltf"
    path.write_text(_painted(50))
    started = process_time()
    with pytest.raises(et.SceneError, match=r"texels of images that are used again in all; the limit for a file of"):
        et.load(path)
    assert process_time() - started < 2 * SECONDS
    path.write_text(_painted(3))
    assert len(et.load(path).model.shapes) == 3


def test_toml_includes_that_double_with_each_level(tmp_path: Path) -> None:
    for level in range(14):
        (tmp_path / f"f{level}.toml").write_text(f'include = ["f{level + 1}.toml"' + f', "f{level + 1}.toml"' * 7 + "]")
    (tmp_path / "f14.toml").write_text("")
    message = _refused(tmp_path / "bomb.toml", 'include = "f0.toml"\n[sensor]\ntype = "perspective"\n')
    assert "included again and again" in message


def test_a_spectrum_that_many_parts_name_is_read_once(tmp_path: Path) -> None:
    (tmp_path / "long.spd").write_text("".join(f"{400 + 0.001 * i} 1\n" for i in range(100_000)))
    part = "<bsdf type='diffuse'><spectrum name='reflectance' filename='long.spd'/></bsdf>"
    path = tmp_path / "scene.xml"
    path.write_text(f"{HEAD}{part * 100}</scene>")
    started = process_time()
    assert et.load(path).model.sensor.type == "perspective"
    assert process_time() - started < 2 * SECONDS


@pytest.mark.parametrize(
    "parts",
    [
        "".join(
            f"<bsdf type='diffuse' id='q{i}'/><shape type='sphere'><ref id='nope{i}'/></shape>" for i in range(3000)
        ),
        "".join(f"<bsdf type='diffuse' id='node{i}'/>" for i in range(6000))
        + "".join(f"<shape type='sphere'><ref id='nope{i}'/></shape>" for i in range(200)),
        "<shape type='sphere'>" + "".join(f"<float name='r{i}' value='1'/>" for i in range(40_000)) + "</shape>",
        "<shape type='sphere' " + " ".join(f"a{i}='1'" for i in range(20_000)) + "/>",
        f"<shape type='sphere'><ref id='{'q' * 100_000}'/></shape>",
        f"<shape type='sphere'><string name='{'q' * 100_000}' value='{'w' * 100_000}'/></shape>",
    ],
    ids=["references", "references among many names", "parameters", "attributes", "a name", "a value"],
)
def test_as_many_problems_are_told_as_anybody_reads(tmp_path: Path, parts: str) -> None:
    message = _refused(tmp_path / "broken.xml", f"{HEAD}{parts}</scene>")
    assert message.count("\n") <= 100
    assert max(map(len, message.splitlines())) < 3000


def test_as_many_warnings_are_told_as_anybody_reads(tmp_path: Path) -> None:
    path = tmp_path / "odd.xml"
    stray = f"stray<path value='{tmp_path}'/>\n"
    path.write_text(f"{HEAD}{stray * 300}</scene>")
    warnings = et.load(path).warnings
    assert len(warnings) == 101
    assert warnings[-1] == "and 200 more warnings"


MIXED: list[Any] = [{"type": "diffuse"}, *([0.5] * 1000)]


def _doubled(leaf: Any, join: Callable[[Any], Any]) -> Any:
    for _ in range(40):
        leaf = join(leaf)
    return leaf


@pytest.mark.parametrize(
    "part",
    [
        _doubled({"type": "diffuse"}, lambda bsdf: {"type": "blendbsdf", "weight": 0.5, "a": bsdf, "b": bsdf}),
        _doubled({"type": "diffuse"}, lambda bsdf: {"type": "blendbsdf", "weight": 0.5, "bsdfs": [bsdf, bsdf]}),
        {"type": "unknown", **{str(number): MIXED for number in range(200)}},
        {"type": "sphere", "center": _doubled([1.0], lambda numbers: [numbers, numbers])},
        {"type": "sphere", "to_world": _doubled([1.0], lambda numbers: [numbers, numbers])},
    ],
    ids=["objects", "lists of objects", "lists of an object and numbers", "numbers", "steps"],
)
def test_dictionaries_and_lists_that_share_parts(part: dict[str, Any]) -> None:
    started = process_time()
    with pytest.raises(et.SceneError, match=r"dictionaries and lists are repeated too often; the limit for this") as e:
        et.load_dict({"type": "scene", "sensor": {"type": "perspective"}, "part": part})
    assert process_time() - started < SECONDS
    assert len(str(e.value)) < 1000
