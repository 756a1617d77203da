"""Scenes in XML: one tree, in any of the ways that XML and Mitsuba's elements have to write it."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from random import Random
from typing import Any
from xml.sax.saxutils import escape, quoteattr

import pytest

import equaltime as et
from equaltime.scene import xml_reader, xml_values

from .examples import EVERYDAY, assert_same_pictures, assert_same_scenes, sizes
from .scene_spellings import blanks, decimal


@dataclass
class Element:
    tag: str
    attributes: dict[str, str] = field(default_factory=dict)
    children: list[Element] = field(default_factory=list)


def element(tag: str, *children: Element, **attributes: str) -> Element:
    return Element(tag, attributes, list(children))


def named(tag: str, name: str, value: str) -> Element:
    return element(tag, name=name, value=value)


def plain() -> list[Element]:
    """The contents of a scene with something of everything."""
    placed = [
        element("scale", value="2"),
        element("rotate", x="0.5", y="1", angle="30"),
        element("translate", x="0.5", z="-1"),
    ]
    view = element("lookat", origin="0, 1, 5", target="0, 0, 0", up="0, 1, 0")
    film = element("film", named("integer", "width", "4"), named("integer", "height", "3"), type="hdrfilm")
    red = element("bsdf", named("rgb", "reflectance", "0.8, 0.25, 0.125"), type="diffuse", id='Röt <1> & "2"')
    glow = element("emitter", named("rgb", "radiance", "17, 12.5, 4"), type="area")
    fog = element(
        "medium",
        named("float", "sigma_t", "0.25"),
        named("rgb", "albedo", "0.5, 0.75, 1"),
        type="homogeneous",
        name="interior",
    )
    board = element(
        *("texture", named("rgb", "color0", "0.25, 0.5, 0.75"), named("float", "color1", "0.125")),
        element("transform", element("scale", x="3", y="4"), name="to_uv"),
        **{"type": "checkerboard", "name": "reflectance"},
    )
    return [
        element("integrator", named("integer", "max_depth", "6"), type="volpath"),
        element(
            "sensor", named("float", "fov", "40"), element("transform", view, name="to_world"), film, type="perspective"
        ),
        red,
        element(
            "shape",
            element("transform", *placed, name="to_world"),
            element("ref", id=red.attributes["id"]),
            type="rectangle",
        ),
        element(
            "shape",
            named("float", "radius", "0.75"),
            element("point", name="center", x="0.1", y="0.2", z="0.3"),
            element("bsdf", type="null"),
            fog,
            type="sphere",
        ),
        element(
            "shape", named("boolean", "flip_normals", "true"), glow, element("bsdf", board, type="diffuse"), type="disk"
        ),
        element("emitter", named("rgb", "radiance", "0.5, 0.5, 0.5"), type="constant"),
    ]


NUMBERS = {"float", "scale", "rotate", "translate", "point", "vector"}
VECTORS = {"rgb", "lookat"}
NAMES = {"name", "id", "type", "filename"}


class Writer:
    """Writes elements with spellings of its own."""

    def __init__(self, random: Random, folder: Path, included: bool = False) -> None:
        self.random, self.folder = random, folder
        self.ends = random.choice(["\n", "\r\n", "\r"])
        self.encoding = random.choice(["utf-8", "utf-8", "utf-8-sig", "iso-8859-1", "utf-16"])
        self.variables: dict[str, str] = {}
        self.files, self.is_included = 0, included

    def document(self, contents: list[Element]) -> bytes:
        body = [self.element(each) for each in self.included(contents)]
        declared = "".join(self.element(named("default", name, value)) for name, value in self.variables.items())
        name = {"utf-8-sig": "utf-8"}.get(self.encoding, self.encoding)
        head = (
            f'<?xml version="1.0" encoding="{name}"?>{self.ends}'
            if name != "utf-8" or self.random.random() < 0.5
            else ""
        )
        return f"{head}{self.between()}<scene version='3.0.0'>{declared}{''.join(body)}</scene>{self.between()}".encode(
            self.encoding
        )

    def included(self, contents: list[Element]) -> Iterator[Element]:
        """Move some of what stands in the scene itself to files of its own."""
        for each in contents:
            if self.random.random() < 0.9 or self.variables:
                yield each
                continue
            self.files += 1
            inner = Writer(self.random, self.folder, included=True)
            path = self.folder / f"part{self.files}.xml"
            wrapped = self.random.random() < 0.5
            text = inner.element(each, version=not wrapped)
            text = f'<scene version="2.1.0">{text}</scene>' if wrapped else text
            path.write_bytes(text.encode("utf-8"))
            yield element("include", filename=path.name)

    def element(self, each: Element, version: bool = False) -> str:
        attributes = [(name, self.value(each.tag, name, value)) for name, value in each.attributes.items()]
        attributes += [("version", "3.0.0")] if version else []
        self.random.shuffle(attributes)
        written = "".join(
            f"{blanks(self.random, self.ends, 1)}{name}{self.blank()}={self.blank()}{self.quoted(value)}"
            for name, value in attributes
        )
        children = each.children if each.tag in ("transform", "animation") else self.reordered(each.children)
        inner = "".join(self.between() + self.element(child) for child in children)
        tail = blanks(self.random, self.ends)
        if not inner and self.random.random() < 0.7:
            return f"{self.between()}<{each.tag}{written}{tail}/>"
        return (
            f"{self.between()}<{each.tag}{written}{tail}>{inner}{self.between()}</{each.tag}{blanks(self.random, ' ')}>"
        )

    def blank(self) -> str:
        return blanks(self.random, " ")

    def reordered(self, children: list[Element]) -> list[Element]:
        return self.random.sample(children, len(children))

    def between(self) -> str:
        """Return what means nothing between elements."""
        text = blanks(self.random, self.ends)
        if self.random.random() < 0.1:
            text += self.random.choice(["<!-- <shape type='no'/> & more -->", "<?editor fold?>", "<!---->"])
        return text

    def quoted(self, value: str) -> str:
        if self.encoding == "iso-8859-1" or self.random.random() < 0.1:
            value = "".join(
                c if c.isascii() else f"&#{ord(c)};" if self.random.random() < 0.5 else f"&#x{ord(c):X};"
                for c in escape(value, {'"': "&quot;", "'": "&apos;"})
            )
            return f'"{value}"' if self.random.random() < 0.5 else f"'{value}'"
        return quoteattr(value)

    def value(self, tag: str, name: str, value: str) -> str:
        """Write an attribute's value, or put it into a variable."""
        if name not in NAMES and tag in NUMBERS:
            value = decimal(float(value), self.random)
        elif name not in NAMES and tag in VECTORS:
            between = self.random.choice([", ", ",", " ", "  ", " , ", "\t"])
            value = between.join(decimal(float(word), self.random) for word in value.split(", "))
        elif name not in NAMES and tag == "boolean":
            value = self.random.choice(["true", "True"])
        fixed = self.is_included or tag in ("default", "include") or name in ("name", "id", "version")
        if not fixed and self.random.random() < 0.05:
            variable = f"v{len(self.variables)}"
            self.variables[variable] = value
            return f"${variable}"
        return value


