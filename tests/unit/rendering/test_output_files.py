"""What outputs may replace: no file of the scene, no other's file, and no long work without keeping it."""

from __future__ import annotations

import os
import socket
import stat
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio  # noqa: N813
import pytest

import equaltime as et
from equaltime import files as disk
from equaltime.cli import main
from equaltime.images import image_files as images
from equaltime.rendering import output_files
from equaltime.rendering.output_files import replaced
from equaltime.rendering.render_file import read_picture, read_record

HEAD = """
[sensor]
type = "perspective"
film = { type = "hdrfilm", width = 6, height = 4 }
[sky]
type = "constant"
"""
OPTIONS = ("--spp", "2", "-q")


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    file = tmp_path / "scene.toml"
    file.write_text(HEAD)
    return file


def refused(words: str, arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    """Check that a command ends with this complaint alone."""
    assert main(arguments) == 2
    said = capsys.readouterr()
    assert words in said.err
    assert said.err.count("\n") == 1
    assert said.out == ""


def pipe(path: Path) -> None:
    os.mkfifo(path)


def listening(path: Path) -> None:
    with socket.socket(socket.AF_UNIX) as one:
        one.bind(str(path))


def device(path: Path) -> None:
    path.symlink_to("/dev/null")


@pytest.mark.parametrize("make", [pipe, listening, device])
@pytest.mark.parametrize("name", ["out.exr", "out.png"])
def test_what_is_no_file_is_refused_and_not_replaced(
    scene: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    make: Callable[[Path], None],
    name: str,
) -> None:
    monkeypatch.chdir(scene.parent)  # names of sockets are short
    make(Path(name))
    before = Path(name).stat()
    refused("is a pipe, a socket or a device, and no file", ["render", "scene.toml", "-o", "out.exr", *OPTIONS], capsys)
    with pytest.raises(OSError, match="no file"), disk.replacing(Path(name)):
        pass
    assert os.path.samestat(Path(name).stat(), before)


@pytest.mark.parametrize("mode", [0o600, 0o640, 0o444])
def test_a_file_keeps_its_mode(scene: Path, tmp_path: Path, mode: int) -> None:
    output = tmp_path / "out.exr"
    command = ["render", str(scene), "-o", str(output), *OPTIONS]
    assert main(command) == 0
    for file in (output, output.with_suffix(".png")):
        file.chmod(mode)
    assert main(command) == 0
    for file in (output, output.with_suffix(".png")):
        assert stat.S_IMODE(file.stat().st_mode) == mode


def with_include(folder: Path) -> tuple[Path, Path]:
    (folder / "part.toml").write_text('[sky]\ntype = "constant"\n')
    (folder / "whole.toml").write_text('include = "part.toml"\n' + HEAD.split("[sky]")[0])
    return folder / "whole.toml", folder / "part.toml"


def with_spectrum(folder: Path) -> tuple[Path, Path]:
    (folder / "light.spd").write_text("400 1\n700 1\n")
    (folder / "whole.xml").write_text(
        '<scene version="3.0.0"><sensor type="perspective"><film type="hdrfilm"><integer name="width" value="6"/>'
        '<integer name="height" value="4"/></film></sensor><emitter type="constant">'
        '<spectrum name="radiance" filename="light.spd"/></emitter></scene>'
    )
    return folder / "whole.xml", folder / "light.spd"


def with_library(folder: Path) -> tuple[Path, Path]:
    (folder / "red.mtl").write_text("newmtl red\nKd 1 0 0\n")
    (folder / "whole.obj").write_text("mtllib red.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\n")
    return folder / "whole.obj", folder / "red.mtl"


def with_buffer(folder: Path) -> tuple[Path, Path]:
    np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32).tofile(folder / "data.bin")
    (folder / "whole.gltf").write_text(
        '{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],'
        '"meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}], "buffers": [{"uri": "data.bin", '
        '"byteLength": 36}], "bufferViews": [{"buffer": 0, "byteLength": 36}], "accessors": [{"bufferView": 0, '
        '"componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}]}'
    )
    return folder / "whole.gltf", folder / "data.bin"


