"""Converts glTF materials to parameters of the principled BSDF, independent of a scene.

The table in `equaltime.scene.gltf` lists the counterparts; this module has the formulas.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from equaltime.scene.gltf.slots import ALPHA, Slot, TextureUse, faded, texture_use

__all__ = ["SurfaceLook", "capped", "look"]

UNIT_FACTORS = frozenset(
    {
        *("baseColorFactor", "metallicFactor", "roughnessFactor"),
        *("diffuseFactor", "specularFactor", "glossinessFactor"),
        *("clearcoatFactor", "clearcoatRoughnessFactor", "sheenColorFactor", "sheenRoughnessFactor"),
        *("transmissionFactor", "attenuationColor", "anisotropyStrength", "strength"),
    }
)
"""Material factors that must be in [0, 1] according to the specification."""

_DEEPEST = 3
"""Levels below a material that are searched: down to a texture of an extension."""


def capped(document: Mapping[str, Any]) -> list[str]:
    """Set material factors above 1 in the JSON `document` to 1, in place, because the specification forbids them.

    Return the JSON paths of the changed factors, such as ``materials[2].pbrMetallicRoughness.metallicFactor``.
    """
    materials = document.get("materials")
    if not isinstance(materials, list):
        return []
    return [place for i, material in enumerate(materials) for place in _capped(material, f"materials[{i}]", _DEEPEST)]


def _capped(node: Any, place: str, depth: int) -> Iterator[str]:
    if not isinstance(node, dict):
        return
    for key, value in node.items():
        if key in UNIT_FACTORS and _exceeds(value):
            node[key] = [min(v, 1.0) for v in value] if isinstance(value, list) else 1.0
            yield f"{place}.{key}"
        elif depth > 0 and key != "extras":
            yield from _capped(value, f"{place}.{key}", depth - 1)


def _exceeds(value: Any) -> bool:
    """Tell whether the value is a number above 1, or a list of numbers with one above 1."""
    values = value if isinstance(value, list) else [value]
    return all(isinstance(v, int | float) and not isinstance(v, bool) for v in values) and any(v > 1.0 for v in values)


DEFAULT_IOR = 1.5

RED, GREEN, BLUE = (0,), (1,), (2,)

DIELECTRIC_F0 = 0.04

BLACKEST = 2.0**-24
"""Smallest transmittance over the attenuation distance. A transmittance of 0 would need an infinite extinction."""

WEAKEST = 1e-6
"""Smallest strength of anisotropy above 0. The square of a smaller one may be 0, and so may be both alphas."""

INFINITE_IOR = 1000.0
"""Index of refraction that replaces 0 in KHR_materials_ior, where 0 means total reflection."""


@dataclass(frozen=True, slots=True, eq=False)
class SurfaceLook:
    """A glTF material, converted to parameters of a BSDF, an emitter and a medium."""

    slots: Mapping[str, Slot]
    """Parameters of `principled` by name, and ``opacity``, ``normal``, ``radiance``, ``transmission`` (thin walls).

    ``alpha`` is the opacity before the cutoff is applied, for meshes with vertex opacities.
    """
    eta: float
    """Index of refraction of the dielectric part of the BSDF."""
    two_sided: bool
    unlit: bool
    uv_set: int
    """Index of the set of texture coordinates that all textures use."""
    notes: tuple[str, ...] = ()
    """Notes for the user on differences from the material in the file."""
    sigma_t: tuple[float, ...] = ()
    """Extinction per channel of the interior, per unit of length in world space; empty without absorption."""

    @property
    def textured(self) -> bool:
        """Whether any parameter has a texture."""
        return any(slot.texture is not None for slot in self.slots.values())


@dataclass(slots=True, eq=False)
class _Reading:
    """A material while it is being read."""

    material: Any
    slots: dict[str, Slot] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)
    sigma_t: tuple[float, ...] = ()

    def extension(self, name: str) -> Mapping[str, Any] | None:
        """Return the extension KHR_materials_`name` if the material has it."""
        found: Mapping[str, Any] | None = (self.material.extensions or {}).get(f"KHR_materials_{name}")
        return found


def look(material: Any) -> SurfaceLook:
    """Return the parameters of a glTF material's BSDF, emitter and medium.

    `material` is a `pygltflib.Material`, or None for the default material.
    """
    if material is None:
        one = Slot((1.0,))
        plain = {"base_color": Slot((1.0, 1.0, 1.0)), "metallic": one, "roughness": one}
        return SurfaceLook(plain, DEFAULT_IOR, False, False, 0)
    reading = _Reading(material)
    _base(reading)
    unlit, eta = reading.extension("unlit") is not None, DEFAULT_IOR
    if not unlit:  # such a material has a colour and an opacity only, as the extension says
        _normal(reading)
        eta = _dielectric(reading)
        _transmission(reading)
        _layers(reading)
        _anisotropy(reading)
    _emission(reading)
    return SurfaceLook(
        reading.slots,
        eta,
        bool(material.doubleSided),
        unlit,
        _uv_set(reading),
        tuple(reading.notes),
        reading.sigma_t,
    )


def _base(reading: _Reading) -> None:
    """Read base colour, opacity, metalness and roughness."""
    if (old := reading.extension("pbrSpecularGlossiness")) is not None:
        color, texture = _specular_glossiness(reading, old)
    else:
        pbr = reading.material.pbrMetallicRoughness
        color, texture = tuple(pbr.baseColorFactor), texture_use(pbr.baseColorTexture)
        both = texture_use(pbr.metallicRoughnessTexture)
        reading.slots |= {
            "base_color": Slot(color[:3], texture, encoded=True),
            "metallic": Slot((pbr.metallicFactor,), both, BLUE),
            "roughness": Slot((pbr.roughnessFactor,), both, GREEN),
        }
    mode = reading.material.alphaMode
    if mode in ("MASK", "BLEND"):
        given = reading.material.alphaCutoff
        cutoff = None if mode == "BLEND" else 0.5 if given is None else given
        reading.slots["opacity"] = Slot(color[3:], texture, ALPHA, cutoff=cutoff)
        reading.slots["alpha"] = Slot(color[3:], texture, ALPHA)
    if reading.material.occlusionTexture is not None:
        reading.notes.append("the occlusion texture is not used: the render computes occlusion")


def _specular_glossiness(reading: _Reading, old: Mapping[str, Any]) -> tuple[tuple[float, ...], TextureUse | None]:
    """Read the old extension that some files still have; return diffuse colour and texture."""
    color, specular = tuple(old.get("diffuseFactor", (1, 1, 1, 1))), old.get("specularFactor", (1, 1, 1))
    texture, both = texture_use(old.get("diffuseTexture")), texture_use(old.get("specularGlossinessTexture"))
    gloss = Slot((old.get("glossinessFactor", 1.0),), both, ALPHA, curve=_roughness_of_gloss)
    metallic, base = _as_metallic(np.array(color[:3], np.float64), np.array(specular, np.float64))
    if both is not None:
        metallic, base = 0.0, np.array(color[:3], np.float64)
        reading.notes.append("the specular colours of KHR_materials_pbrSpecularGlossiness are not used")
    elif texture is not None and metallic > 0.5:
        texture_of_base: TextureUse | None = None
        reading.slots["base_color"] = Slot(tuple(base.tolist()), texture_of_base)
        reading.notes.append("the diffuse texture of KHR_materials_pbrSpecularGlossiness is not used: this is a metal")
    if "base_color" not in reading.slots:
        reading.slots["base_color"] = Slot(tuple(base.tolist()), texture, encoded=True)
    reading.slots |= {"metallic": Slot((metallic,)), "roughness": gloss}
    return color, texture


def _roughness_of_gloss(gloss: NDArray[Any]) -> NDArray[Any]:
    return 1.0 - gloss


def _as_metallic(diffuse: NDArray[np.float64], specular: NDArray[np.float64]) -> tuple[float, NDArray[np.float64]]:
    """Return metalness and base colour with nearly the same reflection (the Khronos group's conversion)."""
    weights = np.array([0.299, 0.587, 0.114])
    left = 1.0 - float(specular.max())
    bright, shine = (math.sqrt(float(weights @ (color * color))) for color in (diffuse, specular))
    f0 = DIELECTRIC_F0
    metallic = 0.0
    if shine >= f0:
        b, c = bright * left / (1.0 - f0) + shine - 2.0 * f0, f0 - shine
        metallic = min(max((-b + math.sqrt(max(b * b - 4.0 * f0 * c, 0.0))) / (2.0 * f0), 0.0), 1.0)
    of_diffuse = diffuse * left / (1.0 - f0) / max(1.0 - metallic, 1e-6)
    of_specular = (specular - f0 * (1.0 - metallic)) / max(metallic, 1e-6)
    return metallic, np.clip(of_diffuse + (of_specular - of_diffuse) * metallic**2, 0.0, 1.0)


def _normal(reading: _Reading) -> None:
    texture = texture_use(reading.material.normalTexture)
    if texture is not None:
        turn = texture.normal_turn * texture.strength
        curve = None if np.array_equal(turn, np.eye(2)) else lambda values: _bent(values, turn)
        reading.slots["normal"] = Slot((1.0, 1.0, 1.0), texture, curve=curve)


def _bent(values: NDArray[Any], turn: NDArray[np.float64]) -> NDArray[Any]:
    """Return encoded normals (..., 3) whose x and y are multiplied by the matrix `turn` (2, 2)."""
    normals = 2.0 * values - 1.0
    x, y = normals[..., 0].copy(), normals[..., 1].copy()
    normals[..., 0], normals[..., 1] = turn[0, 0] * x + turn[0, 1] * y, turn[1, 0] * x + turn[1, 1] * y
    lengths = np.linalg.norm(normals, axis=-1, keepdims=True)
    unit: NDArray[Any] = np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 0.0)
    return 0.5 * unit + 0.5


