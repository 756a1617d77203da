"""Inputs that once ended in a traceback are errors with their place."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

import pytest

import equaltime as et
from equaltime.scene.lint import lint


@pytest.mark.parametrize("version", ["\u00b2.0.0", "\u0661.0", "1" * 5000, "3x", ""])
def test_a_version_of_other_digits_or_too_many(tmp_path: Path, version: str) -> None:
    path = tmp_path / "v.xml"
    path.write_text(f"<scene version='{version}'/>")
    with pytest.raises(et.SceneError, match=r"v\.xml:1: <scene> has version"):
        et.load(path)


def test_a_ragged_list_where_an_object_checks_its_values() -> None:
    sensor = {"type": "perspective", "fov": [[1.0], [1.0, 2.0], 3.0]}
    with pytest.raises(et.SceneError, match="fov"):
        et.load_dict({"type": "scene", "sensor": sensor})


def test_lint_of_a_mesh_that_is_scaled_to_infinity(tmp_path: Path) -> None:
    (tmp_path / "t.obj").write_text("v 0 0 0\nv 4 0 0\nv 0 4 0\nf 1 2 3\n")
    path = tmp_path / "s.toml"
    path.write_text(
        'type = "scene"\n[sensor]\ntype = "perspective"\n[mesh]\ntype = "obj"\nfilename = "t.obj"\n'
        "to_world = [{ scale = 1e308 }]\n"
    )
    with pytest.raises(et.SceneError, match="to infinity"):
        lint(et.load(path))


def test_a_black_body_that_is_too_hot(tmp_path: Path) -> None:
    path = tmp_path / "s.xml"
    hot = '<spectrum type="blackbody" name="radiance"><float name="temperature" value="1e300"/></spectrum>'
    path.write_text(f'<scene version="3.0.0">\n<emitter type="constant">\n{hot}</emitter></scene>')
    with pytest.raises(et.SceneError, match=r"s\.xml:3: .*expected finite numbers in a spectrum"):
        et.load(path)


def test_a_film_with_sides_of_hundreds_of_digits() -> None:
    film = {"type": "hdrfilm", "width": 10**300, "height": 10**300}
    with pytest.raises(et.SceneError, match="the limit is"):
        et.load_dict({"type": "scene", "sensor": {"type": "perspective", "film": film}})


def test_lint_of_numbers_that_overflow_prints_no_warnings_of_numpy(tmp_path: Path) -> None:
    (tmp_path / "t.obj").write_text("v 1e200 0 0\nv 4 1e300 0\nv 0 4 -1e250\nf 1 2 3\n")
    path = tmp_path / "s.toml"
    path.write_text(
        'type = "scene"\n[sensor]\ntype = "perspective"\n[mesh]\ntype = "obj"\nfilename = "t.obj"\n'
        'emitter = { type = "area" }\n'
    )
    assert isinstance(lint(et.load(path)), tuple)


def test_numbers_of_a_mesh_that_signal_are_told_without_warnings_of_numpy(tmp_path: Path) -> None:
    numbers = struct.pack("<9I", *[0x7FA00000] * 9)
    body = struct.pack("<I", 0x1000) + b"\0" + struct.pack("<QQ", 3, 1) + numbers + struct.pack("<3I", 0, 1, 2)
    path = tmp_path / "m.serialized"
    path.write_bytes(struct.pack("<HH", 0x041C, 4) + zlib.compress(body) + struct.pack("<QI", 0, 1))
    shape = {"type": "serialized", "filename": str(path)}
    with pytest.raises(et.SceneError, match="finite"):
        et.load_dict({"type": "scene", "sensor": {"type": "perspective"}, "mesh": shape})


@pytest.mark.parametrize("value", ["1" * 400, f"[1, {'1' * 400}, 1]"])
def test_a_variable_with_hundreds_of_digits(tmp_path: Path, value: str) -> None:
    path = tmp_path / "s.toml"
    path.write_text(
        f'[default]\nlarge = {value}\n[sensor]\ntype = "perspective"\n[sky]\ntype = "constant"\nradiance = "$large"\n'
    )
    with pytest.raises(et.SceneError, match=r"s\.toml:7: sky\.radiance: expected a number below 1\.8e308"):
        et.load(path)
