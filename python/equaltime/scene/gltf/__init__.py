"""Converts glTF 2.0 files (``.gltf``, ``.glb``) to Mitsuba's plugins. A table lists the plugin for each element.

Meshes and bitmaps stay in the file. The model names them, and `Assets` reads their data through this package:
``model.glb#/meshes/0/primitives/1`` (shape `gltf`) and ``model.glb#/materials/2/roughness`` (`bitmap`). In the table,
italics mark differences from glTF.

=========================  ===========================================================================================
in the file                here
=========================  ===========================================================================================
primitives                 `gltf` shapes: triangles, strips and fans, with flat faces if normals are missing; points and
                           lines are left out, with a warning
skins, morph targets       poses of a `gltf` shape. ``/nodes/N/...`` is the pose in the file, with the weights of the
                           node or its mesh; ``/animations/A/T/nodes/N/...`` is the pose at time T of animation A.
                           Emitting meshes keep their first pose. *Vertices move linearly in each of 16 parts of the
                           shutter's time*
COLOR_0                    `mesh_attribute`, times the base colour; for unlit materials too, *unless they have a
                           texture*. With BLEND or MASK, the opacity of COLOR_0 is multiplied by the material's;
                           *emission from a texture does not fade with the opacity of COLOR_0*
nodes                      ``to_world``. A scale of 0 along one axis counts as 1e-8 times the largest; meshes scaled to
                           a line or a point are left out. ``-D shutter=`` plays animations
cameras                    `perspective`, `orthographic`: the first camera, or the one named by ``-D camera=`` (name or
                           number). Without a camera in the file, or with ``-D view=``, a camera that sees the whole
                           scene is added
metallic-roughness         `principled`. Metals reflect as much as in glTF, within 1 % up to roughness 0.5, *up to 21 %
                           less at roughness 1*. Other materials reflect 3 to 10 % more, *28 % more if rough and at
                           grazing angles*
alphaMode                  `mask`: BLEND is opaque with probability alpha; MASK compares alpha with alphaCutoff, on a
                           finer grid of texels
doubleSided                `twosided`; without it the back side absorbs light *instead of being invisible*
normalTexture              `normalmap`. Tangents follow u of the texture coordinates, *TANGENT is not used*; green is
                           inverted where a texture is seen mirrored, and slopes turn with KHR_texture_transform
occlusionTexture           not used: the render computes occlusion itself
emission                   `area`, from the front side only. Nits are W/(m² sr) per channel. Emission fades with the
                           opacity, *unless the two have different textures*
extensions                 see `MAPPING`; extensions of materials mostly become parameters of `principled`
=========================  ===========================================================================================

README.md in this folder lists every property. A file without lights gets a sky and a sun (``-D sky=`` and ``-D sun=``
set them). The scene's warnings list the properties of the file that are not used. ``equaltime info`` shows the
counterparts of the file's extensions. Compressed meshes (Draco, meshopt) and other unsupported extensions that a file
requires are refused. Images that are missing or cannot be decoded, such as images of Basis, are errors where a material
uses them. ``--substitute`` replaces them by the material's factors, and leaves normal maps out.
"""

from __future__ import annotations

from equaltime.scene.gltf.contents import Contents, split
from equaltime.scene.gltf.primitives import Triangles
from equaltime.scene.gltf.reader import read_gltf
from equaltime.scene.gltf.schema import MAPPING

__all__ = ["MAPPING", "Contents", "Triangles", "read_gltf", "split"]
