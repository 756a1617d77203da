"""MTL: statements, options and names as they are written; what is not used is told."""

from __future__ import annotations

import pytest

from equaltime.scene.mtl import NEUTRAL, WORDS, ImageMap, Material, read_mtl
from equaltime.scene.report import Account


def read(text: bytes | str) -> tuple[dict[bytes, Material], list[str]]:
    account = Account()
    content = text if isinstance(text, bytes) else text.encode()
    return read_mtl(content, "a.mtl", account), list(account)


def material(text: str) -> tuple[Material, list[str]]:
    found, told = read(f"newmtl m\n{text}\n")
    return found[b"m"], told


def image(rest: str) -> tuple[ImageMap, list[str]]:
    found, told = material(f"map_Kd {rest}")
    return found.images["map_kd"], told


@pytest.mark.parametrize(
    "text",
    [
        "newmtl m\nKd 0.8 0.1 0.1\n",
        "newmtl\tm\nKd\t0.8\t0.1 0.1\n",
        "\ufeffnewmtl m\nKd 0.8 0.1 0.1\n",
        "newmtl m\r\nKd 0.8 0.1 0.1\r\n",
        "newmtl m\rKd 0.8 0.1 0.1\r",
        "# a\\\nnewmtl m # red\n  # b\\\n\f\n\v\tKd  .8 1e-1 +0.1 # red\\\n",
        "newmtl m   \nKd 0.8 \\\n 0.1\\\r\n 0.1\n",
        "NEWMTL m\nKD 0.8 0.1 0.1",
        "newmtl m\nkd 0.8 0.1 0.1\nkd 0.8 0.1 0.1 \\",
    ],
)
def test_one_material_in_many_spellings(text: str) -> None:
    found, _ = read(text)
    assert list(found) == [b"m"]
    assert found[b"m"].color == (0.8, 0.1, 0.1)


@pytest.mark.parametrize(
    "name", [b"M\xf6bel", "Möbel_木".encode(), b"Material_#25", b"Material #25", b"dark red", b'"a"']
)
def test_names_are_bytes(name: bytes) -> None:
    assert list(read(b"newmtl " + name + b" \nKd 1 1 1")[0]) == [name]


def test_a_name_that_ends_in_a_backslash_takes_no_line() -> None:
    found, _ = read("newmtl a\\\nKd 0.1 0.2 0.3\nmap_Kd C:\\images\\\nd 0.5\n")
    assert list(found) == [b"a\\"]
    assert found[b"a\\"].color == (0.1, 0.2, 0.3)
    assert found[b"a\\"].opacity == 0.5


def test_a_backslash_of_its_own_continues_an_image() -> None:
    found, _ = image("-s 2 2 1 \\\n wood.png")
    assert (found.rest, found.scale) == (b"wood.png", (2.0, 2.0))


@pytest.mark.parametrize(
    ("text", "color"),
    [("Kd 0.25", (0.25, 0.25, 0.25)), ("Kd 0 .5 1.", (0.0, 0.5, 1.0)), ("Kd 1e-1 0 0 # c", (0.1, 0.0, 0.0))],
)
def test_colours(text: str, color: tuple[float, ...]) -> None:
    assert material(text)[0].color == color
    assert material(text)[1] == []


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("Kd 1 2", "'Kd' is not used: expected one number or 3, found '1 2'"),
        ("Kd 1,0 0 0", "'Kd' is not used: expected one number or 3, found '1,0 0 0'"),
        ("Kd nan 0 0", "'Kd' is not used: expected one number or 3, found 'nan 0 0'"),
        ("Kd 1e999 0 0", "'Kd' is not used: expected one number or 3, found '1e999 0 0'"),
        ("Kd", "'Kd' is not used: expected one number or 3, found ''"),
        ("Kd xyz 1 1 1", "'Kd xyz' is not used: colours are read as R, G, B"),
        ("Kd spectral a.rfl", "'Kd spectral' is not used: colours are read as R, G, B"),
        ("Kd 0.5 0.1 2", "'Kd' is cut to [0, 1]"),
        ("Kd -1 0 0", "'Kd' is cut to [0, 1]"),
        ("Ke -1 0 0", "'Ke' is negative and counts as 0"),
        ("d 1.5", "'d' is cut to [0, 1]"),
        ("d -halo 0.5", "'d' is not used: expected one number, found '-halo 0.5'"),
        ("d 0.5\nTr 0.4", "'d' and 'Tr' of a material do not add up to 1: 'd' counts"),
        ("Ks 1 1 1", "'Ks' is not used: gloss comes from Pr and Pm alone"),
        ("illum 7", "'illum' is not used: mirrors and glass are diffuse"),
        ("disp a.png", "'disp' is not used: surfaces are not displaced"),
        ("map_Bump -bm x a.png", "'-bm' of 'map_Bump' is not used"),
        ("bump -bm 1e999 a.png", "'-bm' of 'bump' is not used"),
        ("bump -imfchan r a.png", "'-imfchan' of 'bump' is not used"),
        ("norm -bm 0.5 a.png", "'-bm' of 'norm' is not used"),
        ("map_Kd -bm 0.5 a.png", "'-bm' of 'map_Kd' is not used"),
        ("bump a.png\nmap_bump b.png", "'map_bump' of a material is given again: the last one counts"),
        ("foo 1", "'foo' is no statement of MTL that is read"),
        ("map_Kd -mm 0 0.5 a.png", "'-mm' of 'map_Kd' is not used"),
        ("map_Kd -t 0.1 0 0 a.png", "'-t' of 'map_Kd' is not used"),
        ("map_Kd -imfchan r a.png", "'-imfchan' of 'map_Kd' is not used"),
        ("map_Kd -s 0 1 1 a.png", "a scale or an offset of 'map_Kd' is not used: it leaves nothing of the image"),
    ],
)
def test_what_is_not_used_is_told_with_its_place(text: str, message: str) -> None:
    assert material(text)[1] == [f"a.mtl:{2 + text.count(chr(10))}: {message}"]


