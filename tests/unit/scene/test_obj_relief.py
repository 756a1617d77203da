"""Normal maps and heights of MTL files: they look as in a scene file and lean as the picture says, or are told."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import numpy as np
import pytest

import equaltime as et
from equaltime.images import image_files as images
from equaltime.scene import model as m
from equaltime.scene.obj_materials import content_of

from .test_obj_materials import SQUARE, load, picture, shapes, square, told

SUN: Final = np.array([-0.5, 1.0, 0.8])
"""Where the sun of a mesh by itself stands: to the left, above, before the square."""
LEANS: Final = [(-0.4, 0.0), (0.4, 0.0), (0.0, 0.4), (0.0, -0.4), (-0.3, 0.2)]
GREY: Final = {"type": "diffuse", "reflectance": 0.5}


def written(path: Path, numbers: Any) -> Path:
    """Write a PNG file of numbers (H, W, 1 or 3) in [0, 1]."""
    pixels = np.round(255.0 * np.asarray(numbers)).astype(np.uint8)
    names = ("R", "G", "B") if pixels.shape[2] == 3 else ("Y",)
    images.write(path, "png", [images.Layer(names, np.ascontiguousarray(pixels), {})])
    return path


def normals(path: Path, lean: tuple[float, float] = (0.2, 0.1), side: int = 8) -> Path:
    """Write a normal map that leans everywhere alike, to the right and upwards, but for a flat texel."""
    n = np.array([*lean, 1.0]) / math.hypot(*lean, 1.0)
    texels = np.tile(0.5 * n + 0.5, (side, side, 1))
    texels[0, 0] = (0.5, 0.5, 1.0)
    return written(path, texels)


def slope(path: Path, lean: tuple[float, float], side: int = 18) -> float:
    """Write heights that lean alike on the square, which is 2 wide; return the height of white."""
    middles = 2.0 * (np.arange(side) + 0.5) / side - 1.0
    x, y = np.meshgrid(middles, -middles)  # the first row is the highest
    height = -(lean[0] * x + lean[1] * y)
    most = float(height.max() - height.min())
    written(path, ((height - height.min()) / most)[..., None])
    return most


def changed(scene: et.Scene, change: Callable[[dict[str, Any]], object]) -> et.Scene:
    """Return the scene after a change of its dictionary."""
    given = json.loads(json.dumps(scene.to_dict()))
    change(given)
    return et.load_dict(given).with_(size=(16, 12))


def with_bsdf(scene: et.Scene, bsdf: dict[str, Any]) -> et.Scene:
    """Return the scene with another BSDF on its mesh, whose images stand beside it."""

    def change(given: dict[str, Any]) -> None:
        (mesh,) = (part for part in given.values() if isinstance(part, dict) and part.get("type") == "obj")
        mesh["bsdf"] = bsdf

    return changed(scene, change)


def stretched(u: float, v: float, right: float, down: float) -> list[list[float]]:
    """Return where a picture lies, from the upper left."""
    return [[u, 0, 0, right], [0, v, 0, down], [0, 0, 1, 0], [0, 0, 0, 1]]


def bitmap(path: Path, **parameters: Any) -> dict[str, Any]:
    return {"type": "bitmap", "filename": str(path), "raw": True, **parameters}


@pytest.mark.parametrize(
    ("statement", "parameters"),
    [
        (b"norm n.png", {}),
        (b"norm -clamp on n.png", {"wrap_mode": "clamp"}),
        (
            b"norm -s 2 3 1 -o 0.25 0.5 0 n.png",
            {"to_uv": stretched(2, 3, 0.25, -2.5)},
        ),
        (b"map_Bump -bm 1 n.png", {}),
        (b"bump n.png", {}),
        (b"bump -bm 0.5 n.png\nnorm n.png", {}),
    ],
)
def test_a_normal_map_is_that_of_a_scene(statement: bytes, parameters: dict[str, Any], tmp_path: Path) -> None:
    path = normals(tmp_path / "n.png")
    scene = square(tmp_path, statement + b"\n")
    explicit = {"type": "normalmap", "normalmap": bitmap(path, **parameters), "bsdf": GREY}
    by_hand = with_bsdf(scene, {"type": "twosided", "bsdf": explicit})
    seen = et.render(scene.with_(size=(16, 12)), spp=4).image
    assert np.array_equal(et.render(by_hand, spp=4).image, seen)
    assert not np.array_equal(et.render(with_bsdf(scene, {"type": "twosided", "bsdf": GREY}), spp=4).image, seen)


@pytest.mark.parametrize(
    ("statement", "scale", "parameters"),
    [
        (b"bump h.png", 1.0, {}),
        (b"map_bump -bm 0.25 h.png", 0.25, {}),
        (b"bump -bm -2 -clamp on h.png", -2.0, {"wrap_mode": "clamp"}),
        (b"map_Bump -s -1 1 1 h.png", 1.0, {"to_uv": stretched(-1, 1, 0, 0)}),
    ],
)
@pytest.mark.parametrize("channels", [1, 3])
def test_heights_are_those_of_a_scene(
    statement: bytes, scale: float, parameters: dict[str, Any], channels: int, tmp_path: Path
) -> None:
    heights = np.random.default_rng(2).random((8, 8, 1))
    path = written(tmp_path / "h.png", np.repeat(heights, channels, axis=2))
    scene = square(tmp_path, statement + b"\n")
    explicit = {"type": "bumpmap", "texture": bitmap(path, **parameters), "scale": scale, "bsdf": GREY}
    by_hand = with_bsdf(scene, {"type": "twosided", "bsdf": explicit})
    assert np.array_equal(et.render(by_hand, spp=4).image, et.render(scene.with_(size=(16, 12)), spp=4).image)
    assert told(scene) == []


def lit(scene: et.Scene) -> float:
    """Return what the middle of the square sends out where the sun alone shines."""

    def change(given: dict[str, Any]) -> None:
        around = {"constant", "sphere", "disk"}
        for name in [name for name, part in given.items() if isinstance(part, dict) and part["type"] in around]:
            del given[name]
        given["sun"] = {"type": "directional", "irradiance": 1.5, "direction": (-SUN).tolist()}

    return float(et.render(changed(scene, change), spp=4).image[6, 8, 0])


def expected(lean: tuple[float, float]) -> float:
    """Return the same for a normal that leans so far, with the shadowing of `tests/analytic/test_bent_normals.py`."""
    n, to_sun = np.array([*lean, 1.0]) / math.hypot(*lean, 1.0), SUN / np.linalg.norm(SUN)
    roughness = min(1.0, 0.125 * (1 / n[2] ** 2 - 1))
    shadow = 2 / (1 + math.sqrt(1 + roughness * (1 / to_sun[2] ** 2 - 1)))
    return float(0.5 / math.pi * 1.5 * shadow * (n @ to_sun))


@pytest.mark.parametrize("lean", LEANS)
def test_red_leans_along_u_and_green_upwards(lean: tuple[float, float], tmp_path: Path) -> None:
    """What leans to the sun, to the left and upwards, is brighter, by as much as the formula says."""
    normals(tmp_path / "n.png", lean)
    assert lit(square(tmp_path, b"norm n.png\n")) == pytest.approx(expected(lean), rel=0.02)
    assert (expected(lean) > expected((0.0, 0.0))) == (lean[0] < 0 or lean[1] > 0)


@pytest.mark.parametrize("lean", LEANS)
def test_heights_lean_away_from_where_they_rise(lean: tuple[float, float], tmp_path: Path) -> None:
    white = slope(tmp_path / "h.png", lean)
    assert lit(square(tmp_path, b"bump -bm %r h.png\n" % white)) == pytest.approx(expected(lean), rel=0.02)


def test_reliefs_are_within_both_sides_and_masks_outside(tmp_path: Path) -> None:
    normals(tmp_path / "n.png")
    (shape,) = shapes(square(tmp_path, b"Kd 1 1 1\nPr 0.5\nd 0.25\nnorm n.png\n"))
    inner = m.Principled(base_color=(1, 1, 1), roughness=0.5)
    bent = m.NormalMap(normalmap=m.Bitmap(filename="n.png", raw=True), bsdf=inner)
    assert shape.bsdf == m.Mask(opacity=0.25, bsdf=m.TwoSided(bsdf=(bent,)))


@pytest.mark.parametrize(
    ("statement", "message", "relief"),
    [
        (b"bump n.png", "the image of 'bump' is coloured and is used as a normal map", m.NormalMap),
        (b"bump -bm 0.5 n.png", "a normal map is not used with another '-bm' than 1", None),
        (b"bump photo.png", "the image of 'bump' is coloured: its luminance is the height", m.BumpMap),
        (b"bump -bm 2 photo.png", "the image of 'bump' is coloured: its luminance is the height", m.BumpMap),
        (b"norm -s 1 -1 1 n.png", "a normal map is not used with a negative '-s'", None),
        (b"bump -s -1 1 1 n.png", "a normal map is not used with a negative '-s'", None),
        (b"norm -bm 2 n.png", "'-bm' of 'norm' is not used", m.NormalMap),
        (b"bump n.png\nnorm n.png", "'bump' is not used beside 'norm'", m.NormalMap),
        (b"norm gone.png", "the image 'gone.png' is left out: no such file", None),
        (b"bump gone.png", "the image 'gone.png' is left out: no such file", None),
    ],
)
def test_what_is_not_as_it_stands_is_told(statement: bytes, message: str, relief: type | None, tmp_path: Path) -> None:
    normals(tmp_path / "n.png")
    picture(tmp_path / "photo.png")
    scene = square(tmp_path, statement + b"\n")
    assert told(scene) == [f"a.mtl:2: {message}"]
    (shape,) = shapes(scene)
    assert isinstance(shape.bsdf, m.TwoSided)
    assert isinstance(shape.bsdf.bsdf[0], relief or m.Diffuse)


@pytest.mark.parametrize("word", [b"norm", b"bump"])
def test_faces_without_texture_coordinates_have_no_relief(word: bytes, tmp_path: Path) -> None:
    normals(tmp_path / "n.png")
    mesh = b"mtllib a.mtl\n" + SQUARE + b"usemtl m\nf 1 2 3 4\n"
    scene = square(tmp_path, word + b" n.png\n", mesh=mesh)
    assert told(scene) == [f"a.mtl:2: '{word.decode()}' is not used: the faces of the material have no vt"]


@pytest.mark.parametrize(("word", "count"), [(b"norm n.png", 1), (b"bump h.png", 0)])
def test_normals_that_are_seen_in_a_mirror_are_told(word: bytes, count: int, tmp_path: Path) -> None:
    normals(tmp_path / "n.png")
    written(tmp_path / "h.png", np.random.default_rng(2).random((8, 8, 1)))
    mesh = b"mtllib a.mtl\n" + SQUARE + b"usemtl m\nf 1/1 2/2 3/3\nf 1/2 3/4 4/3\n"
    message = "a.mtl:2: a normal map leans the wrong way along v on faces that mirror it"
    assert told(square(tmp_path, word + b"\n", mesh=mesh)) == [message] * count


def test_a_picture_of_many_materials_is_looked_at_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    normals(tmp_path / "n.png")
    read = []

    def counted(path: Path) -> str:
        read.append(path)
        return content_of(path)

    monkeypatch.setattr("equaltime.scene.obj_materials.content_of", counted)
    parts = b"usemtl a\nf 1/1 2/2 3/3\nusemtl b\nf 1/1 3/3 4/4\n"
    scene = load(tmp_path, b"mtllib a.mtl\n" + SQUARE + parts, a=b"newmtl a\nbump n.png\nnewmtl b\nbump n.png\n")
    assert told(scene) == ["a.mtl:2: the image of 'bump' is coloured and is used as a normal map (first of 2)"]
    assert len(read) == 1
    assert tmp_path / "n.png" in scene.files


@pytest.mark.parametrize("word", [b"norm", b"bump", b"map_Kd"])
def test_a_picture_that_cannot_be_read_is_refused(word: bytes, tmp_path: Path) -> None:
    (tmp_path / "t.png").write_bytes(b"no picture")
    with pytest.raises(et.SceneError, match=r"t\.png: cannot be read as an image"):
        square(tmp_path, word + b" t.png\n")


def test_pictures_of_normals_are_told_from_others(tmp_path: Path) -> None:
    random = np.random.default_rng(3)
    rough = random.normal((0.0, 0.0, 1.0), 0.3, (64, 64, 3))
    texels = 0.5 * rough / np.linalg.norm(rough, axis=2, keepdims=True) + 0.5
    assert content_of(written(tmp_path / "n.png", texels)) == "normals"
    texels[:, :48] = 0.0  # what no face shows
    assert content_of(written(tmp_path / "part.png", texels)) == "normals"
    assert content_of(written(tmp_path / "photo.png", random.random((600, 700, 3)))) == "colours"
    bricks = np.array([0.6, 0.3, 0.25]) * random.uniform(0.5, 1.0, (64, 64, 1))
    assert content_of(written(tmp_path / "bricks.png", bricks)) == "colours"
    grey = np.repeat(random.random((300, 300, 1)), 3, axis=2)
    assert content_of(written(tmp_path / "grey.png", grey)) == "grey"
    grey[1, 1, 2] = 1.0 - grey[1, 1, 2]  # a texel beside those that are looked at closely
    assert content_of(written(tmp_path / "dot.png", grey)) == "colours"
