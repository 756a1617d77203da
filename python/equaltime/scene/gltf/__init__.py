"""glTF 2.0 (``.gltf``, ``.glb``) in Mitsuba's words: what each part of a file becomes, and where that is not exact.

Meshes and bitmaps stay in the file. The model names them, and `Assets` asks here for their data when it is needed:
``model.glb#/meshes/0/primitives/1`` (shape `gltf`) and ``model.glb#/materials/2/roughness`` (`bitmap`).

=========================  ===========================================================================================
in the file                here
=========================  ===========================================================================================
primitives                 `gltf` shapes; triangles, strips, fans; flat where there are no normals; points and lines
                           are told and left out
skins, morph targets       poses of a `gltf` shape: ``/nodes/N/...`` as the file's nodes stand, with weights of the node
                           or its mesh; ``/animations/A/T/nodes/N/...`` as they are at a time; what glows keeps the
                           first; *in each of 16 parts of the shutter's time, vertices go straight*
COLOR_0                    `mesh_attribute`, times the base colour, also of what is unlit, *unless it has a texture*;
                           its opacity, times that of the material, where that blends or cuts; *the light of a
                           texture does not fade with it*
nodes                      ``to_world``; a scale of 0 along one axis counts as 1e-8 times the largest; what is scaled to
                           a line or a point is left out; ``-D shutter=`` plays animations
cameras                    `perspective`, `orthographic`; the first, or ``-D camera=`` name or number; an added one has
                           everything in view
metallic-roughness         `principled`; its metals reflect as much as the specification's to 1 % up to roughness 0.5,
                           *up to 21 % less at roughness 1*; others 3 to 10 % more, *28 % where rough and grazing*
alphaMode                  `mask`: BLEND by chance in proportion, MASK cut at alphaCutoff on a finer grid
doubleSided                `twosided`; without it the back side absorbs *instead of not being there*
normalTexture              `normalmap`; tangents follow u of the texture coordinates, *TANGENT is not used*; green is
                           turned round where a texture is seen in a mirror
occlusionTexture           not used: light is traced
emission                   `area`, from the front side only; nits are W/(m² sr) per channel; fades with the opacity,
                           *unless the two have different textures*
extensions                 see `mapping`; those of materials become parameters of `principled`, mostly
=========================  ===========================================================================================

README.md beside this has the fate of every property. A file without lights gets a sky and a sun (``-D sky=`` and
``-D sun=`` set them). Whatever a file asks for and does not get is among the scene's warnings, and ``equaltime info``
shows what becomes of its extensions. Compressed data (Draco, meshopt, Basis) and other extensions that a file requires
are refused.
"""

from __future__ import annotations

from equaltime.scene.gltf.contents import Contents, split
from equaltime.scene.gltf.mapping import MAPPING
from equaltime.scene.gltf.primitives import Triangles
from equaltime.scene.gltf.reader import read_gltf

__all__ = ["MAPPING", "Contents", "Triangles", "read_gltf", "split"]
