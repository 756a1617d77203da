"""Reads MTL files, the material libraries of OBJ files, into values that this renderer can use.

`WORDS` defines the use of each statement. Unused statements go into the `Account`, which is shown to the user. The
words of statements and options are recognised in any letter case. Names of materials are bytes. The bytes in the OBJ
and MTL files are compared unchanged, whatever their encodings.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Final, Literal

from equaltime.scene.core import obj_name
from equaltime.scene.report import Account

__all__ = ["WORDS", "Color", "ImageMap", "Material", "read_mtl", "shown"]

Color = tuple[float, float, float]
Use = Literal["color", "radiance", "number", "image", "name", "silent", "told"]

_NOT_GLOSS: Final = "gloss comes from Pr and Pm alone"
_UNMOVED: Final = "surfaces are not displaced"
WORDS: Final[dict[str, tuple[Use, str]]] = {
    # lower-case word: its use, and the reason if it is not used
    "newmtl": ("name", ""),
    "kd": ("color", ""),
    "ke": ("radiance", ""),
    "d": ("number", ""),
    "tr": ("number", ""),
    "pr": ("number", ""),
    "pm": ("number", ""),
    "map_kd": ("image", ""),
    "map_ke": ("image", ""),
    "map_d": ("image", ""),
    "map_pr": ("image", ""),
    "map_pm": ("image", ""),
    "norm": ("image", ""),
    "bump": ("image", ""),
    "map_bump": ("image", ""),
    "ka": ("silent", "ambient light is replaced by traced light"),
    "map_ka": ("silent", "ambient light is replaced by traced light"),
    "ns": ("silent", "the exponent of Ks and map_Ks, which are told"),
    "map_ns": ("silent", "the exponent of Ks and map_Ks, which are told"),
    "ni": ("silent", "counts for the glass of illum 4 to 9, which is told"),
    "sharpness": ("silent", "counts for refl, which is told"),
    "pcr": ("silent", "counts for Pc, which is told"),
    "anisor": ("silent", "counts for aniso, which is told"),
    "map_aat": ("silent", "asks for antialiasing, which is there"),
    "illum": ("told", "mirrors and glass are diffuse"),
    "ks": ("told", _NOT_GLOSS),
    "map_ks": ("told", _NOT_GLOSS),
    "refl": ("told", _NOT_GLOSS),
    "map_refl": ("told", _NOT_GLOSS),
    "tf": ("told", "surfaces that are not opaque let all colours through"),
    "map_tf": ("told", "surfaces that are not opaque let all colours through"),
    "ps": ("told", _NOT_GLOSS),
    "pc": ("told", _NOT_GLOSS),
    "aniso": ("told", _NOT_GLOSS),
    "map_ps": ("told", _NOT_GLOSS),
    "disp": ("told", _UNMOVED),
    "map_disp": ("told", _UNMOVED),
    "decal": ("told", "images do not replace each other"),
    "map_tr": ("told", "opacities come from map_d"),
}
_SAME: Final = {"map_bump": "bump"}
"""Words of statements with the same meaning as another word, by the less usual word."""
NEUTRAL: Final[dict[str, frozenset[float]]] = {
    "illum": frozenset({0.0, 1.0, 2.0}),
    "tf": frozenset({1.0}),
    **dict.fromkeys(("ks", "ps", "pc", "aniso"), frozenset({0.0})),
}
"""Values with which an unused statement changes nothing, so that it is not reported."""

_OPTIONS: Final[dict[bytes, int]] = {
    **dict.fromkeys((b"-s", b"-o", b"-t"), 3),
    b"-mm": 2,
    **dict.fromkeys(
        (b"-bm", b"-boost", b"-texres", b"-clamp", b"-blendu", b"-blendv", b"-cc", b"-imfchan", b"-type"), 1
    ),
}
"""Largest number of words that follow an option; only numbers follow ``-s``, ``-o`` and ``-t``."""
_DEFAULTS: Final[dict[bytes, frozenset[bytes]]] = {
    b"-blendu": frozenset({b"on", b"off"}),  # texture filtering, which the file does not decide here
    b"-blendv": frozenset({b"on", b"off"}),
    b"-cc": frozenset({b"off"}),
    b"-imfchan": frozenset({b"l"}),
}
"""Values of unused options that change nothing."""
_NUMBER: Final = re.compile(rb"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
_NUMBERED: Final = frozenset({b"-s", b"-o", b"-t"})
_FARTHEST: Final = 2.0**20
"""Largest absolute value of an option's number that is used."""


@dataclass(frozen=True, slots=True)
class ImageMap:
    """An image of a material, with its placement on the surface.

    Texture coordinates (u, v) show the image's point (su u + ou, sv v + ov). `scale` is (su, sv), and `offset` is (ou,
    ov).
    """

    rest: bytes
    """The end of the statement in the MTL file, after all options: the image's file name as written there.

    It may include quotes or a comment, and is not decoded from bytes.
    """
    line: int
    """Line of the statement in the MTL file."""
    scale: tuple[float, float] = (1.0, 1.0)
    offset: tuple[float, float] = (0.0, 0.0)
    clamp: bool = False
    """Option ``-clamp``: whether edge texels continue outside the image, where it otherwise repeats."""
    multiplier: float = 1.0
    """Option ``-bm`` of a height map (``bump``): the factor from texel values to heights, which is the height of white.

    Heights are in the mesh's units of length.
    """


