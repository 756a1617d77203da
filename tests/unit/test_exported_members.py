"""The public names: what `import equaltime as et` offers, and that nothing else leaks into it."""

import ast
import importlib
import inspect
import pkgutil
from pathlib import Path

import pytest

import equaltime as et


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
    first = ["scene", "spp", "time", "strategy", "seed", "threads", "progress", "backend"]
    assert list(parameters)[: len(first)] == first
    more = {name for name, parameter in parameters.items() if parameter.kind == inspect.Parameter.KEYWORD_ONLY}
    saving = {"resume", "checkpoint", "checkpoint_every", "unsaved"}
    assert more == {"error", "quoted", "unquoted", "without", "within", "decided", "show", "stop", "traps"} | saving
    assert [p.default for p in parameters.values()][1 : len(first)] == [None, None, "best", 0, 0, None, "core"]


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
        if path.relative_to(folder).parts[0] in ("cli", "cli.py"):
            continue
        calls = [node.func for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.Call)]
        assert not [call for call in calls if isinstance(call, ast.Name) and call.id == "print"], path
