"""The rooms of the repository: who may include whom, and where things stand."""

import ast
import fnmatch
import re
import subprocess
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
FLOORS = {
    "base": 0,
    "math": 1,
    **dict.fromkeys(("shapes", "sampling", "film", "io"), 2),
    **dict.fromkeys(("accel", "textures", "media", "sensors"), 3),
    **dict.fromkeys(("bsdfs", "lights"), 4),
    "scene": 5,
    **dict.fromkeys(("build", "transport"), 6),
    "render": 7,
    "analysis": 8,
    "bindings": 9,
}
"""Rooms of the core, each with its floor. A room knows those on lower floors, and none beside it."""
PUBLIC_ROOMS = ("analysis", "build", "film", "io", "render")
"""Rooms that a user of the core calls: each has one public header, which has the room's name."""
UMBRELLA = "equaltime.h"
"""Header that includes the public headers. It stands above all rooms."""
TOP_LEVEL = {"pyproject.toml", "CMakeLists.txt", "cpp", "python", "tests", "scenes", "README.md", "LICENSE"}
MAY_STAND_THERE = {"CHANGELOG.md", "CITATION.cff"}
LONGEST_ESTIMATOR = 150
LONGEST_CPP_LINE = 120
"""As .clang-format has it; Ruff sees to the Python."""
EXCEPTIONS = ("std::runtime_error", "std::logic_error", "std::invalid_argument")
"""Classes of the standard library that exceptions of the core may derive from."""
CORE_IMPORTERS = {"bench", "experiments", "film", "rendering", "scene"}
"""Rooms that may import the compiled module."""


def files(folder: str, *patterns: str) -> list[Path]:
    return sorted(path for pattern in patterns for path in (ROOT / folder).rglob(pattern) if path.is_file())


def sources() -> list[Path]:
    return [
        *files("cpp", "*.h", "*.cpp"),
        *files("python", "*.py", "*.pyi"),
        *files("tests", "*.py", "*.cpp", "*.h"),
        ROOT / "tests" / "run",
    ]


def place(path: Path) -> str:
    return str(path.relative_to(ROOT))


def includes(path: Path) -> list[str]:
    return re.findall(r'^\s*#\s*include\s*["<]([^">]+)[">]', path.read_text(), re.MULTILINE)


def may_include(folder: str, other: str) -> bool:
    """Tell whether a room of the core may include another: itself or one on a lower floor."""
    return folder == other or (other != UMBRELLA and FLOORS[other] < FLOORS[folder])


CORE = [path for folder in FLOORS for path in files(f"cpp/equaltime/{folder}", "*.h", "*.cpp")]


@pytest.mark.parametrize("path", CORE, ids=place)
def test_a_cpp_file_includes_only_its_own_floor_or_lower_ones(path: Path) -> None:
    ours = [name.split("/") for name in includes(path) if name.startswith("equaltime/")]
    assert ["/".join(name) for name in ours if not may_include(path.parent.name, name[1])] == []


def test_rooms_beside_each_other_do_not_know_each_other() -> None:
    beside = ("sampling", "shapes", "film")
    assert not any(may_include(a, b) for a in beside for b in beside if a != b)


def test_every_room_of_the_core_has_a_floor() -> None:
    assert {path.name for path in (ROOT / "cpp").iterdir() if path.is_dir()} == {"equaltime", "tests"}
    assert {path.name for path in (ROOT / "cpp/equaltime").iterdir()} == {*FLOORS, UMBRELLA}


def test_the_umbrella_header_has_the_public_header_of_each_public_room() -> None:
    expected = [f"equaltime/{room}/{room}.h" for room in PUBLIC_ROOMS]
    assert includes(ROOT / "cpp/equaltime" / UMBRELLA) == expected


@pytest.mark.parametrize("path", files("tests/consumer", "*.cpp"), ids=place)
def test_a_user_needs_no_other_header_of_ours(path: Path) -> None:
    assert [name for name in includes(path) if name.startswith("equaltime/")] == [f"equaltime/{UMBRELLA}"]


