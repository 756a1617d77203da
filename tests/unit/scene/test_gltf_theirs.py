"""glTF files that others wrote: a few that stand beside the tests, and many more where they are at hand."""

import filecmp
from pathlib import Path

import numpy as np
import pytest

import equaltime as et

SHIPPED = Path(__file__).parents[1] / "data" / "gltf"
OTHERS = Path(__file__).parents[4] / "shared" / "scenes" / "gltf"

SHAPES_AND_TRIANGLES = {
    "assimp/ClearCoat-glTF/ClearCoatTest.gltf": (27, 37116),
    "assimp/cameras/Cameras.gltf": (1, 2),
    "assimp/textureTransform/TextureTransformTest.gltf": (12, 24),
    "blender-io/01_alpha_mask/01_alpha_mask.gltf": (1, 2),
    "blender-io/01_color_attribute/01_color_attribute.gltf": (1, 1),
    "blender-io/04_lights/04_lights.gltf": (1, 2),
    "blender-io/05_metallic_sphere_light/05_metallic_sphere_light.gltf": (2, 962),
    "blender-io/09_texture_transform/09_texture_transform.gltf": (1, 2),
    "blender-io/14_emission_strength/14_emission_strength.gltf": (18, 17280),
    "blender-io/15_transmission/15_transmission.gltf": (5, 4800),
    "blender-io/17_ior/17_ior.gltf": (5, 60),
    "gltf-transform/ShapeCollection.glb": (7, 3542),
    "trimesh/AlphaBlendModeTest.glb": (9, 61),
    "trimesh/BoxInterleaved.glb": (1, 12),
    "trimesh/BoxTextured.glb": (1, 12),
    "trimesh/CesiumMilkTruck.glb": (5, 3624),
    "trimesh/Mesh_PrimitiveMode_04.gltf": (1, 2),
    "trimesh/cubevc.glb": (1, 48),
    "trimesh/monkey.glb": (1, 968),
    "trimesh/nested.glb": (3, 36),
    "trimesh/no_indices_3storybuilding.glb": (3, 72),
}
COPIES = {
    "nested.glb": "trimesh/nested.glb",
    "cubevc.glb": "trimesh/cubevc.glb",
    "17_ior/17_ior.gltf": "blender-io/17_ior/17_ior.gltf",
    "09_texture_transform/09_texture_transform.gltf": "blender-io/09_texture_transform/09_texture_transform.gltf",
}

at_hand = pytest.mark.skipif(not OTHERS.exists(), reason="the scenes of other people are not here")


def check(path: Path, shapes: int, triangles: int) -> None:
    """Load and render a file; the picture must show something."""
    scene = et.load(path)
    assert len(scene.model.shapes) == shapes
    assert sum(len(surface.faces) for surface in scene.surfaces()) == triangles  # type: ignore[union-attr]
    image = et.render(scene.with_(size=(24, 18)), spp=4).image
    assert np.isfinite(image).all()
    assert image.std() > 0.01


@pytest.mark.parametrize("file", COPIES)
def test_files_beside_the_tests_are_loaded_and_rendered(file: str) -> None:
    check(SHIPPED / file, *SHAPES_AND_TRIANGLES[COPIES[file]])


@at_hand
@pytest.mark.parametrize("file", COPIES)
def test_the_shipped_copies_are_the_originals(file: str) -> None:
    assert filecmp.cmp(SHIPPED / file, OTHERS / COPIES[file], shallow=False)


@at_hand
@pytest.mark.parametrize("file", SHAPES_AND_TRIANGLES)
def test_every_file_at_hand_is_loaded_and_rendered(file: str) -> None:
    check(OTHERS / file, *SHAPES_AND_TRIANGLES[file])


@at_hand
def test_a_crowd_of_instances_is_loaded_and_rendered() -> None:
    scene = et.load(OTHERS / "blender-io" / "24_gpu_instancing" / "24_gpu_instancing.gltf")
    assert len(scene.model.shapes) == 1900
    assert scene.core.triangles < 10_000
    image = et.render(scene.with_(size=(24, 18)), spp=4).image
    assert image.std() > 0.01
