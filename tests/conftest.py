"""What all tests share."""

from __future__ import annotations

import signal
from typing import Any

import pytest

from equaltime import _core

# A runner that was started in the background ignores Ctrl-C and would hand that on to the programs under test.
signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--traps", action="store_true", help="look for floating-point faults in every render, and fail where one is"
    )


_WITHOUT_TRAPS = {
    "test_core_stub.py": "describes the renderer that is not watched, and renders nothing",
    "test_G09_extreme_numbers": "asks for numbers whose products overflow",
}


class _Watched(_core.Renderer):
    """A renderer that looks for faults, whatever it is asked for."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        self._watched = options.get("traps", "ignore") == "ignore"
        super().__init__(*arguments, **options | ({"traps": "check"} if self._watched else {}))

    def advance(self, *arguments: Any, **options: Any) -> bool:
        complete = super().advance(*arguments, **options)
        assert not (self._watched and self.faulty), self.faulty
        return complete


def pytest_configure(config: pytest.Config) -> None:
    if config.getoption("--traps"):
        setattr(_core, "Renderer", _Watched)  # noqa: B010 -- the name is a type elsewhere


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    if config.getoption("--traps"):
        for item in items:
            for name, reason in _WITHOUT_TRAPS.items():
                if name in item.nodeid:
                    item.add_marker(pytest.mark.skip(reason))
