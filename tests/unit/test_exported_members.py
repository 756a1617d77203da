"""The public names: what `import equaltime as et` offers, and that nothing else leaks into it."""

import ast
import importlib
import inspect
import pkgutil
import subprocess
import sys
from pathlib import Path

import pytest

import equaltime as et

FEW = 40
"""Modules that `import equaltime` may import: itself, and what `typing` and `importlib` need."""


def test_the_documented_names_are_exported() -> None:
    assert {"load", "load_dict", "render", "Scene", "Strategy", "Result", "Estimate", "__version__"} <= set(et.__all__)


def test_every_exported_name_exists_once_and_is_documented() -> None:
    assert len(et.__all__) == len(set(et.__all__))
    for name in et.__all__:
        assert name == "__version__" or inspect.getdoc(getattr(et, name)), name


def test_every_error_is_exported_and_an_equaltime_error() -> None:
    errors = importlib.import_module("equaltime.errors")
    assert set(errors.__all__) <= set(et.__all__)
    kinds = [getattr(et, name) for name in errors.__all__ if name not in ("Problem", "EqualtimeWarning")]
    assert all(issubclass(kind, et.EqualtimeError) for kind in kinds)


def test_render_takes_what_it_promises() -> None:
    parameters = inspect.signature(et.render).parameters
    named = [name for name, parameter in parameters.items() if parameter.kind == inspect.Parameter.KEYWORD_ONLY]
    assert list(parameters) == ["scene", *named]
    usual = {"spp": None, "time": None, "error": None, "strategy": "best", "seed": 0, "threads": 0}
    saving = {"resume": None, "checkpoint": None, "checkpoint_every": 60.0, "checkpoint_exposure": "auto"}
    saving["overwrite"] = False
    effects = {"without": (), "within": None}
    rare = {"observer": None, "stop": "look", "show": None, "traps": "ignore", "backend": "core", "cluster": None}
    assert {name: parameters[name].default for name in named} == usual | saving | effects | rare


def test_no_public_name_is_a_module() -> None:
    assert set(et.__all__) & {module.name for module in pkgutil.iter_modules(et.__path__)} == set()


def test_importing_the_package_imports_little() -> None:
    program = "import sys; before = set(sys.modules); import equaltime; print(*sorted(set(sys.modules) - before))"
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    imported = run.stdout.split()
    assert [name for name in imported if name.startswith("equaltime")] == ["equaltime"]
    assert len(imported) <= FEW, imported


def test_editors_see_the_same_names_as_python() -> None:
    tree = ast.parse(Path(et.__file__).read_text())
    typed = {
        (node.module, alias.name)
        for branch in tree.body
        if isinstance(branch, ast.If)
        for node in branch.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    assert typed == {(home, name) for name, home in et._HOMES.items()}
    assert set(et.__all__) == {*et._HOMES, "__version__"}
    assert dir(et) == sorted(et.__all__), "no imports of its own"


def test_the_package_is_marked_as_typed() -> None:
    folder = Path(et.__file__).parent
    assert (folder / "py.typed").exists()
    assert (folder / "_core.pyi").exists()


MODULES = [m.name for m in pkgutil.walk_packages(et.__path__, "equaltime.") if not m.name.endswith("_core")]


@pytest.mark.parametrize("name", MODULES)
def test_what_a_module_exports_is_there(name: str) -> None:
    module = importlib.import_module(name)
    for member in getattr(module, "__all__", ()):
        assert hasattr(module, member), member


def test_the_library_prints_nothing() -> None:
    folder = Path(et.__file__).parent
    for path in folder.rglob("*.py"):
        if path.relative_to(folder).parts[0] in ("cli", "scenes"):  # scripts of the pages are among the scenes
            continue
        calls = [node.func for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.Call)]
        assert not [call for call in calls if isinstance(call, ast.Name) and call.id == "print"], path
