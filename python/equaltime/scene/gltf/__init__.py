"""glTF 2.0 (``.gltf``, ``.glb``) in Mitsuba's words: what each part of a file becomes, and where that is not exact.

Meshes and bitmaps stay in the file. The model names them, and `Assets` asks here for their data when it is needed:
``model.glb#/meshes/0/primitives/1`` (shape `gltf`) and ``model.glb#/materials/2/roughness`` (`bitmap`).

=========================  ===========================================================================================
in the file                here
=========================  ===========================================================================================
primitives                 `gltf` shapes; triangles, strips, fans; flat where there are no normals; points and lines
                           are told and left out. Morph targets are applied with the mesh's own weights; skins are not.
COLOR_0                    `mesh_attribute`, times the base colour; *not used where that has a texture*
nodes                      ``to_world``; what is scaled to nothing is left out; animations stand still
cameras                    `perspective`, `orthographic`; the first, or ``-D camera=`` name or number; an added one has
                           everything in view
metallic-roughness         `principled`: its diffuse part is Burley's, not Lambert's
alphaMode                  `mask`: BLEND by chance in proportion, MASK cut at alphaCutoff on a finer grid
doubleSided                `twosided`; without it the back side absorbs *instead of not being there*
normalTexture              `normalmap`; tangents follow u of the texture coordinates, *TANGENT is not used*
occlusionTexture           not used: light is traced
emission                   `area`, from the front side only; nits are W/(m² sr) per channel
KHR_lights_punctual        `point`, `directional`, `spot` in candela and lux; *a spot falls linearly with the angle*;
                           range is not used
KHR_materials_anisotropy   ``anisotropic``; *along u only, alphas at most a factor of 10 apart*
.. clearcoat               ``clearcoat``; *a quarter as strong, alpha from 0.001 to 0.1, no normals of its own*
.. emissive_strength       a factor on the radiance
.. ior, .. specular        ``eta`` with the same reflection at normal incidence; *no colour, no textures*
.. pbrSpecularGlossiness   metalness and base colour that reflect nearly the same; *the textures' specular is lost*
.. sheen                   ``sheen``; *white, of one roughness*
.. transmission            `blendbsdf` with `thindielectric`; *not blurred by roughness*
.. transmission + volume   ``spec_trans``, refracting; *attenuation over the thickness, at the surface*
.. unlit                   a light of the base colour; *it shines on its surroundings*
KHR_texture_transform      ``to_uv``; *one set of texture coordinates for all textures of a material*
KHR_mesh_quantization      read as it is
EXT_mesh_gpu_instancing    one shape for each instance
=========================  ===========================================================================================

A file without lights gets a sky of radiance 1 (``-D sky=`` sets it). Whatever a file asks for and does not get is among
the scene's warnings. Compressed data (Draco, meshopt, Basis) and other extensions that a file requires are refused.
"""

from __future__ import annotations

from equaltime.scene.gltf.contents import Contents, split
from equaltime.scene.gltf.primitives import Triangles
from equaltime.scene.gltf.reader import read_gltf
from equaltime.scene.gltf.slots import Texels

__all__ = ["Contents", "Texels", "Triangles", "read_gltf", "split"]
