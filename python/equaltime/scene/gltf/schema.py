"""Rules for the parts of glTF 2.0 and its extensions that this package reads; see the specification's JSON schema.

In a document that passes, every listed property has the right type and range, and every index is within its list. Later
code need not check them again. Properties that are not listed are allowed, as the specification requires, and noted as
not used (`equaltime.scene.gltf.account`). Listed properties are used, or noted by the code that reads them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import is_dataclass
from functools import cache
from typing import Any, Final, get_args, get_type_hints

from equaltime.scene.gltf.rules import (
    Rule,
    every,
    flag,
    index,
    integer,
    mapping,
    number,
    numbers,
    one_of,
    table,
    text,
)

__all__ = ["BASIS", "DOCUMENT", "MAPPING", "MATERIAL_EXTENSIONS", "UNREADABLE", "typed"]

MAPPING: Final = {
    "EXT_mesh_gpu_instancing": "instances",
    "EXT_texture_webp": "read, if the texture has no other image",
    "KHR_lights_punctual": "point, directional, spot, in candela and lux; "
    "approximation: a spot falls linearly with the angle, and a light's range is not used",
    "KHR_materials_anisotropy": "principled's anisotropic; "
    "approximation: along u, alphas at most a factor of 10 apart, no texture",
    "KHR_materials_clearcoat": "principled's clearcoat; "
    "approximation: a quarter as strong, alpha from 0.001 to 0.1, no normals of its own",
    "KHR_materials_emissive_strength": "a factor on the radiance of area",
    "KHR_materials_ior": "principled's eta",
    "KHR_materials_pbrSpecularGlossiness": "principled with metalness and base colour that reflect nearly the same; "
    "approximation: the specular colours of a texture are not used",
    "KHR_materials_sheen": "principled's sheen; approximation: white, of one roughness",
    "KHR_materials_specular": "principled's eta with the same reflection at normal incidence; "
    "approximation: no colour, no textures",
    "KHR_materials_transmission": "blendbsdf with thindielectric, or principled's spec_trans where there is a volume; "
    "approximation: roughness does not blur light that passes a thin wall",
    "KHR_materials_unlit": "area of the base colour; approximation: it shines on its surroundings",
    "KHR_materials_volume": "homogeneous, inside materials with a thickness above 0, whose value is not used",
    "KHR_mesh_quantization": "supported in full",
    "KHR_node_visibility": "invisible nodes are left out",
    "KHR_texture_transform": "to_uv; approximation: all textures of a material use one set of texture coordinates",
}
"""Mitsuba's plugin or parameter that each supported glTF extension becomes, in words, by the extension's name."""


def typed(document: Mapping[str, Any]) -> Any:
    """Convert a JSON document that follows the schema to an object of the class `pygltflib.GLTF2`.

    Materials without ``pbrMetallicRoughness`` get the default of this property. Properties that pygltflib does not know
    are left out, except the weights of nodes.
    """
    import pygltflib  # imported late: it is slow to import, and only glTF files need it

    gltf = _made(pygltflib.GLTF2, document)
    for material in gltf.materials:
        material.pbrMetallicRoughness = material.pbrMetallicRoughness or pygltflib.PbrMetallicRoughness()
    for node, given in zip(gltf.nodes, document.get("nodes", ()), strict=True):
        node.weights = given.get("weights")  # pygltflib has no such field
    return gltf


def _made(kind: type, value: Any) -> Any:
    """Return the JSON `value` as an object of pygltflib's class `kind`, or as a list of such objects."""
    if isinstance(value, list):
        return [_made(kind, item) for item in value]
    if not is_dataclass(kind):  # the class of attributes, which may have any name
        return kind(**value)
    known = _fields(kind)
    return kind(**{name: _made(k, v) if (k := known[name]) else v for name, v in value.items() if name in known})


@cache
def _fields(kind: type) -> dict[str, type | None]:
    """Return the fields of a pygltflib class, with the class of their objects; None for plain values."""
    return {name: _class_in(hint) for name, hint in get_type_hints(kind).items()}


