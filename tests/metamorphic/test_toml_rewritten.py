"""Scenes in TOML: one tree of tables, in any of the ways that TOML has to write it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from random import Random
from typing import Any

import pytest

import equaltime as et
from equaltime.scene import toml_reader

from .examples import EVERYDAY, assert_same_pictures, assert_same_scenes, sizes
from .scene_spellings import decimal

Table = dict[str, Any]


def plain() -> Table:
    """The contents of a scene with something of everything."""
    placed = [{"scale": 2.0}, {"rotate": {"axis": [0.5, 1.0, 0.0], "angle": 30.0}}, {"translate": [0.5, 0.0, -1.0]}]
    view = {"look_at": {"origin": [0.0, 1.0, 5.0], "target": [0.0, 0.0, 0.0], "up": [0.0, 1.0, 0.0]}}
    fog = {"type": "homogeneous", "sigma_t": 0.25, "albedo": {"type": "rgb", "value": [0.5, 0.75, 0.9]}}
    board = {
        "type": "checkerboard",
        "color0": [0.25, 0.5, 0.75],
        "color1": 0.125,
        "to_uv": [{"scale": [3.0, 4.0, 1.0]}],
    }
    return {
        "integrator": {"type": "volpath", "max_depth": 6},
        "sensor": {
            "type": "perspective",
            "fov": 40.0,
            "to_world": [view],
            "film": {"type": "hdrfilm", "width": 16, "height": 12},
        },
        'Röt <1> & "2"\\': {"type": "diffuse", "reflectance": [0.8, 0.25, 0.125]},
        "floor": {"type": "rectangle", "to_world": placed, "bsdf": {"type": "ref", "id": 'Röt <1> & "2"\\'}},
        "ball": {
            "type": "sphere",
            "radius": 0.75,
            "center": [0.1, 0.2, 0.3],
            "bsdf": {"type": "null"},
            "interior": fog,
        },
        "lamp": {
            "type": "disk",
            "flip_normals": True,
            "emitter": {"type": "area", "radiance": [17.0, 12.5, 4.0]},
            "bsdf": {"type": "diffuse", "reflectance": board},
        },
        "sky": {"type": "constant", "radiance": 0.5},
    }


class Writer:
    """Writes tables with spellings of its own."""

    def __init__(self, random: Random) -> None:
        self.random = random
        self.ends = random.choice(["\n", "\r\n"])
        self.variables: dict[str, str] = {}

    def document(self, scene: Mapping[str, Any]) -> bytes:
        body = self.table((), scene)
        declared = "".join(f"default.{name} = {value}{self.ends}" for name, value in self.variables.items())
        text = self.random.choice(["", "\ufeff"]) + self.idle() + declared + body
        return text.encode()

    def table(self, path: tuple[str, ...], content: Mapping[str, Any]) -> str:
        """Write the entries of a table: plain ones first, then those that get a header of their own."""
        entries = list(content.items())
        if path:  # the order of what stands in the scene itself is that of its shapes
            self.random.shuffle(entries)
        below = [name for name, value in entries if isinstance(value, dict) and self.random.random() < 0.6]
        if not path:
            below = [name for name, _ in entries]
        text = ""
        for name, value in entries:
            if name in below:
                continue
            if isinstance(value, dict) and self.random.random() < 0.5:
                text += self.dotted((name,), value)
            else:
                text += self.entry(self.key(name), self.value(value))
        for name in below:
            inner = self.table((*path, name), content[name])
            text += f"{self.blank()}[{self.blank()}{self.keys((*path, name))}{self.blank()}]{self.rest()}{inner}"
        return text

    def dotted(self, path: tuple[str, ...], value: Mapping[str, Any]) -> str:
        """Write the entries of a table one by one, with all of their keys."""
        text = ""
        for name, inner in self.random.sample(list(value.items()), len(value)):
            if isinstance(inner, dict):
                text += self.dotted((*path, name), inner)
            else:
                text += self.entry(self.keys((*path, name)), self.value(inner))
        return text

    def entry(self, key: str, value: str) -> str:
        return f"{self.blank()}{key}{self.blank()}={self.blank()}{value}{self.rest()}"

    def rest(self) -> str:
        """Return the end of a line, and what means nothing after it."""
        comment = "# [shape] type = 'no'" if self.random.random() < 0.1 else ""
        return f"{self.blank()}{comment}{self.ends}{self.idle()}"

    def idle(self) -> str:
        return self.random.choice(["", "", self.ends, f"\t# a = 1{self.ends}"])

    def blank(self) -> str:
        return self.random.choice(["", " ", " ", "\t "])

    def keys(self, path: tuple[str, ...]) -> str:
        return f"{self.blank()}.{self.blank()}".join(map(self.key, path))

    def key(self, name: str) -> str:
        if name.replace("_", "").isalnum() and name.isascii() and self.random.random() < 0.8:
            return name
        return self.text(name, may_have_lines=False)

    def value(self, value: Any) -> str:
        if isinstance(value, list) and value and isinstance(value[0], dict):
            return self.list([self.value(item) for item in value])
        if isinstance(value, dict):
            inner = f",{self.blank()}".join(
                f"{self.key(name)}{self.blank()}={self.blank()}{self.value(item)}"
                for name, item in self.random.sample(list(value.items()), len(value))
            )
            return f"{{{self.blank()}{inner}{self.blank()}}}"
        written = self.plain(value)
        if self.random.random() < 0.05:
            self.variables[f"v{len(self.variables)}"] = written
            return f'"$v{len(self.variables) - 1}"'
        return written

    def plain(self, value: Any) -> str:
        if isinstance(value, bool):
            return str(value).lower()
        if isinstance(value, int):
            return self.random.choice([str(value), f"+{value}", hex(value), oct(value), f"0b{value:b}"])
        if isinstance(value, float):
            whole = [str(int(value))] if value == int(value) else []
            return self.random.choice([decimal(value, self.random), decimal(value, self.random), *whole])
        if isinstance(value, list):
            return self.list([self.plain(item) for item in value])
        return self.text(value)

    def list(self, items: list[str]) -> str:
        between = self.random.choice([", ", ",", f",{self.ends}    ", f" , # next{self.ends}"])
        return f"[{self.blank()}{between.join(items)}{self.random.choice(['', ',', f',{self.ends}'])}]"

    def text(self, text: str, may_have_lines: bool = True) -> str:
        escaped = "".join(
            f"\\u{ord(c):04X}" if self.random.random() < 0.1 else f"\\{c}" if c in '"\\' else c for c in text
        )
        ways = [f'"{escaped}"', f"'{text}'"]
        if may_have_lines:
            ways += [f'"""{self.ends}{escaped}"""', f"'''{text}'''"]
        return self.random.choice(ways)


def loaded(folder: Path, scene: Mapping[str, Any], random: Random) -> et.Scene:
    path = folder / "scene.toml"
    path.write_bytes(Writer(random).document(scene))
    return et.load(path)


@pytest.fixture(scope="module")
def original() -> et.Scene:
    scene = et.load_dict({"type": "scene", **plain()})
    assert scene.warnings == ()
    return scene


@sizes
def test_any_spelling_is_the_same_scene(examples: int, original: et.Scene, tmp_path: Path) -> None:
    assert_same_scenes(lambda random: loaded(tmp_path, plain(), random), original, examples)


def test_a_picture_of_another_spelling_has_the_same_bits(original: et.Scene, tmp_path: Path) -> None:
    assert_same_pictures(lambda random: loaded(tmp_path, plain(), random), original)


def numbers(value: Any) -> list[tuple[Any, Any]]:
    """Return where the numbers of a tree are: what they are in, and their key."""
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    found: list[tuple[Any, Any]] = []
    for key, inner in items:
        found += [(value, key)] if isinstance(inner, float) else numbers(inner)
    return found


def test_a_number_that_is_changed_changes_the_scene(original: et.Scene, tmp_path: Path) -> None:
    """The twin: by a millionth of each number in turn, in any spelling."""
    same = []
    for place in range(len(numbers(plain()))):
        scene = plain()
        holder, key = numbers(scene)[place]
        holder[key] += 2**-20
        if loaded(tmp_path, scene, Random(place)).digest == original.digest:
            same.append(place)
    assert len(same) <= 3, same  # up: along the view, and its length; the third scale of a plane


def of_lines(text: str) -> Any:
    return PARSED(text.replace("\r", "|"))


PARSED: Any = toml_reader.tomllib.loads
FAULTS: dict[str, Any] = {
    "ends of lines are line feeds": of_lines,
    "names are not quoted": lambda text: PARSED(text.replace("'", "")),
    "numbers have no minus": lambda text: PARSED(text.replace("-", "")),
    "comments are values": lambda text: PARSED(text.replace("#", "")),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_is_noticed(fault: str, original: et.Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def is_same(seed: int) -> bool:
        path = tmp_path / "scene.toml"
        path.write_bytes(Writer(Random(seed)).document(plain()))
        try:
            scene = et.load(path)
        except et.SceneError:
            return False
        return (scene.digest, scene.warnings) == (original.digest, original.warnings)

    monkeypatch.setattr(toml_reader.tomllib, "loads", FAULTS[fault])
    assert not all(is_same(seed) for seed in range(EVERYDAY))
