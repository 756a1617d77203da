"""Other builds of the core: with other CMake options, or with an edit to the source, each in a folder of its own."""

from __future__ import annotations

import hashlib
import re
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[2]


@dataclass(frozen=True)
class Variant:
    """What to change before building; edits are (file, regular expression, replacement), and each must fit."""

    options: Mapping[str, str]
    edits: Sequence[tuple[str, str, str]] = ()


def build(variant: Variant, folder: Path) -> str:
    """Build the Python module in ``folder`` and return its file, unless it is there, of these sources."""
    stamp, now = folder / "stamp", stamp_of(variant)
    if not stamp.is_file() or stamp.read_text() != now:
        shutil.rmtree(folder, ignore_errors=True)
        made(variant, folder)
        stamp.write_text(now)
    (module,) = (folder / "build").glob(f"_core*{sysconfig.get_config_var('EXT_SUFFIX')}")
    return str(module)


def stamp_of(variant: Variant) -> str:
    """Return what a build depends on, as a digest."""
    files = [REPOSITORY / "CMakeLists.txt", *sorted((REPOSITORY / "cpp").rglob("*.[hc]*"))]
    texts = [
        path.read_bytes() for path in files if path.is_file() and "tests" not in path.relative_to(REPOSITORY).parts
    ]
    return hashlib.sha256(b"\0".join([*texts, repr(variant).encode(), sys.executable.encode()])).hexdigest()


def made(variant: Variant, folder: Path) -> None:
    """Copy the sources, edit them and build."""
    source = folder / "source"
    shutil.copytree(REPOSITORY / "cpp", source / "cpp", ignore=shutil.ignore_patterns("tests"))
    shutil.copy(REPOSITORY / "CMakeLists.txt", source)
    for file, pattern, replacement in variant.edits:
        text, fits = re.subn(pattern, replacement, (source / file).read_text())
        if not fits:
            raise SystemExit(f"{file} has nothing like {pattern}")
        (source / file).write_text(text)
    import pybind11  # of the environment that runs the benchmark

    defines = {
        "CMAKE_BUILD_TYPE": "Release",
        "EQUALTIME_PYTHON": "ON",
        "EQUALTIME_TESTS": "OFF",
        "Python_EXECUTABLE": sys.executable,
        "pybind11_DIR": pybind11.get_cmake_dir(),
        **variant.options,
    }
    binary = folder / "build"
    words = [f"-D{name}={value}" for name, value in defines.items()]
    for command in (["cmake", "-S", str(source), "-B", str(binary), *words], ["cmake", "--build", str(binary), "-j2"]):
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode:
            raise SystemExit(f"{' '.join(command)} failed:\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
