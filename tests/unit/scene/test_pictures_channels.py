"""The meaning of a picture's channels: their names, their types, their colour space."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import OpenEXR
import pytest
from PIL import Image, ImageCms

import equaltime as et
from equaltime.scene.picture_colors import CIE_XYZ, NAMED, REC709, luminance_weights, to_srgb

from .picture_files import colors, hdr, numbers, png_with, scene, srgb_decoded, texels, written

BYTES = np.random.default_rng(2).integers(0, 256, (4, 6, 3), np.uint8)

# -- types ------------------------------------------------------------------------------------------------------------


def exr(path: Path, **channels: np.ndarray) -> Path:
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    OpenEXR.File(header, {name: np.ascontiguousarray(values) for name, values in channels.items()}).write(str(path))
    return path


@pytest.mark.parametrize("use", ["texture", "sky"])
def test_whole_numbers_of_exr_are_the_numbers_themselves(tmp_path: Path, use: str) -> None:
    whole = np.arange(72, dtype=np.uint32).reshape(4, 6, 3)
    path = exr(tmp_path / "a.exr", **{name: whole[..., i] for i, name in enumerate("RGB")})
    if use == "sky":
        loaded = scene(path, use)
        assert (loaded.assets.image(loaded.model.emitters[0]) == whole).all()  # type: ignore[arg-type]
    for raw in (False, True):
        assert (numbers(path, raw) == whole).all()


def test_the_channels_of_exr_may_have_different_types(tmp_path: Path) -> None:
    values = colors()
    whole = (values[..., 2] * 1024).astype(np.uint32)
    path = exr(tmp_path / "a.exr", R=values[..., 0], G=values[..., 1].astype(np.float16), B=whole)
    assert (numbers(path) == np.dstack([values[..., :2], whole])).all()


def test_half_precision_stays_half(tmp_path: Path) -> None:
    found = texels(written(tmp_path / "a.exr", colors().astype(np.float16)))
    assert found.texels.dtype == np.float16
    assert (found.linear == colors()).all()


def test_bytes_and_words_are_encoded_fractions_unless_they_are_raw(tmp_path: Path) -> None:
    for kind in ("png", "tif"):
        words = written(tmp_path / f"w.{kind}", BYTES.astype(np.uint16) * 257)
        small = written(tmp_path / f"b.{kind}", BYTES)
        assert texels(small).srgb
        assert not texels(small, raw=True).srgb
        assert (texels(small).texels == BYTES).all()
        assert numbers(words, raw=True) == pytest.approx(BYTES / 255, abs=1e-7)
        assert numbers(words) == pytest.approx(srgb_decoded(BYTES / 255), abs=1e-6)


@pytest.mark.parametrize("kind", ["float32", "float64"])
def test_floating_point_tiff_is_linear(tmp_path: Path, kind: str) -> None:
    assert (numbers(written(tmp_path / "a.tif", colors().astype(kind))) == colors()).all()


@pytest.mark.parametrize(("height", "tile"), [(1, 0), (4, 16)])
def test_float64_that_would_be_misread_is_refused(tmp_path: Path, height: int, tile: int) -> None:
    path = written(tmp_path / "a.tif", colors(height).astype(np.float64), tile=tile)
    with pytest.raises(ValueError, match=r"a\.tif: OpenImageIO misreads tiles and single rows of float64"):
        texels(path)


def test_whole_numbers_with_a_sign_are_linear_which_is_told(tmp_path: Path) -> None:
    path = written(tmp_path / "a.tif", np.full((4, 6, 3), -16384, np.int16))
    assert numbers(path) == pytest.approx(-16384 / 32767, abs=1e-4)
    assert texels(path).told == ("whole numbers with a sign count as linear, from -1 to 1",)


@pytest.mark.parametrize("kind", ["png", "bmp", "tif"])
@pytest.mark.parametrize("inverse", [False, True])
def test_one_bit_is_black_and_white(tmp_path: Path, kind: str, inverse: bool) -> None:
    seen = BYTES[..., 0] > 128
    more = {"tiffinfo": {262: 0}} if inverse and kind == "tif" else {}
    Image.fromarray(seen).save(tmp_path / f"a.{kind}", **more)
    assert (numbers(tmp_path / f"a.{kind}")[..., 0] == seen).all()


# -- names ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "names", ["R G B", "B G R", "r g b", "red green blue", "diffuse.R diffuse.G diffuse.B", "a.b.R a.b.G a.b.B"]
)
def test_colours_go_by_the_names_of_channels(tmp_path: Path, names: str) -> None:
    planes = dict(zip(names.split(), np.moveaxis(colors(), 2, 0), strict=True))
    order = "BGR" if names == "B G R" else "RGB"
    expected = colors()[..., [order.index(c) for c in "RGB"]]
    path = exr(tmp_path / "a.exr", **planes)
    assert (numbers(path) == expected).all()
    assert texels(path).told == ()


def test_the_first_layer_is_used_and_the_channels_of_others_are_told(tmp_path: Path) -> None:
    planes = {f"{layer}.{c}": np.full((4, 6), v, np.float32) for layer, v in (("a", 0.25), ("b", 0.5)) for c in "RGB"}
    path = exr(tmp_path / "a.exr", **planes, Z=np.full((4, 6), 9.0, np.float32))
    assert (numbers(path) == 0.25).all()
    assert texels(path).told == ("channels that are not used: Z, b.R, b.G, b.B",)
    path = exr(tmp_path / "b.exr", **planes, **{c: np.full((4, 6), 0.75, np.float32) for c in "RGB"})
    assert (numbers(path) == 0.75).all()


@pytest.mark.parametrize("names", ["Y", "Y A", "depth.V", "roughness", "A"])
def test_one_channel_is_grey(tmp_path: Path, names: str) -> None:
    planes = dict.fromkeys(names.split(), np.ones((4, 6), np.float32)) | {names.split()[0]: colors()[..., 0]}
    path = exr(tmp_path / "a.exr", **planes)
    assert texels(path).texels.shape == (4, 6, 1)
    assert (texels(path).texels == colors()[..., :1]).all()
    assert texels(path).told == ()


@pytest.mark.parametrize(("names", "used"), [("u v", "u is"), ("m n o", "m, n, o are"), ("m n o q", "m, n, o are")])
def test_names_that_say_nothing_are_told(tmp_path: Path, names: str, used: str) -> None:
    planes = {name: np.full((4, 6), i / 8, np.float32) for i, name in enumerate(names.split())}
    found = texels(exr(tmp_path / "a.exr", **planes))
    assert found.texels[0, 0].tolist() == ([0.0] if len(planes) == 2 else [0.0, 0.125, 0.25])
    left = f"channels that are not used: {names.split()[-1]}"
    expected = (f"no layer has R, G and B, or Y: {used} taken", left)
    assert found.told == (expected[:1] if len(planes) == 3 else expected)


@pytest.mark.parametrize("space", ["rec709", "ap1"])
def test_luminance_and_chroma_are_colours(tmp_path: Path, space: str) -> None:
    rgb = colors().astype(np.float64) + 0.01
    y = rgb @ luminance_weights(NAMED[space])
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    header |= {"chromaticities": tuple(NAMED[space])} if space != "rec709" else {}
    planes = {"Y": y, "RY": (rgb[..., 0] - y) / y, "BY": (rgb[..., 2] - y) / y}
    channels = {name: np.ascontiguousarray(values, np.float32) for name, values in planes.items()}
    OpenEXR.File(header, channels).write(str(tmp_path / "a.exr"))
    matrix = to_srgb(NAMED[space])
    assert numbers(tmp_path / "a.exr") == pytest.approx(rgb if matrix is None else rgb @ matrix.T, abs=1e-5)


def test_cie_xyz_is_converted(tmp_path: Path) -> None:
    planes = dict(zip("XYZ", np.moveaxis(colors(), 2, 0), strict=True))
    path = exr(tmp_path / "a.exr", **planes)
    matrix = to_srgb(CIE_XYZ)
    assert matrix is not None
    assert numbers(path) == pytest.approx(colors() @ matrix.T, abs=1e-5)
    assert (numbers(path, raw=True) == colors()).all()
    assert texels(path).told == ()


# -- opacity ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["png", "tif", "exr"])
def test_an_opacity_is_told_where_it_is_below_one_and_leaves_colours_as_the_file_has_them(
    tmp_path: Path, kind: str
) -> None:
    for alpha, told in ((255, ()), (100, ("its opacity is not used: a mask takes a texture of its own",))):
        pixels = np.dstack([BYTES, np.full((4, 6), alpha, np.uint8)])
        given = pixels.astype(np.float32) / 255 if kind == "exr" else pixels
        found = texels(written(tmp_path / f"{alpha}.{kind}", given, "R G B A"))
        assert (found.texels == given[..., :3]).all()
        assert found.told == told


def test_grey_with_opacity_is_grey(tmp_path: Path) -> None:
    found = texels(written(tmp_path / "a.png", BYTES[..., :2], "Y A"))
    assert (found.texels == BYTES[..., :1]).all()
    assert len(found.told) == 1


def test_palettes_are_colours(tmp_path: Path) -> None:
    pixels = np.array([[[255, 0, 0], [0, 255, 0]], [[0, 0, 255], [9, 9, 9]]], np.uint8)
    image = Image.fromarray(pixels).convert("P", palette=Image.Palette.ADAPTIVE, colors=4)
    image.save(tmp_path / "a.png")
    assert (texels(tmp_path / "a.png").texels == np.array(image.convert("RGB"))).all()
    image.save(tmp_path / "b.png", transparency=image.getpixel((1, 1)))
    assert len(texels(tmp_path / "b.png").told) == 1


@pytest.mark.parametrize("kind", ["jpg", "tif"])
def test_cmyk_is_told_to_be_turned_into_rgb(tmp_path: Path, kind: str) -> None:
    Image.new("CMYK", (6, 4), (0, 255, 255, 0)).save(tmp_path / f"a.{kind}")
    found = texels(tmp_path / f"a.{kind}")
    assert np.abs(found.texels.astype(int) - (255, 0, 0)).max() <= 3
    assert found.told == ("colours in CMYK are turned into RGB without a profile",)


# -- colour spaces ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("gamma", "expected"), [(100000, 1.0), (45455, None), (55555, 1.8), (31250, 3.2)])
def test_the_power_that_a_png_names_is_used(tmp_path: Path, gamma: int, expected: float | None) -> None:
    Image.fromarray(BYTES).save(tmp_path / "a.png")
    path = png_with(tmp_path / "a.png", b"gAMA", struct.pack(">I", gamma))
    fractions = BYTES / 255
    want = srgb_decoded(fractions) if expected is None else fractions**expected
    assert numbers(path) == pytest.approx(want, abs=1e-5)
    assert (texels(path, raw=True).texels == BYTES).all()
    assert texels(path).told == ()


@pytest.mark.parametrize(("name", "encoded"), [("sRGB", True), ("lin_rec709_scene", False)])
def test_floats_that_are_declared_encoded_are_decoded(tmp_path: Path, name: str, encoded: bool) -> None:
    path = written(tmp_path / "a.exr", colors(), oiio__ColorSpace=name)
    assert numbers(path) == pytest.approx(srgb_decoded(colors()) if encoded else colors(), abs=1e-6)


def test_primaries_that_are_named_are_converted_and_unknown_ones_told(tmp_path: Path) -> None:
    found = numbers(written(tmp_path / "a.exr", colors(), oiio__ColorSpace="lin_ap1_scene"))
    matrix = to_srgb(NAMED["ap1"])
    assert matrix is not None
    assert found == pytest.approx(colors() @ matrix.T, abs=1e-5)
    assert to_srgb(NAMED["rec709"]) is to_srgb(REC709) is None
    told = texels(written(tmp_path / "b.exr", colors(), colorInteropID="my_own")).told
    assert told == ("its colour space my_own is not known: linear is taken",)


@pytest.mark.parametrize(("profile", "told"), [("sRGB", 0), ("XYZ", 1)])
def test_profiles_of_other_colours_are_told(tmp_path: Path, profile: str, told: int) -> None:
    made = ImageCms.ImageCmsProfile(ImageCms.createProfile(profile)).tobytes()
    Image.fromarray(BYTES).save(tmp_path / "a.tif", icc_profile=made)
    found = texels(tmp_path / "a.tif").told
    assert len(found) == told
    assert all("its profile of colours is not used: 'XYZ" in line for line in found)
    assert texels(tmp_path / "a.tif", raw=True).told == ()


def test_variables_of_radiance_headers_are_told(tmp_path: Path) -> None:
    pixels = np.full((4, 6, 4), 128, np.uint8)
    header = b"EXPOSURE=2.0\nEXPOSURE=4\nSOFTWARE=x\nPRIMARIES= 0.7 0.3 0.2 0.7 0.1 0.05 0.33 0.33\nGAMMA=2.2\n"
    path = hdr(tmp_path / "a.hdr", pixels, header=header)
    assert (numbers(path) == numbers(hdr(tmp_path / "b.hdr", pixels))).all()
    assert texels(path).told == (
        "EXPOSURE=2.0, 4 in its header is not used",
        "PRIMARIES=0.7 0.3 0.2 0.7 0.1 0.05 0.33 0.33 in its header is not used",
        "GAMMA=2.2 in its header is not used",
    )


# -- what is told -----------------------------------------------------------------------------------------------------


def test_attributes_with_numbers_that_nobody_reads_are_told_and_words_are_not(tmp_path: Path) -> None:
    told = texels(written(tmp_path / "a.exr", colors(), stretch=2.0, comment="mine", ExposureTime=0.5)).told
    assert told == ("attributes that are not used: stretch = 2.0",)


def test_what_several_pictures_have_is_one_line_with_the_first_place(tmp_path: Path) -> None:
    pixels = np.full((2, 2, 4), 100, np.uint8)
    parts = {}
    for name in ("a", "b", "c"):
        bitmap = {"type": "bitmap", "filename": str(written(tmp_path / f"{name}.png", pixels, "R G B A"))}
        parts[name] = {"type": "rectangle", "bsdf": {"type": "diffuse", "reflectance": bitmap}}
    told = et.load_dict({"type": "scene", "sensor": {"type": "perspective"}, **parts}).warnings
    assert told == (f"{tmp_path / 'a.png'}: its opacity is not used: a mask takes a texture of its own (and 2 more)",)
