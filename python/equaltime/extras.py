"""Imports optional packages when they are first used.

The error for a missing package has the line that installs it (`install`).
"""

from __future__ import annotations

import importlib
from typing import Any

from equaltime.errors import EqualtimeError

__all__ = ["install", "optional"]


def install(extra: str) -> str:
    """Return the line that installs the group of optional packages called ``extra``, in a checkout or from a wheel.

    The name ``equaltime`` alone would ask the package index, which need not have it.
    """
    return f"pip install '.[{extra}]' in a checkout of equaltime, or 'equaltime-….whl[{extra}]' with its wheel"


def optional(module: str, extra: str = "report") -> Any:
    """Import and return the Python module called ``module``, which belongs to an optional package.

    Raises EqualtimeError if the package is missing. The message has the line that installs the group of optional
    packages called ``extra``.
    """
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        if error.name is None or module.split(".")[0] != error.name.split(".")[0]:
            raise
        raise EqualtimeError(f"this needs the package {error.name}: {install(extra)}") from error
