"""``equaltime replay OUT.exr`` traces the samples of a saved render again, by its record."""

from __future__ import annotations

import json
import re
import shlex
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import equaltime as et
from equaltime.cli import main
from equaltime.cli.replay import ENDS
from equaltime.images import image_files as images
from equaltime.rendering.brightest import Brightest
from equaltime.rendering.render_file import RenderFile

from ..scene.test_frames import KEYS, STANDING

TEXT = """
[default]
light = 0.3
[sensor]
type = "thinlens"
aperture_radius = 0.2
focus_distance = 4
fov = 40
to_world = [{ look_at = { origin = [0, 0, 5], target = [0, 0, 0], up = [0, 1, 0] } }]
film = { type = "hdrfilm", width = 6, height = 4 }
[ball]
type = "sphere"
[lamp]
type = "point"
position = [3, 3, 3]
[sky]
type = "constant"
radiance = "$light"
"""
"""A ball under a lamp and a sky of the radiance ``light``, through a lens."""
PIXEL = ("--pixel", "3,2")


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "scene.toml"
    path.write_text(TEXT)
    return path


def rendered(scene: Path, *options: str, name: str = "a.exr") -> Path:
    """Render the scene by the command line, 4 samples a pixel, into a file beside it; return the file."""
    output = scene.parent / name
    assert main(["render", str(scene), "-o", str(output), "--spp", "4", "-q", *options]) == 0
    return output


def replayed(capsys: pytest.CaptureFixture[str], file: Path, *words: str) -> dict[str, Any]:
    """Return what the command tells of a sample of the pixel 3,2."""
    capsys.readouterr()
    assert main(["replay", str(file), *PIXEL, *words, "--json"]) == 0
    data: dict[str, Any] = json.loads(capsys.readouterr().out)
    return data


def refused(capsys: pytest.CaptureFixture[str], file: Path, *words: str) -> str:
    """Return why the command refuses to replay a sample."""
    assert main(["replay", str(file), *(words if "--pixel" in words else (*PIXEL, *words))]) == 2
    return capsys.readouterr().err


