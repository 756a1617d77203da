"""Instructions in the path loop of scenes with an element that does nothing, against the same scenes without it.

The scenes are those of `tests/unit/scene/test_effects.py`. Counted by valgrind, in one process: the same each time.
"""

from __future__ import annotations

import argparse
import importlib.util
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from types import ModuleType

from instructions import profiles

TESTS = Path(__file__).resolve().parents[1] / "unit" / "scene" / "test_effects.py"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--render", metavar="FOLDER", type=Path, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.render is not None:
        render(options.render)
        return
    with tempfile.TemporaryDirectory() as folder:
        tests = load()
        names = list(tests.inert(Path(folder)))
        worker = [sys.executable, __file__, "--render", folder]
        totals = [found.total for found in profiles(worker)]
    assert len(totals) == 2 * len(names), (len(totals), len(names))
    for number, name in enumerate(names):
        declared, absent = totals[2 * number : 2 * number + 2]
        print(f"{declared - absent:+6d} of {absent} instructions: {name}")


def load() -> ModuleType:
    """Load the module of the tests."""
    spec = importlib.util.spec_from_file_location("test_effects", TESTS)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def render(folder: Path) -> None:
    """Render each scene with its inert element, then without, and have a profile of each."""
    tests = load()
    for pair in tests.inert(folder).values():
        for scene in pair:
            tests.bits(scene)
            subprocess.run(["callgrind_control", "--dump", str(os.getpid())], capture_output=True, check=True)


if __name__ == "__main__":
    main()