@dataclass(slots=True)
class Material:
    """The properties of one material of an MTL file that are used here."""

    line: int
    color: Color | None = None
    """Reflectance ``Kd``, in [0, 1]."""
    opacity: float = 1.0
    """Opacity ``d``, or 1 - ``Tr``."""
    radiance: Color = (0.0, 0.0, 0.0)
    """Emitted radiance ``Ke``, not negative."""
    roughness: float | None = None
    """Roughness ``Pr``."""
    metallic: float | None = None
    """Metalness ``Pm``."""
    images: dict[str, ImageMap] = field(default_factory=dict)
    """Images by their lower-case words, such as ``map_kd``; ``map_bump`` is stored as ``bump``."""
    words: set[str] = field(default_factory=set)
    """The words of all statements of the material, in lower case."""

    @property
    def has_color(self) -> bool:
        """Whether the material gives a reflectance: True with a colour ``Kd`` or an image ``map_Kd``."""
        return self.color is not None or "map_kd" in self.images


def shown(name: bytes) -> str:
    """Return the bytes `name` as text, decoded as UTF-8, or as Latin-1 if they are not UTF-8."""
    try:
        return name.decode("utf-8")
    except UnicodeDecodeError:
        return name.decode("latin-1")


def read_mtl(content: bytes, file: str, account: Account) -> dict[bytes, Material]:
    """Return the materials in the `content` of an MTL file, as a dict by name; count unused statements in `account`.

    `file` is the file's name for messages.
    """
    return _Reader(file, account).read(content)


class _Reader:
    def __init__(self, file: str, account: Account) -> None:
        self._file = file
        self._account = account
        self._materials: dict[bytes, Material] = {}
        self._current: Material | None = None
        self._line = 0

    def read(self, content: bytes) -> dict[bytes, Material]:
        for self._line, statement in _statements(content):
            word, rest = _first(statement)
            if word:
                self._take(word, rest)
        return self._materials

    def _tell(self, kind: str) -> None:
        self._account.tell(kind, f"{self._file}:{self._line}")

    def _take(self, word: bytes, rest: bytes) -> None:
        key = word.lower().decode("ascii", "replace")
        name = shown(word[:64])
        use, why = WORDS.get(key, ("told", ""))
        if use == "silent":
            return
        if use == "told":
            if not _is_neutral(key, rest):
                self._tell(f"'{name}' is not used: {why}" if why else f"'{name}' is no statement of MTL that is read")
        elif use == "name":
            self._begin(obj_name(rest))
        elif self._current is None:
            self._tell(f"'{name}' stands before any material and is not used")
        else:
            key = _SAME.get(key, key)
            if key in self._current.words:
                self._tell(f"'{name}' of a material is given again: the last one counts")
            self._set(self._current, key, name, rest)
            self._current.words.add(key)

    def _begin(self, name: bytes) -> None:
        """Begin a material; a material without a name belongs to no face."""
        if not name:
            self._tell("'newmtl' has no name: its material is not used")
        if name in self._materials:
            self._tell(f"the material '{shown(name)}' is defined again: the last one counts")
        self._current = Material(self._line)
        if name:
            self._materials[name] = self._current

    def _set(self, material: Material, key: str, name: str, rest: bytes) -> None:
        if WORDS[key][0] == "image":
            material.images[key] = self._image(key, name, rest)
        elif key == "kd":
            material.color = self._color(name, rest, 1.0)
        elif key == "ke":
            material.radiance = self._color(name, rest, float("inf")) or (0.0, 0.0, 0.0)
        elif (values := self._numbers(name, rest, 1)) is not None:
            value = self._within(name, values[0], 1.0)
            if key == "pr":
                material.roughness = value
            elif key == "pm":
                material.metallic = value
            else:
                self._set_opacity(material, key, value)

    def _set_opacity(self, material: Material, key: str, value: float) -> None:
        opacity = value if key == "d" else 1.0 - value
        if {"d", "tr"} - {key} <= material.words and opacity != material.opacity:
            self._tell("'d' and 'Tr' of a material do not add up to 1: 'd' counts")
            opacity = opacity if key == "d" else material.opacity
        material.opacity = opacity

    def _color(self, name: str, rest: bytes, most: float) -> Color | None:
        """Return a colour from three numbers or one; None if it is in another colour space or invalid."""
        if (kind := _first(rest)[0].lower()) in (b"spectral", b"xyz"):
            self._tell(f"'{name} {kind.decode()}' is not used: colours are read as R, G, B")
            return None
        values = self._numbers(name, rest, 3)
        if values is None:
            return None
        values = values if len(values) == 3 else values * 3
        red, green, blue = (self._within(name, value, most) for value in values)
        return red, green, blue

    def _within(self, name: str, value: float, most: float) -> float:
        if not 0.0 <= value <= most:
            self._tell(f"'{name}' is cut to [0, 1]" if most == 1.0 else f"'{name}' is negative and counts as 0")
        return min(max(value, 0.0), most)

    def _numbers(self, name: str, rest: bytes, count: int) -> list[float] | None:
        """Return one number or `count` numbers; None, with a report, if the statement has others."""
        words = rest.split(b"#", 1)[0].split()
        numbers = [float(word) for word in words if _NUMBER.fullmatch(word)]
        if len(numbers) != len(words) or len(numbers) not in (1, count) or not all(map(_is_finite, numbers)):
            expected = "one number" if count == 1 else f"one number or {count}"
            self._tell(f"'{name}' is not used: expected {expected}, found '{shown(rest[:40])}'")
            return None
        return numbers

    def _image(self, key: str, name: str, rest: bytes) -> ImageMap:
        """Return an image with its options, which precede the name of its file."""
        given: dict[bytes, list[bytes]] = {}
        while (option := _first(rest)[0].lower()) in _OPTIONS:
            rest = _first(rest)[1]
            given[option] = words = []
            for _ in range(_OPTIONS[option]):
                word, after = _first(rest)
                if not after or (option in _NUMBERED and not _NUMBER.fullmatch(word)):
                    break  # the last word is the file's name
                words.append(word)
                rest = after
        scale = self._pair(name, given.pop(b"-s", []), 1.0)
        offset = self._pair(name, given.pop(b"-o", []), 0.0)
        clamp = [word.lower() for word in given.pop(b"-clamp", [])] == [b"on"]
        multiplier = _multiplier(given.get(b"-bm", [])) if key == "bump" else None
        if multiplier is not None:
            del given[b"-bm"]
        for option, words in given.items():
            if not _asks_for_nothing(option, words):
                self._tell(f"'{option.decode()}' of '{name}' is not used")
        return ImageMap(rest, self._line, scale, offset, clamp, 1.0 if multiplier is None else multiplier)

    def _pair(self, name: str, words: list[bytes], usual: float) -> tuple[float, float]:
        """Return the numbers of an option for u and v; the third number is for solid textures."""
        numbers = [float(word) for word in words]
        first, second = [*numbers, usual, usual][:2] if numbers else (usual, usual)
        if not max(abs(first), abs(second)) <= _FARTHEST or (usual and not min(abs(first), abs(second)) > 1e-6):
            self._tell(f"a scale or an offset of '{name}' is not used: it leaves nothing of the image")
            return usual, usual
        return first, second


