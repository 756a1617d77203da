"""What the core is told about a scene: recorded by a builder that only listens."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, cast

import numpy as np
import OpenImageIO
import pytest

from equaltime import SceneError, _core
from equaltime.scene import load_dict
from equaltime.scene.compile import compile_scene


class Listener:
    """Answers like the core's scene builder and remembers what it was told."""

    def __init__(self) -> None:
        self.told: list[tuple[str, tuple[Any, ...], dict[str, Any]]] = []

    def __getattr__(self, name: str) -> Callable[..., int]:
        def listen(*args: Any, **kwargs: Any) -> int:
            family = {"add_mesh", "add_rectangle", "add_disk", "add_sphere"}
            same = [told for told, _, _ in self.told if (told in family) == (name in family) and told.startswith("add")]
            self.told.append((name, args, kwargs))
            return len(same)

        return listen

    def all(self, name: str) -> list[tuple[tuple[Any, ...], dict[str, Any]]]:
        return [(args, kwargs) for told, args, kwargs in self.told if told == name]

    def bsdfs(self, type: str) -> list[dict[str, Any]]:
        """The parameters of the BSDFs of a type."""
        return [kwargs for args, kwargs in self.all("add_bsdf") if args == (type,)]


def listen(sensor: dict[str, Any] | None = None, **objects: Any) -> Listener:
    scene = load_dict({"type": "scene", "sensor": sensor or {"type": "perspective"}, **objects})
    listener = Listener()
    compile_scene(scene.model, scene.assets, cast(_core.SceneBuilder, listener))
    return listener


def sides(**shape: Any) -> tuple[Any, Any, Any]:
    """The front, the back and the radiance of a disk."""
    (((_,), kwargs),) = listen(it={"type": "disk", **shape}).all("add_disk")
    return kwargs["front"], kwargs["back"], kwargs["radiance"]


GREY = {"type": "diffuse", "reflectance": 0.25}
MIRROR = {"type": "conductor"}
GLASS = {"type": "dielectric", "int_ior": 1.5, "ext_ior": 1.25}
BLACK = {"type": "diffuse", "reflectance": 0}
LIGHT = {"type": "area", "radiance": [1, 2, 3]}


# -- sides -----------------------------------------------------------------------------------------------------------


def test_an_opaque_material_has_a_front_and_its_back_absorbs() -> None:
    assert sides(bsdf=GREY) == (0, None, None)


def test_two_sides_of_one_material_share_it() -> None:
    assert sides(bsdf={"type": "twosided", "bsdf": GREY}) == (0, 0, None)


def test_two_sides_of_two_materials_are_front_and_back() -> None:
    assert sides(bsdf={"type": "twosided", "bsdf": [GREY, MIRROR]}) == (0, 1, None)


def test_two_sides_within_two_sides_show_their_front_as_in_mitsuba() -> None:
    inner = {"type": "twosided", "bsdf": [GREY, MIRROR]}
    assert sides(bsdf={"type": "twosided", "bsdf": inner}) == (0, 0, None)
    assert sides(bsdf={"type": "twosided", "bsdf": [MIRROR, inner]}) == (0, 1, None)


def test_glass_is_on_both_sides_and_its_index_is_inside_over_outside() -> None:
    assert sides(bsdf=GLASS) == (0, 0, None)
    assert listen(it={"type": "disk", "bsdf": GLASS}).bsdfs("dielectric")[0]["ior"] == pytest.approx(1.2)


def test_a_black_material_is_none_at_all() -> None:
    assert sides(bsdf=BLACK) == (None, None, None)
    assert sides(bsdf={"type": "twosided", "bsdf": [BLACK, GREY]}) == (None, 0, None)


def test_a_shape_without_material_is_half_grey_or_black_if_it_shines() -> None:
    assert listen(it={"type": "disk"}).bsdfs("diffuse") == [{"reflectance": (0.5, 0.5, 0.5)}]
    assert sides(emitter=LIGHT) == (None, None, (1.0, 2.0, 3.0))
    assert sides(emitter=LIGHT, bsdf=GREY) == (0, None, (1.0, 2.0, 3.0))


def test_a_light_without_radiance_is_no_light() -> None:
    assert sides(emitter={"type": "area", "radiance": 0}) == (None, None, None)
    dark = listen(lamp={"type": "point", "intensity": 0}, sky={"type": "constant", "radiance": 0})
    assert not dark.all("add_point_light")
    assert not dark.all("add_constant_environment")