@pytest.mark.parametrize(
    "options",
    [
        ["-D", "light=0.7", "--seed", "7", "--strategy", "mis,roulette=none"],
        ["--size", "12x8", "--crop", "2,1,5,4", "--max-depth", "3"],
        ["--transparent", "--strategy", "best,adaptive=none"],
        ["--without", "lens", "--without", "long_paths=3", "--strategy", "best,adaptive=none"],
    ],
)
def test_the_samples_of_a_pixel_make_the_saved_picture(
    options: list[str], scene: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = rendered(scene, *options)
    paths = [replayed(capsys, file, "--sample", str(index)) for index in range(4)]
    result = et.read(file)
    mean = np.mean([path["radiance"] for path in paths], axis=0)
    window = result.origin.window
    np.testing.assert_allclose(mean, result.image[2 - window.y, 3 - window.x], rtol=1e-5)
    brightest = replayed(capsys, file)
    assert brightest["brightest"]["samples"] == 4, "those of the render, not the 64 of a scene"
    assert sum(brightest["radiance"]) == max(sum(path["radiance"]) for path in paths)


def test_a_frame_is_replayed_at_its_time(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scene = tmp_path / "moving.toml"
    scene.write_text(STANDING + KEYS)
    rendered(scene, "--size", "8x6", "--frames", "0-1", "--fps", "2", "--seed", "5", name="f.exr")
    still = et.load(scene).with_(size=(8, 6), shutter=(0.5, 0.5))
    path = et.replay(still, pixel=(3, 2), sample=1, seed=6)
    told = replayed(capsys, tmp_path / "f_0001.exr", "--sample", "1")
    assert (told["seed"], told["radiance"]) == (6, list(path.radiance))
    assert told["vertices"][0]["surface"] == json.loads(json.dumps(path.vertices[0]["surface"]))
    scene.write_text(STANDING + KEYS.replace("[4, 0, 5]", "[5, 0, 5]"))
    assert "moving.toml, has changed since" in refused(capsys, tmp_path / "f_0001.exr")


def test_of_a_merged_render_the_seed_chooses_the_part(scene: Path, capsys: pytest.CaptureFixture[str]) -> None:
    parts = [rendered(scene, "--seed", str(seed), name=f"{seed}.exr") for seed in (3, 8)]
    both = scene.parent / "both.exr"
    assert main(["merge", *map(str, parts), "-o", str(both)]) == 0
    assert "was rendered with the seeds 3, 8: choose one by --seed" in refused(capsys, both)
    assert "was rendered with the seeds 3, 8: choose one by --seed" in refused(capsys, both, "--seed", "0")
    assert replayed(capsys, both, "--seed", "8") == replayed(capsys, parts[1])
    assert "was rendered with the seed 8, not 3" in refused(capsys, parts[1], "--seed", "3")


def test_a_scene_that_has_changed_or_is_gone_is_told(scene: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = rendered(scene, "-D", "light=0.7", "--size", "8x6", "--crop", "2,1,5,4", "--seed", "9")
    scene.write_text(TEXT.replace("[3, 3, 3]", "[3, 4, 3]"))
    told = refused(capsys, file)
    assert "scene.toml, has changed since" in told
    command = shlex.split(told.partition("; as it is now: ")[2])
    assert command[:2] == ["equaltime", "replay"]
    assert {"--size", "8x6", "light=0.7", "9"} <= {*command}
    assert main(command[1:]) == 0
    scene.unlink()
    assert f"its scene, {scene}, is not there" in refused(capsys, file)


def test_samples_that_were_not_rendered_are_refused(scene: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = rendered(scene)
    assert "--sample: the render has samples 0 to 3 of pixel 3,2" in refused(capsys, file, "--sample", "4")
    assert "pixel 9,9 is not on the film, 6x4 from 0,0" in refused(capsys, file, "--pixel", "9,9")


def test_options_that_the_record_tells_are_refused(scene: Path, capsys: pytest.CaptureFixture[str]) -> None:
    told = refused(capsys, rendered(scene), "--max-depth", "3")
    assert "--max-depth: " in told
    assert "tells this option itself: leave it out, or give the scene file instead" in told


def test_pictures_without_paths_are_refused(scene: Path, capsys: pytest.CaptureFixture[str]) -> None:
    told = refused(capsys, rendered(scene).with_suffix(".png"))
    assert ".png: a picture has no samples to replay; give the EXR file of its render, or the scene" in told
    images.write_exr(scene.parent / "b.exr", np.zeros((4, 6, 3)))
    assert "b.exr: was not rendered by equaltime" in refused(capsys, scene.parent / "b.exr")
    et.render(et.load_dict({"type": "scene", "sensor": {"type": "perspective"}}).with_(size=(6, 4)), spp=1).save(
        scene.parent / "c.exr"
    )
    assert "c.exr: its scene was made in memory: replay it in Python" in refused(capsys, scene.parent / "c.exr")


LONG = """
[integrator]
type = "path"
[sensor]
type = "perspective"
film = { type = "hdrfilm", width = 4, height = 4 }
[room]
type = "sphere"
radius = 3
flip_normals = true
bsdf = { type = "diffuse", reflectance = "$grey" }
[default]
grey = 0.25
"""
"""A closed room without light: paths end by underflow of their throughput."""


def shown(scene: Path, capsys: pytest.CaptureFixture[str], *options: str) -> list[str]:
    """Return the lines on the first sample of a pixel."""
    words = ["replay", str(scene), "--pixel", "1,1", "--sample", "0", "--strategy", "bsdf", *options]
    assert main(words) == 0
    return capsys.readouterr().out.splitlines()


def test_a_long_path_is_cut_unless_all_is_asked_for(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scene = tmp_path / "room.toml"
    scene.write_text(LONG)
    lines, every = shown(scene, capsys), shown(scene, capsys, "-v")
    begin, end = (next(i for i, line in enumerate(lines) if line.startswith(text)) for text in ("1. ", "... "))
    count = sum(line.startswith("   throughput") for line in every)
    assert lines[end] == f"... {count - 15} more (-v shows all)"
    assert sum(line.startswith("   throughput") for line in lines[begin:end]) == 10
    assert sum(line.startswith("   throughput") for line in lines[end:]) == 5
    shorter, whole = (  # they differ by the digits of their numbers alone
        [re.sub(r"[-0-9.e]+", "", line) for line in told[told.index("") + 1 :] if "digits here" not in line]
        for told in (lines, every)
    )
    cut = shorter.index(next(line for line in shorter if "v shows all" in line))
    assert whole[: cut - 1] == shorter[: cut - 1]
    assert whole[cut + 1 - len(shorter) :] == shorter[cut + 1 :]
    short = shown(scene, capsys, "--max-depth", "16")
    assert sum(line.startswith("   throughput") for line in short) == 16, "one hidden vertex would save nothing"


def test_a_path_that_ends_by_underflow_says_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scene = tmp_path / "room.toml"
    scene.write_text(LONG)
    assert [line for line in shown(scene, capsys) if "ends: its throughput becomes 0 by underflow" in line]
    black = shown(scene, capsys, "-D", "grey=0")
    assert [line.strip() for line in black if "ends:" in line] == ["ends: " + ENDS["absorbed"]]


def test_a_roulette_is_told_where_it_may_end_the_path(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scene = tmp_path / "room.toml"
    scene.write_text(LONG)
    assert not [line for line in shown(scene, capsys, "-v") if "Russian roulette" in line]
    words = ("--strategy", "bsdf,roulette=constant,survival=0.5,roulette_depth=1", "-v")
    lines = shown(scene, capsys, *words)
    told = [number for number, line in enumerate(lines) if "Russian roulette" in line]
    assert lines[told[0]].endswith("divided by that number, which keeps the mean right; else it ends"), "the legend"
    assert told[0] < next(number for number, line in enumerate(lines) if line.startswith("1. "))
    assert lines[told[0] + 1] == "survival probability: 0.5 (roulette=constant)"
    assert lines[told[1]] == "     Russian roulette: survival probability 0.5, the path ends"
    assert "   ends: by Russian roulette" in lines
    longer = shown(scene, capsys, *words[:1], "bsdf,roulette=constant,survival=0.999,roulette_depth=1")
    assert "     Russian roulette: survival probability 0.999, the path survives" in longer


@pytest.mark.parametrize(
    ("rule", "formula"),
    [
        ("albedo", "the largest component of the albedo, at most 1 (roulette=albedo)"),
        (
            "throughput",
            "the largest component of throughput · BSDF weight, at most 1; a split or a refraction counts as if",
        ),
    ],
)
def test_the_survival_probability_follows_from_the_formula_in_the_legend(
    rule: str, formula: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    scene = tmp_path / "room.toml"
    scene.write_text(LONG)
    words = ("--strategy", f"bsdf,roulette={rule},roulette_depth=1", "--max-depth", "3", "-D", "grey=[0.2, 0.9, 0.4]")
    lines = shown(scene, capsys, *words, "-v")
    assert [line for line in lines if line.startswith(f"survival probability: {formula}")]
    assert "albedo: the share of the light that is scattered, for each colour" in lines
    assert "BSDF weight: BSDF·cos / pdf of the direction that is drawn; it multiplies the throughput" in lines
    assert float(next(line.split()[4] for line in lines if "roulette: survival" in line).rstrip(",")) == np.float32(0.9)


def test_parts_of_an_obj_file_are_named_by_material(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "a.mtl").write_text("newmtl cloth\nKd 1 0 0\n")
    mesh = tmp_path / "a.obj"
    mesh.write_text("mtllib a.mtl\nv -1 0 0\nv 1 0 0\nv 0 2 0\nusemtl cloth\nf 1 2 3\n")
    assert main(["replay", str(mesh), "--pixel", "16,12", "--size", "32x24"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert any("meets the front of 'cloth' (obj, " in line for line in lines)


LAMP = """
[sensor]
type = "perspective"
fov = 20
film = { type = "hdrfilm", width = 4, height = 4 }
to_world = [{ look_at = { origin = [0, 0, 4], target = [0, 0, 0], up = [0, 1, 0] } }]
[default]
surface = "diffuse"
[wall]
type = "rectangle"
bsdf = { type = "twosided", bsdf = { type = "$surface" } }
[lamp]
type = "sphere"
center = [0, 0, 3]
radius = 0.5
emitter = { type = "area", radiance = 2.0 }
"""
"""A wall before the camera, and a lamp that the camera sees or, farther behind, that it does not see."""


def told_of_lamp(tmp_path: Path, capsys: pytest.CaptureFixture[str], strategy: str, *options: str, z: int = 3) -> str:
    """Return what the command tells of the brightest sample of a pixel, with the lamp's centre at this z."""
    scene = tmp_path / "lamp.toml"
    scene.write_text(LAMP.replace("[0, 0, 3]", f"[0, 0, {z}]"))
    words = ["replay", str(scene), "--pixel", "1,1", "--spp", "64", "--max-depth", "2", "--strategy", strategy]
    assert main([*words, *options]) == 0
    return capsys.readouterr().out


@pytest.mark.parametrize(
    ("strategy", "z", "words"),
    [
        ("bsdf", 3, "MIS weight 1 (this strategy does not aim at this light)"),
        ("mis", 3, "MIS weight 1 (the camera's ray: no light is aimed at from the camera)"),
        ("mis", 6, "MIS weight 1 (the ray's direction is discrete: no light sample has it)"),
    ],
)
def test_a_full_weight_has_its_reason(
    strategy: str, z: int, words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert words in told_of_lamp(tmp_path, capsys, strategy, "-D", "surface=conductor", z=z)


@pytest.mark.parametrize(("strategy", "power"), [("best,lights=uniform", 2), ("mis", 1)])
def test_the_weight_follows_from_the_pdfs_in_the_lines_by_the_formula_in_the_legend(
    strategy: str, power: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    told = told_of_lamp(tmp_path, capsys, strategy, "-v", "-D", "surface=roughconductor", z=6)
    light, bsdf = (float(re.findall(rf"{name} pdf ([0-9][0-9.e+-]*)", told)[0]) for name in ("light", "BSDF"))
    (weight,) = (float(number) for number in re.findall(r"MIS weight ([0-9.e-]+)$", told, re.MULTILINE))
    assert weight == pytest.approx(light**power / (light**power + bsdf**power), rel=1e-5)
    assert 0.0 < weight < 1.0
    square = "²" if power == 2 else ""
    assert f"heuristic): light pdf{square} / (light pdf{square} + BSDF pdf{square}) of a picked light" in told
    assert "light pdf: of light sampling, with the probability of the pick" in told
    assert "both per steradian" in told


def test_a_light_that_only_aiming_finds_says_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    aimed = told_of_lamp(tmp_path, capsys, "light", z=6)
    assert "MIS weight 1 (only aiming finds this light)" in aimed
    assert "heuristic" not in aimed
    scene = tmp_path / "point.toml"
    scene.write_text(LAMP.partition("[lamp]")[0] + '[lamp]\ntype = "point"\nposition = [0, 0, 3]\n')
    told = "\n".join(shown(scene, capsys, "--strategy", "mis"))
    assert "light pdf 1 (a discrete direction: the probability of the pick)" in told
    assert "MIS weight 1 (only aiming finds this light)" in told


def test_uniform_directions_have_a_pdf_of_that_name(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    told = told_of_lamp(tmp_path, capsys, "naive", z=6)
    assert "uniform pdf: of a direction drawn uniformly, per steradian" in told
    assert ", uniform pdf 0.15915, BSDF weight " in told


def test_a_bsdf_of_0_has_its_reason(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    told = told_of_lamp(tmp_path, capsys, "light", z=-6)
    assert "  BSDF 0, as the light is behind the surface: adds nothing" in told


def test_a_vertex_that_no_light_can_reach_says_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The twins: uniform picks do not know where lamps are, mirrors do not aim, and neither does the strategy bsdf."""
    words = "picks no light: none can shine on this side"
    scene, behind = tmp_path / "lamps.toml", LAMP.replace("[0, 0, 3]", "[0, 0, -6]")
    scene.write_text(f"{behind}{behind.partition('[lamp]')[2].join(('[other]', ''))}")

    def told(strategy: str, surface: str = "diffuse") -> list[str]:
        return shown(scene, capsys, "--strategy", strategy, "-D", f"surface={surface}")

    assert f"   {words}" in told("best")
    for other in (told("best,lights=uniform"), told("best", "conductor"), told("bsdf")):
        assert f"   {words}" not in other


def test_the_legend_comes_first_and_explains_what_occurs(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    told = told_of_lamp(tmp_path, capsys, "light", z=-6)
    legend = told.partition("\n1. ")[0]
    assert "a picked light adds throughput" in legend
    assert "primitive: the number of the triangle" in legend
    assert "a picked light" not in told_of_lamp(tmp_path, capsys, "bsdf", z=-6)


def test_numbers_have_every_digit_with_v_alone(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    short, every = (told_of_lamp(tmp_path, capsys, "mis", *more, z=6) for more in ([], ["-v"]))
    shown, whole = (re.findall(r"^radiance 0\.0*([0-9]+) ", text, re.MULTILINE) for text in (short, every))
    assert [len(digits) for digits in shown] == [5]
    assert [len(digits) for digits in whole] >= [8]
    assert shown[0][:4] == whole[0][:4]
    assert "all of theirs with -v" in short
    assert "all of theirs with -v" not in every


def test_only_bright_samples_lead_to_advice_on_bright_dots(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    advice = "scenes/render/README.md, When the error is in doubt"
    assert told_of_lamp(tmp_path, capsys, "bsdf", z=6).rstrip().endswith(advice), "the lamp is found by chance"
    assert advice not in told_of_lamp(tmp_path, capsys, "light", z=6), "each sample finds it"
    assert advice not in told_of_lamp(tmp_path, capsys, "light", z=-6), "all samples are black"
    dots = [Brightest(0, 4, luminance, mean).stands_out for luminance, mean in ((9.0, 1.0), (10.0, 1.0), (2.0, 0.0))]
    assert dots == [False, True, True]
    assert Brightest(3, 4, float("nan"), 1.0).stands_out
    assert not Brightest(0, 1, 5.0, float("nan")).stands_out


def test_only_a_path_that_splits_has_copies(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "copy of the path" not in told_of_lamp(tmp_path, capsys, "mis", z=6)


def test_numbers_of_another_version_are_refused(scene: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = rendered(scene, "--strategy", "best,sampler=sobol")
    saved = RenderFile.read(file)
    replace(saved, record={**saved.record, "numbers": 1}).write(file)
    assert "has random numbers of version 1, not 2, so that its paths cannot be replayed" in refused(capsys, file)
