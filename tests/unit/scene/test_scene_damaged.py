"""Damaged files: whatever is done to a scene file, reading it ends with a scene or with problems, never otherwise."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from equaltime import SceneError
from equaltime.scene.report import Report
from equaltime.scene.resolve import resolve
from equaltime.scene.scene import Reader
from equaltime.scene.search import Search
from equaltime.scene.toml_reader import read_toml
from equaltime.scene.xml_reader import read_xml

SCENES = Path(__file__).parents[3] / "scenes"
XML = (SCENES / "mitsuba" / "veach-mis" / "scene.xml").read_bytes()
TOML = (SCENES / "veach-mis.toml").read_bytes()
JUNK = [
    b"",
    b"<",
    b">",
    b'"',
    b"=",
    b"[",
    b"]",
    b"{",
    b"}",
    b"$",
    b"$x",
    b"\n",
    b"\x00",
    b"\xff",
    b"nan",
    b"1e999",
    b"-1",
]


def check(reader: Reader, content: bytes) -> None:
    report = Report()
    root = reader("scene", content, {"integrator": "path"} if reader is read_xml else {}, report, Search(Path()))
    model = None if root is None else resolve(root, report).model
    try:
        report.raise_if_any()
    except SceneError as error:
        for problem in error.problems:
            assert problem.place.startswith("scene")
    else:
        assert model is not None


@pytest.mark.parametrize(("reader", "content"), [(read_xml, XML), (read_toml, TOML)])
@given(data=st.data())
def test_a_damaged_file_gives_problems_or_a_scene(reader: Reader, content: bytes, data: st.DataObject) -> None:
    for _ in range(data.draw(st.integers(1, 3))):
        start = data.draw(st.integers(0, len(content)))
        end = data.draw(st.integers(start, min(len(content), start + 40)))
        content = content[:start] + data.draw(st.sampled_from(JUNK) | st.binary(max_size=6)) + content[end:]
    check(reader, content)


@pytest.mark.parametrize(("reader", "content"), [(read_xml, XML), (read_toml, TOML)])
@given(data=st.data())
def test_a_truncated_file_gives_problems_or_a_scene(reader: Reader, content: bytes, data: st.DataObject) -> None:
    check(reader, content[: data.draw(st.integers(0, len(content)))])


@pytest.mark.parametrize("encoding", ["foo", "utf-7", "idna", "utf-16", "latin-1", "base64", "shift_jis"])
def test_any_declared_encoding_gives_problems_or_a_scene(encoding: str) -> None:
    check(read_xml, f'<?xml version="1.0" encoding="{encoding}"?>\n<scene version="3.0.0"/>'.encode())


@given(content=st.binary(max_size=200))
def test_bytes_that_are_no_scene_give_problems(content: bytes) -> None:
    check(read_xml, content)
    check(read_toml, content)