def _class_in(hint: Any) -> type | None:
    """Return the pygltflib class in a type such as ``Optional[List[Accessor]]``, or None."""
    if isinstance(hint, type) and hint.__module__ == "pygltflib":
        return hint
    return next((found for part in get_args(hint) if (found := _class_in(part)) is not None), None)


BASIS = "KHR_texture_basisu"
"""Extension that stores images in a form that is not supported."""
UNREADABLE = {
    "EXT_meshopt_compression": "decode it first, for example with gltf-transform copy",
    "KHR_draco_mesh_compression": "decode it first, for example with gltf-transform copy",
    "KHR_meshopt_compression": "decode it first, for example with gltf-transform copy",
    BASIS: "convert the textures to PNG or JPEG",
}
"""Extensions that store data in a form that is not supported, with advice for the user. A file is refused if a mesh is
stored only in such a form, or an image that a material uses."""

_unit, _positive, _color = number(0.0, 1.0), number(0.0), numbers(3, 0.0, 1.0)

_strong_color = numbers(3, 0.0)

_TRANSFORM = table(offset=numbers(2), rotation=number(), scale=numbers(2), texCoord=integer())

_TEXTURE = table(
    "index",
    index=index("textures"),
    texCoord=integer(),
    scale=number(),
    strength=_unit,
    extensions=table(KHR_texture_transform=_TRANSFORM),
)

MATERIAL_EXTENSIONS: dict[str, Rule] = {
    "KHR_materials_anisotropy": table(
        anisotropyStrength=_unit, anisotropyRotation=number(), anisotropyTexture=_TEXTURE
    ),
    "KHR_materials_clearcoat": table(
        clearcoatFactor=_unit,
        clearcoatTexture=_TEXTURE,
        clearcoatRoughnessFactor=_unit,
        clearcoatRoughnessTexture=_TEXTURE,
        clearcoatNormalTexture=_TEXTURE,
    ),
    "KHR_materials_emissive_strength": table(emissiveStrength=_positive),
    "KHR_materials_ior": table(ior=_positive),
    "KHR_materials_pbrSpecularGlossiness": table(
        diffuseFactor=numbers(4, 0.0, 1.0),
        diffuseTexture=_TEXTURE,
        specularFactor=_color,
        glossinessFactor=_unit,
        specularGlossinessTexture=_TEXTURE,
    ),
    "KHR_materials_sheen": table(
        sheenColorFactor=_color,
        sheenColorTexture=_TEXTURE,
        sheenRoughnessFactor=_unit,
        sheenRoughnessTexture=_TEXTURE,
    ),
    "KHR_materials_specular": table(
        specularFactor=_unit,
        specularTexture=_TEXTURE,
        specularColorFactor=_strong_color,
        specularColorTexture=_TEXTURE,
    ),
    "KHR_materials_transmission": table(transmissionFactor=_unit, transmissionTexture=_TEXTURE),
    "KHR_materials_unlit": table(),
    "KHR_materials_volume": table(
        thicknessFactor=_positive,
        attenuationDistance=_positive,
        attenuationColor=_color,
    ),
}

_MATERIAL = table(
    pbrMetallicRoughness=table(
        baseColorFactor=numbers(4, 0.0, 1.0),
        baseColorTexture=_TEXTURE,
        metallicFactor=_unit,
        roughnessFactor=_unit,
        metallicRoughnessTexture=_TEXTURE,
    ),
    normalTexture=_TEXTURE,
    occlusionTexture=_TEXTURE,
    emissiveTexture=_TEXTURE,
    emissiveFactor=_strong_color,  # some exporters wrote more than 1 before there was an extension for it
    alphaMode=one_of("OPAQUE", "MASK", "BLEND"),
    alphaCutoff=_positive,
    doubleSided=flag,
    name=text,
    extensions=table(**MATERIAL_EXTENSIONS),
)

_PRIMITIVE = table(
    "attributes",
    attributes=mapping(index("accessors")),
    indices=index("accessors"),
    material=index("materials"),
    mode=one_of(0, 1, 2, 3, 4, 5, 6),
    targets=every(mapping(index("accessors"))),
)