def test_includes_name_the_folder_and_never_climb() -> None:
    quoted = re.compile(r'^\s*#\s*include\s*"([^"]+)"', re.MULTILINE)
    lost = [
        f"{place(path)}: {name}"
        for path in files("cpp", "*.h", "*.cpp")
        for name in quoted.findall(path.read_text())
        if not (ROOT / "cpp" / name).exists()
    ]
    assert lost == []


def test_embree_is_included_under_accel_only() -> None:
    users = [path for path in files("cpp", "*.h", "*.cpp") if any("embree" in name for name in includes(path))]
    assert {path.parent.name for path in users} == {"accel"}


def test_the_core_has_its_own_elementary_functions() -> None:
    # those of a C library differ between its versions, and between processors
    call = re.compile(r"std::(a?(sin|cos|tan)h?|atan2|exp(2|m1)?|log(2|10|1p)?|pow|cbrt|hypot|erfc?|[tl]gamma)f?\(")
    found = [place(path) for path in files("cpp/equaltime", "*.h", "*.cpp") if call.search(path.read_text())]
    assert not found


def test_the_estimator_stands_on_a_screen() -> None:
    assert len((ROOT / "cpp/equaltime/transport/path.h").read_text().splitlines()) <= LONGEST_ESTIMATOR


def test_no_cpp_line_is_wider_than_the_others() -> None:
    wide = [
        f"{place(path)}:{number}"
        for path in files("cpp", "*.h", "*.cpp")
        for number, line in enumerate(path.read_text().splitlines(), 1)
        if len(line) > LONGEST_CPP_LINE
    ]
    assert wide == []


def test_nothing_in_the_core_inherits_but_exceptions_and_observers() -> None:
    """`PathObserver` holds no data: it is what an observer of paths does unless it says otherwise."""
    based = re.compile(r"^ *(?:class|struct) \w+(?: final)? : (?:public |private |protected )?(\S+)", re.MULTILINE)
    bases = [f"{place(path)}: {base}" for path in CORE for base in based.findall(path.read_text())]
    assert [base for base in bases if not base.endswith((*EXCEPTIONS, "PathObserver"))] == []


CLASS = re.compile(
    r"^ *(?:template <[^;{]*?>\s*(?:requires\([^)]*\)\s*)?)?"
    r"(?:class|struct) (\w+)(?: final)?(?:<[^>{;]*>)?\s*(?::[^{;]*)?\{",
    re.MULTILINE,
)
MEMBER = re.compile(r"^(?=\S)(?!//|#)[^\n;={}()]*?\b(\w+)(?:<[^<>()\n]*>)?::(~?\w+|operator[^(\n]*)\(", re.MULTILINE)


def member_definitions(text: str) -> Iterator[tuple[str, str]]:
    """Yield class and name of each member function that a C++ source defines outside its class."""
    for match in MEMBER.finditer(text):
        end, depth = match.end(), 1
        while depth and end < len(text):
            depth += {"(": 1, ")": -1}.get(text[end], 0)
            end += 1
        if re.match(r"[^;{]*\{", text[end:]):
            yield match[1], match[2]


def members_defined_elsewhere(text_of: Mapping[str, str]) -> list[str]:
    """Return the member functions that are defined in another room than their class; paths are ``room/file``."""
    rooms: dict[str, set[str]] = {}
    for path, text in text_of.items():
        for name in CLASS.findall(text):
            rooms.setdefault(name, set()).add(path.split("/")[0])
    return [
        f"{path}: {owner}::{name}"
        for path, text in text_of.items()
        for owner, name in member_definitions(text)
        if path.split("/")[0] not in rooms.get(owner, {path.split("/")[0]})
    ]


def test_a_member_function_is_defined_in_the_room_of_its_class() -> None:
    text_of = {str(path.relative_to(ROOT / "cpp/equaltime")): path.read_text() for path in CORE}
    assert members_defined_elsewhere(text_of) == []
    assert len([name for text in text_of.values() for name in member_definitions(text)]) > 150