def test_equal_materials_are_told_once_whatever_their_names() -> None:
    listener = listen(
        one={"type": "disk", "bsdf": {**GREY, "id": "a"}},
        two={"type": "disk", "bsdf": {**GREY, "id": "b"}},
        three={"type": "disk", "bsdf": {"type": "twosided", "bsdf": GREY}},
        four={"type": "disk", "bsdf": MIRROR},
    )
    assert len(listener.bsdfs("diffuse")) == 1
    assert [kwargs["front"] for _, kwargs in listener.all("add_disk")] == [0, 0, 0, 1]


# -- shapes, materials, lights ---------------------------------------------------------------------------------------


def test_each_shape_is_told_once_and_in_order() -> None:
    listener = listen(
        a={"type": "sphere", "center": [1, 2, 3], "radius": 2, "flip_normals": True},
        b={"type": "rectangle"},
        c={"type": "cube"},
        d={"type": "disk"},
    )
    shapes = [name for name, _, _ in listener.told if name in ("add_sphere", "add_rectangle", "add_mesh", "add_disk")]
    assert shapes == ["add_sphere", "add_rectangle", "add_mesh", "add_disk"]
    (((center, radius), kwargs),) = listener.all("add_sphere")
    assert (center, radius, kwargs["flip_normals"]) == ([1, 2, 3], 2, True)
    (((vertices, faces, normals, uvs), _),) = listener.all("add_mesh")
    # Each face of a cube has its own corners, since each has its own texture coordinates.
    assert (vertices.shape, faces.shape, normals, uvs.shape) == ((24, 3), (12, 3), None, (24, 2))


def test_metals_are_told_with_their_optical_constants() -> None:
    rough = {"type": "roughconductor", "distribution": "ggx", "alpha_u": 0.1, "alpha_v": 0.2, "eta": 2, "k": [1, 2, 3]}
    listener = listen(a={"type": "disk", "bsdf": rough}, b={"type": "disk", "bsdf": MIRROR})
    metal = {"eta": (2.0,) * 3, "k": (1.0, 2.0, 3.0), "specular_reflectance": (1.0,) * 3}
    roughness = {"distribution": "ggx", "alpha_u": 0.1, "alpha_v": 0.2}
    assert listener.bsdfs("roughconductor") == [metal | roughness]
    assert listener.bsdfs("conductor") == [{"eta": (0.0,) * 3, "k": (1.0,) * 3, "specular_reflectance": (1.0,) * 3}]


def test_free_lights_are_told_with_their_places() -> None:
    listener = listen(
        a={"type": "point", "intensity": 2, "to_world": [{"translate": [1, 2, 3]}]},
        b={"type": "constant", "radiance": [1, 2, 3]},
    )
    assert listener.all("add_point_light")[0][0] == ((1.0, 2.0, 3.0), (2.0, 2.0, 2.0))
    assert listener.all("add_constant_environment")[0][0] == ((1.0, 2.0, 3.0),)


# -- camera and film -------------------------------------------------------------------------------------------------


def test_the_camera_is_told_with_clips_only_if_the_scene_has_them() -> None:
    ((plain, _),) = listen({"type": "perspective", "fov": 40}).all("set_perspective")
    assert plain[0].tolist() == np.eye(4).tolist()
    assert plain[1:] == (40.0, None, None, (0.0, 0.0))
    clipped = {"type": "perspective", "near_clip": 1, "far_clip": 2, "principal_point_offset_x": 0.1}
    ((args, _),) = listen(clipped).all("set_perspective")
    assert args[2:] == (1.0, 2.0, (0.1, 0.0))


@pytest.mark.parametrize(
    ("rfilter", "told"),
    [
        ({"type": "box"}, ("box", 0.5)),
        ({"type": "tent", "radius": 2}, ("tent", 2.0)),
        ({"type": "gaussian"}, ("gaussian", 0.5)),
        (None, ("gaussian", 0.5)),
    ],
)
def test_the_film_is_told_with_its_crop_and_filter(rfilter: dict[str, Any] | None, told: tuple[str, float]) -> None:
    film: dict[str, Any] = {"type": "hdrfilm", "width": 20, "height": 10, "crop_offset_x": 5, "crop_width": 3}
    if rfilter is not None:
        film["rfilter"] = rfilter
    ((args, _),) = listen({"type": "perspective", "film": film}).all("set_film")
    assert args == (20, 10, (5, 0, 3, 10), *told)


# -- environments ----------------------------------------------------------------------------------------------------


def write_image(path: Path, pixels: np.ndarray, kind: str) -> None:
    height, width, channels = pixels.shape
    image = OpenImageIO.ImageBuf(OpenImageIO.ImageSpec(width, height, channels, kind))
    image.set_pixels(OpenImageIO.ROI(), pixels.astype(np.float32))
    assert image.write(str(path)), image.geterror()