def _dielectric(reading: _Reading) -> float:
    """Return the index of refraction whose reflection is the one that ior and specular give."""
    given = (reading.extension("ior") or {}).get("ior", DEFAULT_IOR) or INFINITE_IOR
    ior = float(min(max(given, 1.0), INFINITE_IOR))
    if ior != given:
        reading.notes.append(f"an index of refraction of {given:g} counts as {ior:g}: it is from 1 to {INFINITE_IOR:g}")
    specular = reading.extension("specular")
    if specular is None:
        return ior
    factor, color = specular.get("specularFactor", 1.0), specular.get("specularColorFactor", (1.0, 1.0, 1.0))
    if "specularTexture" in specular or "specularColorTexture" in specular:
        reading.notes.append("the textures of KHR_materials_specular are not used, only its factors")
    if len(set(color)) > 1:
        reading.notes.append("the colour of KHR_materials_specular is not used, only its mean")
    f0 = min(((ior - 1.0) / (ior + 1.0)) ** 2 * sum(color) / 3.0, 0.98) * factor
    return (1.0 + math.sqrt(f0)) / (1.0 - math.sqrt(f0))


def _transmission(reading: _Reading) -> None:
    """Read transmitted light: refracted if there is a volume, straight on through thin walls."""
    transmission, volume = reading.extension("transmission"), reading.extension("volume") or {}
    if transmission is None or not transmission.get("transmissionFactor", 0.0):
        return
    texture = texture_use(transmission.get("transmissionTexture"))
    metallic = reading.slots["metallic"]
    opaque = metallic.factor[0] if metallic.texture is None else 0.0
    if metallic.texture is not None and metallic.factor[0]:
        reading.notes.append("metal lets light through where KHR_materials_transmission says so")
    amount = Slot((transmission["transmissionFactor"] * (1.0 - opaque),), texture, RED)
    if amount.factor[0] == 0.0:
        return
    thick = volume.get("thicknessFactor", 0.0)
    reading.slots["spec_trans" if thick else "transmission"] = amount
    if not thick:
        if reading.slots["roughness"].factor[0]:
            reading.notes.append("roughness does not blur light that passes a thin wall")
        return
    color, distance = volume.get("attenuationColor", (1.0, 1.0, 1.0)), volume.get("attenuationDistance", math.inf)
    if distance == 0.0:
        reading.notes.append("an attenuation distance of 0 is not used: the volume absorbs nothing")
    elif math.isfinite(distance) and tuple(color) != (1.0, 1.0, 1.0):
        reading.sigma_t = tuple(-math.log(max(c, BLACKEST)) / distance for c in color)


