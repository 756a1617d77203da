"""The core against the cross-check: what the camera sees, and whole images.

Seeds are fixed. All image comparisons together have a false-alarm rate of 0.1 %, shared equally.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO
import pytest
from numpy.typing import NDArray

import equaltime as et
from equaltime import crosscheck

Shape = dict[str, Any]
SHIPPED = Path(__file__).parents[2] / "scenes"
METAL = {"eta": [0.2, 0.9, 1.1], "k": [3.9, 2.4, 2.1]}
FLOOR = {
    "type": "rectangle",
    "to_world": [{"rotate": {"axis": (1, 0, 0), "angle": -90}}, {"scale": 4}, {"translate": (0, -1, 0)}],
    "bsdf": {"type": "diffuse", "reflectance": [0.6, 0.5, 0.4]},
}
LAMP = {"type": "sphere", "center": [1, 3, 2], "radius": 0.5, "emitter": {"type": "area", "radiance": [9, 10, 11]}}
WINDOW = {
    "type": "rectangle",
    "to_world": [{"scale": (0.5, 2, 1)}, {"look_at": {"origin": (-3, 2, 3), "target": (0, 0, 0)}}],
    "emitter": {"type": "area", "radiance": [3, 2, 1]},
}
TURNED = [{"rotate": {"axis": (1, 2, 0), "angle": 50}}, {"translate": (0.1, 0, 0)}]
SKY = {"type": "constant", "radiance": [0.3, 0.4, 0.5]}


def rough(distribution: str, alpha_u: float, alpha_v: float) -> Shape:
    return {"type": "roughconductor", "distribution": distribution, "alpha_u": alpha_u, "alpha_v": alpha_v, **METAL}


def twosided(*bsdfs: Shape) -> Shape:
    return {"type": "twosided", **{f"bsdf{i}": bsdf for i, bsdf in enumerate(bsdfs)}}


def scene(*objects: Shape, depth: int = 4, film: Shape | None = None, **sensor: object) -> et.Scene:
    """Objects near the origin, seen from the front and a little above, 24x16 pixels."""
    view = {"look_at": {"origin": (0.5, 1.5, 5), "target": (0, 0, 0), "up": (0, 1, 0)}}
    film = {"type": "hdrfilm", "width": 24, "height": 16, "rfilter": {"type": "box"}, **(film or {})}
    return et.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "path", "max_depth": depth},
            "sensor": {"type": "perspective", "fov": 40, "to_world": [view], "film": film, **sensor},
            **{f"object{i}": shape for i, shape in enumerate(objects)},
        }
    )


def shipped(name: str, depth: int) -> et.Scene:
    return et.load(SHIPPED / name).with_(size=(24, 16), max_depth=depth)


def matte_room(reflectance: float = 0.5) -> et.Scene:
    """A mirrored cube from inside, a turned box, light from a slanted rectangle (so two triangles) and from a cube."""
    matte = {"type": "diffuse", "reflectance": [reflectance, reflectance / 2, 0.8]}
    walls = {"type": "cube", "to_world": [{"scale": (-5, 4, 6)}], "bsdf": twosided(matte)}
    box = {"type": "cube", "to_world": [{"scale": (0.6, 0.9, 0.5)}, *TURNED], "bsdf": matte}
    slanted = np.array([[1, 0.5, 0, 1], [0, 0, 1, 3], [0, -1, 0, 0.5], [0, 0, 0, 1]])
    lamp = {
        "type": "rectangle",
        "to_world": slanted,
        "flip_normals": True,
        "emitter": {"type": "area", "radiance": [4, 5, 6]},
    }
    glow = {"type": "cube", "to_world": [{"scale": 0.3}, {"translate": (-2, 0, 1)}], "emitter": {"type": "area"}}
    return scene(walls, box, lamp, glow)


def icosahedron(path: Path, smooth: bool) -> Shape:
    g = (1 + math.sqrt(5)) / 2
    vertices = [v for a in (-1, 1) for b in (-g, g) for v in ((0, a, b), (a, b, 0), (b, 0, a))]
    corners = np.array(vertices, dtype=np.float64)
    faces = [
        (i, j, k) if np.linalg.det(corners[[i, j, k]]) > 0 else (i, k, j)
        for i in range(12)
        for j in range(i)
        for k in range(j)
        if all(np.linalg.norm(corners[a] - corners[b]) < 2.1 for a, b in ((i, j), (j, k), (k, i)))
    ]
    lines = [f"v {x} {y} {z}" for x, y, z in vertices] + [f"f {i + 1} {j + 1} {k + 1}" for i, j, k in faces]
    path.write_text("\n".join(lines))
    return {"type": "obj", "filename": str(path), "face_normals": not smooth, "to_world": [{"scale": 0.5}, *TURNED]}


def environment(path: Path) -> Shape:
    """A small image with a bright spot off the axes, so that half a texel would be seen."""
    pixels = np.full((9, 16, 3), (0.2, 0.3, 0.4), np.float32)
    pixels[2, 3] = (40.0, 30.0, 20.0)
    pixels[6, 11] = (0.0, 5.0, 9.0)
    buffer = OpenImageIO.ImageBuf(pixels)
    assert buffer.write(str(path), "float")
    return {
        "type": "envmap",
        "filename": str(path),
        "scale": 0.5,
        "to_world": [{"rotate": {"axis": (0, 1, 0), "angle": 70}}],
    }


SCENES: dict[str, Callable[[Path], et.Scene]] = {
    "a room of matte boxes": lambda _: matte_room(),
    "the Cornell box": lambda _: shipped("cornell-box.toml", 5),
    "Veach's plates": lambda _: shipped("veach-mis.toml", 3),
    "walls of radius 1e5, one lamp": lambda _: shipped("montelight/simple.toml", 4),
    "walls of radius 1e5, two lamps": lambda _: shipped("montelight/complex.toml", 4),
    "rough metals": lambda _: scene(
        *(FLOOR, LAMP, SKY),
        {"type": "sphere", "center": [-1, 0, 0], "radius": 0.9, "bsdf": rough("ggx", 0.3, 0.3)},
        {
            "type": "cube",
            "to_world": [{"scale": 0.5}, *TURNED, {"translate": (1, 0, 0)}],
            "bsdf": rough("beckmann", 0.2, 0.2),
        },
    ),
    "brushed sphere": lambda _: scene(
        FLOOR, LAMP, {"type": "sphere", "to_world": TURNED, "bsdf": rough("ggx", 0.1, 0.4)}
    ),
    "brushed cube": lambda _: scene(
        # The sky lights every block enough for its z to be normal: the lamp's highlight is out of sight.
        *(FLOOR, LAMP, WINDOW, SKY),
        {"type": "cube", "to_world": [{"scale": 0.7}, *TURNED], "bsdf": rough("beckmann", 0.1, 0.5)},
    ),
    "brushed disk and rectangle": lambda _: scene(
        *(FLOOR, LAMP, SKY),
        {"type": "disk", "to_world": [{"translate": (-1, 0, 0)}], "bsdf": twosided(rough("ggx", 0.1, 0.4))},
        {"type": "rectangle", "to_world": [{"scale": 0.8}, {"translate": (1, 0, 0)}], "bsdf": rough("ggx", 0.1, 0.4)},
    ),
    "glass": lambda _: scene(
        FLOOR, LAMP, SKY, {"type": "sphere", "radius": 0.9, "bsdf": {"type": "dielectric", "int_ior": 1.5}}, depth=8
    ),
    "mirrors and a point light": lambda _: scene(
        *(FLOOR, {"type": "point", "position": [1, 2, 3], "intensity": [5, 6, 7]}),
        {"type": "cube", "to_world": [{"scale": 0.6}, *TURNED], "bsdf": {"type": "conductor", **METAL}},
    ),
    "a disk of light, two-sided walls": lambda _: scene(
        FLOOR,
        {
            "type": "disk",
            "to_world": [
                {"scale": (1, 0.5, 1)},
                {"rotate": {"axis": (1, 0, 0), "angle": 60}},
                {"translate": (-1, 2, 0)},
            ],
            "emitter": {"type": "area", "radiance": [8, 7, 6]},
        },
        {
            "type": "rectangle",
            "to_world": [{"rotate": {"axis": (0, 1, 0), "angle": 120}}],
            "bsdf": twosided(
                {"type": "diffuse", "reflectance": [0.9, 0.1, 0.1]}, {"type": "diffuse", "reflectance": [0.1, 0.9, 0.1]}
            ),
        },
    ),
    "a light with its inside out": lambda _: scene(
        {"type": "sphere", "radius": 7, "flip_normals": True, "emitter": {"type": "area", "radiance": [1, 2, 3]}},
        *(FLOOR, {"type": "cube", "to_world": TURNED}),
    ),
    "a flat mesh": lambda path: scene(FLOOR, LAMP, icosahedron(path / "mesh.obj", smooth=False)),
    "a smooth mesh": lambda path: scene(FLOOR, LAMP, SKY, icosahedron(path / "mesh.obj", smooth=True)),
    "a brushed mesh": lambda path: scene(
        *(FLOOR, LAMP, WINDOW, SKY), icosahedron(path / "mesh.obj", smooth=True) | {"bsdf": rough("ggx", 0.1, 0.5)}
    ),
    "an environment image": lambda path: scene(
        FLOOR, environment(path / "sky.exr"), {"type": "sphere", "bsdf": rough("ggx", 0.2, 0.2)}
    ),
    "a tent filter and a crop": lambda _: scene(
        FLOOR, LAMP, {"type": "cube", "to_world": TURNED}, film=CROP | {"rfilter": {"type": "tent", "radius": 1.2}}
    ),
    "a Gaussian filter": lambda _: scene(
        FLOOR, LAMP, {"type": "cube", "to_world": TURNED}, film={"rfilter": {"type": "gaussian", "stddev": 0.8}}
    ),
    "clip planes, off the axis": lambda _: scene(
        *(FLOOR, LAMP, {"type": "cube", "to_world": TURNED}),
        **CLIPS,
    ),
}
CROP: Shape = {"width": 48, "height": 32, "crop_offset_x": 14, "crop_offset_y": 8, "crop_width": 24, "crop_height": 16}
CLIPS: Shape = {
    "near_clip": 4.5,
    "far_clip": 7.0,
    "principal_point_offset_x": 0.1,
    "principal_point_offset_y": -0.05,
}
LEVEL = 0.001 / (len(SCENES) + 4)


# A place on a lamp's far side, which sends nothing, has a density so large in the cross-check that it may overflow.
@pytest.mark.filterwarnings("ignore:overflow encountered in divide")
@pytest.mark.parametrize("name", SCENES)
def test_core_and_cross_check_have_the_same_image(name: str, tmp_path: Path, agreement: Callable[..., float]) -> None:
    assert agreement(SCENES[name](tmp_path), spp=512) > LEVEL


@pytest.mark.parametrize("strategy", ["best,technique=bsdf", "best,technique=light", "best,sampler=independent"])
def test_they_have_it_whatever_the_strategy(strategy: str, agreement: Callable[..., float]) -> None:
    assert agreement(matte_room(), spp=512, strategy=strategy) > LEVEL


def test_two_percent_more_reflectance_in_one_channel_is_found(agreement: Callable[..., float]) -> None:
    """The power twin: that the tests above pass means something."""
    assert agreement(matte_room(), spp=512, core=matte_room(0.51)) < LEVEL


@pytest.mark.parametrize("name", SCENES)
def test_both_see_the_same_first_surfaces_off_the_edges(name: str, tmp_path: Path) -> None:
    loaded = SCENES[name](tmp_path).with_(size=(96, 64))
    seen = crosscheck.primary_hits(loaded)
    camera = crosscheck.Camera(loaded.model.sensor)
    directions, near, far = camera.rays(camera.pixels() + 0.5)
    hits = loaded.core.intersect(np.tile(camera.origin, (len(directions), 1)) + near[:, None] * directions, directions)
    clipped = hits["t"] > far - near
    shape = np.where(clipped, -1, hits["shape"]).reshape(seen.shape.shape)
    primitive = np.where(clipped, -1, hits["primitive"]).reshape(seen.shape.shape)
    same = (shape == seen.shape) & (primitive == seen.primitive)
    assert same[_off_edges(seen.shape * 1000 + seen.primitive)].all()
    both = same & (shape >= 0)
    assert both.mean() > 0.2
    t = hits["t"].reshape(both.shape) + near.reshape(both.shape)
    np.testing.assert_allclose(t[both], seen.t[both], rtol=2e-6)
    size = np.abs(seen.point[both]).max()
    np.testing.assert_allclose(hits["p"].reshape(seen.point.shape)[both], seen.point[both], atol=2e-6 * size)


def _off_edges(what: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Where a pixel and its four neighbours see the same thing."""
    padded = np.pad(what, 1, mode="edge")
    neighbours = (padded[:-2, 1:-1], padded[2:, 1:-1], padded[1:-1, :-2], padded[1:-1, 2:])
    same: NDArray[np.bool_] = np.logical_and.reduce([neighbour == what for neighbour in neighbours])
    return same


def test_the_embreex_backend_gives_the_cross_checks_image() -> None:
    loaded = scene(FLOOR, LAMP)
    mean, _ = crosscheck.render(loaded, 8, seed=5)
    result = et.render(loaded, spp=8, seed=5, backend="embreex")
    np.testing.assert_array_equal(result.image, mean.astype(np.float32))
    assert (result.samples == 8).all()
