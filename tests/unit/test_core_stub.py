"""The stub `_core.pyi` says what the compiled module offers: the same names, parameters and defaults."""

import ast
import inspect
import re
from pathlib import Path
from typing import Any

import pytest

import equaltime
from equaltime import _core

STUB = ast.parse((Path(equaltime.__file__).parent / "_core.pyi").read_text())
CLASSES = {node.name: node for node in STUB.body if isinstance(node, ast.ClassDef)}
FUNCTIONS = {node.name: node for node in STUB.body if isinstance(node, ast.FunctionDef)}
MODULES = {ast.unparse(node.target) for node in STUB.body if isinstance(node, ast.AnnAssign)}
METHODS = [
    (class_name, node)
    for class_name, body in CLASSES.items()
    for node in body.body
    if isinstance(node, ast.FunctionDef)
]


def is_property(node: ast.FunctionDef) -> bool:
    return any(isinstance(decorator, ast.Name) and decorator.id == "property" for decorator in node.decorator_list)


def stub_parameters(node: ast.FunctionDef) -> list[str]:
    """Return ``name`` or ``name=default`` for every parameter but self, with ``*`` where keywords begin."""
    arguments = node.args
    positional = [argument.arg for argument in arguments.args]
    defaults = [None] * (len(positional) - len(arguments.defaults)) + [ast.unparse(d) for d in arguments.defaults]
    words = [
        name if default is None else f"{name}={default}" for name, default in zip(positional, defaults, strict=True)
    ]
    if arguments.vararg:
        words.append(f"*{arguments.vararg.arg}")
    elif arguments.kwonlyargs:
        words.append("*")
    for argument, default_node in zip(arguments.kwonlyargs, arguments.kw_defaults, strict=True):
        words.append(argument.arg if default_node is None else f"{argument.arg}={ast.unparse(default_node)}")
    if arguments.kwarg:
        words.append(f"**{arguments.kwarg.arg}")
    return [word for word in words if word != "self"]


def bound_parameters(function: Any) -> list[str]:
    """Return the same from the first line of a bound function's docstring, which is its signature."""
    line = (inspect.getdoc(function) or "").splitlines()[0]
    inside = re.fullmatch(r"\w+\((.*)\) -> .*", line)
    assert inside, f"no signature in {line!r}"
    words = []
    for part in split_outside_brackets(inside[1]):
        name, _, rest = part.partition(":")
        default = rest.rpartition(" = ")[2] if " = " in rest else ""
        words.append(f"{name.strip()}={default.strip()}" if default else name.strip())
    return [word for word in words if word not in ("self", "")]


def split_outside_brackets(text: str) -> list[str]:
    parts, depth = [""], 0
    for character in text:
        depth += (character in "([{") - (character in ")]}")
        if character == "," and depth == 0:
            parts.append("")
        else:
            parts[-1] += character
    return parts


def test_the_module_and_the_stub_have_the_same_names() -> None:
    assert {name for name in vars(_core) if not name.startswith("_")} == CLASSES.keys() | FUNCTIONS.keys() | MODULES


@pytest.mark.parametrize("name", CLASSES)
def test_a_class_has_the_members_that_the_stub_gives_it(name: str) -> None:
    members = {node.name for class_name, node in METHODS if class_name == name}
    public = {member for member in vars(getattr(_core, name)) if not member.startswith("_")}
    assert public == members - {"__init__"}


@pytest.mark.parametrize(("class_name", "node"), METHODS, ids=lambda value: getattr(value, "name", value))
def test_a_member_is_what_the_stub_says(class_name: str, node: ast.FunctionDef) -> None:
    bound = getattr(_core, class_name).__dict__[node.name]
    assert isinstance(bound, property) == is_property(node)
    if not is_property(node):
        assert bound_parameters(bound) == stub_parameters(node)


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_function_takes_what_the_stub_says(name: str) -> None:
    assert bound_parameters(getattr(_core, name)) == stub_parameters(FUNCTIONS[name])


@pytest.mark.parametrize("name", [*CLASSES, *FUNCTIONS])
def test_everything_in_the_module_is_documented(name: str) -> None:
    assert inspect.getdoc(getattr(_core, name))