def test_a_member_function_in_another_room_is_found() -> None:
    header = "struct Scene {\n  float size(int axis) const noexcept;\n  template <bool B> int count() const;\n};\n"
    size = "float Scene::size(int axis) const noexcept {\n  return 1;\n}\n"
    count = "template <bool B>\nint Scene::count() const {\n  return 0;\n}\n"
    call = "float twice(const Scene& s) {\n  return 2 * Film::gain(s);\n}\nstruct Film {};\n"
    own = {"scene/scene.h": header, "scene/size.cpp": size + count, "lights/twice.cpp": call}
    assert members_defined_elsewhere(own) == []
    assert members_defined_elsewhere({**own, "lights/size.cpp": size}) == ["lights/size.cpp: Scene::size"]
    assert members_defined_elsewhere({**own, "build/count.cpp": count}) == ["build/count.cpp: Scene::count"]


def imports_core(tree: ast.AST) -> bool:
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and (
            node.module in ("equaltime._core", "_core") or any(alias.name == "_core" for alias in node.names)
        ):
            return True
        if isinstance(node, ast.Import) and any(alias.name == "equaltime._core" for alias in node.names):
            return True
    return False


def test_the_compiled_module_is_imported_in_a_handful_of_files() -> None:
    importers = [path for path in files("python/equaltime", "*.py") if imports_core(ast.parse(path.read_text()))]
    rooms = {path.relative_to(ROOT / "python" / "equaltime").parts[0].removesuffix(".py") for path in importers}
    assert rooms == CORE_IMPORTERS
    assert len(importers) <= 9, importers


def test_a_room_of_the_package_imports_only_rooms_below_it() -> None:
    program = Path(sys.executable).with_name("lint-imports")
    run = subprocess.run([program, "--no-cache"], cwd=ROOT, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stdout


def test_the_tests_mirror_the_rooms() -> None:
    rooms = {path.name for path in (ROOT / "python" / "equaltime").iterdir() if path.is_dir()} | {"bench", "data"}
    folders = {path.name for path in (ROOT / "tests" / "unit").iterdir() if path.is_dir()} - {"__pycache__"}
    assert folders <= rooms


def test_no_room_imports_the_face() -> None:
    faced = [
        f"{place(path)}: {alias.name}"
        for path in files("python/equaltime", "*.py")
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.ImportFrom) and node.module == "equaltime"
        for alias in node.names
        if alias.name != "_core" and not (ROOT / "python/equaltime" / f"{alias.name}.py").exists()
    ]
    assert faced == []


def test_the_library_prints_nothing() -> None:
    printing = [
        place(path)
        for path in files("python", "*.py")
        if "cli" not in path.relative_to(ROOT).parts
        and any(
            isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "print"
            for node in ast.walk(ast.parse(path.read_text()))
        )
    ]
    assert printing == []


def top_level() -> Iterator[str]:
    """Yield what stands at the top level but dot-files and what git is told to ignore."""
    ignored = [line.strip("/") for line in (ROOT / ".gitignore").read_text().splitlines() if line]
    for path in ROOT.iterdir():
        if not path.name.startswith(".") and not any(fnmatch.fnmatch(path.name, pattern) for pattern in ignored):
            yield path.name


def test_nothing_else_stands_at_the_top_level() -> None:
    assert set(top_level()) - MAY_STAND_THERE == TOP_LEVEL


def test_nothing_is_put_off_in_a_comment() -> None:
    put_off = re.compile("|".join(("TO" + "DO", "FIX" + "ME", "XX" + "X")))  # in halves, since this file is read too
    marked = [
        f"{place(path)}:{number}"
        for path in [*sources(), ROOT / "CMakeLists.txt", ROOT / "README.md"]
        for number, line in enumerate(path.read_text().splitlines(), 1)
        if put_off.search(line)
    ]
    assert marked == []
