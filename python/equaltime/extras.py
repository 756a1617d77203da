"""Imports packages of the extras when they are first used, and says which extra has a missing one."""

from __future__ import annotations

import importlib
from typing import Any

from equaltime.errors import EqualtimeError

__all__ = ["optional"]


def optional(module: str, extra: str = "report") -> Any:
    """Import a module that comes with one of equaltime's extras; if it is missing, say how to get it."""
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        if error.name is None or module.split(".")[0] != error.name.split(".")[0]:
            raise
        raise EqualtimeError(f"this needs the package {error.name}: pip install equaltime[{extra}]") from error
