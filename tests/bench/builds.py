"""Other builds of the core: with other CMake options, or with an edit to the source, each in a folder of its own."""

from __future__ import annotations

import hashlib
import os
import re
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

Edit = tuple[str, str, str]

REPOSITORY = Path(__file__).resolve().parents[2]
KERNEL_TABLE = "cpp/equaltime/transport/kernel_effects.h"
KERNELS = "cpp/equaltime/transport/compile_kernel.h"
"""What the files of all kernels include, and no other file."""
_rows = re.search(r"kKernelCount = (\d+)", (REPOSITORY / KERNEL_TABLE).read_text())
assert _rows is not None
ROWS = int(_rows[1])
"""Number of kernels."""
ONE_ROW: Mapping[str, str] = {"EQUALTIME_KERNEL_ROWS": str(ROWS - 1)}
"""Only the kernel for all effects."""
TWO_ROWS: Mapping[str, str] = {"EQUALTIME_KERNEL_ROWS": f"0;{ROWS - 1}"}
"""Only the kernel for no effect, and the one for all: minutes of compiling less."""


@dataclass(frozen=True)
class Variant:
    """What to change before building; edits are (file, regular expression, replacement), and each must fit."""

    options: Mapping[str, str]
    edits: Sequence[Edit] = ()


def build(variant: Variant, folder: Path) -> str:
    """Build the Python module in ``folder`` and return its file, unless it is there, of these sources."""
    stamp, now = folder / "stamp", stamp_of(variant)
    if not stamp.is_file() or stamp.read_text() != now:
        shutil.rmtree(folder, ignore_errors=True)
        made(variant, folder)
        stamp.write_text(now)
    return _module(folder)


def rebuild(variant: Variant, folder: Path, unit: str) -> str:
    """Compile one file anew where a variant was built, with other edits, and link it with all that there is.

    Returns the file of the module, which takes the place of the other. What else depends on the edits does not change.
    """
    source = folder / "source"
    (folder / "stamp").unlink(missing_ok=True)
    _write_source(source, _edited(variant.edits))
    (source / unit).touch()
    _compile(variant, folder)
    return _module(folder)


def stamp_of(variant: Variant) -> str:
    """Return what a build depends on, as a digest."""
    files = [REPOSITORY / "CMakeLists.txt", *sorted((REPOSITORY / "cpp").rglob("*.[hc]*"))]
    texts = [
        path.read_bytes() for path in files if path.is_file() and "tests" not in path.relative_to(REPOSITORY).parts
    ]
    return hashlib.sha256(b"\0".join([*texts, repr(variant).encode(), sys.executable.encode()])).hexdigest()


def made(variant: Variant, folder: Path) -> None:
    """Copy the sources, edited, and build."""
    _write_source(folder / "source", _edited(variant.edits))
    _compile(variant, folder)


def _edited(edits: Sequence[Edit]) -> dict[str, str]:
    """Return the text of each file that has edits."""
    found: dict[str, str] = {}
    for file, pattern, replacement in edits:
        found[file], fits = re.subn(pattern, replacement, found.get(file) or (REPOSITORY / file).read_text())
        if not fits:
            raise SystemExit(f"{file} has nothing like {pattern}")
    return found


def _write_source(target: Path, edited: Mapping[str, str]) -> None:
    """Write what is built. A file that is there and differs becomes no younger, so that nothing is built for it."""
    core = [path.relative_to(REPOSITORY) for path in (REPOSITORY / "cpp").rglob("*") if path.is_file()]
    for name in (Path("CMakeLists.txt"), *(name for name in core if "tests" not in name.parts)):
        text, file = edited.get(str(name)) or (REPOSITORY / name).read_text(), target / name
        if not file.exists():
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text)
        elif file.read_text() != text:
            before = file.stat()
            file.write_text(text)
            os.utime(file, ns=(before.st_atime_ns, before.st_mtime_ns))


def _compile(variant: Variant, folder: Path) -> None:
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
    for command in (
        ["cmake", "-S", str(folder / "source"), "-B", str(binary), *words],
        ["cmake", "--build", str(binary), "-j2"],
    ):
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode:
            raise SystemExit(f"{' '.join(command)} failed:\n{done.stdout[-2000:]}{done.stderr[-2000:]}")


def _module(folder: Path) -> str:
    (module,) = (folder / "build").glob(f"_core*{sysconfig.get_config_var('EXT_SUFFIX')}")
    return str(module)