@pytest.mark.parametrize(
    "made", [with_include, with_spectrum, with_library, with_buffer, lambda f: (f / "scene.toml",) * 2]
)
@pytest.mark.parametrize("link", ["out.exr", "out.png"])
@pytest.mark.parametrize("tie", [os.symlink, os.link])
def test_no_output_takes_the_place_of_a_file_that_the_scene_was_read_from(
    scene: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    made: Callable[[Path], tuple[Path, Path]],
    link: str,
    tie: Callable[[Path, Path], None],
) -> None:
    whole, part = made(tmp_path)
    assert part in et.load(whole).files
    tie(part, tmp_path / link)
    before = part.read_bytes()
    command = ["render", str(whole), "-o", str(tmp_path / "out.exr"), *OPTIONS, "--overwrite"]
    refused(f"{tmp_path / link}: the scene is made of this file", command, capsys)
    with pytest.raises(et.ImageError, match="the scene is made of"):
        et.render(et.load(whole), spp=2, checkpoint=tmp_path / "out.exr")
    assert part.read_bytes() == before


@pytest.mark.parametrize(
    "change", [[], ["--size", "9x3"], ["--crop", "0,0,2,2"], ["--strategy", "naive"], ["--seed", "5"]]
)
def test_a_render_of_the_same_scene_file_is_replaced(scene: Path, tmp_path: Path, change: list[str]) -> None:
    command = ["render", str(scene), "-o", str(tmp_path / "out.exr"), *OPTIONS]
    assert main(command) == 0
    scene.write_text(HEAD + "radiance = 2.0\n")
    assert main([*command, *change]) == 0
    assert read_picture(tmp_path / "out.exr").image.mean() > 1.9


@pytest.mark.parametrize("name", ["out.exr", "out.png"])
def test_another_scene_or_program_is_not_replaced_unless_that_is_asked_for(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str
) -> None:
    output = tmp_path / name
    other = tmp_path / "other.toml"
    other.write_text(HEAD + "radiance = 3.0\n")
    assert main(["render", str(other), "-o", str(output), *OPTIONS]) == 0
    command = ["render", str(scene), "-o", str(output), *OPTIONS]
    words = f"{output}: is there already, a render of another scene ({other}); --overwrite replaces it"
    refused(words, command, capsys)
    output.unlink()
    images.write(output, "openexr" if name == "out.exr" else "png", [images.Layer(images.RGB, photo(name), {})])
    refused(
        f"{output}: is there already, and does not say that equaltime made it; --overwrite replaces it", command, capsys
    )
    output.write_bytes(b"a diary")
    refused("does not say that equaltime made it", command, capsys)
    assert output.read_bytes() == b"a diary"
    assert main([*command, "--overwrite"]) == 0


