"""Table of the supported glTF extensions: the Mitsuba plugins or parameters that an extension becomes, in words.

The entries also name the approximations. The command ``equaltime info`` shows the entries for a file.
"""

from __future__ import annotations

from typing import Final

__all__ = ["MAPPING"]

MAPPING: Final = {
    "EXT_mesh_gpu_instancing": "instances",
    "EXT_texture_webp": "read as it is, where there is no other image",
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
    "approximation: what passes a thin wall is not blurred by its roughness",
    "KHR_materials_unlit": "area of the base colour; approximation: it shines on its surroundings",
    "KHR_materials_volume": "homogeneous, inside what has a thickness, whatever that is",
    "KHR_mesh_quantization": "read as it is",
    "KHR_node_visibility": "what is not visible is left out",
    "KHR_texture_transform": "to_uv; approximation: all textures of a material use one set of texture coordinates",
}
"""Counterpart of each supported extension, by the extension's name."""