class Plain(Random):
    """Makes none of the choices."""

    def random(self) -> float:
        return 0.99

    def choice(self, seq: Any) -> Any:
        return seq[0]

    def sample(self, population: Any, k: int, **_: Any) -> list[Any]:
        return list(population)[:k]

    def shuffle(self, x: Any) -> None:
        pass


def loaded(folder: Path, contents: list[Element], random: Random) -> et.Scene:
    path = folder / "scene.xml"
    path.write_bytes(Writer(random, folder).document(contents))
    return et.load(path)


@pytest.fixture(scope="module")
def original(tmp_path_factory: pytest.TempPathFactory) -> et.Scene:
    scene = loaded(tmp_path_factory.mktemp("xml"), plain(), Plain())
    assert scene.warnings == ()
    return scene


@sizes
def test_any_spelling_is_the_same_scene(examples: int, original: et.Scene, tmp_path: Path) -> None:
    assert_same_scenes(lambda random: loaded(tmp_path, plain(), random), original, examples)


def test_a_picture_of_another_spelling_has_the_same_bits(original: et.Scene, tmp_path: Path) -> None:
    assert_same_pictures(lambda random: loaded(tmp_path, plain(), random), original)


def numbers(contents: list[Element]) -> Iterator[tuple[Element, str]]:
    for each in contents:
        yield from ((each, name) for name in each.attributes if name not in NAMES and each.tag in NUMBERS | VECTORS)
        yield from numbers(each.children)


def test_a_number_that_is_changed_changes_the_scene(original: et.Scene, tmp_path: Path) -> None:
    """The twin: by a millionth of each number in turn, in any spelling."""
    for place in range(len(list(numbers(plain())))):
        contents = plain()
        each, name = list(numbers(contents))[place]
        words = each.attributes[name].split(", ")
        each.attributes[name] = ", ".join([repr(float(words[0]) + 2**-20), *words[1:]])
        assert loaded(tmp_path, contents, Random(place)).digest != original.digest, (each.tag, name)


PARSED: Any = xml_reader._parsed
FAULTS: dict[str, tuple[str, str, Any]] = {
    "numbers are separated by a comma and a blank": ("xml_values", "_BETWEEN", re.compile(", ")),
    "a name has ASCII letters alone": (
        *("xml_reader", "_parsed"),
        lambda file, content, report: PARSED(file, re.sub(rb"[^ -~\s]", b"?", content), report),
    ),
    "ends of lines are line feeds": (
        *("xml_reader", "_parsed"),
        lambda file, content, report: PARSED(file, content.replace(b"\r", b"|"), report),
    ),
    "attributes are in quotation marks": (
        *("xml_reader", "_parsed"),
        lambda file, content, report: PARSED(file, content.replace(b"'", b"&apos;"), report),
    ),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_is_noticed(fault: str, original: et.Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    module, name, value = FAULTS[fault]
    monkeypatch.setattr({"xml_values": xml_values, "xml_reader": xml_reader}[module], name, value)

    def is_same(seed: int) -> bool:
        try:
            scene = loaded(tmp_path, plain(), Random(seed))
        except et.SceneError:
            return False
        return (scene.digest, scene.warnings) == (original.digest, original.warnings)

    assert not all(is_same(seed) for seed in range(EVERYDAY))
