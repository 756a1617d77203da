"""Every property that the schema of glTF lists is used, told or refused: a change of its value changes what is loaded.

The schema is the account of what is read, so that a property which it lists and nobody reads would be lost in silence.
"""

from __future__ import annotations

import base64
import json
import re
from collections.abc import Callable
from copy import deepcopy
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import equaltime as et
from equaltime.errors import SceneError
from equaltime.scene.gltf import surfaces
from equaltime.scene.gltf.account import DESCRIPTIONS
from equaltime.scene.gltf.rules import Index, walk
from equaltime.scene.gltf.schema import DOCUMENT

from .gltf_files import TRIANGLE, Builder

Json = dict[str, Any]
TRANSFORM = {"offset": [0.1, 0.2], "rotation": 0.3, "scale": [2.0, 3.0]}
WORDS: dict[str, Any] = {
    **{"mode": 5, "alphaMode": "OPAQUE", "wrapS": 33071, "wrapT": 33071, "magFilter": 9728, "type": "VEC2"},
    **{"componentType": 5123, "interpolation": "STEP", "path": "scale", "uri": "gone.bin", "version": "3.0"},
    **{"minVersion": "3.0"},
}
"""Other values of words and of numbers that stand for words."""


def use(texture: int, **more: Any) -> Json:
    return {"index": texture, "extensions": {"KHR_texture_transform": dict(TRANSFORM)}, **more}


def materials() -> list[Json]:
    """Return materials that have between them every property that the schema lists."""
    layered = {
        "KHR_materials_anisotropy": {
            **{"anisotropyStrength": 0.5, "anisotropyRotation": 0.5, "anisotropyTexture": use(0)},
        },
        "KHR_materials_clearcoat": {
            **{"clearcoatFactor": 0.5, "clearcoatTexture": use(0), "clearcoatRoughnessFactor": 0.25},
            **{"clearcoatRoughnessTexture": use(0), "clearcoatNormalTexture": use(0)},
        },
        "KHR_materials_emissive_strength": {"emissiveStrength": 2.0},
        "KHR_materials_ior": {"ior": 1.4},
        "KHR_materials_sheen": {
            **{"sheenColorFactor": [0.5, 0.25, 0.125], "sheenColorTexture": use(0)},
            **{"sheenRoughnessFactor": 0.5, "sheenRoughnessTexture": use(0)},
        },
        "KHR_materials_specular": {
            **{"specularFactor": 0.5, "specularTexture": use(0), "specularColorFactor": [0.5, 0.25, 1.0]},
            "specularColorTexture": use(0),
        },
        "KHR_materials_transmission": {"transmissionFactor": 0.5, "transmissionTexture": use(0)},
        "KHR_materials_volume": {"thicknessFactor": 1.0, "attenuationDistance": 2.0, "attenuationColor": [0.5, 0.5, 1]},
    }
    return [
        {
            "pbrMetallicRoughness": {
                **{"baseColorFactor": [0.5, 0.25, 0.125, 0.75], "baseColorTexture": use(0), "metallicFactor": 0.5},
                **{"roughnessFactor": 0.5, "metallicRoughnessTexture": use(0)},
            },
            "normalTexture": use(0, scale=0.5),
            "occlusionTexture": use(0, strength=0.5),
            "emissiveFactor": [0.5, 0.25, 0.125],
            "emissiveTexture": use(0),
            **{"alphaMode": "MASK", "alphaCutoff": 0.25, "doubleSided": True},
            "extensions": layered,
        },
        {
            "extensions": {
                "KHR_materials_pbrSpecularGlossiness": {
                    **{"diffuseFactor": [0.5, 0.25, 0.125, 0.5], "diffuseTexture": use(0), "glossinessFactor": 0.5},
                    "specularFactor": [0.5, 0.25, 0.125],
                }
            },
            "alphaMode": "BLEND",
        },
        {"extensions": {"KHR_materials_pbrSpecularGlossiness": {"specularGlossinessTexture": use(0)}}},
        {"extensions": {"KHR_materials_unlit": {}}},
        {"pbrMetallicRoughness": {"baseColorTexture": {"index": 1, "texCoord": 1}}},
        {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}},
    ]