_NODE = table(
    children=every(index("nodes")),
    mesh=index("meshes"),
    camera=index("cameras"),
    skin=index("skins"),
    matrix=numbers(16),
    translation=numbers(3),
    rotation=numbers(4),
    scale=numbers(3),
    weights=every(number()),
    name=text,
    extensions=table(
        EXT_mesh_gpu_instancing=table("attributes", attributes=mapping(index("accessors"))),
        KHR_lights_punctual=table("light", light=index("extensions/KHR_lights_punctual/lights")),
        KHR_node_visibility=table(visible=flag),
    ),
)

_CAMERA = table(
    "type",
    type=one_of("perspective", "orthographic"),
    name=text,
    perspective=table(
        "yfov znear", yfov=number(1e-6, 3.14159), aspectRatio=number(1e-3, 1e3), znear=_positive, zfar=_positive
    ),
    orthographic=table("xmag ymag", xmag=number(), ymag=number(), znear=_positive, zfar=_positive),
)

_LIGHT = table(
    "type",
    type=one_of("directional", "point", "spot"),
    color=_strong_color,
    intensity=_positive,
    range=_positive,
    name=text,
    spot=table(innerConeAngle=number(0.0, 1.5707964), outerConeAngle=number(0.0, 1.5707964)),
)

_ACCESSOR = table(
    "componentType count type",
    bufferView=index("bufferViews"),
    byteOffset=integer(),
    componentType=one_of(5120, 5121, 5122, 5123, 5125, 5126),
    normalized=flag,
    count=integer(),
    type=one_of("SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4"),
    sparse=table(
        "count indices values",
        count=integer(),
        indices=table(
            "bufferView componentType",
            bufferView=index("bufferViews"),
            byteOffset=integer(),
            componentType=one_of(5121, 5123, 5125),
        ),
        values=table("bufferView", bufferView=index("bufferViews"), byteOffset=integer()),
    ),
)

_VIEW = table(
    "buffer byteLength", buffer=index("buffers"), byteOffset=integer(), byteLength=integer(), byteStride=integer()
)

_TEXTURE_FORMS = table(EXT_texture_webp=table("source", source=index("images")))

_TARGET = table("path", node=index("nodes"), path=text)

_DATA, _INTERPOLATION = index("accessors"), one_of("LINEAR", "STEP", "CUBICSPLINE")

DOCUMENT = table(
    "asset",
    asset=table("version", version=text, minVersion=text),
    extensionsUsed=every(text),
    extensionsRequired=every(text),
    scene=index("scenes"),
    scenes=every(table(nodes=every(index("nodes")), name=text)),
    nodes=every(_NODE),
    meshes=every(table("primitives", primitives=every(_PRIMITIVE), weights=every(number()), name=text)),
    accessors=every(_ACCESSOR),
    bufferViews=every(_VIEW),
    buffers=every(table("byteLength", uri=text, byteLength=integer(1))),
    materials=every(_MATERIAL),
    textures=every(table(sampler=index("samplers"), source=index("images"), name=text, extensions=_TEXTURE_FORMS)),
    samplers=every(
        table(
            magFilter=one_of(9728, 9729),
            minFilter=one_of(9728, 9729, 9984, 9985, 9986, 9987),
            wrapS=one_of(33071, 33648, 10497),
            wrapT=one_of(33071, 33648, 10497),
        )
    ),
    images=every(table(uri=text, mimeType=text, bufferView=index("bufferViews"), name=text)),
    cameras=every(_CAMERA),
    skins=every(table("joints", joints=every(index("nodes")), inverseBindMatrices=index("accessors"))),
    animations=every(
        table(
            name=text,
            channels=every(table("sampler target", sampler=integer(), target=_TARGET)),
            samplers=every(table("input output", input=_DATA, output=_DATA, interpolation=_INTERPOLATION)),
        )
    ),
    extensions=table(KHR_lights_punctual=table(lights=every(_LIGHT))),
)
"""Rule for a whole glTF document."""