def environment(path: Path) -> np.ndarray:
    (((pixels, scale, to_world), _),) = listen(sky={"type": "envmap", "filename": str(path), "scale": 2}).all(
        "add_image_environment"
    )
    assert (scale, to_world.tolist()) == (2.0, np.eye(4).tolist())
    return cast(np.ndarray, pixels)


def test_a_float_image_is_told_to_the_texel(tmp_path: Path) -> None:
    pixels = np.arange(4 * 5 * 3, dtype=np.float32).reshape(4, 5, 3)
    write_image(tmp_path / "sky.exr", pixels, "float")
    told = environment(tmp_path / "sky.exr")
    assert told.dtype == np.float32
    assert (told == pixels).all()


def test_a_grey_image_and_one_with_alpha_become_three_channels(tmp_path: Path) -> None:
    write_image(tmp_path / "grey.exr", np.full((4, 5, 1), 0.25), "float")
    write_image(tmp_path / "alpha.exr", np.concatenate([np.full((4, 5, 3), 0.5), np.ones((4, 5, 1))], axis=2), "float")
    assert (environment(tmp_path / "grey.exr") == 0.25).all()
    assert (environment(tmp_path / "alpha.exr") == 0.5).all()
    assert environment(tmp_path / "alpha.exr").shape == (4, 5, 3)


def test_an_image_of_bytes_is_decoded_from_srgb(tmp_path: Path) -> None:
    write_image(tmp_path / "sky.png", np.full((4, 5, 3), 128 / 255), "uint8")
    assert environment(tmp_path / "sky.png") == pytest.approx(0.21586, abs=1e-5)


@pytest.mark.parametrize(
    ("pixel", "problem"),
    [
        ((np.nan, 0, 0), r"pixel \(2, 1\) is not finite: \[nan, 0.0, 0.0\]"),
        ((0, 0, np.inf), r"pixel \(2, 1\) is not finite"),
    ],
)
def test_an_image_with_a_pixel_that_is_not_finite_is_refused(
    tmp_path: Path, pixel: tuple[float, float, float], problem: str
) -> None:
    pixels = np.ones((4, 5, 3))
    pixels[1, 2] = pixel
    write_image(tmp_path / "sky.exr", pixels, "float")
    with pytest.raises(SceneError, match=rf"^sky.filename: {tmp_path}/sky.exr: {problem}"):
        listen(sky={"type": "envmap", "filename": str(tmp_path / "sky.exr")})


def test_light_below_zero_is_none_and_told(tmp_path: Path) -> None:
    pixels = np.ones((4, 5, 3))
    pixels[1, 2] = 0, -0.25, 8
    write_image(tmp_path / "sky.exr", pixels, "float")
    assert environment(tmp_path / "sky.exr")[1, 2].tolist() == [0, 0, 8]
    sky = {"type": "envmap", "filename": str(tmp_path / "sky.exr")}
    (told,) = load_dict({"type": "scene", "sensor": {"type": "perspective"}, "sky": sky}).warnings
    assert "sky.exr: 1 pixels have negative values, which count as 0: the least is -0.25, the largest 8" in told


def test_an_image_that_is_none_or_too_small_is_refused(tmp_path: Path) -> None:
    (tmp_path / "text.exr").write_text("no image")
    write_image(tmp_path / "small.exr", np.ones((1, 1, 3)), "float")
    for name, problem in (("text", "cannot be read as an image"), ("small", "at least 2x3 pixels, found 1x1")):
        with pytest.raises(SceneError, match=problem):
            listen(sky={"type": "envmap", "filename": str(tmp_path / f"{name}.exr")})


# -- the core itself -------------------------------------------------------------------------------------------------


def test_the_core_builds_what_it_is_told() -> None:
    scene = load_dict(
        {
            "type": "scene",
            "sensor": {"type": "perspective", "film": {"type": "hdrfilm", "width": 8, "height": 6}},
            "ball": {"type": "sphere", "bsdf": GLASS},
            "box": {"type": "cube", "to_world": [{"translate": [5, 0, 0]}]},
            "lamp": {"type": "rectangle", "emitter": LIGHT, "to_world": [{"translate": [0, 5, 0]}]},
            "sky": {"type": "constant"},
        }
    )
    core = scene.core
    assert core is scene.core
    assert (core.shapes, core.film_shape) == (3, (6, 8))
    hit = core.intersect([[0, 0, -9], [5, 0, -9]], [[0, 0, 1], [0, 0, 1]])
    assert hit["shape"].tolist() == [0, 1]
    assert hit["t"] == pytest.approx([8, 8])
    assert set(scene.timings) == {"load", "build"}