def everything(folder: Path) -> Json:
    """Return a document that has every property that the schema lists, with its buffer as a data URI."""
    builder = Builder()
    builder.image(np.random.default_rng(1).integers(0, 256, (4, 4, 4), np.uint8), folder)
    builder.image(np.random.default_rng(2).integers(0, 256, (4, 4, 4), np.uint8), folder)
    builder.json["images"][1]["uri"] = "data:image/png;base64," + base64.b64encode(_image(builder)).decode()
    del builder.json["images"][1]["bufferView"]
    webp = builder.add("textures", {"extensions": {"EXT_texture_webp": {"source": 0}}, "sampler": 0})
    builder.json["textures"][0]["sampler"] = 0
    builder.json["samplers"] = [{"magFilter": 9729, "wrapS": 10497, "wrapT": 33648}]
    builder.json["materials"] = materials()
    uv, other = [[0, 0.25], [1, 0], [0, 1]], [[0.5, 0.25], [1, 0.5], [0, 1]]
    moved = builder.accessor(np.ones((3, 3)))
    meshes = [
        builder.mesh(
            material=i,
            indices=[0, 1, 2],
            mode=4,
            TEXCOORD_0=uv,
            TEXCOORD_1=other,
            COLOR_0=builder.accessor(np.full((3, 4), 100), "u1", normalized=True),
            targets=[{"POSITION": moved}],
        )
        for i in range(len(builder.json["materials"]))
    ]
    builder.json["materials"][5]["pbrMetallicRoughness"]["baseColorTexture"]["index"] = webp
    for mesh in meshes:
        builder.json["meshes"][mesh]["weights"] = [0.5]
        builder.node(mesh=mesh, translation=[mesh, 0, 0])
    _nodes(builder, meshes[0])
    _accessors(builder)
    used = ["EXT_mesh_gpu_instancing", "KHR_lights_punctual", "KHR_node_visibility"]
    builder.json |= {"extensionsUsed": [*used, "KHR_not_known"], "extensionsRequired": used, "scene": 0}
    builder.json["asset"] |= {"minVersion": "2.0"}
    roots = [i for i in range(len(builder.json["nodes"])) if i != CHILD]
    builder.json["scenes"] = [{"nodes": roots}, {"nodes": [0]}]
    document = builder.document()
    document["buffers"][0]["uri"] = "data:application/octet-stream;base64," + base64.b64encode(builder.binary).decode()
    return document


def _image(builder: Builder) -> bytes:
    view = builder.json["bufferViews"][builder.json["images"][1]["bufferView"]]
    return builder.binary[view["byteOffset"] : view["byteOffset"] + view["byteLength"]]


CHILD = 7
"""The node that hangs on another."""