def _layers(reading: _Reading) -> None:
    """Read the layers on top: clear coat and sheen."""
    coat, sheen = reading.extension("clearcoat"), reading.extension("sheen")
    if coat is not None and coat.get("clearcoatFactor", 0.0):
        rough = Slot(
            (coat.get("clearcoatRoughnessFactor", 0.0),),
            texture_use(coat.get("clearcoatRoughnessTexture")),
            GREEN,
            curve=_gloss_of_roughness,
        )
        amount = Slot((coat["clearcoatFactor"],), texture_use(coat.get("clearcoatTexture")), RED)
        reading.slots |= {"clearcoat": amount, "clearcoat_gloss": rough}
        reading.notes.append("the clear coat is principled's: a quarter as strong, with roughness up to 0.32")
        if "clearcoatNormalTexture" in coat:
            reading.notes.append("the clear coat has the normals of the base, not its own")
    if sheen is not None and any(sheen.get("sheenColorFactor", (0, 0, 0))):
        color, texture = tuple(sheen["sheenColorFactor"]), texture_use(sheen.get("sheenColorTexture"))
        reading.slots["sheen"] = Slot(color, texture, encoded=True, curve=_strongest)
        reading.notes.append("the sheen is principled's: white, of one roughness")


def _gloss_of_roughness(roughness: NDArray[Any]) -> NDArray[Any]:
    """Return the gloss of principled's coat with the same alpha; its alpha goes from 0.1 to 0.001."""
    gloss: NDArray[Any] = np.clip((0.1 - roughness * roughness) / (0.1 - 0.001), 0.0, 1.0)
    return gloss


