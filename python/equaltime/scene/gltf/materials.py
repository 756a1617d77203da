"""Converts glTF materials to BSDFs, media and emitters of the scene tree."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from equaltime.scene.gltf.document import Document
from equaltime.scene.gltf.ids import Ids
from equaltime.scene.gltf.slots import Slot
from equaltime.scene.gltf.surfaces import SurfaceLook, look
from equaltime.scene.gltf.textures import MIRRORED, bitmap_parameters
from equaltime.scene.tree import Object, Place, add, plant

__all__ = ["GltfMaterials", "Variant"]

PRINCIPLED: Final = (
    *("base_color", "metallic", "roughness", "anisotropic", "spec_trans", "sheen", "clearcoat", "clearcoat_gloss"),
)
OF_VERTICES: Final = {"base_color": "vertex_color", "alpha": "vertex_alpha"}
"""Vertex attributes that hold a material's parameter, by the parameter's name."""
BLACK: Final = (0.0, 0.0, 0.0)
COLORED: Final = "_colored"
FADED: Final = "_faded"


@dataclass(frozen=True, slots=True)
class Variant:
    """Properties of a mesh that the BSDF of its material depends on: vertex colours, opacities, mirrored textures.

    One glTF material has a BSDF of its own for each variant in use.
    """

    colored: bool
    """True if the mesh has vertex colours that are not all white."""
    faded: bool
    """True if the mesh has vertex opacities that are not all 1, and the material uses opacity."""
    mirrored: bool
    """True if textures appear mirrored on the mesh; the green channel of normal maps is then inverted."""


class GltfMaterials:
    """Converter of a document's materials to BSDFs, media and emitters. Each BSDF and medium is created once.

    The methods have the parameter `material`, a material's index in the file, or None for the default material.

    Parameters
    ----------
    document
        The glTF file.
    place
        Position of the glTF file in the scene's description, for messages.
    ids
        Maker of the ids of all objects in the scene.
    """

    def __init__(self, document: Document, place: Place, ids: Ids) -> None:
        self._document = document
        self._place = place
        self._ids = ids
        self._names = [ids.take(material.name or f"material_{i}") for i, material in enumerate(document.gltf.materials)]
        self._bsdfs: dict[tuple[int | None, Variant], Object] = {}
        self._looks: dict[int | None, SurfaceLook] = {}
        self._media: dict[int, Object] = {}

    @property
    def bsdfs(self) -> list[Object]:
        """BSDFs created so far, as objects of the scene tree."""
        return list(self._bsdfs.values())

    @property
    def media(self) -> list[Object]:
        """Interior media created so far, as objects of the scene tree."""
        return list(self._media.values())

    def medium(self, material: int | None) -> str | None:
        """Return the id of the medium inside shapes with this material, or None if the interior does not absorb.

        The medium is created at the first call.
        """
        sigma_t = self.look(material).sigma_t
        if material is None or not any(sigma_t):
            return None
        if material not in self._media:
            parameters: dict[str, object] = {"sigma_t": sigma_t, "albedo": 0.0}
            name = self._ids.take(f"{self._names[material]}_volume")
            self._media[material] = plant("medium", "homogeneous", self._at(material), name, **parameters)
        return str(self._media[material].id)

    def look(self, material: int | None) -> SurfaceLook:
        """Return the parameters of the BSDF, emitter and medium of `material`, converted at the first call."""
        if material not in self._looks:
            self._looks[material] = look(None if material is None else self._document.gltf.materials[material])
        return self._looks[material]

    def bsdf(self, material: int | None, variant: Variant) -> str:
        """Return the id of the BSDF of `material` on meshes with the properties `variant`.

        The properties are vertex colours, vertex opacities and mirrored textures. The BSDF is created at the first
        call.
        """
        key = (material, variant)
        if key not in self._bsdfs:
            self._bsdfs[key] = self._bsdf(material, variant)
        return str(self._bsdfs[key].id)

    def shines(self, material: int | None) -> bool:
        """Tell whether surfaces with the material `material` emit light."""
        return "radiance" in self.look(material).slots

    def emitter(self, material: int | None, variant: Variant) -> Object | None:
        """Return the area light of `material` on meshes with the properties `variant`; None if it emits no light.

        The properties are vertex colours, vertex opacities and mirrored textures. If an unlit material has no texture,
        vertices with colours emit these colours.
        """
        seen = self.look(material)
        slot = seen.slots.get("radiance")
        if material is None or slot is None:
            return None
        place, radiance = self._at(material), self._color(material, "radiance", slot)
        told = []
        if slot.texture is None and ((seen.unlit and variant.colored) or variant.faded):
            radiance = plant("texture", "mesh_attribute", place, name="vertex_radiance")
            if variant.faded and seen.slots["opacity"].cutoff is not None:
                told.append("emission is interpolated: it fades towards vertices with an opacity below the cutoff")
        elif seen.unlit and variant.colored:
            told.append("the colours of vertices are not used where an unlit material has a texture")
        elif variant.faded:
            told.append("emission from a texture does not fade with the opacity of vertices")
        for message in told:
            self._document.note(message, place.path)
        return plant("emitter", "area", place, radiance=radiance)

    def _at(self, material: int | None) -> Place:
        return self._place if material is None else self._place.key("materials").key(material)

    def _bsdf(self, material: int | None, variant: Variant) -> Object:
        seen, place = self.look(material), self._at(material)
        for note in seen.notes:
            self._document.note(note, place.path)
        suffix = COLORED if variant.colored else ""
        suffix += (FADED if variant.faded else "") + (MIRRORED if variant.mirrored else "")
        if material is None:
            name = self._ids.take(f"material{suffix}")
        else:
            name = self._ids.take(self._names[material] + suffix) if suffix else self._names[material]
        layers = self._layers(seen, material, variant, place)
        return Object(place, layers.type, layers.kind, id=name, children=layers.children)

    def _layers(self, seen: SurfaceLook, material: int | None, variant: Variant, place: Place) -> Object:
        """Return the BSDF with the BSDFs that are wrapped around it."""
        slots = seen.slots
        if seen.unlit:
            bsdf = plant("bsdf", "diffuse", place, reflectance=BLACK)
        else:
            bsdf = self._principled(seen, material, variant.colored, place)
        if "normal" in slots:
            name = "normal" + (MIRRORED if variant.mirrored else "")
            bsdf = plant(
                "bsdf", "normalmap", place, normalmap=self._texture(material, name, slots["normal"]), bsdf=bsdf
            )
        if seen.two_sided and "spec_trans" not in slots and not seen.unlit:
            bsdf = plant("bsdf", "twosided", place, bsdf=bsdf)
        if "transmission" in slots:
            bsdf = self._thin(seen, material, variant.colored, bsdf, place)
        if "opacity" in slots and variant.faded:
            opacity = self._of_vertices(material, "alpha", slots["alpha"], place)
            return plant("bsdf", "mask", place, opacity=opacity, cutoff=slots["opacity"].cutoff, bsdf=bsdf)
        if "opacity" in slots:
            bsdf = plant("bsdf", "mask", place, opacity=self._number(material, "opacity", slots["opacity"]), bsdf=bsdf)
        return bsdf

    def _principled(self, seen: SurfaceLook, material: int | None, colored: bool, place: Place) -> Object:
        result = plant("bsdf", "principled", place, eta=seen.eta)
        for name in PRINCIPLED:
            if (slot := seen.slots.get(name)) is None:
                continue
            if name == "base_color":
                add(result, name, self._base_color(material, slot, colored, place))
            else:
                add(result, name, self._number(material, name, slot))
        return result

    def _base_color(self, material: int | None, slot: Slot, colored: bool, place: Place) -> object:
        """Return the base colour; a constant base colour is part of the vertex colours (`meshes.read`)."""
        if not colored:
            return self._color(material, "base_color", slot)
        return self._of_vertices(material, "base_color", slot, place)

    def _of_vertices(self, material: int | None, name: str, slot: Slot, place: Place) -> Object:
        """Return the vertex attribute of a parameter, times the parameter's texture if it has one."""
        result = plant("texture", "mesh_attribute", place, name=OF_VERTICES[name])
        if slot.texture is not None:
            add(result, "times", self._texture(material, name, slot))
        return result

    def _thin(self, seen: SurfaceLook, material: int | None, colored: bool, bsdf: Object, place: Place) -> Object:
        """Return a BSDF that lets a part of the light pass straight on, dyed by the base colour."""
        color = self._base_color(material, seen.slots["base_color"], colored, place)
        glass = plant("bsdf", "thindielectric", place, int_ior=seen.eta, ext_ior=1.0, specular_transmittance=color)
        weight = self._number(material, "transmission", seen.slots["transmission"])
        result = plant("bsdf", "blendbsdf", place, weight=weight)
        add(result, None, bsdf)
        add(result, None, glass)
        return result

    def _number(self, material: int | None, name: str, slot: Slot) -> object:
        return slot.constant[0] if slot.texture is None else self._texture(material, name, slot)

    def _color(self, material: int | None, name: str, slot: Slot) -> object:
        return slot.constant if slot.texture is None else self._texture(material, name, slot)

    def _texture(self, material: int | None, name: str, slot: Slot) -> Object:
        filename = f"{self._document.name}#/materials/{material}/{name}"
        parameters = bitmap_parameters(self._document, slot)
        return plant("texture", "bitmap", self._at(material), filename=filename, **parameters)