def _nodes(builder: Builder, mesh: int) -> None:
    """Add nodes, cameras, lights, a skin and an animation."""
    lights = [
        {"type": "point", "color": [1, 0.5, 0.25], "intensity": 2.0, "range": 10.0},
        {
            "type": "spot",
            "color": [1, 0.5, 0.25],
            "intensity": 2.0,
            "spot": {"innerConeAngle": 0.2, "outerConeAngle": 0.4},
        },
        {"type": "directional", "intensity": 2.0},
    ]
    builder.json["extensions"] = {"KHR_lights_punctual": {"lights": lights}}
    joint = builder.node(rotation=[0, 0, 0.6, 0.8], scale=[1, 2, 3], translation=[1, 2, 3], children=[CHILD])
    child = builder.node(mesh=mesh, matrix=[2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 1, 2, 3, 1], weights=[0.25])
    assert child == CHILD
    bones = builder.accessor([np.eye(4).ravel() * 2] * 2, type="MAT4")
    builder.add("skins", {"joints": [joint, child], "inverseBindMatrices": bones})
    joints = builder.accessor([[0, 1, 0, 0]] * 3, "u1")
    skinned = builder.mesh(JOINTS_0=joints, WEIGHTS_0=[[0.5, 0.5, 0, 0]] * 3)
    builder.node(mesh=skinned, skin=0)
    hidden = {"KHR_node_visibility": {"visible": True}}
    instancing = {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": builder.accessor([[5, 5, 5], [6, 6, 6]])}}}
    builder.node(mesh=mesh, extensions=hidden)
    builder.node(mesh=mesh, extensions=instancing)
    for light in range(len(lights)):
        place = {} if lights[light]["type"] == "directional" else {"translation": [light, 5, 5]}
        builder.node(extensions={"KHR_lights_punctual": {"light": light}}, **place)
    perspective = {"yfov": 0.8, "aspectRatio": 1.5, "znear": 0.1, "zfar": 100.0}
    builder.json["cameras"] = [
        {"type": "perspective", "perspective": perspective},
        {"type": "orthographic", "orthographic": {"xmag": 2.0, "ymag": 1.0, "znear": 0.1, "zfar": 100.0}},
    ]
    builder.node(camera=0, translation=[0, 0, 10])
    builder.node(camera=1, translation=[0, 0, 10])
    times, places = builder.accessor([0.0, 1.0]), builder.accessor([[0, 0, 0], [1, 1, 1]])
    target = {"node": 1, "path": "translation"}
    sampler = {"input": times, "output": places, "interpolation": "LINEAR"}
    builder.add("animations", {"channels": [{"sampler": 0, "target": target}], "samplers": [sampler]})


def _accessors(builder: Builder) -> None:
    """Give an accessor an offset and a stride, and another corrections."""
    packed = np.zeros((3, 5), "<f4")
    packed[:, 1:4] = TRIANGLE
    view = builder.view(packed.tobytes(), byteStride=20)
    where, values = builder.view(bytes([0, 0, 1, 0])), builder.view(np.full((1, 6), 0.5, "<f4").tobytes())
    sparse = {
        "count": 1,
        "indices": {"bufferView": where, "byteOffset": 2, "componentType": 5121},
        "values": {"bufferView": values, "byteOffset": 4},
    }
    strided = {"bufferView": view, "byteOffset": 4, "componentType": 5126, "count": 3, "type": "VEC3", "sparse": sparse}
    builder.node(mesh=builder.mesh(POSITION=builder.add("accessors", strided)))


def outcome(document: Json, folder: Path, **defines: Any) -> tuple[object, ...]:
    """Return all that can be known of a document: its scene and what is told, or why it is refused."""
    path = folder / "a.gltf"
    path.write_text(json.dumps(document))
    try:
        scene = et.load(path, **defines)
        return scene.digest, scene.warnings
    except SceneError as error:
        return (str(error),)


def changed(name: str, value: Any, rule: Any) -> Any:
    """Return another value of a property."""
    if isinstance(rule, Index):
        return value - 1 if value else 1
    if isinstance(value, bool):
        return not value
    if name in WORDS:
        return WORDS[name]
    if isinstance(value, str):
        return value + "?"
    if isinstance(value, list):
        return [0.5 * value[0] + 0.0625, *value[1:]]
    return value - 1 if isinstance(value, int) and value else 0.5 * value + 0.0625


def steps_of(place: str) -> list[Any]:
    """Return the keys and numbers of a place such as ``nodes[1].mesh``."""
    return [int(step[1:-1]) if step[0] == "[" else step for step in re.findall(r"\[\d+\]|[^.\[\]]+", place)]


def replaced(document: Json, place: str, change: Callable[[str, Any], Any]) -> Json:
    """Return the document with another value at a place such as ``nodes[1].mesh``."""
    result = deepcopy(document)
    *steps, last = steps_of(place)
    inner: Any = result
    for step in steps:
        inner = inner[step]
    name = next(step for step in (last, *reversed(steps)) if isinstance(step, str))
    inner[last] = change(name, inner[last])
    return result


LAYOUT = re.compile(r"accessors|bufferViews|buffers|extensions(Used|Required)")
"""Parts that lay out bytes, which tests/metamorphic/test_gltf_rewritten.py writes in many ways, and lists of names."""
TOGETHER = (
    *("asset.version", "meshes[].primitives[].mode", "scenes[].nodes[]"),
    *("materials[].extensions.KHR_materials_anisotropy", "materials[].extensions.KHR_materials_sheen.sheenRoughness"),
    *("materials[].extensions.KHR_materials_specular.specularTexture",),
    *("materials[].extensions.KHR_materials_specular.specularColorTexture",),
)
"""Beginnings of properties that are told or used with others.

minVersion stands for version, one triangle is a strip too, and a scene that is not shown is told. One line tells of
both properties that are not used of an anisotropy, of a sheen, or of a specular reflection.
"""


def without(document: Json, place: str) -> Json:
    """Return the document without the entry at a place."""
    result = deepcopy(document)
    *steps, last = steps_of(place)
    inner: Any = result
    for step in steps:
        inner = inner[step]
    del inner[last]
    return result


def is_lost(document: Json, rule: Any, place: str, folder: Path) -> bool:
    """Tell whether neither another value of a property, nor its absence, nor that of its texture changes anything."""
    view = {"camera": "1" if place.startswith(("cameras[1]", "nodes[15]")) else "0"}
    view |= {"shutter": "0,0.5"} if place.startswith("animations") else {}
    before = outcome(document, folder, **view)
    assert len(before) == 2, before
    if outcome(replaced(document, place, lambda name, value: changed(name, value, rule)), folder, **view) != before:
        return False
    texture = re.match(r".*?Texture(?=\.)", place)
    absent = [place] if texture is None else [place, texture[0]]
    return all(outcome(without(document, gone), folder, **view) == before for gone in absent)


def properties(document: Json) -> list[tuple[Any, str]]:
    """Return the rules and the places of all properties that are looked at."""
    found = []
    for rule, _, place in walk(DOCUMENT, document):
        kind = re.sub(r"\[\d+\]", "[]", place)
        described = kind in DESCRIPTIONS or place.rpartition(".")[2] in DESCRIPTIONS
        if rule is not None and not described and not LAYOUT.match(place) and not kind.startswith(TOGETHER):
            found.append((rule, place))
    return found


SHARE = 8
"""The everyday run looks at one property in so many."""


@pytest.mark.parametrize("share", [SHARE, pytest.param(1, marks=pytest.mark.slow)])
def test_a_change_of_any_property_that_is_listed_changes_what_is_loaded(tmp_path: Path, share: int) -> None:
    document = everything(tmp_path)
    found = properties(document)
    assert len(found) > 150
    assert [place for rule, place in found[::share] if is_lost(document, rule, place, tmp_path)] == []


def test_a_property_that_nobody_reads_is_caught(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    document = everything(tmp_path)
    rule, place = next(found for found in properties(document) if found[1].endswith("KHR_materials_ior.ior"))
    assert not is_lost(document, rule, place, tmp_path)
    monkeypatch.setattr(surfaces, "_dielectric", lambda reading: 1.5)
    assert is_lost(document, rule, place, tmp_path)