def _statements(content: bytes) -> Iterator[tuple[int, bytes]]:
    """Iterate over the statements with their line numbers; a separate backslash at its end continues a line."""
    begun, first = b"", 0
    text = content.removeprefix(b"\xef\xbb\xbf").replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    for number, line in enumerate(text.split(b"\n"), 1):
        statement, first = (begun + line, first) if begun else (line, number)
        if _goes_on(statement):
            begun = statement.rstrip()[:-1] + b" "
            continue
        begun = b""
        if not statement.lstrip().startswith(b"#"):
            yield first, statement
    if begun:
        yield first, begun


def _goes_on(statement: bytes) -> bool:
    """Tell whether a backslash continues the line, instead of ending a comment or a name such as a Windows folder."""
    word, rest = _first(statement)
    use = WORDS.get(word.lower().decode("ascii", "replace"), ("told", ""))[0]
    if word.startswith(b"#") or use == "name":
        return False
    numeric = use in ("color", "radiance", "number")
    said = rest.split(b"#", 1)[0].rstrip() if numeric else obj_name(rest)
    return said.endswith(b"\\") if numeric else said == b"\\" or said.endswith((b" \\", b"\t\\"))


def _first(text: bytes) -> tuple[bytes, bytes]:
    """Return the first word of a text and the rest without blanks around it."""
    word, rest = [*text.split(None, 1), b"", b""][:2]
    return word, rest.strip()


def _is_finite(number: float) -> bool:
    return abs(number) != float("inf")


def _multiplier(words: list[bytes]) -> float | None:
    """Return the number of ``-bm``; None if it is missing or above `_FARTHEST`."""
    numbers = [float(word) for word in words if _NUMBER.fullmatch(word)]
    return numbers[0] if numbers and abs(numbers[0]) <= _FARTHEST else None


def _is_neutral(key: str, rest: bytes) -> bool:
    """Tell whether an unused statement changes nothing, so that it needs no report."""
    words = rest.split(b"#", 1)[0].split()
    numbers = {float(word) for word in words if _NUMBER.fullmatch(word)}
    return bool(words) and key in NEUTRAL and all(map(_NUMBER.fullmatch, words)) and numbers <= NEUTRAL[key]


def _asks_for_nothing(option: bytes, words: list[bytes]) -> bool:
    numbers = [float(word) for word in words if _NUMBER.fullmatch(word)]
    if option in (b"-t", b"-mm"):
        return numbers == ([0.0, 1.0] if option == b"-mm" else [0.0] * len(words))
    if option == b"-bm":
        return numbers == [1.0]
    return option in _DEFAULTS and [word.lower() in _DEFAULTS[option] for word in words] == [True]