def _strongest(color: NDArray[Any]) -> NDArray[Any]:
    strongest: NDArray[Any] = color.max(axis=-1, keepdims=True)
    return strongest


def _anisotropy(reading: _Reading) -> None:
    """Read stretched highlights; principled's alphas lie within a factor of sqrt(10) of their geometric mean."""
    given = reading.extension("anisotropy")
    strength = (given or {}).get("anisotropyStrength", 0.0)
    if given is None or not strength:
        return
    roughness = reading.slots["roughness"]

    def alphas(values: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
        """Return the larger alpha, and the ratio of the smaller one to it."""
        narrow = (values if roughness.curve is None else roughness.curve(values)) ** 2
        wide = narrow + (1.0 - narrow) * max(strength, WEAKEST) ** 2
        return wide, np.maximum(narrow / wide, 0.1)

    def stretched(values: NDArray[Any]) -> NDArray[Any]:
        stretch: NDArray[Any] = (1.0 - alphas(values)[1]) / 0.9
        return stretch

    def mean(values: NDArray[Any]) -> NDArray[Any]:
        wide, ratio = alphas(values)
        geometric: NDArray[Any] = (wide * wide * ratio) ** 0.25
        return geometric

    reading.slots |= {"anisotropic": replace(roughness, curve=stretched), "roughness": replace(roughness, curve=mean)}
    if given.get("anisotropyRotation", 0.0) or "anisotropyTexture" in given:
        reading.notes.append(
            "the direction of KHR_materials_anisotropy is that of the texture's u, its texture is not used"
        )


def _emission(reading: _Reading) -> None:
    strength = (reading.extension("emissive_strength") or {}).get("emissiveStrength", 1.0)
    color = tuple(c * strength for c in reading.material.emissiveFactor or (0.0, 0.0, 0.0))
    if reading.extension("unlit") is not None:
        base = reading.slots["base_color"]
        reading.slots["radiance"] = base
        reading.notes.append("an unlit material emits its colour, and lights its surroundings")
    elif any(color):
        reading.slots["radiance"] = Slot(color, texture_use(reading.material.emissiveTexture), encoded=True)
    if "radiance" in reading.slots and "opacity" in reading.slots:
        light = faded(reading.slots["radiance"], reading.slots["opacity"])
        reading.slots["radiance"] = light or reading.slots["radiance"]
        if light is None:
            reading.notes.append("transparent parts emit too: opacity and emission have different textures")
    if "radiance" in reading.slots and reading.material.doubleSided:
        reading.notes.append("light is emitted from the front side only")


def _uv_set(reading: _Reading) -> int:
    """Return the set of texture coordinates of the first texture; meshes here have only one set."""
    sets = dict.fromkeys(slot.texture.uv_set for slot in reading.slots.values() if slot.texture is not None)
    if len(sets) > 1:
        others = ", ".join(f"TEXCOORD_{i}" for i in list(sets)[1:])
        reading.notes.append(f"all textures are looked up with TEXCOORD_{next(iter(sets))}, not with {others}")
    return next(iter(sets), 0)
