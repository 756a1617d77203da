"""How opaque pixels are: exact where it must be, to its binomial error at edges and in fog, and how it is written.

Errors of edges and fog lie within 4 standard deviations of independent samples: a false alarm in 16,000 tests, and the
twins are as far off as a tenth.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio  # noqa: N813
import pytest
from numpy.typing import NDArray

import equaltime as et
from equaltime.rendering.render_file import RenderFile, read_picture

pytestmark = pytest.mark.filterwarnings("ignore:the picture is black everywhere")
SPP = 1024
GREY = {"type": "diffuse", "reflectance": 0.5}
SKY = {"type": "constant", "radiance": 0.7}
WIDE = [{"look_at": {"origin": [0, 0, 1], "target": [0, 0, 0]}}, {"scale": 50}]


def wall(bsdf: Any = GREY, z: float = 0.0, **more: Any) -> dict[str, Any]:
    """A wall across the whole view."""
    return {"type": "rectangle", "to_world": [{"scale": 50}, {"translate": [0, 0, z]}], "bsdf": bsdf} | more


def mask(opacity: float, z: float = 0.0) -> dict[str, Any]:
    return wall({"type": "mask", "opacity": opacity, "bsdf": GREY}, z)


def scene(film: dict[str, Any] | None = None, integrator: dict[str, Any] | None = None, **shapes: Any) -> et.Scene:
    """What a camera of parallel rays sees that looks along -z at a square of 2 by 2 units."""
    box = {"type": "hdrfilm", "width": 2, "height": 2, "pixel_format": "rgba", "rfilter": {"type": "box"}}
    camera = {
        "type": "orthographic",
        "to_world": [{"look_at": {"origin": [0, 0, 9], "target": [0, 0, 0], "up": [0, 1, 0]}}],
        "film": box | (film or {}),
    }
    inner = integrator or {"type": "volpath", "max_depth": 3}
    return et.load_dict({"type": "scene", "integrator": inner, "sensor": camera, **shapes})


def alpha(spp: int = SPP, **parts: Any) -> NDArray[np.float32]:
    found = et.render(scene(**parts), spp=spp, seed=3).alpha
    assert found is not None
    return found


LAMP = wall(emitter={"type": "area", "radiance": 2.0})
HIDING = {"type": "path", "hide_emitters": True, "max_depth": 3}
EXACT: dict[str, tuple[float, dict[str, Any]]] = {
    "nothing": (0.0, {}),
    "a sky": (0.0, {"sky": SKY}),
    "a wall": (1.0, {"wall": wall(), "sky": SKY}),
    "a black wall": (1.0, {"wall": wall({"type": "diffuse", "reflectance": 0.0})}),
    "glass": (1.0, {"wall": wall({"type": "thindielectric"}), "sky": SKY}),
    "a lamp": (1.0, {"lamp": LAMP}),
    "a hidden lamp": (0.0, {"lamp": LAMP, "integrator": HIDING}),
    "a hidden lamp before a wall": (1.0, {"lamp": LAMP, "wall": wall(z=-1.0), "integrator": HIDING}),
    "a surface that is nothing": (0.0, {"wall": wall({"type": "null"}), "sky": SKY}),
    "a mask": (0.25, {"mask": mask(0.25), "sky": SKY}),
    "a mask of opacity 0": (0.0, {"mask": mask(0.0)}),
    "two masks": (1 - 0.75 * 0.5, {"mask": mask(0.25), "other": mask(0.5, -1.0), "sky": SKY}),
    "a mask before a wall": (1.0, {"mask": mask(0.25), "wall": wall(z=-1.0)}),
}


@pytest.mark.parametrize("name", EXACT)
def test_alpha_is_exact_where_it_needs_no_luck(name: str) -> None:
    expected, parts = EXACT[name]
    assert alpha(4, **parts) == pytest.approx(np.full((2, 2), expected), abs=1e-7)
    if expected in (0.0, 1.0):
        assert (alpha(4, **parts) == expected).all()


@pytest.mark.parametrize("rfilter", ["box", "tent", "gaussian", "mitchell", "lanczos"])
def test_what_fills_a_pixel_is_opaque_by_any_filter(rfilter: str) -> None:
    film = {"rfilter": {"type": rfilter}}
    assert (alpha(7, wall=wall(), film=film) == 1.0).all()
    assert (alpha(7, sky=SKY, film=film) == 0.0).all()


def off_by(found: NDArray[np.float32], share: float) -> NDArray[np.float64]:
    """How many standard deviations of independent samples."""
    return np.asarray(np.abs(found - share) / np.sqrt(share * (1 - share) / SPP))


@pytest.mark.parametrize("sampler", ["independent", "sobol"])
def test_an_edge_covers_its_share_of_a_pixel(sampler: str) -> None:
    """The wall ends at x = 0.3: in pixels of width 1 it covers 0.3 of the right ones, and all of the left ones."""
    edge = wall() | {"to_world": [{"scale": 50}, {"translate": [-49.7, 0, 0]}]}
    found = et.render(scene(wall=edge, sky=SKY), spp=SPP, seed=5, strategy=f"best,sampler={sampler}").alpha
    assert found is not None
    covered = found if found[0, 0] == 1.0 else found[:, ::-1]
    assert (covered[:, 0] == 1.0).all()
    assert (off_by(covered[:, 1], 0.3) < 4.0).all()
    assert (off_by(covered[:, 1], 0.4) > 4.0).all(), "the twin"


def test_fog_stops_what_it_does_not_let_through() -> None:
    fog = {"type": "homogeneous", "sigma_t": 0.5, "albedo": 0.9}
    slab = {"type": "cube", "to_world": [{"scale": [50, 50, 1]}], "bsdf": {"type": "null"}, "interior": fog}
    found, share = alpha(slab=slab, sky=SKY), 1 - np.exp(-0.5 * 2)
    assert (off_by(found, share) < 4.0).all()
    assert (off_by(found, 1.1 * share) > 4.0).all(), "the twin"


def test_alpha_is_of_the_very_rays_of_the_image() -> None:
    """A wall of radiance 1 under a black sky: the image is alpha, to the bit, at any place of its edge."""
    edge = wall(emitter={"type": "area", "radiance": 1.0}) | {
        "to_world": [{"rotate": {"axis": [0, 0, 1], "angle": 20}}]
    }
    result = et.render(scene(wall=edge, film={"width": 9, "height": 9}), spp=16, seed=8)
    assert result.alpha is not None
    assert 0.0 < result.alpha.min(initial=1.0, where=result.alpha > 0.0) < 1.0
    assert np.array_equal(result.image[..., 0], result.alpha)


def test_alpha_is_an_output_of_its_own_too() -> None:
    integrator = {"type": "aov", "aovs": "cover:alpha", "image": {"type": "path"}}
    result = et.render(scene(mask=mask(0.25), sky=SKY, integrator=integrator, film={"pixel_format": "rgb"}), spp=4)
    assert result.aovs["cover.A"] == pytest.approx(np.full((2, 2), 0.25))
    assert result.alpha is None


CHANNELS = {
    "rgb": ("R", "G", "B"),
    "rgba": ("R", "G", "B", "A"),
    "luminance": ("Y",),
    "luminance_alpha": ("Y", "A"),
    "xyz": ("X", "Y", "Z"),
    "xyza": ("X", "Y", "Z", "A"),
}
TO_XYZ = np.array(
    [[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750], [0.0193339, 0.1191920, 0.9503041]]
)
"""Of Rec. 709 under D65 (IEC 61966-2-1)."""


@pytest.mark.parametrize("component", ["float16", "float32", None])
@pytest.mark.parametrize("pixel_format", CHANNELS)
def test_the_file_has_what_the_film_asks_for(pixel_format: str, component: str | None, tmp_path: Path) -> None:
    path = tmp_path / "a.exr"
    film = {"pixel_format": pixel_format} | ({"component_format": component} if component else {})
    red = wall(
        {
            "type": "mask",
            "opacity": 0.25,
            "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.8, 0.3, 0.1]}},
        }
    )
    result = et.render(scene(film, wall=red, sky=SKY), spp=16)
    result.save(path)
    seen = oiio.ImageBuf(str(path))
    assert tuple(seen.spec().channelnames) == CHANNELS[pixel_format]
    assert str(seen.spec().format) == ("half" if component == "float16" else "float")
    xyz = result.image @ TO_XYZ.T
    expected = {"rgb": result.image, "xyz": xyz, "luminance": xyz[..., 1:2]}[
        pixel_format.removesuffix("_alpha").replace("rgba", "rgb").replace("xyza", "xyz")
    ]
    if pixel_format in ("rgba", "xyza", "luminance_alpha"):
        expected = np.dstack([expected, np.full((2, 2), 0.25)])
    assert seen.get_pixels(oiio.FLOAT) == pytest.approx(expected, rel=1e-3 if component == "float16" else 3e-4)


@pytest.mark.parametrize("pixel_format", CHANNELS)
def test_the_render_itself_is_read_again(pixel_format: str, tmp_path: Path) -> None:
    path = tmp_path / "a.exr"
    asked = scene({"pixel_format": pixel_format, "component_format": "float16"}, wall=mask(0.25), sky=SKY)
    half = et.render(asked, spp=8)
    half.save(path)
    assert np.array_equal(RenderFile.read(path).image, half.image)
    whole, again = et.render(asked, spp=16), et.render(asked, spp=16, resume=path)
    assert np.array_equal(whole.image, again.image)
    if whole.alpha is not None:
        assert np.array_equal(whole.alpha, np.asarray(again.alpha))
    half.save(path, small=True)
    assert read_picture(path).image == pytest.approx(half.image, rel=1e-3)
    assert tuple(oiio.ImageBuf(str(path)).spec().channelnames) == CHANNELS[pixel_format]


def test_numbers_that_are_not_written_are_told() -> None:
    assert scene({"component_format": "float16"}, sky=SKY).warnings == ()
    (warning,) = scene({"component_format": "uint32"}, sky=SKY).warnings
    assert warning.endswith("film.component_format: integers are not written: the image has 32-bit floats")


def test_merged_renders_have_the_alpha_of_all_their_samples(tmp_path: Path) -> None:
    edge = wall() | {"to_world": [{"scale": 50}, {"translate": [-49.7, 0, 0]}]}
    parts = []
    for seed, spp in ((1, 8), (2, 24)):
        parts.append(et.render(scene({"component_format": "float16"}, wall=edge, sky=SKY), spp=spp, seed=seed))
        parts[-1].save(tmp_path / f"{seed}.exr")
    merged = et.merge([tmp_path / "1.exr", tmp_path / "2.exr"])
    few, many = (np.asarray(part.alpha, np.float64) for part in parts)
    assert merged.alpha == pytest.approx((8 * few + 24 * many) / 32, abs=1e-3)
    merged.save(tmp_path / "all.exr")
    seen = oiio.ImageBuf(str(tmp_path / "all.exr")).spec()
    assert (tuple(seen.channelnames), str(seen.format)) == (("R", "G", "B", "A"), "half")


def test_an_alpha_of_others_is_a_damage(tmp_path: Path) -> None:
    path = tmp_path / "a.exr"
    result = et.render(scene(wall=mask(0.25), sky=SKY), spp=8)
    result.save(path)
    assert read_picture(path).channels["A"] == pytest.approx(np.full((2, 2), 0.25))
    changed = replace(result, aovs={"A": np.full((2, 2), 0.5, np.float32)})
    parts = [oiio.ImageBuf(str(path), part, 0) for part in range(oiio.ImageBuf(str(path)).nsubimages)]
    changed.save(tmp_path / "b.exr")
    other = oiio.ImageBuf(str(tmp_path / "b.exr"))
    alpha_of = oiio.ImageBufAlgo.channels(other, ("A",))
    parts[0] = oiio.ImageBufAlgo.channel_append(oiio.ImageBufAlgo.channels(parts[0], ("R", "G", "B")), alpha_of)
    parts[0].specmod().attribute("oiio:subimagename", "beauty")
    output = oiio.ImageOutput.create(str(path))
    assert output.open(str(path), tuple(part.spec() for part in parts))
    for number, part in enumerate(parts):
        assert number == 0 or output.open(str(path), part.spec(), "AppendSubimage")
        assert output.write_image(part.get_pixels(part.spec().format))
    output.close()
    with pytest.raises(et.ImageError, match="'beauty' is not what was saved"):
        RenderFile.read(path)


def test_a_preview_has_colours_without_their_weight(tmp_path: Path) -> None:
    """A quarter of a white wall of radiance 0.5, before nothing."""
    lit = {"type": "mask", "opacity": 0.25, "bsdf": {"type": "diffuse", "reflectance": 1.0}}
    result = et.render(scene(wall=wall(lit), sky={"type": "constant", "radiance": 0.5}, integrator=HIDING), spp=4096)
    result.save(tmp_path / "a.png")
    as_it_is = oiio.ImageSpec()
    as_it_is.attribute("oiio:UnassociatedAlpha", 1)
    seen = oiio.ImageInput.open(str(tmp_path / "a.png"), as_it_is)
    pixels = seen.read_image("uint8")
    assert tuple(seen.spec().channelnames) == ("R", "G", "B", "A")
    assert (pixels[..., 3] == 64).all()
    assert np.abs(pixels[..., :3].astype(int) - 188).max() <= 2  # 0.5 by the curve of sRGB
