"""Transparent backgrounds: the camera does not see the sky, files get alpha, and resuming and merging keep both."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio  # noqa: N813
import pytest

import equaltime as et
from equaltime.cli import main
from equaltime.images import image_files

from ..scene.gltf_files import one_triangle

SCENE = """
[integrator]
type = "path"
max_depth = 3
[sensor]
type = "perspective"
fov = 40
to_world = [{ look_at = { origin = [0, 0, 4], target = [0, 0, 0], up = [0, 1, 0] } }]
film = { type = "hdrfilm", width = 16, height = 12 }
[sky]
type = "constant"
radiance = 0.5
[ball]
type = "sphere"
bsdf = { type = "diffuse", reflectance = 1.0 }
"""
LAMP = """
[lamp]
type = "sphere"
center = [1.4, 0.9, 0.0]
radius = 0.3
emitter = { type = "area", radiance = 5.0 }
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "ball.toml"
    path.write_text(SCENE)
    return path


def channels(path: Path) -> tuple[str, ...]:
    return tuple(oiio.ImageBuf(str(path)).spec().channelnames)


@pytest.mark.parametrize(("radius", "told"), [(1.0, False), (9.0, True)], ids=["a ball", "inside of a ball"])
def test_a_picture_without_a_transparent_pixel_says_so(
    radius: float, told: bool, file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file.write_text(f"{SCENE}radius = {radius}\n".replace("bsdf =", "flip_normals = true\nbsdf ="))
    for words in ([], ["--transparent"]):
        assert main(["render", str(file), "-o", str(tmp_path / "a.png"), "--spp", "3", *words]) == 0
        said = "nothing is transparent: surfaces fill the picture" in capsys.readouterr().out
        assert said == (told and bool(words))


def test_a_picture_with_hardly_a_transparent_pixel_says_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["--size", "60x60", "--spp", "4", "--transparent"]
    assert main(["render", "cornell-box", "-o", str(tmp_path / "a.png"), *words]) == 0
    assert re.search(r"^only [0-9.]+ % of the picture is transparent: surfaces", capsys.readouterr().out, re.MULTILINE)


@pytest.mark.parametrize(
    ("pixel_format", "expected"),
    [("rgb", "rgba"), ("rgba", "rgba"), ("luminance", "luminance_alpha"), ("xyz", "xyza"), ("xyza", "xyza")],
)
def test_the_film_gets_alpha_whatever_its_colours(pixel_format: str, expected: str, file: Path) -> None:
    file.write_text(SCENE.replace("width", f'pixel_format = "{pixel_format}", width'))
    scene = et.load(file)
    clear = scene.with_(transparent=True)
    assert clear.model.sensor.film.pixel_format == expected
    assert (scene.transparent, clear.transparent, clear.with_(size=(4, 4)).transparent) == (False, True, True)
    assert clear.with_(transparent=True).digest == clear.digest != scene.digest
    assert clear.warnings == ()


@pytest.mark.parametrize("around", ['type = "path"', 'type = "aov"\naovs = "d:depth"\nimage = { type = "path" }'])
def test_the_sky_is_hidden_by_the_integrator_that_makes_the_image(around: str, file: Path) -> None:
    file.write_text(SCENE.replace('type = "path"\nmax_depth = 3', around))
    assert et.load(file).with_(transparent=True).model.integrator.hides_emitters


def test_lamps_stay_in_sight_unless_there_is_a_sky(file: Path) -> None:
    file.write_text(SCENE + LAMP)
    (warning,) = et.load(file).with_(transparent=True).warnings
    assert "neither sky nor lamps" in warning
    file.write_text(SCENE.replace('[sky]\ntype = "constant"\nradiance = 0.5', "") + LAMP)
    scene = et.load(file)
    clear = scene.with_(transparent=True)
    assert clear.warnings == ()
    assert clear.digest == scene.digest
    first, whole = et.render(scene, spp=4), et.render(clear, spp=8)
    assert np.array_equal(et.render(clear, spp=8, resume=first).image, whole.image), "the same samples"
    assert whole.alpha is not None


def test_the_camera_looks_through_a_lamp_that_is_hidden(file: Path) -> None:
    """A lamp before the ball leaves the ball in the picture, and a lamp before the sky leaves nothing."""
    alphas = []
    for lamp in ("", LAMP, LAMP.replace("[1.4, 0.9, 0.0]", "[0.0, 0.0, 2.0]")):
        file.write_text(SCENE + lamp)
        result = et.render(et.load(file).with_(transparent=True), spp=16, strategy="best,adaptive=none")
        assert result.alpha is not None
        assert result.image[6, 8].max() < 4.0, "the ball, not the lamp"
        alphas.append(result.alpha)
    assert alphas[1] == pytest.approx(alphas[0])
    assert alphas[2] == pytest.approx(alphas[0])


def test_the_ground_of_a_mesh_is_opaque_and_can_be_left_out(tmp_path: Path) -> None:
    path = tmp_path / "a.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    for ground, alpha in ((0.6, 1.0), (0, 0.0)):
        scene = et.load(path, ground=ground).with_(size=(16, 12), transparent=True)
        found = et.render(scene, spp=4).alpha
        assert found is not None
        assert found[0, 0] == alpha


def test_the_words_say_that_the_ground_of_a_mesh_stays(tmp_path: Path) -> None:
    mesh, told = tmp_path / "a.obj", "the ground is a surface, not background: it stays opaque and fills the picture; "
    mesh.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    clear = et.load(mesh).with_(transparent=True)
    assert f"{told}-D ground=0 leaves it out" in clear.warnings
    assert clear.with_(size=(8, 6), transparent=True).warnings == clear.warnings
    assert not any("ground=0" in line for line in et.load(mesh).warnings)
    assert not any("ground=0" in line for line in et.load(mesh, ground=0).with_(transparent=True).warnings)
    model = one_triangle().glb(tmp_path / "a.glb")
    assert not any("ground=0" in line for line in et.load(model).with_(transparent=True).warnings)
    assert any("ground=0" in line for line in et.load(model, ground="0.5").with_(transparent=True).warnings)


def test_the_picture_over_the_sky_is_the_picture_with_the_sky(file: Path) -> None:
    """An opaque ball of albedo 1 under a sky of 0.5 has its radiance, so that colour without alpha is 0.5 anywhere."""
    scene = et.load(file)
    clear = et.render(scene.with_(transparent=True), spp=64, strategy="best,adaptive=none")
    alpha = clear.alpha
    assert alpha is not None
    assert (alpha[0, 0], alpha[6, 8]) == (0.0, 1.0)
    assert (clear.image[alpha == 0.0] == 0.0).all()
    edge = (alpha > 0.2) & (alpha < 0.8)
    assert edge.any()
    assert clear.image[edge].mean(axis=1) / alpha[edge] == pytest.approx(0.5, rel=0.1)
    over = clear.image + 0.5 * (1.0 - alpha[..., None])
    assert over == pytest.approx(et.render(scene, spp=64, strategy="best,adaptive=none").image, abs=0.03)
    twin = et.load(file).with_(transparent=True).replaced(scene.model)  # the sky stays in sight
    assert et.render(twin, spp=4).image[0, 0, 0] == pytest.approx(0.5, rel=1e-3)


def test_the_command_writes_alpha_and_the_render_goes_on(
    file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "a.exr"
    command = ["render", str(file), "-o", str(out), "--transparent"]
    assert main([*command, "--spp", "4"]) == 0
    assert channels(out) == channels(tmp_path / "a.png") == ("R", "G", "B", "A")
    assert main([*command, "--spp", "8", "--resume"]) == 0
    whole = et.render(et.load(file).with_(transparent=True), spp=8)
    assert np.array_equal(et.read(out).image, whole.image)
    assert np.array_equal(np.asarray(et.read(out).alpha), np.asarray(whole.alpha))
    capsys.readouterr()
    assert main(["info", str(out)]) == 0
    again = next(line for line in capsys.readouterr().out.splitlines() if line.startswith("repeat"))
    assert again.endswith("--transparent --seed 0"), "and the scene has not changed"
    assert main(["render", str(file), "-o", str(out), "--spp", "16", "--resume"]) == 2
    assert "it has a transparent background, not an opaque background\n" in capsys.readouterr().err


def test_renders_with_one_background_are_merged(file: Path) -> None:
    scene = et.load(file)
    parts = [et.render(scene.with_(transparent=True), spp=4, seed=seed) for seed in (1, 2)]
    merged = et.merge(parts)
    assert merged.alpha == pytest.approx(np.mean([np.asarray(part.alpha) for part in parts], axis=0), abs=1e-6)
    assert merged.record["transparent"] is True
    with pytest.raises(et.ImageError, match="an opaque background, not a transparent background"):
        et.merge([parts[0], et.render(scene, spp=4, seed=3)])


@pytest.mark.parametrize("name", ["a.jpg", "a.JPEG"])
def test_a_jpeg_cannot_be_transparent(
    name: str, file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["render", str(file), "-o", str(tmp_path / name), "--transparent"]) == 2
    said = "error: Invalid value for --transparent: a JPEG has no transparency: write FILE.png or FILE.exr; "
    said += "`equaltime convert FILE.exr FILE.jpg --background white` then gives a JPEG\n"
    assert capsys.readouterr().err == said
    assert not (tmp_path / name).exists()


def test_a_jpeg_from_python_is_over_black(file: Path, tmp_path: Path) -> None:
    et.render(et.load(file).with_(transparent=True), spp=4).save(tmp_path / "a.jpg", exposure=0.0)
    assert image_files.read(tmp_path / "a.jpg").image[0, 0].max() < 0.02


def test_the_cross_check_has_no_alpha(file: Path) -> None:
    with pytest.raises(et.RenderError, match="makes no alpha"):
        et.render(et.load(file).with_(transparent=True), spp=2, backend="embreex")


def test_a_sample_of_a_transparent_render_is_replayed(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    command: list[Any] = ["replay", str(file), "--pixel", "0,0", "--sample", "1"]
    assert main(command) == 0
    assert "radiance 0.5" in capsys.readouterr().out
    assert main([*command, "--transparent"]) == 0
    assert "radiance 0\n" in capsys.readouterr().out.replace("0 0 0", "0")


def test_the_words_say_that_the_own_ground_of_a_model_stays(tmp_path: Path) -> None:
    told = "the ground is a surface, not background: it stays opaque and fills the picture; "
    model = et.load("windmill")
    way = "to leave out the file's own ground, 'equaltime convert' the file to TOML and delete [table_2] there"
    assert f"{told}{way}" in model.with_(transparent=True).warnings
    assert not any(told in line for line in model.warnings)
    both = et.load("windmill", ground="#804020").with_(transparent=True).warnings
    assert {f"{told}{way}", f"{told}-D ground=0 leaves it out"} <= {*both}
    model.write(tmp_path / "mill.toml")
    edited = et.load(tmp_path / "mill.toml").with_(transparent=True)
    assert edited.warnings[-1].startswith(f"{told}to leave it out, delete it (")
    assert edited.warnings[-1].endswith(": table_2)")
