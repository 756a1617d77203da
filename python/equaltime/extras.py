"""Imports optional packages when they are first used, and names the extra that installs a missing package."""

from __future__ import annotations

import importlib
from typing import Any

from equaltime.errors import EqualtimeError

__all__ = ["optional"]


def optional(module: str, extra: str = "report") -> Any:
    """Return the imported ``module`` of an optional package.

    Raises EqualtimeError if the package is missing; the message says that ``extra`` installs the package.
    """
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        if error.name is None or module.split(".")[0] != error.name.split(".")[0]:
            raise
        raise EqualtimeError(f"this needs the package {error.name}: pip install equaltime[{extra}]") from error