def test_a_render_of_another_scene_is_not_resumed_and_is_named_with_the_way_out(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    output, other = tmp_path / "out.exr", tmp_path / "other.toml"
    other.write_text(HEAD + "radiance = 3.0\n")
    assert main(["render", str(other), "-o", str(output), *OPTIONS]) == 0
    command = ["render", str(scene), "-o", str(output), *OPTIONS]
    how = "--overwrite without --resume replaces it"
    words = f"error: {output}: is there already, a render of another scene ({other}); {how}"
    refused(words, [*command, "--resume"], capsys)
    refused("cannot be resumed: it has another scene", [*command, "--resume", "--overwrite"], capsys)
    assert main([*command, "--overwrite"]) == 0


def in_memory(radiance: float = 1.0, size: tuple[int, int] = (6, 4)) -> et.Scene:
    film = {"type": "hdrfilm", "width": size[0], "height": size[1]}
    sky = {"type": "constant", "radiance": radiance}
    return et.load_dict({"type": "scene", "sensor": {"type": "perspective", "film": film}, "sky": sky})


@pytest.mark.parametrize("name", ["out.exr", "out.png"])
def test_a_render_of_a_scene_made_in_memory_is_not_replaced_by_one_of_a_file(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str
) -> None:
    output = tmp_path / name
    et.render(in_memory(3.0), spp=2).save(output)
    before = output.read_bytes()
    command = ["render", str(scene), "-o", str(output), *OPTIONS]
    words = "is there already, a render of a scene made in memory, maybe another one; --overwrite replaces it"
    refused(f"{output}: {words}", command, capsys)
    assert output.read_bytes() == before
    assert main([*command, "--overwrite"]) == 0
    assert output.read_bytes() != before


@pytest.mark.parametrize("name", ["out.exr", "out.png"])
@pytest.mark.parametrize("small", [False, True])
def test_saving_a_result_keeps_renders_of_other_scenes(scene: Path, tmp_path: Path, name: str, small: bool) -> None:
    output = tmp_path / name
    kept = tmp_path / f"{name}~"
    of_file, of_dict = et.render(scene, spp=4), et.render(in_memory(3.0), spp=4)
    of_file.save(output, small)
    before = output.read_bytes()
    assert kept in of_dict.save(output, small)
    assert kept.read_bytes() == before
    kept.unlink()
    et.render(in_memory(3.0), spp=8).save(output, small, aov=["variance"])
    et.render(in_memory(2.0), spp=4).save(output, small, overwrite=True)
    assert not kept.exists()
    before = output.read_bytes()
    of_file.save(output, small)
    assert kept.read_bytes() == before


def test_a_checkpoint_replaces_renders_of_its_scene_alone(scene: Path, tmp_path: Path) -> None:
    output = tmp_path / "out.exr"
    et.render(scene, spp=2).save(output)
    words = "is there already, a render of "
    with pytest.raises(et.ImageError, match=rf"{words}another scene \({scene}\); overwrite=True replaces it"):
        et.render(in_memory(3.0), spp=4, checkpoint=output)
    et.render(in_memory(3.0), spp=2, checkpoint=output, overwrite=True).save(output, overwrite=True)
    et.render(in_memory(3.0), spp=2, checkpoint=output)
    with pytest.raises(et.ImageError, match=f"{words}a scene made in memory, maybe another one; overwrite=True"):
        et.render(scene, spp=2, checkpoint=output)


def photo(name: str) -> Any:
    return np.ones((2, 2, 3), np.float32 if name == "out.exr" else np.uint8)


def test_merging_replaces_a_merge_of_the_same_scene_and_nothing_else(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    files = [str(tmp_path / f"{seed}.exr") for seed in range(2)]
    for seed, file in enumerate(files):
        assert main(["render", str(scene), "-o", file, "--seed", str(seed), *OPTIONS]) == 0
    merging = ["merge", *files, "-o", str(tmp_path / "both.exr")]
    assert [main(merging), main(merging)] == [0, 0]
    capsys.readouterr()
    (tmp_path / "both.png").write_bytes(b"a diary")
    refused("does not say that equaltime made it", merging, capsys)


def seconds(path: Path, result: et.Result, seconds: float, **origin: Any) -> et.Result:
    """Save a result as if it had taken so long."""
    phases = {**result.stats.phases, "render": seconds}
    found = replace(result, stats=replace(result.stats, phases=phases), origin=replace(result.origin, **origin))
    found.save(path)
    return found


def test_more_than_a_minute_of_rendering_is_kept_beside(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, result = tmp_path / "out.exr", et.render(scene, spp=2)
    seconds(path, result, 59.0)
    assert result.save(path) == (path, tmp_path / "out.png"), "less is not"
    long = seconds(path, result, 61.0)
    command = ["render", str(scene), "-o", str(path), "--spp", "2"]
    assert main([*command, "--seed", "3"]) == 0
    assert f"the render that was there is kept as {path}~" in capsys.readouterr().out
    kept = tmp_path / "out.exr~"
    assert read_picture(kept).record["seconds"] == 61.0
    np.testing.assert_array_equal(read_picture(kept).image, long.image)
    seconds(path, result, 500.0)
    assert result.save(path)[:2] == (path, tmp_path / "out.png"), "one that has all its samples loses nothing"
    assert read_picture(kept).record["seconds"] == 61.0
    seconds(path, result, 500.0)
    assert main(["render", str(scene), "-o", str(path), "--spp", "1", "-q"]) == 0
    assert read_picture(kept).record["seconds"] == 500.0, "one backup"


def test_what_a_checkpoint_keeps_is_told_at_the_end(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, kept = tmp_path / "out.exr", tmp_path / "out.exr~"
    seconds(path, et.render(scene, spp=2), 61.0)
    command = ["render", str(scene), "-o", str(path), "--checkpoint", "10ms", "--time", "1s", "--seed"]
    assert main([*command, "3"]) == 0
    assert f"the render that was there is kept as {kept}" in capsys.readouterr().out.splitlines()
    assert read_picture(kept).record["seconds"] == 61.0
    assert main([*command, "3"]) == 0
    assert "is kept as" not in capsys.readouterr().out, "an older copy is none of this render's"


def test_a_long_render_is_kept_also_where_its_preview_is_no_render(scene: Path, tmp_path: Path) -> None:
    path, result = tmp_path / "out.exr", et.render(scene, spp=2)
    seconds(path, result, 61.0)
    (tmp_path / "out.png").write_bytes(b"a diary")
    kept = et.render(scene, spp=2, seed=1).save(path)[2:]
    assert kept == (tmp_path / "out.png~", tmp_path / "out.exr~")
    assert kept[0].read_bytes() == b"a diary"
    assert read_picture(kept[1]).record["seconds"] == 61.0


@pytest.mark.parametrize("name", ["out.png", "out.jpg"])
def test_a_picture_of_another_render_is_kept(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str
) -> None:
    path, kept = tmp_path / name, tmp_path / f"{name}~"

    def told(*options: str) -> list[str]:
        assert main(["render", str(scene), "-o", str(path), *options]) == 0
        return [line for line in capsys.readouterr().out.splitlines() if "was there" in line]

    assert told("--spp", "2") == []
    assert told("--spp", "4") == []  # it has all samples of the earlier picture
    assert told("--spp", "4", "--exposure", "1") == []
    assert not kept.exists()
    for change in (["--spp", "2"], ["--spp", "2", "--seed", "5"], ["--spp", "2", "--size", "3x2"]):
        before = path.read_bytes()
        assert told(*change) == [f"the render that was there is kept as {kept}"]
        assert kept.read_bytes() == before
    scene.write_text(HEAD + "radiance = 2.0\n")
    assert told("--spp", "9") == [f"the render that was there is kept as {kept}"]


def test_a_preview_goes_with_its_own_exr_alone(scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    output, preview, kept = tmp_path / "out.exr", tmp_path / "out.png", tmp_path / "out.png~"

    def told(path: Path, *options: str) -> list[str]:
        assert main(["render", str(scene), "-o", str(path), *options]) == 0
        return [line for line in capsys.readouterr().out.splitlines() if "was there" in line]

    assert told(output, "--spp", "2") == []
    assert told(output, "--spp", "8", "--resume") == []
    assert [line.split(" is ")[1].split(",")[0] for line in told(output, "--spp", "2", "--seed", "3")] == ["replaced"]
    assert not kept.exists()
    own = preview.read_bytes()
    assert told(preview, "--spp", "2", "--seed", "4") == [f"the render that was there is kept as {kept}"]
    assert kept.read_bytes() == own
    other = preview.read_bytes()
    assert told(output, "--spp", "4", "--seed", "3", "--resume") == [f"the render that was there is kept as {kept}"]
    assert kept.read_bytes() == other


@pytest.mark.parametrize("name", ["out.exr", "out.png"])
@pytest.mark.parametrize("transparent", [False, True])
def test_an_edited_picture_is_not_replaced(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str, transparent: bool
) -> None:
    preview, change = tmp_path / "out.png", ["--transparent"] * transparent
    command = ["render", str(scene), "-o", str(tmp_path / name), *OPTIONS, *change]
    assert main(command) == 0
    assert main(command) == 0
    edited = oiio.ImageBuf(str(preview))  # which keeps all texts
    edited.setpixel(0, 0, (0.1, 0.2, 0.3, 0.4)[: edited.nchannels])
    assert edited.write(str(preview))
    before = preview.read_bytes()
    for more in [[], ["--resume"]] if name == "out.exr" else [[]]:
        refused(f"{preview}: is there already, and was edited since equaltime wrote it", [*command, *more], capsys)
    result = et.render(scene, spp=2)
    assert preview.with_name("out.png~") in result.save(tmp_path / name)
    assert preview.with_name("out.png~").read_bytes() == before
    preview.write_bytes(before)
    assert main([*command, "--overwrite"]) == 0
    assert preview.read_bytes() != before


def test_a_short_render_is_not_replaced_silently(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A render that has all its samples loses nothing."""
    path = tmp_path / "out.exr"

    def told(*options: str) -> str:
        assert main(["render", str(scene), "-o", str(path), *options]) == 0
        return next((line for line in capsys.readouterr().out.splitlines() if "was there" in line), "")

    before = "the render that was there is replaced, as it took less than a minute: "
    assert told("--spp", "2", "--size", "4x4") == ""
    other = ("--size", "4x4", "--seed", "3")
    assert told("--spp", "2", *other) == f"{before}4x4, 2 samples a pixel, strategy best, seed 0"
    assert told("--spp", "4", *other) == ""
    assert told("--spp", "8", *other, "--resume") == ""
    assert told("--spp", "4", "--size", "4x4") == f"{before}4x4, 8 samples a pixel, strategy best, seed 3"
    assert not path.with_name("out.exr~").exists()
    old = {"digest": "", "seconds": 1.0, "spp": 32.7628125}
    assert replaced(path, {"digest": ""}, old) == f"{before}, 33 samples a pixel, strategy None, seed None"


def test_a_short_render_of_an_edited_scene_is_kept(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """No command can make it again; but a longer render that was kept is worth more."""
    path, kept = tmp_path / "out.exr", tmp_path / "out.exr~"
    command = ["render", str(scene), "-o", str(path), "--spp", "2"]
    assert main(command) == 0
    first = path.read_bytes()
    scene.write_text(scene.read_text() + "radiance = 0.5\n")
    assert main(command) == 0
    assert kept.read_bytes() == first
    assert "out.exr~" in capsys.readouterr().out
    seconds(path, et.render(scene, spp=2), 61.0, seed=5)
    long = path.read_bytes()
    assert main([*command, "--size", "4x4"]) == 0
    capsys.readouterr()
    assert main([*command, "--size", "8x4"]) == 0
    assert kept.read_bytes() == long
    words = "is replaced, as it took less than a minute, and out.exr~, which stays, more: 4x4, 2 samples a pixel"
    assert words in capsys.readouterr().out


def test_a_finished_render_is_not_lost_to_one_that_ends_early(scene: Path, tmp_path: Path) -> None:
    path, kept, result = tmp_path / "out.exr", tmp_path / "out.exr~", et.render(scene, spp=2)
    new = et.render(scene, spp=2, seed=1)
    for end in ("interrupt", "unfinished", "nonfinite", "faulty"):
        seconds(path, result, 20.0)
        finished = path.read_bytes()
        early = replace(new, stopped_by=end)
        record = {**early.record, "seconds": 3.0}
        assert replaced(path, record, read_record(path)) == "", "kept, so not lost"
        seconds(path, early, 3.0)
        assert kept.read_bytes() == finished
        seconds(path, replace(early, origin=replace(new.origin, seed=2)), 1.0)
        assert kept.read_bytes() == finished, "one that ended early is not kept in place of the finished one"
        kept.unlink()
    seconds(path, result, 20.0)
    seconds(path, early, 21.0)
    assert not kept.exists(), "one that took longer replaces it, as a finished one does"


def test_a_finished_render_that_a_checkpoint_keeps_is_not_called_replaced(
    scene: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, kept = tmp_path / "out.exr", tmp_path / "out.exr~"
    seconds(path, et.render(scene, spp=2), 0.3)
    command = ["render", str(scene), "-o", str(path), "--checkpoint", "10ms", "--time", "1s", "--seed", "3"]
    assert main(command) == 0
    told = [line for line in capsys.readouterr().out.splitlines() if "was there" in line]
    assert told == [f"the render that was there is kept as {kept}"]


def test_a_render_that_cannot_be_kept_is_not_replaced(
    scene: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, result = tmp_path / "out.exr", et.render(scene, spp=2)
    seconds(path, result, 100.0)
    before = path.read_bytes()
    monkeypatch.setattr(output_files, "replacing", lambda path: disk.replacing(path / "none" / "x"))
    with pytest.raises(et.ImageError, match="100 s of rendering would be lost"):
        et.render(scene, spp=2, seed=1).save(path)
    assert path.read_bytes() == before


def test_the_checkpoints_of_one_render_are_no_work_to_keep(scene: Path, tmp_path: Path) -> None:
    path = tmp_path / "out.exr"
    seconds(path, et.render(scene, spp=2), 100.0, seed=7)
    et.render(et.load(scene).with_(size=(64, 64)), spp=64, checkpoint=path, checkpoint_every=1e-6).save(path)
    assert {file.name for file in tmp_path.iterdir()} == {"scene.toml", "out.exr", "out.png", "out.exr~"}
    assert read_picture(tmp_path / "out.exr~").record["seed"] == 7