def test_what_is_told_has_a_count() -> None:
    assert read("newmtl a\nKs 1 1 1\nnewmtl b\nks 1 1 1\nKs 1 1 1\n")[1] == [
        "a.mtl:2: 'Ks' is not used: gloss comes from Pr and Pm alone (first of 2)",
        "a.mtl:4: 'ks' is not used: gloss comes from Pr and Pm alone",
    ]


@pytest.mark.parametrize("text", ["Ks 0 0 0", "illum 2", "Tf 1 1 1", "Ps 0", "Ka 1 1 1", "Ns 50", "Ni 1.5"])
def test_what_asks_for_what_is_rendered_is_silent(text: str) -> None:
    assert material(text)[1] == []


def test_every_word_has_its_reason() -> None:
    assert all((use in ("silent", "told")) == bool(why) for use, why in WORDS.values())
    assert all(WORDS[word][0] == "told" for word in NEUTRAL)


@pytest.mark.parametrize(
    ("text", "opacity"), [("d 0.25", 0.25), ("Tr 0.25", 0.75), ("d 0.25\nTr 0.75", 0.25), ("Tr 0.75\nd 0.25", 0.25)]
)
def test_opacities(text: str, opacity: float) -> None:
    found, told = material(text)
    assert found.opacity == opacity
    assert told == []


@pytest.mark.parametrize(
    ("rest", "expected"),
    [
        ("wood.png", ImageMap(b"wood.png", 2)),
        ("my wood.png", ImageMap(b"my wood.png", 2)),
        ("123.png", ImageMap(b"123.png", 2)),
        ("2 by 4.png", ImageMap(b"2 by 4.png", 2)),
        ("-s 2 2 1 123.png", ImageMap(b"123.png", 2, (2, 2))),
        ("-s 2 2 1 5", ImageMap(b"5", 2, (2, 2))),
        ("-s 2 3 5", ImageMap(b"5", 2, (2, 3))),
        ("-s 2 wood.png", ImageMap(b"wood.png", 2, (2, 1))),
        ("-o 0.5 .25 0 -s 2 -3 1 my wood.png", ImageMap(b"my wood.png", 2, (2, -3), (0.5, 0.25))),
        ("-S 2 2 1 -Clamp ON wood.png", ImageMap(b"wood.png", 2, (2, 2), clamp=True)),
        ("-clamp off -blendu on -mm 0 1 -cc off wood.png", ImageMap(b"wood.png", 2)),
        ("images\\wood.png", ImageMap(b"images\\wood.png", 2)),
        ('"my wood.png" # oak', ImageMap(b'"my wood.png" # oak', 2)),
        ("-sand.png", ImageMap(b"-sand.png", 2)),
    ],
)
def test_images_have_options_and_a_name(rest: str, expected: ImageMap) -> None:
    found, told = image(rest)
    assert found == expected
    assert told == []


@pytest.mark.parametrize(
    ("statement", "word", "expected"),
    [
        ("norm n.png", "norm", ImageMap(b"n.png", 2)),
        ("Norm -bm 1 -s 2 3 1 -o 0.5 -clamp on my n.png", "norm", ImageMap(b"my n.png", 2, (2, 3), (0.5, 0), True)),
        ("bump -bm 0.25 -imfchan l h.png", "bump", ImageMap(b"h.png", 2, multiplier=0.25)),
        ("map_Bump -bm -2 2 by 4.png", "bump", ImageMap(b"2 by 4.png", 2, multiplier=-2)),
        ("map_bump -BM 1e-1 -s 2 2 2 h.png # rough", "bump", ImageMap(b"h.png # rough", 2, (2, 2), multiplier=0.1)),
        ("bump -bm 0.25", "bump", ImageMap(b"0.25", 2)),
    ],
)
def test_reliefs_have_the_options_of_images_and_heights_a_factor(statement: str, word: str, expected: ImageMap) -> None:
    found, told = material(statement)
    assert found.images == {word: expected}
    assert told == ([] if statement != "bump -bm 0.25" else ["a.mtl:2: '-bm' of 'bump' is not used"])


def test_the_last_of_two_counts_and_the_first_is_told() -> None:
    found, told = read("newmtl a\nKd 1 0 0\nnewmtl a\nKd 0 1 0\nKd 0 0 1\n")
    assert found[b"a"].color == (0, 0, 1)
    assert told == [
        "a.mtl:3: the material 'a' is defined again: the last one counts",
        "a.mtl:5: 'Kd' of a material is given again: the last one counts",
    ]


def test_what_belongs_to_no_material_is_told() -> None:
    found, told = read("Kd 1 0 0\nnewmtl\nKd 0 1 0\n")
    assert found == {}
    assert told == [
        "a.mtl:1: 'Kd' stands before any material and is not used",
        "a.mtl:2: 'newmtl' has no name: its material is not used",
    ]
