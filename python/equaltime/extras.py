"""Imports optional packages when they are first used.

The error for a missing package names the extra that installs it, as in ``pip install equaltime[report]``.
"""

from __future__ import annotations

import importlib
from typing import Any

from equaltime.errors import EqualtimeError

__all__ = ["optional"]


def optional(module: str, extra: str = "report") -> Any:
    """Import and return the Python module called ``module``, which belongs to an optional package.

    Raises EqualtimeError if the package is missing. The message says ``pip install equaltime[extra]``, where ``extra``
    is the name of a group of optional packages.
    """
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        if error.name is None or module.split(".")[0] != error.name.split(".")[0]:
            raise
        raise EqualtimeError(f"this needs the package {error.name}: pip install equaltime[{extra}]") from error
